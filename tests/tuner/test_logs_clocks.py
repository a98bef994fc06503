"""Clocks as loggers write them: counters that begin anew, restarts, repeated times, two columns."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.tuner.recordings import refusal
from tuner.data.logs.clock import judged
from tuner.data.logs.steps import Steps
from tuner.data.logs.timename import is_time, unit_of
from tuner.data.reading import read_record, read_records
from tuner.run.recipe import LogEntries

N = 300


def written(folder, times, name="t", extra=""):
    path = folder / "log.csv"
    rows = "".join(f"{extra}{t},{k % 7}\n" for k, t in enumerate(times))
    path.write_text(f"{'run,' * bool(extra)}{name},x\n{rows}")
    return path


def clock(path, **options):
    record = read_record(path, ["z=x"], **options)
    return record.channels["z"].clock, record.notes


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("millis", "millis"),
        ("micros", "micros"),
        ("Test_Time(s)", "s"),
        ("%time", None),
        ("timestamp_us", "us"),
        ("TimeUS", "us"),
        ("seconds_elapsed", "seconds"),
        ("Zeit [ms]", "ms"),
        ("Uhrzeit", None),
        ("time since boot", None),
        ("device_time", None),
        ("Elapsed Time (sec)", "sec"),
    ],
)
def test_names_of_clocks(name, unit):
    assert is_time(name)
    assert unit_of(name) == unit


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    kind=st.sampled_from([("millis", 2**16, 10), ("micros", 2**32, 4000), ("t_ms", 2**32, 5)]),
    before=st.integers(3, N - 3),
)
def test_counters_go_on_where_they_begin_anew(tmp_path, kind, before):
    name, end, step = kind
    times = [(end - before * step + k * step) % end for k in range(N)]
    runs, notes = clock(written(tmp_path, times, name))
    unit = 1e-6 if name == "micros" else 1e-3
    np.testing.assert_allclose(runs.seconds, step * unit * np.arange(N), rtol=1e-12, atol=1e-15)
    power = 16 if end == 2**16 else 32
    assert any(f"begun anew at 2^{power} 1 time, counted on" in note for note in notes)


def test_seconds_and_their_parts_in_two_columns(tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{1700000000 + k // 8},{k % 8 * 125_000_000},{k}\n" for k in range(40))
    path.write_text("stamp.secs,stamp.nsecs,x\n" + rows)
    runs, _ = clock(path)
    assert runs.source == "columns 'stamp.secs', 'stamp.nsecs'"
    np.testing.assert_allclose(runs.seconds, np.arange(40) / 8, atol=1e-9)
    named, _ = clock(path, time="stamp.secs:s,stamp.nsecs:ns")
    np.testing.assert_array_equal(named.seconds, runs.seconds)


def test_a_log_that_was_started_again(tmp_path):
    times = [0.01 * (k % 100) for k in range(N)]
    path = written(tmp_path, times)
    sentence = refusal(path, ["z=x"])
    assert "runs backwards by 0.99 s at line 102; say --by restart" in sentence
    records = read_records(path, ["z=x"], by="restart")
    assert [record.name for record in records] == [f"log.csv: restart {k}" for k in (1, 2, 3)]
    assert [len(record.channels["z"].values) for record in records] == [100, 100, 100]
    assert [r.channels["z"].rate_hz for r in records] == pytest.approx([100, 100, 100])


def test_restarts_need_times(tmp_path):
    path = written(tmp_path, range(N), "count")
    assert "--by restart needs a time column" in refusal(
        path, ["z=x"], by="restart", rate_hz=10, reader=read_records
    )
    assert "--drop-repeats needs a time column" in refusal(
        path, ["z=x"], drop_repeats=True, rate_hz=10
    )


TWICE = np.sort(np.r_[np.arange(N), np.arange(0, N, 40)]) / 100


def test_repeated_rows_are_left_out_where_it_is_said(tmp_path):
    path = written(tmp_path, TWICE)
    assert "--drop-repeats" in refusal(path, ["z=x"])
    runs, notes = clock(path, drop_repeats=True)
    np.testing.assert_allclose(runs.seconds, np.arange(N) / 100)
    told = "8 rows with the time of the row before left out, 8 of them with other numbers"
    assert told in notes


def test_no_repeated_rows_to_leave_out(tmp_path):
    runs, notes = clock(written(tmp_path, np.arange(N) / 100), drop_repeats=True)
    assert len(runs.seconds) == N
    assert "0 rows with the time of the row before left out" in notes


def test_repeats_of_each_recording(tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{run},{t},{k}\n" for run in "ab" for k, t in enumerate(TWICE))
    path.write_text("run,t,x\n" + rows)
    records = read_records(path, ["z=x"], by="run", drop_repeats=True)
    assert [len(record.channels["z"].values) for record in records] == [N, N]


@pytest.mark.parametrize(
    ("times", "why"),
    [
        (TWICE, "it stands still at line 3"),
        ([0.01 * (k % 100) for k in range(N)], "it runs backwards by 0.99 s at line 102"),
        ([0.01 * (k // 2) for k in range(N)], "it has 150 repeated times"),
        ([0.02 * k for k in range(N)], "it runs at 50 Hz as it stands, 2 times as many"),
        ([10 * k for k in range(N)], "it steps by 10, which is hardly seconds"),
        (["" if k == 5 else 0.01 * k for k in range(N)], "it is missing"),
    ],
)
def test_a_rate_overrules_a_clock_and_says_so(tmp_path, times, why):
    runs, notes = clock(written(tmp_path, times), rate_hz=100)
    assert (runs.rate_hz, runs.source, len(runs.seconds)) == (100, "--rate", len(times))
    (told,) = [note for note in notes if "overruled by --rate 100" in note]
    assert why in told


@pytest.mark.parametrize(
    ("step", "unit", "rate"), [(10, "ms", 100), (5000, "us", 200), (5_000_000, "ns", 200)]
)
def test_the_unit_of_a_likely_rate_is_proposed(tmp_path, step, unit, rate):
    path = written(tmp_path, [step * k for k in range(N)], "timestamp")
    assert f"--time 'timestamp:{unit}' ({rate} Hz), or :s where it is" in refusal(path, ["z=x"])


def test_repeats_by_the_command_line(cli, here):
    words = ("--filter", "local-level", "--map", "z=x:m", "--dry-run", "--jobs", 1)
    path = written(here, TWICE)
    code, out, err = cli("fit", path, *words, "--drop-repeats")
    assert code == 0, (out, err)
    assert "8 rows with the time of the row before left out" in err + out


def test_repeats_in_a_recipe():
    entries = LogEntries.of_options({"drop_repeats": True, "from_s": 0.0})
    assert entries.options == ["--drop-repeats", "--from"]
    assert LogEntries.of_options({"drop_repeats": None}).drop_repeats is None


@pytest.mark.parametrize("samples", [100_001, 100_002])
@pytest.mark.parametrize("kind", ["even", "alternating", "random", "mostly even", "one gap"])
def test_usual_step_of_a_long_record_is_the_median(samples, kind):
    draw = np.random.default_rng(3).exponential(size=samples)
    rows = np.arange(samples)
    steps = {
        "even": np.full(samples, 0.01),
        "alternating": np.where(rows % 2, 0.01, 0.02),
        "random": draw,
        "mostly even": np.where(draw < 0.7, 0.01, 0.01 + draw),
        "one gap": np.where(rows == 7, 5.0, 0.01 + 1e-5 * draw),
    }[kind]
    times = np.cumsum(steps)
    found, usual = judged(times), np.median(np.diff(times))
    mean = pytest.approx(np.diff(times).mean(), rel=1e-12)  # a sum in another order
    assert found.step in (usual, mean)
    rows = np.flatnonzero(np.diff(times) > 1.5 * usual)
    assert [row for row, _ in found.gaps] == (rows.tolist() if kind == "one gap" else [])
    assert found.seconds[0] == 0
    assert found.seconds[-1] == times[-1] - times[0]


def test_median_of_many_steps():
    for draw in np.random.default_rng(4).exponential(size=(3, 100_001)):
        for steps in (draw, draw[1:], np.sort(draw), np.round(draw, 1)):
            times = np.cumsum(steps)
            assert Steps(times).median == np.median(np.diff(times))


def test_clock_of_a_long_record_is_that_of_all_its_steps_at_once():
    draw = np.random.default_rng(5)
    steps = 0.01 + 2e-3 * draw.random(200_000)
    gaps = [32_767, 32_768, 65_535, 199_998]  # at the borders of blocks
    steps[gaps] = 0.5
    times = np.cumsum(steps)
    steps = np.diff(times)  # as rounded
    found = judged(times)
    usual = np.delete(steps, rows := np.flatnonzero(steps > 0.1))
    assert [row for row, _ in found.gaps] == rows.tolist() == [k - 1 for k in gaps]
    assert [length for _, length in found.gaps] == steps[rows].tolist()
    assert found.step == np.median(steps)
    assert found.jitter == pytest.approx(np.abs(usual - found.step).max() / found.step, rel=1e-12)
    assert Steps(times).lowest == steps.min()
    assert Steps(times).highest == steps.max()
