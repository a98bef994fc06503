"""One case per way of using a filter; every filter has to pass every check of test_battery.py."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters import (
    AccelerometerFilter,
    AnyFilter,
    ConventionalLoop,
    FixedGainFilter,
    Flow,
    GainCovariance,
    GainedSample,
    Gains,
    GainTable,
    GyroscopeFilter,
    KalmanCovariance,
    LinearKalman,
    LinearModel,
    LoopGains,
    LoopStep,
    Noise,
    RiccatiCovariance,
    Sample,
    StoredGains,
    TableCovariance,
    Transition,
    loop_step,
    riccati_flow,
    transitions,
)

N = 24


@dataclass(frozen=True, eq=False)
class Case:
    """A filter with parameters ``build(point)`` and a record.

    ``measured`` are the measurements, time first; ``inputs`` makes the filter's inputs of them.
    ``holes`` says that a NaN among them is a missing sample. It is False for a filter that takes no
    measurements: ``measured`` is then whatever it takes instead, and no check makes holes in it.
    """

    name: str
    filter: AnyFilter
    build: Callable[[Any], Any]
    point: np.ndarray
    measured: np.ndarray
    inputs: Callable[[Any], Any] = jnp.asarray
    holes: bool = True


def _noise(point):
    R, Q, p = jnp.exp(point)
    return Noise(R=R, Q=Q, P0=p * jnp.ones((2, 2)))


def _gains(point):
    return Gains(*jnp.exp(point))


_RNG = np.random.default_rng(20100907)
_ONE, _TWO = _RNG.normal(size=N), _RNG.normal(size=(N, 2))
_DT = _RNG.choice([0.1, 0.0, 0.25], N)
_A = jnp.array([[0.0, 1.0], [-2.0, -0.4]])
_PUSH = jnp.asarray(_RNG.normal(size=(N, 1)))


def _linear(point, full):
    q, r, p = jnp.exp(point)
    R = r * jnp.array([[1.0, 0.4], [0.4, 0.7]])
    return LinearModel(
        transition=Transition(
            F=jnp.array([[0.9, 0.1], [-0.2, 0.8]]),
            G=jnp.array([[0.5], [1.0]]),
            Q=q * jnp.eye(1),
            B=jnp.array([[0.0], [0.3]]),
        ),
        H=jnp.array([[1.0, 0.0], [0.3, 1.0]]),
        R=R if full else jnp.diag(R),
        P0=p * jnp.ones((2, 2)),
        x0=jnp.array([0.1, -0.2]),
    )


def _three_signals(point):
    return _linear(point, full=False)._replace(x0=jnp.array([[0.1, 0.0, 0.3], [-0.2, 0.0, 0.1]]))


@cache
def _steps():
    return transitions(_A, jnp.eye(2), 0.1 * jnp.eye(2), _DT)


def _varying(z):
    return Sample(jnp.asarray(z), transition=_steps())


def _full(point):
    return _linear(point, full=True)


def _table(point):
    return GainTable(_linear(point, full=False), K=jnp.exp(point[:2, None, None]) * _GAINS[:2])


@cache
def _hamiltonian():
    return riccati_flow(_A, jnp.array([[1.0, 0.3]]), jnp.eye(2), jnp.eye(1), jnp.array(0.1))


def _flow(point):
    """Both densities times s: in that unit P is s times as large."""
    s, p = jnp.exp(point)
    return Flow(_hamiltonian().at[:2, 2:].divide(s).at[2:, :2].multiply(s), p * jnp.ones((2, 2)))


@cache
def _loop_step():
    return loop_step(LoopGains(1.2, 0.8, 0.3), 0.1, k_gh=0.01)


def _loop(point):
    return LoopStep(_loop_step().F * point[0], _loop_step().B * point[1])


def _seen(point):
    """What a filter with given gains makes use of: how the model moves, is seen and starts."""
    model = _linear(point, full=False)
    move = model.transition._replace(F=model.transition.F * jnp.exp(point[0]) / 0.3)
    return model._replace(transition=move, H=model.H * point[1], x0=point[2] * model.x0)


def _gained(z):
    return GainedSample(jnp.asarray(z), _GAINS)


_POINT = np.log([0.3, 2.0, 1.5])
_COUNTED = np.zeros(N)
_GAINS = jnp.asarray(0.3 * np.random.default_rng(1981).normal(size=(N, 2, 2)))

CASES = [
    Case("accelerometer", AccelerometerFilter(0.1), _noise, _POINT, _ONE),
    Case("gyroscope", GyroscopeFilter(0.1), _noise, _POINT, _ONE),
    Case("gyroscope, two signals", GyroscopeFilter(0.1, (2,)), _noise, _POINT, _TWO),
    Case("fixed gains", FixedGainFilter(0.1), _gains, np.log([0.4, 0.7]), _ONE),
    Case(
        "linear, diagonal R, control, three signals",
        LinearKalman(),
        _three_signals,
        _POINT,
        _RNG.normal(size=(N, 2, 3)),
        lambda z: Sample(jnp.asarray(z), u=_PUSH),
    ),
    Case(
        "linear, full R, varying dt",
        LinearKalman(),
        _full,
        _POINT,
        _TWO,
        _varying,
    ),
    Case("covariance", KalmanCovariance(), _full, _POINT, _COUNTED, holes=False),
    Case("covariance, gains", GainCovariance(), _full, _POINT, np.asarray(_GAINS), holes=False),
    Case(
        "covariance, table of gains",
        TableCovariance(),
        _table,
        _POINT,
        _RNG.integers(2, size=N),
        holes=False,
    ),
    Case("covariance, continuous", RiccatiCovariance(), _flow, _POINT[:2], _COUNTED, holes=False),
    Case(
        "conventional loop",
        ConventionalLoop(),
        _loop,
        np.array([1.1, 0.9]),
        _RNG.normal(size=(N, 1)),  # a column, for what is put out is no estimate of it alone
        lambda z: jnp.asarray(z)[:, 0],
    ),
    Case("stored gains", StoredGains(), _seen, _POINT, _TWO, _gained),
]
