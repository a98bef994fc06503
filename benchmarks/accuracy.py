"""Digits, where P0 has rank one and R is 1e-12."""

import jax
import numpy as np

from benchmarks.baseline import Baseline
from benchmarks.loops import exact
from benchmarks.peers import PEERS, Prepare, statsmodels_default
from benchmarks.table import Row
from benchmarks.timing import Call
from benchmarks.work import DT, STEP, Work, linear_model
from filters import GyroscopeFilter, KownackiNoise, LinearKalman, Sample, run

PART = "Largest error at R = 1e-12, as a share of the step"
SMALL_R = 1e-12
SMALL_Q = 1027.47 * SMALL_R
OURS = ("gyroscope filter", "generic LinearKalman")
_WHY = (
    "a general covariance does not keep its rank of one exactly, in Joseph's form no more than in "
    "the peers'; the gyroscope filter carries the determinant and loses nothing"
)


def rows(work: Work, limit: Baseline | None) -> list[Row]:
    """Ours, C's and the peers' error against a loop that carries 40 digits."""
    expected = exact(work.signal, SMALL_R, SMALL_Q, DT)
    found = [_row(name, call, expected) for name, call in _ours(work).items()]
    if limit is not None:
        c = lambda: limit.forward(work.signal, SMALL_R, SMALL_Q)  # noqa: E731
        found.append(_row("C", c, expected))
    peers = {name: prepare for name, (prepare, _) in PEERS.items()}
    peers["statsmodels as it comes"] = statsmodels_default
    return found + [_peer(name, prepare, work, expected) for name, prepare in peers.items()]


def _ours(work: Work) -> dict[str, Call]:
    noise, model = KownackiNoise.of(SMALL_R, SMALL_Q), linear_model(SMALL_R, SMALL_Q)
    gyroscope = jax.jit(lambda z: run(GyroscopeFilter(DT), noise, z)[1])
    generic = jax.jit(lambda z: run(LinearKalman(), model, Sample(z[:, None]))[1].x[:, 0])
    calls = (lambda: gyroscope(work.signal)), (lambda: generic(work.signal))
    return dict(zip(OURS, calls, strict=True))


def _peer(name: str, prepare: Prepare, work: Work, expected: np.ndarray) -> Row:
    try:
        return _row(name, prepare(work.signal, SMALL_R, SMALL_Q), expected)
    except ImportError as error:
        return Row(PART, name, note=f"not installed ({error.name})")


def _row(name: str, call: Call, expected: np.ndarray) -> Row:
    error = float(np.abs(np.asarray(call()) - expected).max() / STEP)
    target = 1e-9 if name in OURS else None
    return Row(PART, name, figure=error, unit="", target=target, why=_WHY)
