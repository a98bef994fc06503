"""Constraints, limits and IPOPT on problems whose optimum, multipliers and limits are known."""

from concurrent.futures import ThreadPoolExecutor

import casadi
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.tuner.helpers import bowl, problem
from tuner.certificate.solution import Status
from tuner.code.casadi import expressions
from tuner.code.refused import NoCounterpartError
from tuner.problem.constraint import Constraint
from tuner.problem.parameters import Bounded, Covariance, Fixed, Limited, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import SOLVERS, Ipopt, make_solver

every_model = pytest.mark.parametrize("model", ["symbolic", "callback"])


def itself(values):
    return values


def design(objective, *constraints, **parameters):
    """A problem that judges its parameters themselves."""
    return Problem("toy", Space.of(**parameters), None, itself, objective, constraints=constraints)


def free(init=1.0):
    return Limited(init, -10.0, 10.0)


def round_bowl(p, _):
    """Lowest at the origin; on x + y >= 1 at (1/2, 1/2)."""
    return 1.0 + p["x"] ** 2 + p["y"] ** 2


def short_of_one(p, _):
    return 1.0 - p["x"] - p["y"]


@every_model
def test_an_active_constraint_has_its_multiplier(model):
    posed = design(round_bowl, Constraint("sum", short_of_one, 0.0), x=free(), y=free(-2.0))
    solution = Ipopt(seed=0, model=model)(posed)
    assert solution.status is Status.CONVERGED
    np.testing.assert_allclose(solution.z, [0.5, 0.5], atol=1e-7)
    # d value / d bound = -1 at value 1.5; the bound is 0, so its excess is absolute.
    assert solution.certificate.multipliers == {"sum": pytest.approx(1 / 1.5, rel=1e-6)}
    # Along (1, -1) / sqrt 2, the only direction left, the Hessian is 2.
    assert solution.certificate.curvatures == (pytest.approx(2 / 1.5, rel=1e-6),)
    assert np.abs(list(solution.certificate.gradient.values())).max() < 1e-7
    assert solution.certificate.starts.agreeing == 4


@every_model
def test_a_curved_constraint_adds_its_curvature(model):
    # Lowest x + 3 on the circle x^2 + y^2 <= 4: at (-2, 0), value 1, multiplier of x^2 + y^2 - 4
    # being 1/4 per unit, 1 per share of the bound; the Lagrangian's curvature along y is 1/2.
    inside = Constraint("circle", lambda p, _: p["x"] ** 2 + p["y"] ** 2, 4.0)
    posed = design(lambda p, _: p["x"] + 3.0, inside, x=free(0.5), y=free(0.5))
    solution = Ipopt(seed=0, model=model)(posed)
    np.testing.assert_allclose(solution.z, [-2.0, 0.0], atol=1e-5)
    assert solution.certificate.multipliers == {"circle": pytest.approx(1.0, rel=1e-6)}
    assert solution.certificate.curvatures == (pytest.approx(0.5, rel=1e-5),)
    assert solution.status is Status.CONVERGED


def test_a_limit_is_no_bound_of_the_search():
    posed = design(round_bowl, x=Limited(3.0, 2.0, 5.0), y=free())
    solution = Ipopt(seed=0)(posed)
    assert solution.status is Status.CONVERGED
    assert solution.certificate.active_bounds == ()
    # value 5, slope 4 at x = 2
    assert solution.certificate.multipliers == {"x >= 2": pytest.approx(0.8, rel=1e-6)}
    # 1 % of 5 over the slope 4; the root of the rise at an end is good to a thousandth.
    assert solution.parameters["x"].interval == pytest.approx((2.0, 2.0125), rel=0, abs=4e-5)
    reach = np.sqrt(0.05)
    assert solution.parameters["y"].interval == pytest.approx((-reach, reach), rel=1e-3)


def test_a_constraint_with_room_does_nothing():
    posed = design(round_bowl, Constraint("sum", short_of_one, 10.0), x=free(), y=free())
    solution = Ipopt(seed=0)(posed)
    np.testing.assert_allclose(solution.z, 0, atol=1e-8)
    assert solution.certificate.multipliers == {"sum": 0.0}
    assert len(solution.certificate.curvatures) == 2


@every_model
def test_constraints_that_nobody_can_keep_are_infeasible(model):
    never = Constraint("never", lambda p, _: p["x"] ** 2, -1.0)
    solution = Ipopt(seed=0, starts=2, model=model)(design(round_bowl, never, x=free(), y=free()))
    assert solution.status is Status.INFEASIBLE
    assert solution.message.startswith("no point was found that satisfies every constraint")


def positive():
    return Positive(1.0, 1e-2, 1e2)


@pytest.mark.parametrize(
    ("objective", "limit"),
    [
        (lambda p, _: 2.0 + 1.0 / p["x"], "towards 2"),
        (lambda p, _: 2.0 + p["x"] ** 0.25, "towards 2"),
    ],
    ids=["at infinity", "at zero"],
)
def test_a_limit_that_no_point_reaches_is_unattained(objective, limit):
    solution = Ipopt(seed=0, starts=2)(design(objective, x=positive()))
    assert solution.status is Status.UNATTAINED
    assert limit in solution.message
    assert "ln x" in solution.message
    assert solution.value > 2.0  # a point that was found, not the limit


def test_no_end_is_worse_than_its_start():
    """Derivatives know nothing of steps: followed alone they lead up the stairs."""

    def stairs(p, _):
        return 1.0 + jnp.sum(p["x"] < jnp.arange(5.0)) + 0.1 * p["x"] + (p["y"] - 2.0) ** 2

    solution = Ipopt(seed=0, starts=1)(design(stairs, x=free(4.5), y=free()))
    assert solution.value <= 2.45
    assert not solution.status.trusted or solution.status is Status.STAIRCASE


def test_an_objective_without_a_floor_is_unbounded():
    solution = Ipopt(seed=0, starts=2)(design(lambda p, _: 30.0 - jnp.log(p["x"]), x=positive()))
    assert solution.status is Status.UNBOUNDED


def test_an_optimum_outside_the_box_is_found():
    objective = lambda p, _: 1.0 + (jnp.log(p["x"]) - 6.0) ** 2  # noqa: E731
    solution = Ipopt(seed=0, starts=2)(design(objective, x=positive()))
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(1.0, abs=1e-9)
    assert "in a box 10 times as wide" in solution.message


@pytest.mark.parametrize("solver", [name for name in SOLVERS if name != "ipopt"])
def test_other_solvers_refuse_constraints(solver):
    posed = design(round_bowl, Constraint("sum", short_of_one, 0.0), x=free(), y=free())
    with pytest.raises(ValueError, match=r"keeps no constraints, and toy has sum: solve it by ipo"):
        make_solver(solver, seed=0, starts=1, storage="")(posed)


def test_a_filter_in_the_problem_needs_the_callback():
    with pytest.raises(ValueError, match="cannot be written symbolically: scan has no counterpart"):
        Ipopt(seed=0, model="symbolic")(problem(bowl))
    with pytest.raises(ValueError, match="model"):
        Ipopt(seed=0, model="symbols")


def test_threads_do_not_disturb_each_other():
    posed = design(round_bowl, Constraint("sum", short_of_one, 0.0), x=free(), y=free(-2.0))
    solvers = [Ipopt(seed=i, starts=2, model="callback") for i in range(4)]
    with ThreadPoolExecutor(4) as pool:
        for solution in pool.map(lambda solver: solver(posed), solvers):
            np.testing.assert_allclose(solution.z, [0.5, 0.5], atol=1e-7)


FUNCTIONS = {
    "matrices": lambda z: jnp.trace(jnp.stack([z, 2 * z]) @ jnp.stack([z, z**3]).T),
    "powers": lambda z: z[0] ** 3 + z[1] ** -2 + jnp.sqrt(z[0]) + z[1] ** z[0],
    "curves": lambda z: jnp.exp(z[0]) + jnp.log(z[1]) + jax.nn.sigmoid(z[0]) + jnp.tanh(z[1]),
    "choices": lambda z: jnp.where(z[0] > z[1], z[0], -z[1]) + jnp.maximum(z[0], 2.0) - abs(z[1]),
    "shapes": lambda z: jnp.concatenate([z[::-1], z[:1]])[None].T.reshape(3).sum() + (-z).sum(),
    "constants": lambda z: (jnp.eye(2) * 3.0 + jnp.arange(2.0)) @ z,
    "branches": lambda z: jnp.where(z > 0.5, z, z**2) / (1 + z),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_symbols_say_the_same_as_jax(name):
    function = FUNCTIONS[name]
    symbols = [casadi.SX.sym("a"), casadi.SX.sym("b")]
    found = casadi.vertcat(*expressions(function, symbols))
    point = np.array([0.3, 1.7])
    here = casadi.Function("f", symbols, [found, casadi.jacobian(found, casadi.vertcat(*symbols))])
    value, slopes = (part.full() for part in here(*point))
    np.testing.assert_allclose(value.ravel(), np.ravel(function(point)), rtol=1e-14)
    expected = np.reshape(jax.jacfwd(function)(jnp.asarray(point)), slopes.shape)
    np.testing.assert_allclose(slopes, expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(
    "function",
    [lambda z: jnp.linalg.inv(jnp.outer(z, z)), lambda z: jax.lax.fori_loop(0, 3, jnp.add, z)],
)
def test_what_casadi_does_not_have_is_named(function):
    with pytest.raises(NoCounterpartError, match="has no counterpart"):
        expressions(function, [casadi.SX.sym("a"), casadi.SX.sym("b")])


@pytest.mark.parametrize(
    ("low", "init", "high"),
    [(0.0, 2.0, 1.0), (1.0, 1.0, 1.0), (0.0, 0.0, np.inf), (0.0, np.nan, 1.0)],
)
def test_limits_have_to_enclose_the_start(low, init, high):
    with pytest.raises(ValueError, match="a limited parameter needs finite low <= init <= high"):
        Limited(init, low, high)


def test_only_positive_parameters_are_widened():
    space = Space.of(
        a=Positive(1.0, 0.5, 2.0),
        b=Bounded(0.5, 0.0, 1.0),
        c=Limited(0.5, 0.0, 1.0),
        d=Fixed(1.0),
        e=Covariance(((1.0,),), 0.1, 10.0),
    )
    wider = dict(space.widened(10.0).parameters)
    assert (wider["a"].low, wider["a"].high) == (0.05, 20.0)
    assert all(wider[name] == dict(space.parameters)[name] for name in "bcde")
    assert space.limited().tolist() == [False, False, True, False]


def test_a_bound_must_be_a_number():
    with pytest.raises(ValueError, match="the bound of variance must be finite, got nan"):
        Constraint("variance", short_of_one, np.nan)
