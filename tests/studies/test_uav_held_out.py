"""What tuning is worth on flights that were not tuned on: synthetic flights, by formula."""

from dataclasses import replace
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from studies.uav import held_out, prediction, six_axes
from studies.uav.flights import Whole, cut, flight
from studies.uav.held_out import NO_HELP, claims_held_out, unfiltered
from studies.uav.joint import joint
from studies.uav.judging import Field, Interval
from studies.uav.prediction import predicted
from studies.uav.problems import problem, start_values
from studies.uav.recordings import GRAVITY
from studies.uav.settings import ANGLES
from tests.studies.test_uav import (
    TICKS,
    flown,
    glitched,
    only,
    planned,
    quick,
    written,
)
from tuner.run.comparison import Verdict

__all__ = ["flown", "quick"]  # pytest's fixtures
SETTINGS = {"ticks_per_second": TICKS, "tuned": "one"}


def named(whole, name):
    return replace(whole, source=replace(whole.source, name=name))


# ------------------------------------------------------------------------- tuned on several


def value(posed, **values):
    z = posed.space.unconstrain(start_values("constant", ANGLES) | values)
    return posed.value(z)


def test_flights_in_turn_count_as_they_do_alone(flown):
    """Twice the same flight has the value of one; two have one between theirs."""
    short = cut(flown, 8.0)
    other = replace(named(short, "other"), rate=short.rate + 0.05)
    alone = value(problem(short, "constant", ANGLES))
    # sums in another order
    assert value(joint("j", [short], "constant", ANGLES)) == pytest.approx(alone, rel=1e-12)
    assert value(joint("j", [short, short], "constant", ANGLES)) == pytest.approx(alone, rel=1e-12)
    longer = joint("j", [short], "constant", ANGLES, ticks=len(short.t) + 50)
    assert value(longer) == pytest.approx(alone, rel=1e-12)
    assert len(longer.data.truth) == len(short.t) + 50
    both = value(joint("j", [short, other], "constant", ANGLES))
    turned_round = value(joint("j", [other, short], "constant", ANGLES))
    assert both == pytest.approx(turned_round, rel=1e-12)
    theirs = value(problem(other, "constant", ANGLES))
    assert min(alone, theirs) < both < max(alone, theirs)


def test_a_joint_problem_has_the_slope_of_its_value(flown):
    posed = joint("j", [cut(flown, 8.0), cut(flown, 8.0)], "constant", ANGLES)
    z = posed.space.start()
    found, step = posed.value_and_gradient(z)[1], 1e-5
    for i, e in enumerate(step * np.eye(len(z))):
        slope = (posed.value(z + e) - posed.value(z - e)) / (2 * step)
        assert found[i] == pytest.approx(slope, rel=1e-5, abs=1e-9)


def test_what_the_gps_measured_in_a_glitch_does_not_count(flown):
    half = cut(flown, 8.0)
    doubtful = replace(half, glitch=half.t > half.t[0] + 4.0)
    clean = replace(half, z=np.where(doubtful.glitch[:, None], np.nan, half.z))
    found, expected = (
        value(joint("j", [doubtful], "constant", ANGLES)),
        value(problem(clean, "constant", ANGLES)),
    )
    assert found == pytest.approx(expected, rel=1e-12)
    with pytest.raises(ValueError, match=r"^no measurement of one lies outside its glitch\Z"):
        joint("j", [replace(half, glitch=half.t > 0)], "constant", ANGLES)
    with pytest.raises(ValueError, match=r"^j has no flight to tune on; give at least one\Z"):
        joint("j", [], "constant", ANGLES)


def test_each_flight_is_left_out_where_there_are_others(tmp_path):
    for name in ("one", "two"):
        written(tmp_path, name)
    written(tmp_path, "bad", GPS=glitched())
    made = planned(tmp_path, judged=("two", "bad"), **SETTINGS)
    names = [task.problem.name for task in made.tasks]
    assert names == [
        *("constant", "fuzzy", "without_one", "without_two", "without_bad"),
        *("alone_two", "alone_bad"),
    ]
    tuned_on = {t.problem.name: t.problem.source.name for t in made.tasks if t.problem.source}
    assert tuned_on["without_one"] == "two"  # the one with a glitch is not tuned on
    assert tuned_on["without_bad"] == "2 flights"
    wanted = made.only(["uav.tuning_gain.others.two"])
    assert [task.problem.name for task in wanted.tasks] == names[2:5]
    none = planned(tmp_path, judged=("two",), left_out="never", **SETTINGS)
    assert [task.problem.name for task in none.tasks] == ["constant", "fuzzy"]


def test_leaving_out_the_only_flight_is_refused(tmp_path):
    written(tmp_path, "one")
    assert len(planned(tmp_path, judged=(), **SETTINGS).tasks) == 2
    sentence = r"^left_out needs another flight without a glitch beside one, and none .*=never\Z"
    with pytest.raises(ValueError, match=sentence):
        planned(tmp_path, judged=(), left_out="always", **SETTINGS)


# --------------------------------------------------------------------------------- the rows


def solution(**values):
    values = start_values("constant", ANGLES) | {k: jnp.asarray(v) for k, v in values.items()}
    parameters = {name: SimpleNamespace(value=value) for name, value in values.items()}
    status = SimpleNamespace(trusted=True)
    return SimpleNamespace(value=1.0, status=status, parameters=parameters)


GOOD = {f"R_{angle}": 3e-5 for angle in ANGLES}
"""Constructed attitudes of exact data err by half a degree."""
COARSE = {f"R_{angle}": 0.01 for angle in ANGLES}
"""Of attitudes with 0.1 rad of noise."""


def rows(field, found):
    each = (row for said in claims_held_out(field) for row in said.compare(field, found))
    return {row.quantity: row for row in each}


@pytest.fixture(scope="module")
def field(flown):
    pair = (flown, named(flown, "two"))
    return Field(*pair[:1], pair[1:], ANGLES, pair)


def table(field, without, alone):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prediction, "MOST", 64)
        return rows(
            field,
            {
                ("constant", "x"): solution(**GOOD),
                ("alone_two", "x"): solution(**alone),
                ("without_one", "x"): solution(**without),
                ("without_two", "x"): solution(**without),
            },
        )


def test_tuning_that_helps_is_said_to(field):
    found = table(field, GOOD, GOOD)
    names = {f"uav.tuning_gain.{how}" for how in ("one.two", "others.one", "others.two")}
    assert names < set(found)
    for name in names:
        assert found[name].verdict is Verdict.HOLDS
        assert NO_HELP not in found[name].note
    assert found["uav.tuning_gap.two"].verdict is Verdict.HOLDS
    assert found["uav.tuning_gap.two"].ours == pytest.approx(0.0, abs=1e-12)
    assert {"uav.tuning_gain_m.one.two", "uav.filter_gain_m.others.one"} < set(found)


def test_tuning_that_harms_is_said_to(flown):
    """Numbers that are far too sure of attitudes with noise."""
    noise = 0.1 * np.random.default_rng(0).standard_normal(flown.z.shape)
    rough = replace(flown, z=flown.z + noise)
    pair = (rough, named(rough, "two"))
    found = table(Field(rough, pair[1:], ANGLES, pair), GOOD, COARSE)
    row = found["uav.tuning_gain.others.two"]
    assert row.verdict is Verdict.FAILS
    assert row.ours < 0
    assert f"{NO_HELP}: it harms" in row.note
    assert found["uav.tuning_gap.two"].verdict is Verdict.FAILS


@pytest.mark.parametrize(
    ("found", "verdict", "sentence"),
    [
        ((0.2, 0.1, 0.3), Verdict.HOLDS, ""),
        ((-0.2, -0.3, -0.1), Verdict.FAILS, "nothing helps: it harms"),
        ((0.1, -0.1, 0.3), Verdict.NOT_IDENTIFIABLE, "nothing helps, as far as this flight"),
        ((np.nan, -np.inf, np.inf), Verdict.NOT_IDENTIFIABLE, "nothing helps, as far as"),
    ],
)
def test_a_gain_has_the_verdict_of_its_interval(found, verdict, sentence):
    row = held_out._gain("q", "w", Interval(*found), "n", "nothing helps")
    assert row.verdict is verdict
    assert sentence in row.note
    assert bool(sentence) == ("nothing helps" in row.note)


def test_without_a_filter_each_constructed_attitude_is_believed(flown, monkeypatch):
    monkeypatch.setattr(prediction, "MOST", 64)
    found = unfiltered(flown)
    at = np.flatnonzero(~np.isnan(flown.z).any(axis=1))
    turned = Rotation.from_quat(found.x[at, :4], scalar_first=True)
    np.testing.assert_allclose(turned.as_euler("ZYX")[:, ::-1], flown.z[at], atol=1e-12)
    # exact sensors carry a constructed attitude, half a degree off, well over 4 s
    assert predicted(flown, found).horizontal[:, 2].mean() < 1.0


# ------------------------------------------------------------------------------- six axes


def test_the_density_of_a_motion_is_that_of_its_deviation_and_correlation_time():
    rng, dt, memory, size = np.random.default_rng(1), 0.1, 2.0, 3.0
    share = np.exp(-dt / memory)
    noise = size * np.sqrt(1 - share**2) * rng.standard_normal((200_000, 2))
    motion = np.zeros_like(noise)
    for k in range(1, len(noise)):
        motion[k] = share * motion[k - 1] + noise[k]
    # 10,000 correlation times
    assert six_axes.root_density(motion, dt) == pytest.approx(size * np.sqrt(2 * memory), rel=0.05)
    motion[::7] = np.nan
    assert six_axes.root_density(motion, dt) == pytest.approx(size * np.sqrt(2 * memory), rel=0.05)
    with pytest.raises(ValueError, match=r"^a motion.s density takes 2 samples or more, not 1"):
        six_axes.root_density(motion[:2], dt)


def test_six_axes_are_judged_in_the_flights_axes(flown):
    """A vehicle that stands tilted, and one whose pilot says something else."""
    tilt = np.array([0.3, -0.2, 1.0])
    down = Rotation.from_euler("ZYX", tilt[::-1]).inv().apply([0.0, 0.0, 1.0])
    n = 40
    whole = Whole(np.tile(-9.81 * down, (n, 1)), np.zeros((n, 3)), np.tile(tilt, (n, 1)), None)
    use = six_axes.uses(flown)["bounded_room"]
    assert six_axes.inclination(use, whole).max() < 0.1
    off = whole._replace(reference=np.tile(tilt * [0, 1, 1], (n, 1)))
    angle = np.degrees(np.arccos(np.cos(0.3) * np.cos(0.2) ** 2 + np.sin(0.2) ** 2))
    np.testing.assert_allclose(six_axes.inclination(use, off), angle, atol=0.1)


def test_rows_of_six_axes(tmp_path):
    found = flight(only(written(tmp_path)), 1 / TICKS, 3.0, GRAVITY)
    assert len(found.whole.rate) > len(found.t)
    np.testing.assert_array_equal(found.whole.rate[-len(found.t) :], found.rate)
    short = cut(found, 20.0)
    np.testing.assert_array_equal(short.whole.rate[-len(short.t) :], short.rate)
    noises = six_axes.motion_noises(found)
    assert noises["speed"] > 5  # 12 m/s on a circle of 0.12 rad/s
    dumb = named(replace(found, whole=found.whole._replace(reference=None)), "dumb")
    table = {row.quantity: row for row in six_axes.rows(Field(found, (dumb,), ANGLES), {})}
    assert len(table) == 6
    assert table["uav.six_axes_deg.bounded_room.dumb"].verdict is Verdict.NOT_IDENTIFIABLE
    flown_by = table["uav.six_axes_deg.bounded_flown.one"]
    room, mahony = (table[f"uav.six_axes_deg.{n}.one"] for n in ("bounded_room", "mahony"))
    assert flown_by.ours < min(room.ours, mahony.ours)
    assert flown_by.verdict is Verdict.HOLDS
