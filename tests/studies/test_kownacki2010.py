"""The Kownacki study, end to end: the rows, the numbers of the notes, and logs of one's own."""

import json
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from filters import AccelerometerFilter, KownackiNoise, run
from studies.kownacki2010 import plan, problems
from studies.kownacki2010.data import benches, synthetic
from studies.kownacki2010.paper import ACC, GYRO
from studies.kownacki2010.settings import Settings
from tuner.cli import invoke
from tuner.export import FORMATS
from tuner.run.comparison import Verdict
from tuner.run.study import find_study
from tuner.solvers import Gradient, NelderMead

REQUIRED = (
    "q_over_r",
    "k1",
    "bandwidth_hz",
    "R",
    "Q",
    "cost_at_paper_over_optimum",
    "q_over_r_literal",
    "table1_R",
    "table1_Q",
    "nelder_mead_linear_evaluations",
)


@pytest.fixture(scope="module")
def rows():
    """The comparison on the built-in record of full size, with one start of one method."""
    tested = benches(Settings(), None, seed=0)
    solutions = {}
    for bench in tested:
        for problem in (problems.problem(bench), problems.paper(bench)):
            solutions[problem.name, "l-bfgs-b"] = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
        literal = problems.literal(bench)
        solutions[literal.name, "nelder-mead"] = NelderMead(seed=0, starts=1)(literal)
    return {row.quantity: row for row in plan(Settings(), None, 0, "").compare(solutions)}


def test_all_required_rows_are_there(rows):
    assert {f"{s}.{row}" for s in ("gyro", "acc") for row in REQUIRED} <= set(rows)


def test_gyroscope_matches_table_2(rows):
    for name in ("q_over_r", "k1", "bandwidth_hz", "cost_at_paper_over_optimum"):
        assert rows[f"gyro.{name}"].verdict is Verdict.MATCH, name


def test_accelerometer_differs_by_the_size_that_the_notes_report(rows):
    """Notes: 82 against 22.95, x3.6, on white noise; a realisation moves it by a tenth."""
    row = rows["acc.q_over_r"]
    assert row.verdict is Verdict.DIFFERS
    assert row.ours / row.paper == pytest.approx(3.6, rel=0.1)
    assert "harmonics" in row.note


@pytest.mark.parametrize("name", ["gyro.R", "gyro.Q", "acc.R", "acc.Q"])
def test_single_values_are_not_identifiable(rows, name):
    assert rows[name].verdict is Verdict.NOT_IDENTIFIABLE
    assert "only Q/R is determined" in rows[name].note


def test_literal_reading_is_far_away(rows):
    """Notes: 2.3e8 and 1.5e6; a realisation moves the flat optimum by some ten per cent."""
    assert rows["gyro.q_over_r_literal"].ours == pytest.approx(2.3e8, rel=0.3)
    assert rows["acc.q_over_r_literal"].ours == pytest.approx(1.5e6, rel=0.3)


@pytest.mark.parametrize("sensor", ["gyro", "acc"])
def test_fminsearch_stops_after_three_evaluations_at_table_1(rows, sensor):
    row = rows[f"{sensor}.nelder_mead_linear_evaluations"]
    assert row.ours == 3
    assert row.verdict is Verdict.FAILS


def test_record_has_table_1s_variance_and_depends_on_the_seed_alone():
    for sensor in (GYRO, ACC):
        record = synthetic(sensor, Settings(), seed=3)
        assert len(record) == 100_001
        # The variance of 1e5 samples scatters by 0.45 %.
        assert record.var() == pytest.approx(sensor.table1.R, rel=0.02)
        assert np.array_equal(record, synthetic(sensor, Settings(), seed=3))
        assert not np.array_equal(record, synthetic(sensor, Settings(), seed=4))


def test_table_1_is_too_slow():
    """Notes: the accelerometer's noise-free answer has come to .1001 of .2 after 5 s."""
    step = jnp.where(jnp.arange(100_001) >= 50_000, 0.2, 0.0)
    _, output = run(AccelerometerFilter(dt=1e-4), KownackiNoise.of(*ACC.table1), step)
    assert float(output[-1]) == pytest.approx(0.1001, abs=5e-5)


def static_log(path: Path) -> Path:
    """A gyroscope at rest, 100 Hz: white noise on a wandering bias."""
    draw = np.random.default_rng(8)
    rate = 0.3 * draw.standard_normal(3000) + 0.002 * np.cumsum(draw.standard_normal(3000))
    np.savez(path, gyr=np.stack([rate, 2 * rate, 3 * rate], axis=1), fs=np.array(100.0))
    return path


QUICK = ("--set", "starts=1", "--set", "solvers=l-bfgs-b", "--set", "grid=3")
FORMS = ("csv", "png")


def test_own_log_is_tuned_and_exported(tmp_path, capsys):
    log = static_log(tmp_path / "rest.npz")
    out = tmp_path / "run"
    words = ["run", "kownacki2010", "--log", str(log), "--map", "omega=gyr[0]:deg/s", "--json"]
    assert invoke([*words, "--out", str(out), *QUICK]) == 0
    captured = capsys.readouterr()
    result = json.loads(captured.out)
    assert next(iter(result)) == "schema"
    assert result["log"]["rate_hz"] == 100.0
    assert "3000 samples" in captured.err
    # A user's run is the user's: one problem a sensor, no row and no mark of the paper.
    assert [s["problem"] for s in result["solutions"]] == ["gyro"]
    assert result["comparisons"] == []
    figures = {name for name in result["artifacts"] if name.startswith("figures/")}
    drawn = [f"figures/{stem}_gyro.{form}" for stem in ("step", "tradeoff") for form in FORMS]
    assert figures == set(drawn)
    assert all("Table" not in (out / name).read_text() for name in figures if ".csv" in name)
    assert {e["format"] for e in result["exports"]} == {*FORMATS}
    # The exports are exact; only the way through ln Q rounds.
    assert all(abs(e["relative_change"]) < 1e-12 for e in result["exports"])
    assert all((out / name).is_file() for name in result["artifacts"])
    for file in out.rglob("*"):
        assert file.is_dir() or str(tmp_path).encode() not in file.read_bytes(), file


def test_study_is_found_by_its_entry_point():
    assert find_study("kownacki2010").channels(Settings()).keys() == {"omega", "a"}


REAL = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "static_adis16405_100hz"


@pytest.mark.skipif(not REAL.is_dir(), reason="the recording of an ADIS16405 is not here")
def test_real_gyroscope_is_read_and_planned(tmp_path, capsys):
    log = REAL / "adis_16405_imu1.npz"
    out = tmp_path / "run"
    words = ["run", "kownacki2010", "--log", str(log), "--map", "omega=gyr_degs[0]*gyr_lsb:deg/s"]
    assert invoke([*words, "--dry-run", "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert "1000000 samples" in captured.err
    assert "would solve gyro" in captured.out
    assert not out.exists()
