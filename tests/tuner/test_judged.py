"""What innovations say beside a fit."""

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
