"""A problem as a linear model with noise of unknown size, for the rank test and the start."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Lanes, LinearKalman, Timed, Transition, bare
from filters.linear import LinearForm, Measured
from objectives import kind_of
from objectives.in_numpy import in_numpy
from tuner.identifiability.noise import Entry, Matrices, NoModelError, parts_of
from tuner.problem.parameters import Fixed
from tuner.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """x' = F x + push + w, z = H x + v: one recording, whose noise is linear in p numbers.

    Cov w = Q[0] + sum of theta_i Q[i], and cov v likewise, R with deviations sigma on both sides.

    Attributes:
        F: the distinct steps, ``(U, n, n)``.
        Q: ``(U, 1 + p, n, n)``.
        which: of them leads to each sample, ``(N,)``.
        push: by the known input, ``(N, n)``.
        H: ``(m, n)``.
        R: ``(1 + p, m, m)``.
        sigma: ``(N, m)``.
        z: ``(N, m)``; NaN is missing.
    """

    F: np.ndarray
    Q: np.ndarray
    which: np.ndarray
    push: np.ndarray
    H: np.ndarray
    R: np.ndarray
    sigma: np.ndarray
    z: np.ndarray


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """The unknown noise parameters of a problem, and its recordings.

    Attributes:
        entries: the p numbers, in the order of ``NoiseModel.Q``.
        recordings: one model each; of several each ends with its last measurement.
        samples: N of the longest.
    """

    entries: tuple[Entry, ...]
    recordings: tuple[NoiseModel, ...]
    samples: int


@dataclass(frozen=True)
class _Noise:
    """The model of a filter whose parameters are made of values by name."""

    own: Any
    build: Any

    def __call__(
        self,
        free: Mapping[str, Array],
        values: Mapping[str, Array],
        steps: Array | None,
        tables: Matrices | None,
    ) -> Matrices:
        """At free parameters, the others as they are."""
        return _noise_at(self.own, self.build(dict(values) | dict(free)), steps, tables)


def linear_problem(problem: Problem) -> LinearProblem:
    """The noise model behind a problem.

    Raises:
        NoModelError: for filters that are not those of a linear model, free parameters that change
            how the state moves or is measured, and noise that is linear neither in the free
            parameters nor in their squares.
    """
    own, data = bare(problem.filter), problem.data.inputs
    if not isinstance(own, LinearKalman) and not (
        hasattr(own, "linear") and hasattr(own, "measured")
    ):
        raise NoModelError(
            f"{problem.name} has no known linear model: its filter is not a LinearKalman and "
            "has no methods linear and measured"
        )
    timed = _wrapper(problem.filter, Timed) is not None
    dt = np.asarray(data.dt) if timed else None
    inputs = data.inputs if timed else data
    steps = np.unique(dt) if dt is not None else np.ones(1)
    values = problem.parameters(problem.space.start())
    free = {
        name: np.array(values[name], float)
        for name, parameter in problem.space.parameters
        if not isinstance(parameter, Fixed)
    }
    if isinstance(own, LinearKalman) and inputs.transition is not None:
        if _wrapper(problem.filter, Lanes) is not None:
            raise NoModelError(f"{problem.name} has recordings whose samples bring their own steps")
        tables = in_numpy(_of_samples, inputs.transition)
    else:
        tables = None

    known = values, steps if timed else None, tables
    parts = parts_of(_Noise(own, problem.static.build), free, *known)
    recordings = _recordings(problem, parts.matrices, inputs, steps, dt)
    return LinearProblem(parts.entries, recordings, len(jax.tree.leaves(inputs)[0]))


def _wrapper(filter: Any, cls: type[Any]) -> Any:
    """The filter of a class inside wrapped filters; None where there is none."""
    while getattr(filter, "same_params", False):
        if isinstance(filter, cls):
            return filter
        filter = filter.filter
    return None


def _of_samples(transition: Transition) -> Matrices:
    G, B = transition.G, transition.B
    none = jnp.zeros(())
    return Matrices(transition.F, B, G @ transition.Q @ jnp.swapaxes(G, -1, -2), none, none)


def _noise_at(own: Any, params: Any, steps: Array | None, tables: Matrices | None) -> Matrices:
    """The model for parameters, with one step for each distinct sample time."""

    def at(filter: Any) -> LinearForm:
        if isinstance(own, LinearKalman):
            return LinearForm(params.transition, params.H, params.R)
        form: LinearForm = filter.linear(params)
        return form

    form = at(own)
    move = form.transition
    if steps is not None and not isinstance(own, LinearKalman):
        move = jax.vmap(lambda dt: at(replace(own, dt=dt)).transition)(steps)
    else:
        move = jax.tree.map(lambda leaf: leaf[None], move)
    F, B, Q, *_ = tables if tables is not None else _of_samples(move)
    return Matrices(F, B, Q, form.H, jnp.diag(form.R) if form.R.ndim == 1 else form.R)


def _recordings(
    problem: Problem, matrices: Matrices, inputs: Any, steps: np.ndarray, dt: np.ndarray | None
) -> tuple[NoiseModel, ...]:
    """One for each lane, and for each of the signals that pass through the same gains."""
    several = _wrapper(problem.filter, Lanes)
    lanes = None if several is None else several.count
    everything = jax.tree.map(np.asarray, (inputs, problem.data.truth, dt))
    found = []
    for lane in range(lanes or 1):
        inputs_, truth, clock = jax.tree.map(
            lambda leaf, lane=lane: leaf if lanes is None else leaf[:, lane], everything
        )
        measured = _measured(bare(problem.filter), inputs_)
        z = np.array(measured.z, float)
        if kind_of(problem.objective) == "likelihood":
            z = _counted(z, truth)
        which = np.zeros(len(z), int) if clock is None else np.searchsorted(steps, clock)
        if len(matrices.F) > 1 and clock is None:
            which = np.arange(len(z))  # a transition with each sample
        sigma = np.ones(z.shape[:2]) if measured.sigma is None else np.asarray(measured.sigma)
        push = np.zeros((len(z), matrices.F.shape[-1]))
        if measured.u is not None and matrices.B is not None:
            push = np.einsum("tij,tj->ti", matrices.B[which], np.asarray(measured.u))
        F, Q, H, R = matrices.F, matrices.Q, matrices.H, matrices.R
        for signal in [z] if z.ndim == 2 else np.moveaxis(z, 2, 0):
            seen = np.where(sigma > 0, signal, np.nan)
            last = np.flatnonzero(np.isfinite(seen).any(axis=1))[-1:]
            # Recordings side by side are as long as the longest; what fills them up is not kept.
            end = len(seen) if lanes is None else 1 + int(last.sum())
            kept = (np.array(part[:end]) for part in (sigma, seen))
            found.append(NoiseModel(F, Q, which[:end].copy(), push[:end].copy(), H, R, *kept))
    return tuple(found)


def _measured(own: Any, inputs: Any) -> Measured:
    if isinstance(own, LinearKalman):
        return Measured(inputs.z, inputs.u)
    found: Measured = own.measured(inputs)
    return found


def _counted(z: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The measurements with NaN where the truth excludes them."""
    lacking = np.isnan(truth.reshape(truth.shape + (1,) * (z.ndim - truth.ndim)))
    return np.where(lacking, np.nan, z)
