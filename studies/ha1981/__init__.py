"""Ha, Kim and Choi 1981: the vertical channel's bias by a conventional loop and a Kalman filter.

Nothing is measured: gains follow from the model. Equation numbers are the paper's;
docs/ha1981.md tells what was found.
"""

import hashlib
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters import (
    ConventionalLoop,
    GainedSample,
    StoredGains,
    loop_step,
)
from studies.ha1981 import conventional, scheme
from studies.ha1981.channel import STATES, Channel, Settings
from studies.ha1981.figures import figures
from studies.ha1981.rows import compare
from tuner.certificate.single_precision import Part, SinglePrecision, single_precision
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.observers.lmi import FastestDecayTask
from tuner.run.study import Plan, Source, Study, Target, Task
from tuner.solvers import Convex, Gradient, Ipopt, NelderMead

LOOP_DT = 0.1
"""How often the loop's single-precision check samples, s."""

LOOP_MEANINGS = {
    "decay": "rate a of the slowest pole",
    "spread": "r of the real pole, -a (1 + r)",
    "damping": "d of the other two poles, (s + a)^2 + d a (s + a) + f a^2",
    "stiffness": "f of the other two poles, as above",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Both schemes designed, and what the paper leaves open settled."""
    channel = Channel.of(settings)
    loop = conventional.fastest_decay(channel)
    stored = scheme.Storage.of(channel, settings.Ts, settings.segments)
    posed = stored.problem()
    return Plan(
        source=_source(channel),
        tasks=(*_conventional_tasks(channel, settings, seed), *_kalman_tasks(channel, posed, seed)),
        targets=(_loop_target(channel, loop), _stored_target(channel, stored, posed)),
        compare=partial(compare, channel, settings),
        figures=partial(figures, channel, settings),
    )


def _source(channel: Channel) -> Source:
    digest = hashlib.sha256(repr(channel).encode()).hexdigest()
    return Source("none: the model alone", digest, 0, 0.0)


def _conventional_tasks(channel: Channel, settings: Settings, seed: int) -> list[Task]:
    loop, closed = conventional.fastest_decay(channel), conventional.closed_form(channel)
    end = scheme.reaches(channel, 5.0)
    gradient = Gradient("l-bfgs-b", seed=seed, starts=2)
    staged = [conventional.staged(channel, end, stages) for stages in (1, 2)]
    return [
        Task(loop, Ipopt(seed=seed, starts=settings.starts), "ipopt"),
        Task(loop, closed, closed.name),
        Task(_one_lyapunov_matrix(channel), Convex("sdp"), "sdp"),
        Task(conventional.least_ise(channel), Ipopt(seed=seed, starts=2), "ipopt"),
        *(Task(problem, gradient, gradient.name) for problem in staged),
    ]


def _one_lyapunov_matrix(channel: Channel) -> FastestDecayTask:
    """The conventional design as a matrix inequality, without altimeter noise as in the paper."""
    bias = np.array([[1.0, 0.0, 0.0]])
    return FastestDecayTask(
        "conventional_lmi", channel.system(0.0), bias, [channel.bound], ("A_B",)
    )


def _kalman_tasks(channel: Channel, stored: Any, seed: int) -> list[Task]:
    steady = scheme.steady(channel, 5.0)
    known = scheme.riccati_gains(channel, 5.0), scheme.printed_gains(channel, 5.0)
    searches = Gradient("l-bfgs-b", seed=seed, starts=1), NelderMead(seed=seed, starts=1)
    return [
        *(Task(steady, solver, solver.name) for solver in (*known, *searches)),
        # Elsewhere than near the mean gains the filter is unstable: more starts find nothing.
        Task(stored, searches[0], searches[0].name),
    ]


def _loop_target(channel: Channel, problem: Any) -> Target:
    return Target(
        problem=problem,
        filter="ConventionalLoop",
        states=STATES,
        dt=0.0,
        quantities=partial(_loop_quantities, channel),
        single=partial(_loop_single, channel),
        meanings=LOOP_MEANINGS,
    )


def _loop_quantities(channel: Channel, solution: Solution) -> tuple[Quantity, ...]:
    gains = conventional.gains_of(solution)
    K1, K2, K3 = (np.array(float(np.asarray(gain))) for gain in gains.loop(channel.k_gh))
    poles = conventional.poles(gains)
    return (
        Quantity("K1", K1, "1/s", "gain on the altitude"),
        Quantity("K2", K2, "1/s^2", "gain on the velocity, Kgh included"),
        Quantity("K3", K3, "1/s^3", "gain on the estimated bias"),
        Quantity("poles_re", poles.real.copy(), "1/s", "real parts of the error's poles"),
        Quantity("poles_im", poles.imag.copy(), "1/s", "imaginary parts of the error's poles"),
    )


def _loop_single(channel: Channel, solution: Solution) -> tuple[SinglePrecision, ...]:
    at = np.arange(0, 5 / channel.eta, LOOP_DT)
    step = loop_step(conventional.gains_of(solution).loop(channel.k_gh), LOOP_DT, channel.k_gh)
    bias, z = _altitude(channel, at)
    check = single_precision("loop", Part(ConventionalLoop(), 0), step, z, scale=bias)
    return (check,)


def _altitude(channel: Channel, at: np.ndarray) -> tuple[float, np.ndarray]:
    """A bias of one standard deviation, and the altitude that it leads to when uncorrected."""
    bias, w = np.sqrt(channel.sigma2_ab), np.sqrt(channel.k_gh)
    return bias, bias * ((np.cosh(w * at) - 1) / channel.k_gh if w else at**2 / 2)


def _stored_target(channel: Channel, storage: scheme.Storage, problem: Any) -> Target:
    return Target(
        problem=problem,
        filter="StoredGains",
        states=STATES,
        dt=storage.Ts,
        quantities=partial(_stored_quantities, channel, storage),
        single=partial(_stored_single, channel, storage),
        meanings={
            f"K{i + 1}_{s}": f"{gain} of the stored gains' row {s}"
            for s in range(1, len(storage.means))
            for i, gain in enumerate(("on the bias", "on the velocity", "on the altitude"))
        },
    )


def _stored_quantities(
    channel: Channel, storage: scheme.Storage, solution: Solution
) -> tuple[Quantity, ...]:
    steady = scheme.steady_gains(channel, storage.Ts)
    move = channel.model(storage.Ts).transition
    history = np.asarray(storage.optimal.K)[:, :, 0]
    units = "1/s^2, 1/s, 1"
    return (
        Quantity("Phi", np.asarray(move.F), "", "transition over one sample"),
        Quantity("Q", np.asarray(move.Q), "", "covariance of the noise in one sample"),
        Quantity("gains", _table(storage, solution), units, "a row for each stored gain"),
        Quantity("edges", np.array(storage.edges, float), "", "first sample of each stored gain"),
        Quantity("history", history, units, "the Kalman filter's gain of every sample"),
        Quantity("K2inf", np.array(steady[0]), "1/s", "steady gain on the velocity"),
        Quantity("K3inf", np.array(steady[1]), "", "steady gain on the altitude"),
    )


def _table(storage: scheme.Storage, solution: Solution) -> np.ndarray:
    values = {name: jnp.asarray(p.value) for name, p in solution.parameters.items()}
    return np.asarray(storage.table(values))[:, :, 0]


def _stored_single(
    channel: Channel, storage: scheme.Storage, solution: Solution
) -> tuple[SinglePrecision, ...]:
    gains = _table(storage, solution)[storage.which][:, :, None]
    bias, z = _altitude(channel, np.arange(len(gains)) * storage.Ts)
    inputs = GainedSample(jnp.asarray(z)[:, None], jnp.asarray(gains))
    model = channel.model(storage.Ts)
    check = single_precision("stored gains", Part(StoredGains(), 0), model, inputs, scale=bias)
    return (check,)


STUDY = Study(
    name="ha1981",
    title="Bias of an INS vertical channel: gains of a conventional loop and a Kalman filter",
    paper="I. J. Ha, Y. K. Kim and K. K. Choi, Kalman Filter Method and the Conventional Method "
    "for the Bias Error Reduction of INS Vertical Channel, 1981",
    settings=Settings,
    channels={},
    plan=plan,
)
