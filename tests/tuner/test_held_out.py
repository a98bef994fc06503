"""Whether what is held out is not seen, and what is said of tuning on it."""

import numpy as np
import pytest
from scipy.signal import lfilter

import tuner
from filters import LocalLevel
from tests.tuner import fit_cases as cases
from tuner.run.blocks import block_mean
from tuner.run.fit import Request as Asked
from tuner.run.fit import plan_fit, pose_on
from tuner.run.sample_terms import Improvement, improvement, sample_terms
from tuner.run.search_space import Wishes
from tuner.run.split import FEW, SHARE, parting


def record(z, **more):
    return tuner.Record.of({"z": z}, rate_hz=1.0, **more)


def posed(*recordings, truth=None):
    records = tuple(record(z, truth=truth) for z in recordings)
    return pose_on("local-level", LocalLevel, records, Wishes())


def solved(case):
    return {
        task.problem.name: task.solver(task.problem)
        for task in plan_fit(case, Asked(starts=1)).tasks
    }


def first_part(case, way=None):
    parted = parting(case.problem, way)
    return None if parted is None else parted.tuned[0]


def numbers(solution):
    return [float(solution.parameters[name].value) for name in ("q", "R")]


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
    fit = tuner.fit("local-level", record(z), starts=1)
    q, R = numbers(solved(posed(z))["local_level_part"])
    y, s = cases.level_loop(z, q, R, 1.0)
    last = int(SHARE * 400)  # row of the last sample that is tuned on; y begins with row 1
    held = fit.judged.held_out
    assert (held.way, held.what) == ("time", f"the last {399 - last} samples")
    assert held.tuned == pytest.approx(cases.deviation(y[last:], s[last:]), rel=1e-9)
    best, _ = cases.tuned_by_hand(
        lambda q, R: cases.level_loop(z[: last + 1], q, R, 1.0), [0.5, 2.0]
    )
    assert [q, R] == pytest.approx(best, rel=1e-3)
    _, there = cases.tuned_by_hand(
        lambda q, R: cases.level_loop(z, q, R, 1.0)[:, last:], [0.5, 2.0]
    )
    assert held.best == pytest.approx(there, rel=1e-5)
    assert held.gap == pytest.approx(held.tuned / there - 1, abs=1e-5)


def test_whole_recordings_are_held_out_from_three_on():
    recordings = [cases.level(seed=30 + i, samples=90)["z"] for i in range(FEW)]
    fit = tuner.fit("local-level", [record(z) for z in recordings], starts=1)
    assert fit.judged.held_out.what == "1 recording"
    q, R = numbers(solved(posed(*recordings))["local_level_part"])
    y, s = cases.level_loop(recordings[-1], q, R, 1.0)
    assert fit.judged.held_out.tuned == pytest.approx(cases.deviation(y, s), rel=1e-9)
    best, _ = cases.tuned_by_hand(
        lambda q, R: np.concatenate(
            [cases.level_loop(z, q, R, 1.0) for z in recordings[:-1]], axis=1
        ),
        [0.5, 2.0],
    )
    assert [q, R] == pytest.approx(best, rel=1e-3)


def test_each_recording_is_left_out_in_turn():
    recordings = [cases.level(seed=50 + i, samples=60 + 10 * i)["z"] for i in range(3)]
    held = tuner.fit(
        "local-level", [record(z) for z in recordings], starts=1, held_out="leave-one-out"
    ).judged.held_out
    assert held.what == "each of 3 recordings in turn"
    for i, row in enumerate(held.recordings):
        rest = [z for j, z in enumerate(recordings) if j != i]
        best, _ = cases.tuned_by_hand(
            lambda q, R, rest=rest: np.concatenate(
                [cases.level_loop(z, q, R, 1.0) for z in rest], axis=1
            ),
            [0.5, 2.0],
        )
        own = cases.level_loop(recordings[i], *best, 1.0)
        _, alone = cases.tuned_by_hand(
            lambda q, R, z=recordings[i]: cases.level_loop(z, q, R, 1.0), [0.5, 2.0]
        )
        assert row.recording == i + 1
        assert row.tuned == pytest.approx(cases.deviation(*own), rel=1e-5)
        assert row.best == pytest.approx(alone, rel=1e-5)
        assert row.best <= row.tuned


def test_two_recordings_are_held_out_by_their_ends():
    recordings = [cases.level(seed=40 + i, samples=100)["z"] for i in range(2)]
    part = first_part(posed(*recordings))
    truth = np.asarray(part.data.truth)[..., 0]
    assert np.isfinite(truth[:71]).all()
    assert np.isnan(truth[71:]).all()


def test_two_recordings_are_parted_where_that_is_asked_for():
    recordings = [cases.level(seed=40 + i, samples=100)["z"] for i in range(2)]
    truth = np.asarray(first_part(posed(*recordings), "recording").data.truth)[..., 0]
    assert np.isfinite(truth[:, 0]).all()
    assert np.isnan(truth[:, 1]).all()


def test_too_little_is_not_parted():
    assert first_part(posed(cases.level(samples=49)["z"])) is None
    gaps = np.where(np.arange(400) % 10 == 0, cases.level()["z"], np.nan)  # 40 measurements
    assert first_part(posed(gaps)) is None
    assert first_part(posed(cases.level(samples=50)["z"])) is not None
    assert first_part(posed(cases.level(samples=49)["z"]), "time") is not None
    assert first_part(posed(cases.level()["z"]), "none") is None


def test_samples_are_counted_where_there_are_some():
    """Of a record whose second half is empty, the first half is parted."""
    z = cases.level()["z"]
    z[200:] = np.nan
    truth = np.asarray(first_part(posed(z)).data.truth)[:, 0]
    assert np.flatnonzero(np.isfinite(truth)).tolist() == list(range(141))


@pytest.mark.parametrize("way", ["recording", "leave-one-out"])
def test_one_recording_is_not_left_out(way):
    with pytest.raises(ValueError, match=f"held_out={way} takes several recordings, and there is"):
        tuner.fit("local-level", record(cases.level()["z"]), held_out=way)


def test_what_is_held_out_needs_samples():
    full, empty = cases.level()["z"], np.full(400, np.nan)
    empty[0] = 1.0  # the filter's start, which does not count
    records = [record(z) for z in (full, full, empty)]
    with pytest.raises(ValueError, match="recording 3 that is held out has no samples that count"):
        tuner.fit("local-level", records, held_out="leave-one-out")
    with pytest.raises(ValueError, match="what is left to tune on has no samples that count"):
        tuner.fit("local-level", [record(empty), record(full)], held_out="recording")


def test_to_hold_out_something_and_nothing_is_refused():
    with pytest.raises(ValueError, match="held_out=time and no hold-out exclude each other"):
        tuner.fit("local-level", record(cases.level()["z"]), hold_out=False, held_out="time")


def test_no_filter_foretells_by_the_last_measurement_or_the_mean():
    draw = np.random.default_rng(3)
    walk, white = cases.level()["z"], draw.standard_normal(400)
    last = int(SHARE * 400)
    for z, name, errors in (
        (walk, "the last measurement", np.diff(walk)),
        (white, "the constant mean", (white - white[1 : last + 1].mean())[1:]),
    ):
        held = tuner.fit("local-level", record(z), starts=1).judged.held_out
        s = np.mean(errors[:last] ** 2)
        assert held.nothing == name
        assert held.unfiltered == pytest.approx(
            cases.deviation(errors[last:], np.full(399 - last, s)), rel=1e-9
        )


def test_no_filter_against_a_truth_is_the_last_measurement():
    level = cases.level(samples=1200)
    z = np.where(np.arange(1200) % 3 == 0, level["z"], np.nan)
    held = tuner.fit(
        "local-level", record(z, truth={"level": level["level"]}), starts=1, fix={"R": 1.0}
    ).judged.held_out
    raw = np.repeat(z[::3], 3)[:1200]
    last = int(SHARE * 1200)
    error = (raw - level["level"])[last + 1 :]
    assert held.nothing == "the last measurement"
    assert held.unfiltered == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert held.over_unfiltered.verdict == "better"


def test_nothing_stands_for_a_filter_of_attitudes():
    imu = cases.imu(seconds=4.0)
    channels = {
        "gyr": np.stack([imu[n] for n in ("gx", "gy", "gz")], axis=1),
        "acc": np.stack([imu[n] for n in ("ax", "ay", "az")], axis=1),
    }
    truth = {"att": np.stack([imu[n] for n in ("q0", "q1", "q2", "q3")], axis=1)}
    fit = tuner.fit("madgwick", tuner.Record.of(channels, rate_hz=50.0, truth=truth), starts=1)
    held = fit.judged.held_out
    assert (held.nothing, held.unfiltered, held.over_unfiltered) == ("", None, None)
    assert held.gain is not None


def test_tuning_that_does_not_help_is_told():
    """It begins at the true noise, which no tuning on 280 samples beats on the others."""
    z = cases.level(seed=5)["z"]
    true = {"q": cases.LEVEL_Q, "R": cases.LEVEL_R}
    fit = tuner.fit("local-level", record(z), starts=1, start=true)
    assert fit.judged.held_out.gain.verdict == "no better"
    assert "tuning does not help here" in fit.summary()
    far = tuner.fit("local-level", record(z), starts=1, start={"q": 10.0, "R": 0.1})
    assert far.judged.held_out.gain.verdict == "better"
    assert "tuning does" not in far.summary()


def test_tuning_that_harms_is_told():
    """The noise is nine times larger in what is tuned on than in what judges."""
    draw = np.random.default_rng(11)
    z = np.where(np.arange(600) < 421, 3.0, 1.0) * draw.standard_normal(600)
    held = tuner.fit(
        "local-level", record(z), starts=1, start={"R": 1.0}, fix={"q": 1e-6}
    ).judged.held_out
    assert held.gain.verdict == "worse"
    assert held.gap > 0.2


def test_a_gain_is_what_both_errors_say():
    """Of errors whose ratio is known the interval holds it, and is as wide as their spread."""
    level = cases.level()
    case = posed(level["z"], truth={"level": level["level"]}).problem
    before = sample_terms(case, {"q": 1.0, "R": 1.0})
    after = sample_terms(case, {"q": 0.1, "R": 1.0})
    found = improvement(case, before, after)
    rms = [np.sqrt(each.added.mean()) for each in (before, after)]
    assert found.share == pytest.approx(1 - rms[1] / rms[0], rel=1e-12)
    assert found.low < found.share < found.high
    assert found.blocks == 24
    same = improvement(case, before, before)
    assert (same.share, same.low, same.high) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("rho", "least"), [(0.0, 0.92), (0.9, 0.88)])
def test_the_mean_of_correlated_numbers_lies_in_its_interval(rho, least):
    """Of 300 records; at 600 samples and rho 0.9 there are 32 independent numbers."""
    draw = np.random.default_rng(5)
    hits = 0
    for _ in range(300):
        x = lfilter([1.0], [1.0, -rho], draw.standard_normal(900))[300:]
        found = block_mean(x, np.ones(600))
        hits += found.low < 0 < found.high
    assert least <= hits / 300 <= 0.98


def test_recordings_that_differ_are_blocks_themselves():
    draw = np.random.default_rng(6)
    x = draw.standard_normal((100, 10)) + draw.standard_normal(10)
    found = block_mean(x, np.ones((100, 10)))
    means = x.mean(axis=0)
    assert found.blocks == 10
    # Student's quantile of nine degrees of freedom.
    assert found.high - found.value == pytest.approx(
        2.262157 * means.std(ddof=1) / np.sqrt(10), rel=1e-6
    )


def test_too_few_samples_tell_nothing():
    found = block_mean(np.ones(3), np.array([0.0, 1.0, 0.0]))
    assert (found.value, found.low, found.high) == (1.0, -np.inf, np.inf)
    assert np.isnan(block_mean(np.zeros(3), np.zeros(3)).value)


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [(0.1, 0.2, "better"), (-0.1, 0.2, "no better"), (-0.2, -0.1, "worse")],
)
def test_verdicts_of_gains(low, high, verdict):
    assert Improvement((low + high) / 2, low, high, 24).verdict == verdict
