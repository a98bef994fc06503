import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tuner.recordings import refusal
from tuner.data.logs.error import FEW, suggest
from tuner.data.logs.mapping import Mapped, Mapping, parse_maps

CHANNELS = ("omega", "theta", "acc_x")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("omega=gx", Mapping("omega", "gx")),
        ("omega=2", Mapping("omega", "2")),
        (" omega = gx : deg/s ", Mapping("omega", "gx", unit="deg/s")),
        ("omega=gyr[2]", Mapping("omega", "gyr", 2)),
        ("omega=gyr[0]*0.05:deg/s", Mapping("omega", "gyr", 0, 0.05, "deg/s")),
        ("omega=gyr [0] * -1e-3", Mapping("omega", "gyr", 0, -1e-3)),
        ("omega=gyr*gyr_lsb", Mapping("omega", "gyr", None, "gyr_lsb")),
        ("omega=Gyroscope X (deg/s):deg/s", Mapping("omega", "Gyroscope X (deg/s)", unit="deg/s")),
        ("omega=rate [deg/s]", Mapping("omega", "rate [deg/s]")),
        ("omega=imu.gyr[1]", Mapping("omega", "imu.gyr", 1)),
        ("omega=a=b", Mapping("omega", "a=b")),
        ("omega=imu:gx:deg/s", Mapping("omega", "imu:gx", unit="deg/s")),
    ],
)
def test_mapping_is_read(text, expected):
    ((part,),) = (mapped.parts for mapped in parse_maps(text, CHANNELS))
    assert part == expected


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("omega", ["'omega'", "NAME=COLUMN"]),
        ("=gx", ["'=gx'", "NAME=COLUMN"]),
        ("omega=", ["'omega='", "NAME=COLUMN"]),
        ("omega=a\nb", ["'a\\nb'", "names no column"]),
        ("omga=gx", ["'omga=gx'", "no known channel", "'omega'"]),
        ("omega=gx*", ["no factor after '*'"]),
        ("omega=gx:", ["no unit after ':'"]),
        ("omega=gx*0", ["multiplies by 0"]),
        ("omega=gx*nan", ["multiplies by nan"]),
        ("omega=gx*-inf", ["multiplies by -inf"]),
    ],
)
def test_bad_mapping_is_refused_in_one_line(text, parts):
    sentence = refusal(text, CHANNELS, reader=parse_maps)
    for part in parts:
        assert part in sentence


def test_among_many_channels_the_near_ones_are_named():
    many = [f"state_{i}" for i in range(30)] + ["Omega_x"]
    assert "near names are 'Omega_x'" in refusal("omega_y=gx", many, reader=parse_maps)


def test_suggestions_never_list_a_crowd():
    assert suggest("x", []) == "there are none"
    assert suggest("zzz", [f"a{i}" for i in range(FEW + 3)]).endswith("and 3 more")


names = st.text(
    st.characters(codec="ascii", exclude_characters="[]*:=,", min_codepoint=33), min_size=1
).filter(lambda name: not name.startswith("-"))
factors = st.one_of(
    st.none(),
    st.floats(allow_nan=False, allow_infinity=False).filter(bool),
    st.from_regex(r"[a-z]+_lsb", fullmatch=True),
)


@settings(max_examples=200, deadline=None)
@given(
    columns=st.lists(
        st.tuples(names, st.none() | st.integers(0, 99), factors, st.booleans()),
        min_size=1,
        max_size=3,
    ),
    unit=st.none() | names,
    blank=st.sampled_from(["", " "]),
)
def test_what_is_written_is_read_back(columns, unit, blank):
    parts = tuple(Mapping("theta", *column, unit, minus) for *column, minus in columns)
    written = f"{blank},{blank}".join(part.source for part in parts)
    written += "" if unit is None else f"{blank}:{blank}{unit}"
    mapped = Mapped("theta", parts, written)
    assert parse_maps(f"theta{blank}={blank}{written}", CHANNELS) == (mapped,)
