"""Whether consistency says what it says."""

import numpy as np
import pytest

import tuner
from tests.tuner import fit_cases as cases
from tuner.run.judged import Consistency, lag_one


@pytest.mark.parametrize(
    ("nis", "verdict"),
    [
        (1.0, "consistent"),
        (0.8, "noise variances too large by a factor 1.25"),
        (4.0, "noise variances too small by a factor 4"),
        (0.0, "nothing that is not foretold: too little noise to judge by"),
        (float("nan"), "nothing that is not foretold: too little noise to judge by"),
    ],
)
def test_verdicts(nis, verdict):
    assert Consistency(nis, 0.9, 1.1, 0.0, 100).verdict == verdict


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
    before, now = fit.judged.consistency
    # At the likelihood's optimum the NIS is 1 to the search's tolerance.
    assert before.nis == pytest.approx(0.01, rel=1e-3)
    assert before.verdict.startswith("noise variances too large by a factor 100")
    assert now.nis == pytest.approx(1.0, abs=1e-3)
    assert (fit.judged.start, before.numbers) == (
        pytest.approx(cases.deviation(*cases.level_loop(z, *start.values(), 1.0)), rel=1e-9),
        399,
    )


def test_lag_one_of_white_and_of_like_numbers():
    white = np.random.default_rng(2).standard_normal((4000, 2))
    assert abs(lag_one(white)) < 4 / np.sqrt(8000)  # four of its deviations
    like = np.cumsum(white, axis=0)
    assert lag_one(like) > 0.99
    assert np.isnan(lag_one(np.full((5, 1), np.nan)))
    # Several measurements are not joined: the last of one and the first of the next are no pair.
    two = np.stack([[1.0, 1.0], [-1.0, -1.0]], axis=1)
    assert lag_one(two) == pytest.approx(1.0)
