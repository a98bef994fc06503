"""Whether a rescaling leaves the estimates, and says so where it cannot."""

from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

import tuner
from filters import (
    Channel,
    LinearKalman,
    LinearModel,
    LocalLevel,
    Param,
    Sample,
    Transition,
    Vertical,
    run,
)
from objectives import ChannelRmse, Data, InnovationLikelihood
from tests.tuner import fit_cases as cases
from tuner.problem.parameters import Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.fit import pose_on
from tuner.run.result import read_result
from tuner.run.search_space import Wishes
from tuner.run.variance_powers import check_powers, variance_powers
from tuner.run.variance_scaling import nees_of, scale_variances
from tuner.solvers.gradient import Gradient

LEVEL = cases.level()


def tuned(fix=None):
    record = tuner.Record.of({"z": LEVEL["z"]}, rate_hz=1.0, truth={"level": LEVEL["level"]})
    return tuner.fit("local-level", record, starts=2, fix=fix, hold_out=False)


def test_a_fit_for_accuracy_has_the_noise_of_its_record():
    """The error tells q / R; the innovations tell the rest, as the likelihood would."""
    fit = tuned()
    q, R = (float(fit.solution.parameters[name].value) for name in ("q", "R"))
    y, s = cases.level_loop(LEVEL["z"], q, R, 1.0)
    assert np.mean(y**2 / s) == pytest.approx(1.0, rel=1e-9)
    found = fit.judged.rescaled
    assert found.powers == {"q": 1.0, "R": 1.0}
    before = cases.level_loop(LEVEL["z"], q / found.factor, R / found.factor, 1.0)
    assert before[0] == pytest.approx(y, rel=1e-9)
    assert found.nis == pytest.approx((np.mean(before[0] ** 2 / before[1]), 1.0), rel=1e-9)
    assert "scaled together by" in fit.summary()
    assert fit.posed.problem.value(fit.solution.z) == pytest.approx(fit.solution.value, rel=1e-9)


def test_what_is_held_is_not_scaled():
    fit = tuned(fix={"R": 2.0})
    found = fit.judged.rescaled
    assert float(fit.solution.parameters["R"].value) == 2.0
    assert (found.factor, found.powers, found.nis[0]) == (1.0, {}, found.nis[1])
    assert found.reason == f"R is held; q, R scaled together by {found.nis[0]:.3g} would make it 1"
    assert found.reason in fit.summary()


class Noise(NamedTuple):
    q: Annotated[Array, Param("m^2/s", "density", 0.1, 1e-6, 1e3)]


class Outputs(NamedTuple):
    level: Annotated[Array, Channel("m", "level")]
    innovation: Annotated[Array, Channel("m", "innovation", (), "detail")]
    variance: Annotated[Array, Channel("m^2", "of it", (), "detail")]


@dataclass(frozen=True)
class Stubborn:
    """A random walk whose measurements have the variance 1, whatever is said of it."""

    dt: float
    params, inputs, outputs = Noise, {"z": Channel("m", "measured")}, Outputs

    def init(self, params):
        return jnp.zeros(()), 100.0 * jnp.ones(())

    def step(self, params, state, inputs):
        x, p = state[0], state[1] + params.q * self.dt
        y, s = inputs - x, p + 1.0
        x, p = x + p / s * y, p / s
        return (x, p), Outputs(x, y[None], s[None])


def test_a_filter_with_noise_of_its_own_is_not_scaled():
    record = tuner.Record.of({"z": LEVEL["z"]}, rate_hz=1.0, truth={"level": LEVEL["level"]})
    fit = tuner.fit(Stubborn, record, starts=1, hold_out=False)
    found = fit.judged.rescaled
    assert "the estimates move by" in found.reason
    assert found.factor == 1.0
    assert "variances not scaled" in fit.summary()


def test_a_gate_that_would_decide_otherwise_is_not_scaled():
    """Of outliers of 30 a gate of 4 deviations of about 1 refuses all, and of about 10 none."""
    z = LEVEL["z"] + 30.0 * (np.arange(400) % 37 == 5)
    record = tuner.Record.of({"z": z}, rate_hz=1.0, truth={"level": LEVEL["level"]})
    wishes = Wishes(options={"gate": 4.0})
    problem = pose_on("local-level", LocalLevel, (record,), wishes).problem
    values = {"q": np.array(0.1), "R": np.array(1.0)}
    by = variance_powers(problem, values)
    assert by == {"q": 1.0, "R": 1.0}
    check_powers(problem, values, by, 1.5)
    with pytest.raises(ValueError, match="noise of its own, or a gate"):
        check_powers(problem, values, by, 100.0)


def test_no_noise_tells_no_factor():
    record = tuner.Record.of({"z": np.ones(60)}, rate_hz=1.0, truth={"level": np.full(60, 1.1)})
    problem = pose_on("local-level", LocalLevel, (record,), Wishes()).problem
    solution = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
    same, found = scale_variances(problem, solution)
    assert same is solution
    assert (found.factor, found.reason) == (1.0, "no factor makes it 1")


def test_variances_and_deviations_are_told_apart():
    """By evaluation: those of the start, whose name and unit are not looked at, as well."""
    climb = cases.climb()
    truth = {"height": np.cumsum(np.cumsum(climb["acc"] - 0.3) * 0.05) * 0.05}
    record = tuner.Record.of(
        {"acc": climb["acc"], "baro": climb["baro"]}, rate_hz=20.0, truth=truth
    )
    problem = pose_on("vertical", Vertical, (record,), Wishes()).problem
    assert variance_powers(problem, problem.parameters(problem.space.start())) == {
        **{"q_acc": 1.0, "q_bias": 1.0, "R_baro": 1.0},
        **{"climb0": 0.5, "bias0": 0.5},
    }


def model(values):
    transition = Transition(jnp.array([[1.0, 1.0], [0.0, 1.0]]), jnp.eye(2), values["Q"])
    return LinearModel(
        transition, jnp.eye(1, 2), values["R"][None], values["P0"] * jnp.eye(2), jnp.zeros(2)
    )


def test_matrices_are_scaled_and_the_nees_is_told():
    draw = np.random.default_rng(2)
    velocity = np.cumsum(0.3 * draw.standard_normal(200))
    x = np.stack([np.cumsum(velocity), velocity], axis=1)
    z = x[:, :1] + 2.0 * draw.standard_normal((200, 1))
    Q = ((0.5, -0.1), (-0.1, 9.0))
    problem = Problem(
        name="track",
        space=Space.of(
            Q=Fixed(Q, nominal=True),
            R=Positive(1.0, 1e-3, 1e6),
            P0=Fixed(100.0, nominal=True),
        ),
        filter=LinearKalman(),
        build=model,
        objective=ChannelRmse("x", parts=2),
        data=Data(Sample(z), x),
    )
    solution = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
    scaled, found = scale_variances(problem, solution)
    assert found.powers == {"Q": 1.0, "R": 1.0, "P0": 1.0}
    assert scaled.parameters["Q"].value == pytest.approx(found.factor * np.array(Q), rel=1e-12)
    before, after = problem.outputs(solution), problem.outputs(scaled)
    assert np.asarray(after.x) == pytest.approx(np.asarray(before.x), rel=1e-9)
    assert np.asarray(after.P) == pytest.approx(found.factor * np.asarray(before.P), rel=1e-9)
    y, s = np.asarray(after.innovation), np.asarray(after.variance)
    assert np.mean(y**2 / s) == pytest.approx(1.0, rel=1e-9)
    nees = []
    for out in (before, after):
        pairs = zip(np.asarray(out.x) - x, np.asarray(out.P), strict=True)
        nees.append(np.mean([e @ np.linalg.inv(P) @ e / 2 for e, P in pairs]))
    assert found.nees == pytest.approx(nees, rel=1e-9)


def test_the_nees_is_of_what_has_a_truth():
    outputs = run(
        LinearKalman(),
        model({"Q": jnp.eye(2), "R": jnp.ones(()), "P0": jnp.ones(())}),
        Sample(np.ones((5, 1))),
    )[1]
    truth = np.stack([np.arange(5.0), np.full(5, np.nan)], axis=1)
    problem = Problem(
        name="track",
        space=Space.of(
            Q=Fixed(((1.0, 0.0), (0.0, 1.0))), R=Positive(1.0, 0.1, 10.0), P0=Fixed(1.0)
        ),
        filter=LinearKalman(),
        build=model,
        objective=ChannelRmse("x", parts=2),
        data=Data(Sample(np.ones((5, 1))), truth),
    )
    e = np.asarray(outputs.x)[:, 0] - np.arange(5.0)
    expected = np.mean(e**2 / np.asarray(outputs.P)[:, 0, 0])
    values = problem.parameters(problem.space.start())
    assert nees_of(problem, values) == pytest.approx(expected, rel=1e-12)
    blind = replace(
        problem, objective=InnovationLikelihood(), data=Data(Sample(np.ones((5, 1))), np.zeros(5))
    )
    assert nees_of(blind, values) is None


def test_a_run_exports_what_was_rescaled(cli, here):
    """With values that the facts suggest, of the start, among what is scaled."""
    climb = cases.climb(samples=300)
    climb["h"] = np.cumsum(np.cumsum(climb["acc"] - 0.3) * 0.05) * 0.05
    cases.write(here / "climb.csv", climb)
    words = ("--map", "acc=acc", "--map", "baro=baro", "--truth", "height=h", "--starts", 1)
    options = ("--no-hold-out", "--bound", "q_bias=1e-8..1e-4", "--out", "free")
    cli("fit", "climb.csv", "--filter", "vertical", *words, *options)
    result = read_result(here / "free")
    found, factor = result.fit.rescaled, result.solutions[0].derived["variances_scaled_by"]
    assert found.powers["climb0"] == 0.5
    assert result.solutions[0].parameters["climb0"].value == pytest.approx(factor**0.5, rel=1e-12)
    assert found.nis == pytest.approx((factor, 1.0), rel=1e-9)
    for written in result.exports:
        assert abs(written.relative_change) < 1e-6


def test_what_the_error_leaves_open_and_the_innovations_settle_is_not_called_open():
    draw = np.random.default_rng(1)
    level = np.cumsum(0.1 * draw.standard_normal(600))
    z = level + 2.0 * draw.standard_normal(600)
    record = tuner.Record.of({"z": z}, rate_hz=10.0, truth={"level": level})
    lines = tuner.fit("local-level", record, starts=2, hold_out=False).summary().splitlines()
    assert "not determined" not in lines[0]
    assert lines[3].endswith(
        "only R/q is determined by the error, and the common factor by the innovations (NIS 1)"
    )
    held = tuner.fit("local-level", record, fix={"R": 2.0}, starts=1, hold_out=False)
    assert "NIS 1)" not in held.summary()
