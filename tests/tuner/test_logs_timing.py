import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.logs.timename import UNITS, is_time, unit_of
from tuner.data.reading import read_record

N = 400
NOISE = np.random.default_rng(3).normal(size=N)


def read(folder, time=None, rate_hz=None, samples=N, **arrays):
    """The clock of a log."""
    np.savez(folder / "log.npz", x=NOISE[:samples], **arrays)
    return clock_of(folder / "log.npz", time=time, rate_hz=rate_hz)


def clock_of(path, **options):
    record = read_record(path, ["omega=x:rad/s"], **options)
    clock = record.channels["omega"].clock
    assert record.sources[0].rate_hz == record.channels["omega"].rate_hz == clock.rate_hz
    assert record.sources[0].samples == len(clock.seconds)
    assert record.notes == clock.notes
    return clock


def printed(folder, times, decimals=None):
    """The clock of a text log whose times are rounded to so many decimals."""
    path = folder / "log.csv"
    texts = times if decimals is None else [f"{t:.{decimals}f}" for t in times]
    lines = (f"{t},{x}\n" for t, x in zip(texts, NOISE, strict=False))
    path.write_text(
        "t_ns,x\n" * (decimals is None) + "t,x\n" * (decimals is not None) + "".join(lines)
    )
    return clock_of(path)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("t", None),
        ("T", None),
        ("time", None),
        ("Timestamp", None),
        ("ts", None),
        ("elapsed_time", None),
        ("time_s", "s"),
        ("t_ms", "ms"),
        ("time_us", "us"),
        ("t_ns", "ns"),
        ("time (s)", "s"),
        ("t [ms]", "ms"),
        ("Time(us)", "us"),
        ("TimeUS", "us"),
        ("timestamp_seconds", "seconds"),
        ("seconds", "seconds"),
        ("milliseconds", "milliseconds"),
        ("imu.time_\N{MICRO SIGN}s", "\N{MICRO SIGN}s"),
    ],
)
def test_names_of_time(name, unit):
    assert is_time(name)
    assert unit_of(name) == unit
    assert unit is None or unit in UNITS


@pytest.mark.parametrize("name", ["omega", "temp", "t_imu", "s", "ms", "gyro (s)", "tilt", "rate"])
def test_names_of_other_things(name):
    assert not is_time(name)


def test_unit_at_the_end_of_any_name():
    assert unit_of("clock_ms") == "ms"
    assert unit_of("t_imu") is None


@pytest.mark.parametrize(
    ("name", "scale"), [("t", 1.0), ("t_ms", 1e3), ("time_us", 1e6), ("t [ns]", 1e9)]
)
@pytest.mark.parametrize("start", [0, 1_700_000_000])
def test_units_are_scaled_to_seconds(tmp_path, name, scale, start):
    exact = start * int(scale) + np.arange(N) * int(scale) // 200
    clock = read(tmp_path, **{name: exact if scale > 1 else start + np.arange(N) / 200})
    assert clock.rate_hz == pytest.approx(200, rel=1e-6)
    assert clock.step == pytest.approx(1 / 200, rel=1e-6)
    assert clock.seconds[0] == 0.0
    assert clock.seconds[-1] == pytest.approx((N - 1) / 200, rel=1e-6)
    assert clock.source == f"column {name!r}"
    assert clock.gaps == ()
    assert clock.jitter < 1e-4


def test_nanoseconds_since_1970_in_text_are_even_but_for_their_rounding(tmp_path):
    clock = printed(tmp_path, 1_700_000_000_000_000_000 + 5_000_000 * np.arange(N))
    assert clock.jitter == 0.0
    assert clock.rate_hz == pytest.approx(200, rel=1e-6)


def test_nanoseconds_since_1970_keep_their_digits(tmp_path):
    ticks = 1_700_000_000_000_000_000 + 5_000_001 * np.arange(N)
    assert read(tmp_path, t_ns=ticks).rate_hz == pytest.approx(1e9 / 5_000_001, rel=1e-12)


@pytest.mark.parametrize(
    "time", ["clock:ms", "clock*0.001", "clock*milli", "clock*1:ms", "both[1]:ms", "clock_ms"]
)
def test_named_time_column(tmp_path, time):
    ticks = 5.0 * np.arange(N)
    arrays = {"clock": ticks, "clock_ms": ticks, "both": np.column_stack([NOISE, ticks])}
    clock = read(tmp_path, time, milli=np.float64(1e-3), **arrays)
    assert clock.rate_hz == pytest.approx(200)
    assert clock.source == f"column {time.split(':')[0].split('*')[0].split('[')[0]!r}"


def test_bursts_are_spread_since_the_time_before(tmp_path):
    times = np.arange(N) / 100
    burst = times.copy()
    burst[10:13] = times[12]
    burst[200:202] = times[201]
    clock = read(tmp_path, t=burst)
    assert clock.notes == ("time 't': 3 repeated times spread over their time",)
    assert (clock.gaps, clock.rate_hz) == ((), pytest.approx(100))
    assert clock.jitter < 1e-6


def test_a_clock_of_coarse_ticks_is_spread(tmp_path):
    clock = read(tmp_path, t=np.floor(np.arange(N) / 7.3) / 10)
    assert clock.rate_hz == pytest.approx(73, rel=0.05)  # ticks of 7 and 8 samples
    assert (clock.gaps, clock.jitter < 0.2) == ((), True)


def test_a_rate_overrules_a_clock_that_stands_still(tmp_path):
    clock = read(tmp_path, rate_hz=100.0, t=np.floor(np.arange(N) / 7))
    assert (clock.rate_hz, clock.source, clock.origin) == (100, "--rate", None)
    assert "342" in clock.notes[0]  # 400 samples of 58 times


@pytest.mark.parametrize(("unit", "scale"), [("s", 1), ("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
def test_times_since_1970_tell_their_unit(tmp_path, unit, scale):
    ticks = 1_700_000_000 * scale + np.arange(N) * (2 * scale)
    clock = read(tmp_path, t=ticks)
    assert clock.rate_hz == pytest.approx(0.5)
    assert clock.notes == (f"time 't': taken as {unit} since 1970",)


@pytest.mark.parametrize(("name", "scale"), [("millis", 1e3), ("micros", 1e6)])
def test_names_of_arduino_clocks(tmp_path, name, scale):
    assert read(tmp_path, **{name: np.arange(N) * scale / 50}).rate_hz == pytest.approx(50)


def test_single_precision_times_are_widened(tmp_path):
    clock = read(tmp_path, t=STEADY.astype(np.float32))
    assert (clock.rate_hz, clock.jitter) == (pytest.approx(100, rel=1e-6), 0.0)


def test_steps_in_turn_are_uneven_and_no_gaps(tmp_path):
    times = np.cumsum(np.resize([0.005, 0.015], N))
    clock = read(tmp_path, t=times)
    assert clock.gaps == ()
    assert clock.rate_hz == pytest.approx(100, rel=1e-2)
    assert clock.jitter == pytest.approx(0.5, rel=1e-2)


def test_a_rate_that_agrees_is_kept(tmp_path):
    clock = read(tmp_path, rate_hz=100.5, t=np.arange(N) / 100)
    assert (clock.rate_hz, clock.step) == (100.5, 1 / 100.5)
    assert clock.source == "column 't' and --rate"
    np.testing.assert_allclose(clock.seconds, np.arange(N) / 100, atol=1e-12)


@pytest.mark.parametrize(
    "array", [np.array(["noon"] * N), np.arange(N + 1), np.float64(3), np.ones((N, 2)), NOISE * 1j]
)
def test_what_cannot_be_time_is_passed_over(tmp_path, array):
    np.savez(tmp_path / "log.npz", x=NOISE, time=array, t=np.arange(N) / 50)
    assert clock_of(tmp_path / "log.npz").source == "column 't'"


def test_a_text_column_called_time_is_passed_over(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,x\nearly,1\nlate,2\n")
    assert clock_of(path, rate_hz=1).origin is None
    assert "neither a time column nor a rate" in refusal(path, ["omega=x"])


STEADY = np.arange(N) / 100


@pytest.mark.parametrize(
    ("options", "arrays", "parts"),
    [
        ({}, {}, ["neither a time column nor a rate", "--rate", "--time", "'x'"]),
        ({}, {"fs": np.float64(0)}, ["'fs' is 0"]),
        ({}, {"fs": np.float64(-5)}, ["'fs' is -5", "--rate"]),
        ({}, {"fs": np.array("fast")}, ["'fs' is neither"]),
        ({"time": "clock"}, {"t": STEADY}, ["no column 'clock'", "'t'"]),
        ({"time": "t:h"}, {"t": STEADY}, ["'h', no unit of time", "ms"]),
        ({"time": "u"}, {"t": STEADY, "u": STEADY[:9]}, ["9 rows", "channels have 400"]),
        ({}, {"t": np.ones(N)}, ["stands still", "--rate"]),
        (
            {},
            {"t": np.insert(STEADY, 9, STEADY[8])[:N]},  # a row twice
            ["stands still at row 9 ", "--drop-repeats", "--by", "--rate"],
        ),
        ({}, {"t": np.r_[STEADY[:200], np.repeat(STEADY[200:300], 2)]}, ["row 201 ", "--by"]),
        ({}, {"t": np.r_[STEADY[:9], STEADY[2:-7]]}, ["runs backwards", "row 9 ", "sort"]),
        ({"time": "t:ms"}, {"t": np.arange(N).astype(np.uint8)}, ["runs backwards", "row 256 "]),
        ({}, {"t": np.where(STEADY > 3, np.nan, STEADY)}, ["'t'", "99 rows", "row 301 "]),
        (
            {},
            {"t": np.arange(N) * 10},
            ["steps by 10", "'t:ms' (100 Hz)", ":s where it is seconds"],
        ),
    ],
    ids=lambda value: "; ".join(value) if isinstance(value, list) else "",
)
def test_bad_timing_is_refused(tmp_path, options, arrays, parts):
    sentence = refusal(tmp_path, **options, **arrays, reader=read)
    assert sentence.startswith("log.npz: ")
    for part in parts:
        assert part in sentence


def test_gaps_are_found_not_refused(tmp_path):
    kept = np.delete(np.arange(N), [10, 200, 201, 202])
    clock = read(tmp_path, samples=N - 4, t=kept / 100)
    assert [row for row, _ in clock.gaps] == [9, 198]
    np.testing.assert_allclose([seconds for _, seconds in clock.gaps], [0.02, 0.04])
    assert clock.rate_hz == pytest.approx(100)
    assert clock.jitter == 0.0
    np.testing.assert_allclose(clock.seconds, kept / 100, atol=1e-12)


def test_jitter_is_the_largest_deviation_from_the_median(tmp_path):
    steps = np.full(N - 1, 0.01)
    steps[[5, 50]] = 0.0125, 0.0078
    times = np.r_[0.0, np.cumsum(steps)] + 1e-7 * NOISE[0]
    clock = read(tmp_path, t=times)
    assert clock.jitter == pytest.approx(0.25, rel=1e-6)
    assert clock.rate_hz == pytest.approx(100)
    assert clock.gaps == ()


@pytest.mark.parametrize("rate", [100.0, 128.0, 2000 / 7, 333.3, 700.0, 960.0])
def test_rounded_times_count_as_even(tmp_path, rate):
    clock = printed(tmp_path, np.arange(N) / rate, 3)
    assert clock.jitter == 0.0
    assert clock.gaps == ()
    assert clock.rate_hz == pytest.approx(rate, rel=5e-3)


def test_samples_lost_by_a_clock_without_spare_digits(tmp_path):
    kept = np.delete(np.arange(N), np.random.default_rng(4).choice(np.arange(1, N - 1), 30, False))
    clock = printed(tmp_path, kept / 100, 2)
    assert len(clock.gaps) > 20
    assert clock.rate_hz == pytest.approx(100)


def test_a_text_log_tells_the_line(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("# two\n# lines\nt,x\n0,1\n0.1,2\n\n0.05,3\n")
    assert "runs backwards by 0.05 s at line 7" in refusal(path, ["omega=x"])
