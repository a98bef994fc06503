from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.data.logs import LogError
from tuner.data.merge import stacked, timeline
from tuner.data.reading import read_record, read_records
from tuner.data.record import Record

CASES = Path(__file__).parents[2].parent / "shared" / "cases"
cases = pytest.mark.skipif(not CASES.is_dir(), reason="no public cases beside the repository")
N = 400
RNG = np.random.default_rng(12)
FAST, SLOW = RNG.normal(size=(N, 3)), RNG.normal(size=N // 20)


def written(folder, name, times, **columns):
    table = np.column_stack([times, *columns.values()])
    path = folder / name
    np.savetxt(path, table, delimiter=",", header=",".join(["t", *columns]), fmt="%.17g")
    return path


def test_an_even_clock_gives_its_rate():
    line = timeline(Record.of({"gyr": FAST}, rate_hz=50.0))
    assert line.rate_hz == 50.0
    np.testing.assert_array_equal(line.dt, np.full(N, 0.02))
    np.testing.assert_array_equal(line.channels["gyr"], FAST)
    assert (line.units, line.notes, line.counts) == ({"gyr": ""}, (), None)


def test_two_files_are_what_the_merged_arrays_are(tmp_path):
    """100 Hz and 5 Hz, the slow one 2 ms off: each sample at the nearest instant of the fast."""
    times = np.arange(N) / 100
    imu = written(tmp_path, "imu.csv", times + 70, gx=FAST[:, 0], gy=FAST[:, 1], gz=FAST[:, 2])
    gps = written(tmp_path, "gps.csv", times[::20] + 70.002, h=SLOW)
    line = timeline(read_record([imu, gps], ["gyr=gx,gy,gz:rad/s", "baro=h:m"]))
    merged = np.full(N, np.nan)
    merged[::20] = SLOW
    np.testing.assert_array_equal(line.channels["gyr"], FAST)
    np.testing.assert_array_equal(line.channels["baro"], merged)
    assert line.rate_hz == pytest.approx(100)
    assert line.notes == ()


@settings(max_examples=20)
@given(
    missing=st.lists(st.booleans(), min_size=30, max_size=30),
    jitter=st.floats(0.0, 0.004),
)
def test_channels_split_in_two_merge_to_the_same(missing, jitter):
    """Two clocks with one's instants among the other's, whatever is missing."""
    times = np.arange(30) / 100 + jitter * np.sin(np.arange(30))
    one, two = RNG.normal(size=(2, 30))
    two[np.array(missing)] = np.nan
    two[:2] = 1.0
    both = timeline(Record.of({"a": one, "b": two}, times=times))
    kept = ~np.isnan(two)
    apart = {"a": times, "b": times[kept]}
    split = timeline(Record.of({"a": one, "b": two[kept]}, times=apart))
    for name in "ab":
        np.testing.assert_array_equal(split.channels[name], both.channels[name])
    np.testing.assert_array_equal(split.dt, both.dt)


def test_rows_of_other_sensors_do_not_break_an_even_clock():
    """As an outer join of two tables writes it: each row has one sensor."""
    fast, slow = np.arange(N) / 100, np.arange(N // 20) / 5 + 0.003
    times = np.concatenate([fast, slow])
    gyr = np.concatenate([FAST, np.full((len(slow), 3), np.nan)])
    baro = np.concatenate([np.full(N, np.nan), SLOW])
    order = np.argsort(times)
    joined = Record.of({"gyr": gyr[order], "baro": baro[order]}, times=times[order])
    apart = Record.of({"gyr": FAST, "baro": SLOW}, times={"gyr": fast, "baro": slow})
    one, two = timeline(joined), timeline(apart)
    assert one.rate_hz == pytest.approx(100)
    for name in ("gyr", "baro"):
        np.testing.assert_array_equal(one.channels[name], two.channels[name])


def test_missing_samples_leave_an_even_clock_as_it_is():
    values = FAST[:, 0].copy()
    values[RNG.random(N) < 0.2] = np.nan
    line = timeline(Record.of({"z": values}, rate_hz=50.0))
    assert (len(line.times), line.rate_hz) == (N, 50.0)


def test_steps_in_turn_are_handed_on_as_they_are():
    steps = np.resize([0.005, 0.015], N)
    line = timeline(Record.of({"z": FAST[:, 0]}, times=np.cumsum(steps)))
    assert line.rate_hz is None
    np.testing.assert_allclose(line.dt[1:], steps[1:], rtol=1e-9)
    assert line.dt[0] == pytest.approx(np.median(steps[1:]))


def test_a_gap_is_handed_on_as_it_is():
    times = np.delete(np.arange(N + 50) / 50, np.s_[100:150])
    line = timeline(Record.of({"z": FAST[:, 0]}, times=times))
    assert line.rate_hz is None
    assert line.dt[100] == pytest.approx(51 / 50)
    assert np.median(line.dt) == line.dt[0] == pytest.approx(1 / 50)


def test_slow_clocks_of_like_rates_are_united():
    one = np.cumsum(RNG.uniform(0.8, 2.0, 30))
    two = np.cumsum(RNG.uniform(0.8, 2.0, 28)) + 0.4
    record = Record.of({"x": one, "y": two}, times={"x": one, "y": two})
    line = timeline(record)
    np.testing.assert_allclose(line.times, np.union1d(one, two) - min(one[0], two[0]), atol=1e-12)
    for name, samples in (("x", one), ("y", two)):
        values = line.channels[name]
        np.testing.assert_array_equal(values[~np.isnan(values)], samples)


def test_fast_clocks_of_like_rates_are_not():
    times = np.arange(N) / 200
    record = Record.of({"gyr": FAST, "acc": FAST}, times={"gyr": times, "acc": times + 0.002})
    line = timeline(record)
    assert len(line.times) == N
    np.testing.assert_array_equal(line.channels["acc"], FAST)


def test_what_finds_no_place_is_said():
    times = np.arange(N) / 100
    truth = np.arange(-50, 10 * N) / 1000  # 45 too early, 4 too late
    record = Record.of({"z": FAST[:, 0]}, times=times, truth={"z": truth}, truth_times=truth)
    line = timeline(record)
    kept = ~np.isnan(line.truth["z"])
    np.testing.assert_allclose(line.truth["z"][kept], line.times[kept] - 0.05, atol=1e-12)
    (note,) = line.notes
    assert note.startswith("truth z: 49 of 4050 samples have no instant within half a step")
    assert "share one with a nearer" in note


def test_channels_that_never_overlap_are_refused():
    times = {"gyr": np.arange(N) / 100, "baro": 1.7e9 + np.arange(20.0)}
    with pytest.raises(LogError, match=r"gyr \(0 to 3.99 s\) and baro .* do not overlap"):
        timeline(Record.of({"gyr": FAST, "baro": SLOW}, times=times))


def test_recordings_side_by_side():
    lengths, rng = (3, 7, 5), np.random.default_rng(1)
    parts = [(rng.normal(size=(n, 3)), np.arange(n, dtype=float)) for n in lengths]
    records = [Record.of({"gyr": g}, rate_hz=20.0, truth={"z": z}) for g, z in parts]
    both = stacked([timeline(record) for record in records])
    assert (both.counts, both.rate_hz) == (lengths, 20.0)
    assert both.channels["gyr"].shape == (7, 3, 3)
    for lane, (gyr, z) in enumerate(parts):
        np.testing.assert_array_equal(both.channels["gyr"][: len(z), lane], gyr)
        np.testing.assert_array_equal(both.truth["z"][: len(z), lane], z)
        assert np.isnan(both.channels["gyr"][len(z) :, lane]).all()
        assert np.isnan(both.truth["z"][len(z) :, lane]).all()
    np.testing.assert_array_equal(both.dt, np.full((7, 3), 0.05))


def test_uneven_recordings_side_by_side_keep_their_steps():
    even = timeline(Record.of({"z": np.ones(4)}, rate_hz=10.0))
    uneven = timeline(Record.of({"z": np.ones(6)}, times=[0.0, 0.2, 0.5, 0.6, 1.0, 1.7]))
    both = stacked([even, uneven])
    assert both.rate_hz is None
    np.testing.assert_allclose(both.dt[:, 0], 0.1)
    np.testing.assert_allclose(both.dt[1:, 1], [0.2, 0.3, 0.1, 0.4, 0.7])
    assert np.isfinite(both.dt).all()


def test_recordings_of_other_channels_are_refused():
    lines = [timeline(Record.of({name: np.ones(4)}, rate_hz=10.0)) for name in "ab"]
    with pytest.raises(LogError, match="'a'.*'b'"):
        stacked(lines)
    with pytest.raises(LogError, match="no recordings"):
        stacked([])


@cases
def test_a_robot_of_two_files():
    files = [CASES / "robot-2d" / name for name in ("odom.csv", "gps.csv")]
    odom, gps = (np.loadtxt(file, delimiter=",", skiprows=1) for file in files)
    maps = ["v=field.twist.linear.x:m/s", "x,y=field.x,field.y:m"]
    line = timeline(read_record(files, maps))
    rows = np.round((gps[:, 0] - odom[0, 0]) / 5e7).astype(int)
    merged = np.full((len(odom), 2), np.nan)
    merged[rows] = gps[:, 1:]
    np.testing.assert_array_equal(line.channels["v"], odom[:, 1])
    np.testing.assert_array_equal(line.channels["x"], merged[:, 0])
    np.testing.assert_array_equal(line.channels["y"], merged[:, 1])
    assert line.rate_hz == pytest.approx(20, rel=1e-6)


@cases
def test_twenty_tracks():
    path = CASES / "several-tracks" / "tracks.csv"
    raw = np.loadtxt(path, delimiter=",", skiprows=1)
    lines = [timeline(record) for record in read_records(path, ["x=x:m"], by="track_id")]
    both = stacked(lines)
    assert sum(both.counts) == np.isfinite(both.channels["x"]).sum() == len(raw) == 975
    assert sorted(both.channels["x"][np.isfinite(both.channels["x"])]) == sorted(raw[:, 2])


def test_recordings_that_one_long_one_makes_too_long_are_refused(monkeypatch):
    monkeypatch.setenv("TUNER_MEMORY", "1GB")
    short, long = (timeline(Record.of({"z": np.ones(n)}, rate_hz=10.0)) for n in (10, 40_000))
    assert stacked([short] * 9 + [long]).counts == (10,) * 9 + (40_000,)
    with pytest.raises(ValueError, match="^1001 recordings .* longest has 40000 .* leave out the"):
        stacked([short] * 1000 + [long])


def test_one_long_recording_makes_the_others_too_long(monkeypatch):
    monkeypatch.setenv("TUNER_MEMORY", "1GB")  # half of which the program itself takes
    long, short = (timeline(Record.of({"z": np.zeros(n)}, rate_hz=10.0)) for n in (100_000, 10))
    assert stacked([long, *10 * [short]]).counts == (100_000, *10 * [10])
    words = "21 recordings side by side, of which the longest has 100000 samples, would take"
    with pytest.raises(ValueError, match=f"{words} 0.673 GB.*leave out the longest"):
        stacked([long, *20 * [short]])


def test_recordings_of_one_rate_share_its_step():
    both = stacked([timeline(Record.of({"z": np.ones(n)}, rate_hz=10.0)) for n in (3, 5)])
    assert both.dt.shape == (5, 2)
    assert set(both.dt.ravel().tolist()) == {both.step} == {0.1}
    times = np.array([0.0, 0.1, 0.5, 0.6, 1.4])
    uneven = timeline(Record.of({"z": np.ones(5)}, times=times))
    assert uneven.rate_hz is None
    assert uneven.step == np.median(np.diff(times, prepend=times[0] - np.median(np.diff(times))))
