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
    FixedGainFilter,
    Gains,
    GyroscopeFilter,
    LinearKalman,
    LinearModel,
    Noise,
    Sample,
    Transition,
    transitions,
)

N = 24


@dataclass(frozen=True, eq=False)
class Case:
    """A filter with parameters ``build(point)`` and a record.

    ``measured`` are the measurements, time first; ``inputs`` makes the filter's inputs of them.
    """

    name: str
    filter: AnyFilter
    build: Callable[[Any], Any]
    point: np.ndarray
    measured: np.ndarray
    inputs: Callable[[Any], Any] = jnp.asarray


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


_POINT = np.log([0.3, 2.0, 1.5])

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
        lambda point: _linear(point, full=True),
        _POINT,
        _TWO,
        _varying,
    ),
]
