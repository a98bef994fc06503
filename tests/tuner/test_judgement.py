"""What innovations say beside a fit."""

import numpy as np
import pytest

import tuner
from tests.tuner import fit_cases as cases


def test_a_wrong_scale_of_all_variances_is_told():
    """All variances 100 times too large: NIS is 0.01, whatever the data."""
    z = cases.level()["z"]
    best, _ = cases.tuned_by_hand(lambda q, R: cases.level_loop(z, q, R, 1.0), [0.5, 2.0])
    start = dict(zip(("q", "R"), 100 * best, strict=True))
    fit = tuner.fit(
        "local-level",
        tuner.Record.of({"z": z}, rate_hz=1.0),
        start=start,
        starts=1,
        hold_out=False,
    )
    before, now = fit.judged.diagnostics
    # At the likelihood's optimum the NIS is 1 to the search's tolerance.
    assert before.nis == pytest.approx(0.01, rel=1e-3)
    assert before.verdict.startswith("noise variances too large by a factor 100")
    assert now.nis == pytest.approx(1.0, abs=1e-3)
    assert (fit.judged.start, before.numbers) == (
        pytest.approx(cases.deviation(*cases.level_loop(z, *start.values(), 1.0)), rel=1e-9),
        399,
    )


def fitted(z, filter="local-level", **more):
    record = tuner.Record.of({"z": z}, rate_hz=1.0, **more)
    return tuner.fit(filter, record, starts=1, hold_out=False)


def test_what_fails_is_told_in_the_summary():
    z = cases.level()["z"]
    assert "outliers" not in fitted(z).summary()
    z[[50, 150, 250, 350]] += [30.0, -30.0, 30.0, -30.0]
    told = fitted(z).summary().splitlines()[2]
    assert "4 of 399 innovations lie beyond 4 deviations" in told
    assert told.endswith("outliers; fit with --set gate=4, which rejects them")


def test_wrapped_angles_are_told_and_their_outliers_are_not():
    z = np.mod(0.02 * np.arange(400) + 0.05 * cases.level()["z"], 2 * np.pi)
    fit = fitted(z, units={"z": "rad"})
    told = fit.summary().splitlines()[2]
    assert "within the noise of a full turn (6.28319)" in told
    assert "outliers" not in told
    assert fit.judged.diagnostics[1]["outliers"].verdict == "failed"


def test_noise_that_grows_with_the_level_is_told_with_the_column_to_give():
    level = np.linspace(1.0, 20.0, 400)
    z = level + 0.05 * level * np.random.default_rng(3).standard_normal(400)
    found = fitted(z, units={"z": "m"}).judged.diagnostics[1]
    assert "grows with the level" in found["over level"].sentence
    assert "--map sigma=COLUMN" in found["over level"].sentence
    assert " m" in found["over level"].sentence


def test_a_fit_by_its_error_is_diagnosed_as_well():
    columns = cases.level()
    record = tuner.Record.of({"z": columns["z"]}, rate_hz=1.0, truth={"level": columns["level"]})
    fit = tuner.fit("local-level", record, starts=1, hold_out=False)
    assert fit.judged.objective == "rmse"
    before, now = fit.judged.diagnostics
    assert before.numbers == now.numbers == 399
    assert now["size"].verdict in ("passed", "failed")
