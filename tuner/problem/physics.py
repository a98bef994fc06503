"""Checks of data and covariances that hold for every filter, before anything is compiled."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import AnyFilter, bare
from filters.declared import optional, parameter_facts
from objectives.in_numpy import Method, in_numpy

_STRAY = float(1 / np.sqrt(np.finfo(float).eps))
"""The square of a number larger by this factor leaves no digit of the others' squares."""
_TOP = 100
"""One in this many numbers may be an outlier."""
_ROUNDING = 1e-9
_COVARIANCES = ("R", "Q", "P0")
_WORDS = ("variance", "covariance", "spectral density")


def check_data(name: str, data: Any) -> None:
    """Refuse samples that no filter can take, and those of unequal number.

    Args:
        name: of the problem.
        data: inputs and truth, time first.

    Raises:
        ValueError: one sentence.
    """
    for path, leaf in jax.tree_util.tree_leaves_with_path(data):
        check_leaf(f"data{jax.tree_util.keystr(path)}", np.asarray(leaf))
    lengths = {np.shape(leaf)[0] for leaf in jax.tree.leaves(data) if np.ndim(leaf)}
    if len(lengths) > 1:
        raise ValueError(f"the data of {name} has unequal lengths {sorted(lengths)}")


def check_leaf(where: str, leaf: np.ndarray) -> None:
    """Refuse samples that are not float64, infinite ones, and impossible outliers.

    Args:
        where: the place in the data, for the sentence.
        leaf: the samples, time first.

    Raises:
        ValueError: one sentence, with the way out.
    """
    if leaf.dtype.kind not in "biuf":
        kind = {"c": "complex"}.get(leaf.dtype.kind, str(leaf.dtype))
        raise ValueError(
            f"{where} is {kind}, and samples are real numbers; give np.asarray(x, float)"
        )
    if leaf.dtype.kind != "f":
        return
    if leaf.dtype != np.float64:
        raise ValueError(
            f"{where} is {leaf.dtype}, in which slow gains may be wrong by their own size; "
            "convert it to float64 with np.asarray(x, float)"
        )
    if np.isinf(leaf).any():
        first = np.argwhere(np.isinf(leaf))[0]
        raise ValueError(f"{where} is infinite at {tuple(map(int, first))}; use NaN if missing")
    _check_outliers(where, leaf)


def _check_outliers(where: str, leaf: np.ndarray) -> None:
    """Refuse a number whose square is so large that those of all others are rounded away."""
    size = np.abs(leaf[np.isfinite(leaf) & (leaf != 0)])
    if len(size) < 2 or size.max() <= _STRAY * size.min():
        return
    count = min(len(size), len(size) // _TOP + 2)
    top = np.sort(np.partition(size, len(size) - count)[-count:])
    if (top[1:] > _STRAY * top[:-1]).any():
        least = top[1:][top[1:] > _STRAY * top[:-1]][0]
        at = tuple(map(int, np.argwhere(np.abs(leaf) >= least)[0]))
        usual = float(np.median(size))
        raise ValueError(
            f"{where} is {leaf[at]:.3g} at {at}, where numbers are usually {usual:.3g}, and its "
            "square leaves no digit of theirs; use NaN if it is no measurement"
        )


def check_present(name: str, filter: AnyFilter | None, inputs: Any) -> None:
    """Refuse inputs without a single sample; optional ones may be absent.

    Args:
        name: of the problem.
        filter: the filter that runs over them, or None.
        inputs: the samples, time first.

    Raises:
        ValueError: one sentence, with the way out.
    """
    spared = _optional(filter)
    for path, leaf in jax.tree_util.tree_leaves_with_path(inputs):
        values = np.asarray(leaf)
        field = next((key.name for key in reversed(path) if hasattr(key, "name")), "")
        if values.dtype.kind != "f" or not values.size or field in spared:
            continue
        gone = np.isnan(values).all(axis=0)
        # Each of several signals side by side is checked; an axis of a sensor may be missing.
        if gone.all() or (not path and gone.any()):
            what = f"the input {field}" if field else "an input"
            raise ValueError(
                f"{what} of {name} is missing in all {len(values)} samples; give samples of it, or "
                "leave it out"
            )


def _optional(filter: AnyFilter | None) -> frozenset[str]:
    own = bare(filter)
    return optional(own) if hasattr(own, "inputs") else frozenset()


def check_start(name: str, space: Any, build: Any, filter: Any) -> None:
    """Refuse, at the start, negative or infinite variances, and matrices that are no covariances.

    Args:
        name: of the problem.
        space: the parameters.
        build: from values by name to what the filter takes.
        filter: the filter.

    Raises:
        ValueError: one sentence, with the way out.
    """
    _check_start(name, space, build, filter)


@lru_cache(maxsize=256)  # cached by its values, as many problems begin with the same
def _check_start(name: str, space: Any, build: Any, filter: Any) -> None:
    z = jax.ShapeDtypeStruct((space.size,), jnp.float64)
    shapes = jax.eval_shape(lambda at: build(space.constrain(at)), z)
    declared = _said(filter)
    if not any(True for _ in _covariances(shapes, declared)):
        return
    params = in_numpy(build, in_numpy(Method(space, "constrain"), space.start()))
    for field, value in _covariances(params, declared):
        fault = _fault(np.asarray(value))
        if fault:
            raise ValueError(f"the {field} of {name} {fault}")


def _said(filter: AnyFilter | None) -> frozenset[str]:
    """The parameters that a filter declares as variances."""
    own = bare(filter)
    if getattr(own, "params", None) is None:
        return frozenset()
    facts = parameter_facts(own)
    return frozenset(n for n, fact in facts.items() if fact.meaning.startswith(_WORDS))


def _covariances(params: Any, declared: frozenset[str]) -> Iterator[tuple[str, Any]]:
    """The fields that hold variances: those declared so, and R, Q, P0 of this package's tuples."""
    if not isinstance(params, tuple):
        return
    ours = type(params).__module__.startswith("filters.")
    for field in getattr(params, "_fields", ()):
        value = getattr(params, field)
        if isinstance(value, tuple):
            yield from _covariances(value, declared)
        elif value is not None and (field in declared or (ours and field in _COVARIANCES)):
            yield field, value


def _fault(value: np.ndarray) -> str:
    """The fault of variances, or of a covariance; "" where there is none."""
    if not np.isfinite(value).all():
        return f"holds {value[~np.isfinite(value)][0]:g}; give a finite number"
    square = value.ndim == 2 and value.shape[0] == value.shape[1]
    diagonal = np.diagonal(value) if square else value
    if (diagonal < 0).any():
        return f"holds the variance {diagonal.min():.4g}; give one that is not negative"
    if not square:
        return ""
    largest = np.abs(value).max(initial=0.0)
    if np.abs(value - value.T).max(initial=0.0) > _ROUNDING * largest:
        return "is not symmetric, and a covariance is; give the mean of it and its transpose"
    least = float(np.linalg.eigvalsh(value).min(initial=0.0))
    if least < -_ROUNDING * largest:
        return (
            f"has the eigenvalue {least:.4g}, and a covariance has none below 0; no state or error "
            "is spread like that"
        )
    return ""
