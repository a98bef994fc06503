"""The exports, and their deviation in single precision."""

from dataclasses import replace
from functools import partial

import jax.numpy as jnp
import numpy as np

from filters import (
    ConventionalLoop,
    GainedSample,
    GainTable,
    StoredGains,
    loop_step,
)
from objectives.in_numpy import in_numpy
from studies.ha1981 import scheme
from studies.ha1981.channel import Channel, Gains
from studies.ha1981.conventional import Loop, poles
from tuner.export.tuned import Quantity
from tuner.problem.exported import Exported, Trial, Weighed, exported_of

LOOP_DT = 0.1
"""Sample time of the loop's test, s."""
BIAS = (1.0, 0.0, 0.0)
"""The state that both schemes estimate."""


def loop(channel: Channel) -> Exported:
    """The conventional loop: its gains and the error's poles."""
    return replace(
        exported_of(ConventionalLoop()),
        derived=partial(_loop_quantities, channel),
        runs=partial(_loop_runs, channel),
    )


def _gains(params: Loop) -> Gains:
    return Gains(float(params.K1), float(params.K2p), float(params.K3))


def _loop_quantities(channel: Channel, params: Loop) -> tuple[Quantity, ...]:
    gains = _gains(params)
    K1, K2, K3 = (np.array(gain) for gain in gains.loop(channel.k_gh))
    found = poles(gains)
    return (
        Quantity("K1", K1, "1/s", "gain on the altitude"),
        Quantity("K2", K2, "1/s^2", "gain on the velocity, Kgh included"),
        Quantity("K3", K3, "1/s^3", "gain on the estimated bias"),
        Quantity("poles_re", found.real.copy(), "1/s", "real parts of the error's poles"),
        Quantity("poles_im", found.imag.copy(), "1/s", "imaginary parts of the error's poles"),
    )


def _loop_runs(channel: Channel, params: Loop) -> dict[str, Trial]:
    at = np.arange(0, 5 / channel.eta, LOOP_DT)
    gains = _gains(params).loop(channel.k_gh)
    step = in_numpy(loop_step, gains, LOOP_DT, channel.k_gh)
    return {
        "loop": Trial(Weighed(ConventionalLoop(), BIAS), step, _uncorrected_altitude(channel, at))
    }


def _uncorrected_altitude(channel: Channel, at: np.ndarray) -> np.ndarray:
    """The altitude that a bias of one standard deviation leads to when uncorrected."""
    bias, w = np.sqrt(channel.sigma2_ab), np.sqrt(channel.k_gh)
    shape = (np.cosh(w * at) - 1) / channel.k_gh if w else at**2 / 2
    return np.asarray(bias * shape)


def stored_gains(channel: Channel, storage: scheme.Storage) -> Exported:
    """The filter with stored gains: its model, its gains, and the Kalman filter's."""
    return Exported(
        "StoredGains",
        tuple(ConventionalLoop.states),
        storage.Ts,
        partial(_stored_quantities, channel, storage),
        runs=partial(_stored_runs, channel, storage),
    )


def _stored_quantities(
    channel: Channel, storage: scheme.Storage, params: GainTable
) -> tuple[Quantity, ...]:
    K2, K3 = scheme.steady_gains(channel, storage.Ts)
    move, units = params.model.transition, "1/s^2, 1/s, 1"
    gains, history = (np.asarray(K)[:, :, 0] for K in (params.K, storage.optimal.K))
    return (
        Quantity("Phi", np.asarray(move.F), "", "transition over one sample"),
        Quantity("Q", np.asarray(move.Q), "", "covariance of the noise in one sample"),
        Quantity("gains", gains, units, "a row for each stored gain"),
        Quantity("edges", np.array(storage.edges, float), "", "first sample of each stored gain"),
        Quantity("history", history, units, "the Kalman filter's gain of every sample"),
        Quantity("K2inf", np.array(K2), "1/s", "steady gain on the velocity"),
        Quantity("K3inf", np.array(K3), "", "steady gain on the altitude"),
    )


def _stored_runs(channel: Channel, storage: scheme.Storage, params: GainTable) -> dict[str, Trial]:
    gains = np.asarray(params.K)[storage.which]
    z = _uncorrected_altitude(channel, np.arange(len(gains)) * storage.Ts)
    inputs = GainedSample(jnp.asarray(z[:, None]), jnp.asarray(gains))
    return {"stored gains": Trial(Weighed(StoredGains(), BIAS), params.model, inputs)}
