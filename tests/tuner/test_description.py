import numpy as np
import pytest

from tuner.data.reading import read_record
from tuner.data.record import Record

N = 60
GYR = np.random.default_rng(6).normal(size=(N, 3))


def test_description_of_a_record(tmp_path):
    times = np.delete(np.arange(1000), [5, 50, 60, 70, 80, 90, 500, 501]) / 100
    turn = np.clip(np.round(100 * np.sin(times)), -90, 200) + 0.0
    acc = np.random.default_rng(6).normal(size=len(times))
    acc[7:10] = np.nan
    np.savez(tmp_path / "turn.npz", t=times, gyr=turn, acc=acc, rest=np.full(len(times), 0.5))
    maps = ["omega=gyr*0.01:rad/s", "acc=acc:m/s^2", "z=rest"]
    lines = read_record(tmp_path / "turn.npz", maps, truth=["w=gyr*0.01:rad/s"]).describe()
    assert lines[:3] == [
        "turn.npz: 992 samples at 100 Hz",
        "time of omega: column 't', even, 7 gaps (rows count from 0), longest 0.03 s",
        "  0.02 s after row 4",
    ]
    assert lines[7] == "  and 2 more"
    table = lines[8:13]
    assert [line.split()[0] for line in table] == ["channel", "omega", "acc", "z", "truth"]
    assert len({len(line) for line in table}) == 1
    header, omega = (line.split() for line in table[:2])
    told = dict(zip(header, omega, strict=True))
    assert (told["column"], told["unit"], told["Hz"]) == ("gyr*0.01", "rad/s", "100")
    assert (told["missing"], told["min"], told["max"], told["step"]) == ("0", "-0.9", "1", "0.01")
    assert float(told["mean"]) == pytest.approx(0.01 * turn.mean(), rel=1e-5)
    assert float(told["std"]) == pytest.approx(0.01 * turn.std(), rel=1e-3)
    assert (table[2].split()[4], table[2].split()[-1]) == ("3", "-")
    low = turn == -90
    assert lines[13:] == [
        f"omega: {low.sum()} samples at the end of the range; the sensor may have been saturated",
        "z: constant, 0.5 in every sample",
        "z: no unit given, left as it is",
    ]


@pytest.mark.parametrize(
    ("arrays", "rate_hz", "line"),
    [
        ({}, 50.0, "time of z: --rate"),
        ({"fs": np.float64(50)}, None, "time of z: scalar 'fs'"),
        ({"t": np.arange(N) / 50}, None, "time of z: column 't', even, no gaps"),
        ({"t": np.arange(N) / 50}, 50.1, "time of z: column 't' and --rate, even, no gaps"),
        (
            {"t": np.arange(N) / 50 + np.where(np.arange(N) == 7, 0.0025, 0.0)},
            None,
            "time of z: column 't', jitter up to 13 % of a step, no gaps",
        ),
        (
            {"t": np.cumsum(np.resize([0.1, 0.2, 0.4], N))},
            None,
            "time of z: column 't', uneven, steps of 0.1 to 0.4 s, no gaps",
        ),
    ],
)
def test_what_told_the_times_and_how_they_run(tmp_path, arrays, rate_hz, line):
    np.savez(tmp_path / "log.npz", x=GYR[:, 0], **arrays)
    lines = read_record(tmp_path / "log.npz", ["z=x", "y=x"], rate_hz=rate_hz).describe()
    assert [told for told in lines if told.startswith("time of")] == [line]


def test_times_of_arrays_are_told_where_they_are_uneven():
    assert len(Record.of({"z": GYR}, times=np.arange(N) / 50).describe()) == 5
    times = np.delete(np.arange(N + 5) / 10, np.s_[20:25])
    lines = Record.of({"z": GYR}, times=times, units={"z": "deg/s"}).describe()
    assert lines[1:3] == [
        "time of z: even, 1 gap (rows count from 0), longest 0.6 s",
        "  0.6 s after row 19",
    ]
    assert [line.split()[0] for line in lines[4:]] == ["z.x", "z.y", "z.z"]
    assert [line.split()[1] for line in lines[4:]] == ["z[0]", "z[1]", "z[2]"]
