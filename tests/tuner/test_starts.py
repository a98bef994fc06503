"""Starts that are lost are drawn again, and defaults come from the data."""

import jax.numpy as jnp
import numpy as np
import pytest

import tuner
from benchmarks.units import Scaled, fitted, of_any_unit
from tests.tuner import fit_cases as cases
from tuner import Positive, Problem, Space
from tuner.catalogue import find
from tuner.problem.starts import usable_starts
from tuner.run.fit import pose_on
from tuner.run.searched import Wishes

BOX = Space.of(a=Positive(1e8, 1e-9, 1e9), b=Positive(1.0, 1e-9, 1e9))


def of(objective, space=BOX, **more):
    return Problem("p", space, None, lambda p: p, objective, **more)


def anywhere(p, _):
    return p["a"] + p["b"]


def half(p, _):
    return jnp.where(p["a"] < 1.0, p["a"], jnp.nan)


def nowhere(p, _):
    return p["a"] * jnp.inf


def test_starts_that_count_are_those_of_the_problem():
    problem = of(anywhere, known_starts=(np.array([1.0, 2.0]),))
    found = usable_starts(problem, 5, seed=3)
    assert found.lost == 0
    np.testing.assert_array_equal(found.points, problem.starts(5, seed=3))


def test_lost_ones_are_drawn_again():
    problem = of(half, known_starts=(np.array([-1.0, 2.0]), np.array([1.0, 2.0])))
    found = usable_starts(problem, 12, seed=3)
    assert len(found.points) == 12
    assert all(np.isfinite(problem.value(z)) for z in found.points)
    suggested = problem.starts(12, seed=3)
    assert found.lost == sum(not np.isfinite(problem.value(z)) for z in suggested) > 2
    # What counts of the problem's own stays in front; the same seed gives the same again.
    assert found.points[0] == pytest.approx([-1.0, 2.0])
    np.testing.assert_array_equal(found.points, usable_starts(problem, 12, seed=3).points)
    assert len(np.unique(found.points, axis=0)) == 12
    low, high = problem.space.box()
    assert ((low <= found.points) & (found.points <= high)).all()


def test_where_no_start_counts_there_is_none():
    found = usable_starts(of(nowhere), 3, seed=1)
    assert (found.points.shape, found.lost) == ((0, 2), 3)


def parameters(filter, channels, rate=1.0, units=None, **wishes):
    record = tuner.Record.of(channels, rate_hz=rate, units=units)
    cls = find("tuner.filters", filter)
    posed = pose_on(filter, cls, (record,), Wishes(**wishes))
    return dict(posed.problem.space.parameters)


def of_level(z, **wishes):
    return parameters("local-level", {"z": z}, **wishes)


def test_the_box_holds_what_the_data_say():
    """A walk too quiet to be seen, and a smooth course of 10^7 times its noise."""
    draw = np.random.default_rng(2)
    quiet = np.cumsum(1e-6 * draw.normal(size=3000)) + draw.normal(size=3000)
    q, R = (of_level(quiet)[name] for name in ("q", "R"))
    assert R.low < 1.0 < R.high
    assert q.low < 1e-2 / 3000**2 < q.high  # N samples of noise 1 show a q of about 1/N^2
    t = np.arange(400.0)
    smooth = 1e4 * np.sin(t / 40) + 1e-3 * draw.normal(size=400)
    R = parameters("constant-velocity", {"x": smooth})["R"]
    assert R.low < 1e-6 < R.high


def test_the_default_is_not_moved_by_outliers():
    z = cases.level()["z"]
    wild = z.copy()
    wild[::40] += 1e6
    one, other = (of_level(each)["R"].init for each in (z, wild))
    assert other == pytest.approx(one, rel=0.2)


@pytest.mark.parametrize("z", [np.zeros(50), np.full(50, 3.0), np.repeat([1.0, 2.0], 25)])
def test_a_record_without_noise_has_a_box(z):
    for parameter in of_level(z).values():
        assert 0 < parameter.low < parameter.init < parameter.high < np.inf


def test_wishes_come_first():
    z = cases.level()["z"]
    space = of_level(z, start={"q": 1e13}, bound={"R": (0.5, 2.0)})
    assert (space["q"].init, space["q"].high) == (1e13, 1e13)
    assert (space["R"].low, space["R"].high) == (0.5, 2.0)


def test_what_a_fit_knows_stays_where_the_data_do_not_contradict():
    data = cases.climb(samples=300)
    units = {"acc": "m/s^2", "baro": "m"}

    def posed(factor):
        channels = {"acc": data["acc"], "baro": factor * data["baro"]}
        return parameters("vertical", channels, 50.0, units)

    plain = posed(1.0)
    assert plain["R_baro"].init == 0.1  # typical
    assert plain["q_bias"].low == 1e-12
    wild = posed(1e6)  # noise of 10^5 m or more
    assert wild["R_baro"].init > 1e8
    assert wild["R_baro"].high > 1e9


@pytest.mark.parametrize(
    ("name", "scaled"),
    [
        ("local-level", Scaled(size=1e-9)),
        ("local-level", Scaled(size=1e9)),
        ("constant-velocity", Scaled(size=1e9, clock=1e-9)),
        ("constant-velocity", Scaled(size=1e-9, clock=1e9)),
    ],
)
def test_a_fit_is_the_same_in_any_unit(name, scaled, plain):
    """All filters and more factors: ``python -m benchmarks.units``."""
    other = fitted(name, scaled, starts=2)
    assert set(other) == {"q", "R"}
    assert other == pytest.approx(plain(name), rel=1e-6)


@pytest.fixture(scope="module")
def plain():
    found = {}

    def of(name):
        if name not in found:
            found[name] = fitted(name, Scaled(), starts=2)
        return found[name]

    return of


def test_the_battery_of_units_has_all_filters_of_any_unit():
    assert {"local-level", "constant-velocity", "constant-acceleration", "alpha-beta"} <= {
        *of_any_unit()
    }
