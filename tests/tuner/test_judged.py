"""Whether what is held out is held out, and what innovations say beside it."""

import numpy as np
import pytest

import tuner
from filters import LocalLevel
from tests.tuner import fit_cases as cases
from tuner.run.fit import Request as Asked
from tuner.run.fit import plan_fit, pose_on
from tuner.run.judged import FEW, SHARE, first_part
from tuner.run.searched import Wishes


def posed(*recordings, truth=None):
    records = [tuner.Record.of({"z": z}, rate_hz=1.0, truth=truth) for z in recordings]
    return pose_on("local-level", LocalLevel, tuple(records), Wishes())


def solved(case):
    return {
        task.problem.name: task.solver(task.problem)
        for task in plan_fit(case, Asked(starts=1)).tasks
    }


def test_the_held_out_part_is_not_seen():
    """Changing it changes the fit, and not the fit on the rest, to the bit."""
    z = cases.level()["z"]
    other = z.copy()
    begins = int(SHARE * 400) + 1
    other[begins:] = other[begins:] + 5 * np.random.default_rng(1).standard_normal(400 - begins)
    one, two = solved(posed(z)), solved(posed(other))
    # The start and the box come from all of the data's own scale, so they are set alike.
    found = [s["local_level_part"].parameters["R"].value for s in (one, two)]
    assert found[0] == pytest.approx(found[1], rel=1e-5)
    assert one["local_level"].parameters["R"].value < 0.7 * two["local_level"].parameters["R"].value


def test_the_held_out_part_judges():
    z = cases.level()["z"]
    fit = tuner.fit("local-level", tuner.Record.of({"z": z}, rate_hz=1.0), starts=1)
    part = solved(posed(z))["local_level_part"]
    q, R = (float(part.parameters[name].value) for name in ("q", "R"))
    y, s = cases.level_loop(z, q, R, 1.0)
    last = int(SHARE * 400)  # row of the last sample that is tuned on; y begins with row 1
    assert fit.judged.held_out.what == f"the last {399 - last} samples"
    assert fit.judged.held_out.tuned == pytest.approx(cases.deviation(y[last:], s[last:]), rel=1e-9)
    best, _ = cases.tuned_by_hand(
        lambda q, R: cases.level_loop(z[: last + 1], q, R, 1.0), [0.5, 2.0]
    )
    assert [q, R] == pytest.approx(best, rel=1e-3)


def test_whole_recordings_are_held_out_from_three_on():
    recordings = [cases.level(seed=30 + i, samples=90)["z"] for i in range(FEW)]
    fit = tuner.fit(
        "local-level", [tuner.Record.of({"z": z}, rate_hz=1.0) for z in recordings], starts=1
    )
    assert fit.judged.held_out.what == "1 recording"
    part = solved(posed(*recordings))["local_level_part"]
    q, R = (float(part.parameters[name].value) for name in ("q", "R"))
    y, s = cases.level_loop(recordings[-1], q, R, 1.0)
    assert fit.judged.held_out.tuned == pytest.approx(cases.deviation(y, s), rel=1e-9)
    best, _ = cases.tuned_by_hand(
        lambda q, R: np.concatenate(
            [cases.level_loop(z, q, R, 1.0) for z in recordings[:-1]], axis=1
        ),
        [0.5, 2.0],
    )
    assert [q, R] == pytest.approx(best, rel=1e-3)


def test_two_recordings_are_held_out_by_their_ends():
    recordings = [cases.level(seed=40 + i, samples=100)["z"] for i in range(2)]
    part = first_part(posed(*recordings))
    truth = np.asarray(part.data.truth)[..., 0]
    assert np.isfinite(truth[:71]).all()
    assert np.isnan(truth[71:]).all()


def test_too_little_is_not_parted():
    assert first_part(posed(cases.level(samples=49)["z"])) is None
    gaps = np.where(np.arange(400) % 10 == 0, cases.level()["z"], np.nan)  # 40 measurements
    assert first_part(posed(gaps)) is None
    assert first_part(posed(cases.level(samples=50)["z"])) is not None


def test_samples_are_counted_where_there_are_some():
    """Of a record whose second half is empty, the first half is parted."""
    z = cases.level()["z"]
    z[200:] = np.nan
    truth = np.asarray(first_part(posed(z)).data.truth)[:, 0]
    assert np.flatnonzero(np.isfinite(truth)).tolist() == list(range(141))


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
