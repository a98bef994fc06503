"""By which powers a filter's parameters scale all of its variances, found by evaluation."""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import run
from filters.declared import bare, channel_facts
from tuner.problem.problem import Problem
from tuner.problem.programs import Static
from tuner.run.sample_terms import run_with

SAME = 1e-9
"""Estimates that differ by less than this share of their own size are unchanged."""
LARGEST = 3.0
"""Powers beyond this are no variance's, nor that of its square."""
SAMPLES = 5000
"""Of so many samples the powers are taken; the trial is on all."""


class Seen(NamedTuple):
    """The outputs of a filter: its estimates, each over its own size, and ln of its variances."""

    estimates: np.ndarray
    variances: np.ndarray


def variance_powers(
    problem: Problem, values: Mapping[str, Any], held: Collection[str] = ()
) -> dict[str, float]:
    """The power of one common factor by which each parameter scales all variances, by name.

    1 of a variance or a density, 1/2 of a deviation. With them every gain, and so every estimate
    and innovation, stays as it is. Found of the outputs' derivatives; :func:`check_powers` tries
    them.

    Args:
        problem: its filter outputs ``innovation`` and ``variance``.
        values: its parameters, by name.
        held: those that are no part of it.

    Raises:
        ValueError: where no powers leave the estimates as they are.
    """
    free = {name: np.asarray(value) for name, value in values.items() if name not in held}
    names = [name for name, value in free.items() if _may_scale(value)]
    if not names:
        raise ValueError("every parameter is fixed")
    found = _halves(*_slopes(problem, values, names))
    return {name: float(power) for name, power in zip(names, found, strict=True) if power}


def _may_scale(value: np.ndarray) -> bool:
    """Whether it may be a variance or a deviation: no number, or none of its diagonal, below 0."""
    square = value.ndim == 2 and value.shape[0] == value.shape[1]
    numbers = np.diagonal(value) if square else value
    return bool((numbers >= 0).all() and (numbers > 0).any())


def scaled_values(
    values: Mapping[str, Any], by: Mapping[str, float], factor: float
) -> dict[str, Any]:
    """Parameters with all variances multiplied by a factor.

    >>> scaled_values({"R": 2.0, "sigma": 3.0, "tau": 1.0}, {"R": 1.0, "sigma": 0.5}, 4.0)
    {'R': 8.0, 'sigma': 6.0, 'tau': 1.0}
    """
    return {
        name: value * factor ** by[name] if name in by else value for name, value in values.items()
    }


def _slopes(problem: Problem, values: Mapping[str, Any], names: list[str]) -> Seen:
    """How the outputs move with the logarithm of each parameter, exactly, ``(.., n)`` each."""
    known = {name: jnp.asarray(value, float) for name, value in values.items()}
    outputs = run_with(problem, values)
    rows = np.arange(len(outputs.innovation))
    if len(rows) > SAMPLES:
        rows = np.linspace(0, len(rows) - 1, SAMPLES).astype(int)
    inputs, columns = problem.data.inputs, []
    for name in names:
        along = {n: value * (n == name) for n, value in known.items()}
        moved = _slope(problem.static, known, along, inputs)
        columns.append(_flat(problem, outputs, moved, rows))
    return Seen(*(np.stack(each, axis=1) for each in zip(*columns, strict=True)))


@jax.jit(static_argnums=0)
def _slope(static: Static, values: dict[str, Array], along: dict[str, Array], inputs: Any) -> Any:
    """The derivative of all outputs along a change of the parameters."""

    filter = static.filter
    assert filter is not None  # whose outputs have been looked at

    def outputs(at: dict[str, Array]) -> Any:
        return run(filter, static.build(at), inputs)[1]

    return jax.jvp(outputs, (values,), (along,))[1]


def _flat(problem: Problem, outputs: Any, moved: Any, rows: np.ndarray) -> Seen:
    """The quantities that move: estimates over their own size, and logarithms of variances."""
    pairs = zip(_kept(problem, outputs), _kept(problem, moved), strict=True)
    estimates = [(np.asarray(d)[rows] / _size(y)).ravel() for y, d in pairs]
    s = np.asarray(outputs.variance)[rows]
    change = np.asarray(moved.variance)[rows][s > 0] / s[s > 0]
    return Seen(np.nan_to_num(np.concatenate(estimates)), change)


def _kept(problem: Problem, outputs: Any) -> list[np.ndarray]:
    leaves = jax.tree.leaves([*_estimates(problem, outputs), outputs.innovation])
    return [np.asarray(leaf, float) for leaf in leaves]


def _size(array: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(array**2))) or 1.0


def _estimates(problem: Problem, outputs: Any) -> list[Any]:
    """The quantities that have to stay: outputs that are no detail; without facts, all but P."""
    own = bare(problem.filter)
    if hasattr(own, "outputs") and hasattr(own, "params"):
        facts = channel_facts(own, "outputs")
        return [getattr(outputs, name) for name, fact in facts.items() if fact.kind != "detail"]
    return [outputs._asdict()[name] for name in outputs._fields if name not in ("P", "variance")]


def _halves(J: np.ndarray, D: np.ndarray) -> np.ndarray:
    """Powers, halves all, that move no estimate and every variance alike."""
    both = np.concatenate([J, D])
    wanted = np.concatenate([np.zeros(len(J)), np.ones(len(D))])
    # A parameter may hardly be seen and belong to the noise all the same: derivatives are exact.
    sizes = np.linalg.norm(both, axis=0)
    sizes = np.where(sizes > 0, sizes, 1.0)
    along = np.linalg.lstsq(both / sizes, wanted, rcond=1e-10)[0] / sizes
    if not (np.abs(along) < LARGEST).all():
        raise ValueError("no common factor of its noise leaves the estimates unchanged")
    found: np.ndarray = np.round(2 * along) / 2
    return found


def check_powers(
    problem: Problem, values: Mapping[str, Any], by: Mapping[str, float], factor: float
) -> None:
    """Scale by a factor, and see whether the estimates stay and the variances follow.

    Raises:
        ValueError: where they do not.
    """
    before, after = run_with(problem, values), run_with(problem, scaled_values(values, by, factor))
    pairs = zip(_kept(problem, before), _kept(problem, after), strict=True)
    apart = max(float(np.nanmax(np.abs(a - b), initial=0.0)) / _size(a) for a, b in pairs)
    if not apart <= SAME:
        raise ValueError(
            f"with {', '.join(by) or 'no parameter'} scaled by {factor:.3g} the estimates move by "
            f"{apart:.1g} of their size: the filter has noise of its own, or a gate"
        )
    s, larger = np.asarray(before.variance), np.asarray(after.variance)
    if not np.allclose(larger, factor * s, rtol=SAME, atol=0.0):
        raise ValueError(f"the variances of the innovations do not follow {', '.join(by)}")
