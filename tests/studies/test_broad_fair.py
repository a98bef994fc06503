"""BROAD: the same freedoms for all, held-out trials, and which delay is whose; synthetic trials."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from studies.broad import held_out, no_filter, other_filters
from studies.broad.claims import claims_of
from studies.broad.contestants import LABELS, SPACES, filter_of, has_lead, start, takes_field
from studies.broad.delays import late
from studies.broad.held_out import NO_HELP, Gain
from studies.broad.lead import Ahead
from studies.broad.problems import Case
from tests.studies.test_broad import HZ, inclination_rmse, pair, quick, solution, solved
from tuner.run.comparison import Verdict

__all__ = ["pair", "quick"]  # pytest's fixtures


def lead(value, name="mahony_lead"):
    return start(name) | {"lead": value}


# ---------------------------------------------------------------------------------- the lead


def test_every_filter_has_a_twin_with_a_lead():
    plain = [name for name in LABELS if not has_lead(name)]
    for name in plain:
        twin = "room" if name == "room_now" else f"{name}_lead"
        assert has_lead(twin)
        assert takes_field(twin) == takes_field(name)
        assert SPACES[twin].size == SPACES[name].size + 1
        assert SPACES[twin].coordinates[-1].endswith("lead") or name == "room_now"
        assert {other_filters.room_of(name), other_filters.room_of(twin)} == {"room", "room_now"}


@pytest.mark.parametrize("name", ["mahony", "madgwick", "gravity", "two_step"])
def test_without_any_lead_the_twin_is_the_filter(name, pair):
    twin = f"{name}_lead"
    found = pair.judged(twin, lead(0.0, twin)).inclination
    # a product with a turn of exactly nothing
    np.testing.assert_allclose(found, pair.judged(name, start(name)).inclination, rtol=1e-12)


def test_a_lead_turns_on_at_the_last_rate(pair):
    """By hand: the attitude of each sample times the turn of its rate."""
    after = 0.05
    trial = pair.trials[0]
    filter = filter_of("mahony_lead", HZ)
    assert isinstance(filter, Ahead)
    q = attitudes(pair, trial)
    turned = Rotation.from_quat(q, scalar_first=True) * Rotation.from_rotvec(trial.rate * after)
    expected = inclination_rmse(turned.as_quat(scalar_first=True), trial.truth)
    found = pair.judged("mahony_lead", lead(after)).inclination[0]
    assert found == pytest.approx(expected, rel=1e-9)
    assert found != pytest.approx(pair.judged("mahony", start("mahony")).inclination[0], rel=1e-3)


def attitudes(contest, trial):
    """Mahony's filter on one trial, ``(N, 4)``."""
    import jax.numpy as jnp

    from filters import ImuSample, assembled, run

    filter = filter_of("mahony", HZ)
    samples = ImuSample(jnp.asarray(trial.acceleration), jnp.asarray(trial.rate))
    return np.asarray(run(filter, assembled(filter, start("mahony")), samples)[1])


def test_a_late_sensor_is_made_up_for_by_every_filter(pair):
    """Sensors that tell everything two samples late: a lead of that is better than none.

    The gains are small, so that gyroscopes alone make the error.
    """

    def delayed(values):
        return np.concatenate([values[:1], values[:1], values[:-2]])

    contest = pair.of(
        [
            replace(trial, rate=delayed(trial.rate), acceleration=delayed(trial.acceleration))
            for trial in pair.trials
        ]
    )
    gains = {"mahony_lead": {"Kp": 0.02, "Ki": 0.0}, "madgwick_lead": {"beta": 1e-3}}
    for name, small in gains.items():
        none, right = (
            contest.judged(name, lead(v, name) | small).inclination for v in (0.0, 2 / HZ)
        )
        assert (right < none).all()


# ------------------------------------------------------------------------------------ delays

RATE, SECONDS = 200.0, 40.0
ARM = np.array([0.03, -0.02, 0.05])


def turning(t):
    return Rotation.from_euler(
        "zyx", np.stack([np.sin(1.1 * t), 0.8 * np.sin(1.7 * t + 1), np.cos(2.3 * t)], axis=1)
    )


def way(t):
    return 0.1 * np.stack([np.sin(2 * t), np.cos(2.6 * t), np.sin(1.5 * t + 2)], axis=1)


def moving(pair, *, gyroscopes, accelerometers, matrix=1.0, noise=0.0, seed=0):
    """A trial by formula whose sensors are late, with an arm from markers to accelerometers."""
    t, h = np.arange(0.0, SECONDS, 1 / RATE), 1e-4
    rng = np.random.default_rng(seed)

    def rate(t):
        return (turning(t - h).inv() * turning(t + h)).as_rotvec() / (2 * h)

    def place(t):
        return way(t) + turning(t).apply(ARM)

    def force(t):
        push = (place(t + 10 * h) - 2 * place(t) + place(t - 10 * h)) / (10 * h) ** 2
        return turning(t).inv().apply(push + np.array([0, 0, 9.81]))

    truth = turning(t).as_quat(scalar_first=True)
    truth[::2] *= -1  # the same attitudes
    truth[3000:3050] = np.nan
    return replace(
        pair.trials[0],
        rate=matrix * rate(t - gyroscopes) + 0.02 + noise * rng.standard_normal((len(t), 3)),
        acceleration=matrix * force(t - accelerometers)
        + 0.1
        + 10 * noise * rng.standard_normal((len(t), 3)),
        truth=truth,
        place=way(t) + 1e-5 * rng.standard_normal((len(t), 3)) * (noise > 0),
        rate_hz=RATE,
        field=None,
    )


@pytest.mark.parametrize(("gyroscopes", "accelerometers"), [(4e-3, 2.5e-3), (-1e-3, 3e-3), (0, 0)])
def test_delays_are_found_whatever_scale_and_bias(gyroscopes, accelerometers, pair):
    trial = moving(pair, gyroscopes=gyroscopes, accelerometers=accelerometers, matrix=1.03)
    found = late(trial)
    # the bell and the differences bend rates of 3 rad/s by a hundredth of a millisecond
    assert found.gyroscopes == pytest.approx(gyroscopes, abs=5e-5)
    assert found.accelerometers == pytest.approx(accelerometers, abs=1e-4)


def test_delays_are_found_in_noise(pair):
    trial = moving(pair, gyroscopes=4e-3, accelerometers=2.5e-3, noise=5e-3)
    found = late(trial)
    assert found.gyroscopes == pytest.approx(4e-3, abs=1e-4)
    assert found.accelerometers == pytest.approx(2.5e-3, abs=3e-4)


def test_where_nothing_tells_there_is_no_delay(pair):
    trial = moving(pair, gyroscopes=4e-3, accelerometers=2e-3)
    assert np.isnan(late(replace(trial, place=None)).accelerometers)
    assert late(replace(trial, place=None)).gyroscopes == pytest.approx(4e-3, abs=5e-5)
    gaps = trial.truth.copy()
    gaps[::20] = np.nan
    assert np.isnan(late(replace(trial, truth=gaps))).all()


def rows(case, found, name):
    (said,) = [claim for claim in claims_of(case) if claim.name == name]
    return said.compare(case, found)


def test_what_the_gyroscopes_are_later_is_the_sensors(pair):
    trials = [
        moving(pair, gyroscopes=4e-3, accelerometers=ms / 1e3, seed=i)
        for i, ms in enumerate((2, 3))
    ]
    case = Case(pair.of(trials), [], ("room",))
    (row,) = rows(case, {}, "delay_sensor_ms")
    assert (row.verdict, row.unit) == (Verdict.HOLDS, "ms")
    assert row.ours == pytest.approx(1.5, abs=0.1)
    found = {("room", "x"): solution(lead=4e-3 - 0.5 / RATE)}
    (row,) = rows(case, found, "delay_lead_ms")
    assert (row.verdict, row.ours) == (Verdict.HOLDS, pytest.approx(4.0))
    (row,) = rows(case, {("room", "x"): solution(lead=0.0)}, "delay_lead_ms")
    assert row.verdict is Verdict.FAILS
    blind = Case(pair.of([replace(trial, place=None) for trial in trials]), [], ("room",))
    assert rows(blind, {}, "delay_sensor_ms")[0].verdict is Verdict.NOT_IDENTIFIABLE


# ----------------------------------------------------------------------------------- held out


def test_a_gain_has_students_interval():
    found = Gain.of(np.array([1.0, 2.0, 3.0]))
    # t of 2 degrees of freedom is 4.303, the deviation 1
    assert found == pytest.approx((2.0, 2 - 4.3027 / np.sqrt(3), 2 + 4.3027 / np.sqrt(3)), rel=1e-4)
    assert Gain.of(np.array([1.0])) == (1.0, -np.inf, np.inf)


WORSE = {"place": 5e-3, "accelerometer": 1.0}


@pytest.mark.parametrize(
    ("changed", "verdict", "said"),
    [
        ({}, Verdict.NOT_IDENTIFIABLE, f"{NO_HELP}, as far as 2 trials can tell"),
        (WORSE, None, NO_HELP),
    ],
)
def test_tuning_that_gains_nothing_is_said_to(changed, verdict, said, pair):
    case = Case(pair, range(2), ("room", "room_now"))
    names = [f"{kind}_{t.name}" for t in pair.trials for kind in ("without", "alone")]
    found = {(name, "x"): solution(**changed) for name in names}
    row = held_out.helps(case, found, name="room")
    assert said in row.note
    assert row.verdict is not Verdict.HOLDS
    if verdict:
        assert (row.verdict, row.ours) == (verdict, 0.0)
    else:
        assert row.ours < 0
    assert held_out.gap(case, found).ours == 0.0


def test_the_gap_is_that_to_each_trials_own_optimum(pair):
    case = Case(pair, range(2), ("room", "room_now"))
    found = {(f"alone_{t.name}", "x"): solution() for t in pair.trials}
    found |= {(f"without_{t.name}", "x"): solution(**WORSE) for t in pair.trials}
    row = held_out.gap(case, found)
    errors = [
        pair.judged("room", {k: p.value for k, p in each.parameters.items()}).inclination.mean()
        for each in (solution(**WORSE), solution())
    ]
    assert row.ours == pytest.approx(errors[0] - errors[1], rel=1e-9)
    assert row.verdict is Verdict.FAILS  # worse than untuned


def test_no_filter_at_all(pair):
    """Accelerometers by hand, and gyroscopes summed up by hand, their mean at rest taken off."""
    case = Case(pair, [], ("room", "room_now"))
    gyroscopes, accelerometers = no_filter.gyroscopes(pair), no_filter.accelerometers(pair)
    for i, trial in enumerate(pair.trials):
        seen = ~np.isnan(trial.truth).any(axis=1)
        turns = Rotation.from_quat(trial.truth[seen], scalar_first=True)
        up = turns.apply(trial.acceleration[seen])
        angle = np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2])
        expected = np.degrees(np.sqrt((angle**2).mean()))
        assert accelerometers[i] == pytest.approx(expected, rel=1e-9)
        rate = trial.rate - trial.rate[: np.argmax(seen)].mean(axis=0)
        q = Rotation.align_vectors([[0, 0, 1.0]], trial.acceleration[:1])[0]
        steps = []
        for turn in Rotation.from_rotvec(rate / HZ):
            q = q * turn
            steps.append(q.as_quat(scalar_first=True))
        # Mahony's filter adds q times half the rate and normalises: 1e-3 of a step's square
        assert gyroscopes[i] == pytest.approx(
            inclination_rmse(np.array(steps), trial.truth), rel=0.02
        )
    found = {(name, "x"): solution() for name in solved()}
    for name, errors in (("accelerometers", accelerometers), ("gyroscopes", gyroscopes)):
        (row,) = rows(case, found, f"inclination_{name}_deg")
        assert row.ours == pytest.approx(errors.mean())
