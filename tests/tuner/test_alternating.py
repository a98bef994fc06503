"""Thresholds: alternating search, who refuses them, what a certificate says; several records."""

import re

import jax.numpy as jnp
import numpy as np
import pytest

from objectives import Records
from tuner.certificate.solution import Status
from tuner.problem.parameters import Bounded, Covariance, Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import SOLVERS, Alternating, Gradient, Ipopt, NelderMead, make_solver

STEPS = (1.3, 3.0)
"""Where the objective steps in the threshold; from 1 the first simplex reaches 1.65."""


def itself(values):
    return values


def stepped(p, _):
    """Lowest, 1, at a = 1 and b = e with the threshold between the steps; 0.2 more elsewhere.

    Below the first step the best b is another one, so that the two kinds have to take turns; it
    costs 0.09 to keep that b beyond the step, so that the step shows.
    """
    low, within = p["switch"] < STEPS[0], p["switch"] < STEPS[1]
    aim = jnp.where(low, 0.7, 1.0)
    step = jnp.where(low, 0.2, jnp.where(within, 0.0, 0.2))
    return 1.0 + step + jnp.log(p["a"]) ** 2 + (jnp.log(p["b"]) - aim) ** 2


def positive(**given):
    return Positive(2.0, 1e-2, 1e2, **given)


def switch(init=1.0):
    return Positive(init, 0.1, 10.0, threshold=True)


def posed(objective=stepped, **parameters):
    space = Space.of(**(parameters or {"a": positive(), "switch": switch(), "b": positive()}))
    return Problem("toy", space, None, itself, objective)


# -------------------------------------------------------------------------------- alternating


@pytest.mark.parametrize("starts", [1, 4])
def test_alternating_finds_the_piece_and_its_bottom(starts):
    problem = posed()
    solution = Alternating(seed=0, starts=starts)(problem)
    assert solution.status is Status.CONVERGED
    assert solution.solver == "alternating"
    found = {name: float(p.value) for name, p in solution.parameters.items()}
    assert STEPS[0] <= found["switch"] < STEPS[1]
    # a slope of ln value below 1e-8 where the curvature is 2
    assert found["a"] == pytest.approx(1.0, abs=1e-6)
    assert found["b"] == pytest.approx(np.e, rel=1e-6)
    assert solution.value == pytest.approx(1.0, abs=1e-12)
    assert solution.certificate.starts.count == starts
    assert solution.evaluations > 10 * starts


def test_its_certificate_speaks_of_what_is_smooth():
    solution = Alternating(seed=0, starts=1)(posed())
    certificate = solution.certificate
    assert certificate.curvatures == (pytest.approx(2.0, rel=1e-6), pytest.approx(2.0, rel=1e-6))
    assert certificate.flat_directions == ()
    assert certificate.gradient["ln switch"] == 0.0
    # Within a piece the value does not change, beyond it by 0.2: its ends, found by trying.
    assert solution.parameters["switch"].interval == pytest.approx(STEPS, rel=1e-6)
    # 1 % more at (ln a)^2 = 0.01
    assert solution.parameters["a"].interval == pytest.approx(np.exp([-0.1, 0.1]), rel=2e-4)


def test_from_the_far_end_of_the_box_the_first_step_goes_inwards():
    """A simplex that stepped out of the box would be flat."""
    objective = lambda p, _: jnp.where(p["switch"] > 8.0, 2.0, 1.0) + jnp.log(p["a"]) ** 2  # noqa: E731
    solution = Alternating(seed=0, starts=1)(posed(objective, a=positive(), switch=switch(10.0)))
    assert solution.parameters["switch"].value < 8.0
    assert solution.value == pytest.approx(1.0, abs=1e-12)


def test_where_no_threshold_helps_the_first_descent_stays():
    objective = lambda p, _: 1.0 + 0.0 * p["switch"] + jnp.log(p["a"]) ** 2  # noqa: E731
    solution = Alternating(seed=0, starts=1)(posed(objective, a=positive(), switch=switch()))
    assert solution.parameters["switch"].value == pytest.approx(1.0)
    assert solution.parameters["a"].value == pytest.approx(1.0, abs=1e-6)


def test_a_start_that_is_no_number_is_left():
    """Where the objective is not a number the threshold moves on, and the descent begins there."""
    objective = lambda p, _: (  # noqa: E731
        jnp.where(p["switch"] < STEPS[0], jnp.nan, 1.0) + jnp.log(p["a"]) ** 2
    )
    solution = Alternating(seed=0, starts=1)(posed(objective, a=positive(), switch=switch()))
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(1.0, abs=1e-12)


def test_one_kind_alone_is_searched_as_it_can_be():
    smooth = posed(a=positive(), b=positive(), switch=Fixed(0.5))
    found, plain = Alternating(seed=0)(smooth), Gradient("l-bfgs-b", seed=0)(smooth)
    assert found.value == pytest.approx(plain.value, rel=1e-9)
    steps = posed(switch=switch(), a=Fixed(1.0), b=Fixed(1.0))
    assert Alternating(seed=0)(steps).value <= NelderMead(seed=0)(steps).value * (1 + 1e-9)
    with pytest.raises(ValueError, match="alternating needs at least one start, got 0"):
        Alternating(seed=0, starts=0)(posed())


def test_it_is_made_by_name():
    assert "alternating" in SOLVERS
    solver = make_solver("alternating", seed=3, starts=2, storage="")
    assert solver == Alternating(seed=3, starts=2)


# ----------------------------------------------------------------------------- other solvers


@pytest.mark.parametrize(
    ("name", "solver"),
    [
        ("l-bfgs-b", Gradient("l-bfgs-b", seed=0)),
        ("trust-constr", Gradient("trust-constr", seed=0)),
        ("ipopt", Ipopt(seed=0)),
        ("ipopt", Ipopt(seed=0, model="callback")),
    ],
)
def test_gradients_alone_refuse_a_threshold(name, solver):
    sentence = (
        f"{name} follows gradients, and toy is piecewise constant in switch; fix it, or solve by "
        "alternating, nelder-mead, cma-es or tpe"
    )
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        solver(posed())


def test_a_fixed_threshold_is_none():
    fixed = posed(a=positive(), switch=Fixed(2.0), b=positive())
    solution = Gradient("l-bfgs-b", seed=0, starts=1)(fixed)
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(1.0, abs=1e-12)


def test_nelder_mead_takes_a_threshold_and_does_not_call_it_flat():
    solution = NelderMead(seed=0, starts=1)(posed())
    assert solution.status is Status.CONVERGED
    # a simplex of 1e-5 around the bottom
    assert solution.value == pytest.approx(1.0, abs=1e-9)
    assert STEPS[0] <= solution.parameters["switch"].value < STEPS[1]
    assert len(solution.certificate.curvatures) == 2
    assert solution.certificate.flat_directions == ()


def test_what_is_flat_beside_a_threshold_is_still_called_so():
    objective = lambda p, _: 1.0 + jnp.log(p["a"]) ** 2 + 0.0 * p["b"]  # noqa: E731
    solution = NelderMead(seed=0, starts=1)(posed(objective, **dict(posed().space.parameters)))
    (sentence,) = solution.certificate.flat_directions
    assert sentence.endswith("b is not determined")


def test_a_space_knows_its_thresholds():
    space = Space.of(
        a=positive(),
        c=Covariance(((1.0, 0.0), (0.0, 1.0)), 0.1, 10.0),
        switch=switch(),
        d=Bounded(0.5, 0.0, 1.0),
        e=Fixed(1.0),
    )
    assert space.thresholds().tolist() == [False] * 4 + [True, False]
    wider = dict(space.widened(10.0).parameters)["switch"]
    assert (wider.low, wider.high, wider.threshold) == (0.01, 100.0, True)


# --------------------------------------------------------------------------- several records

OUTPUTS = jnp.array([[1.0, 2.0, 4.0], [3.0, 2.0, 8.0]])
TRUTH = jnp.zeros((2, 3))


def mean(outputs, truth):
    return (outputs - truth).mean()


def test_records_are_judged_one_by_one():
    assert Records(mean).each(OUTPUTS, TRUTH).tolist() == [2.0, 2.0, 6.0]


@pytest.mark.parametrize(
    ("objective", "value"),
    [
        (Records(mean), 10 / 3),
        (Records(mean, (1.0, 2.0, 1.0)), (2 + 4 + 6) / 4),
        (Records(mean, (10.0, 20.0, 10.0)), (2 + 4 + 6) / 4),
        (Records(mean, over="worst"), 6.0),
        (Records(mean, (1.0, 5.0, 1.0), over="worst"), 10.0),
    ],
)
def test_records_make_one_number(objective, value):
    # one sum of three
    assert float(objective(OUTPUTS, TRUTH)) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("over", ["mean", "worst"])
def test_every_record_needs_its_weight(over):
    with pytest.raises(ValueError, match="2 weights for 3 records; give one for each"):
        Records(mean, (1.0, 2.0), over)(OUTPUTS, TRUTH)
