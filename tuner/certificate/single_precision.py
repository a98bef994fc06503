"""Deviation of a tuned filter in single precision from the same filter in double precision."""

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from filters import AnyFilter
from filters.declared import Channel, bare, channel_facts, output
from tuner.problem.programs import run_filter, try_filter

HARMLESS = 0.01
"""A deviation below this share of the signal's scale is not worth a warning."""


@dataclass(frozen=True)
class SinglePrecision:
    """Deviation of a filter in float32 from the same filter in float64 on the same record.

    Attributes:
        form: which form of the filter was run, "full" or "steady".
        output: the output that deviates most, "" where the filter has only one.
        largest: largest deviation of it, in its unit.
        share: the same over the scale of that output: how far it goes up and down over the record,
            its size where it never moves; 1 for an attitude.
        sample: where it occurs.
        rms: root mean square of the deviation.
        warning: a sentence where it matters, otherwise "".
    """

    form: str
    output: str
    largest: float
    share: float
    sample: int
    rms: float
    warning: str


def single_precision(form: str, filter: AnyFilter, params: Any, inputs: Any) -> SinglePrecision:
    """Run a filter in both precisions and compare its outputs.

    Outputs that are details (innovations and their variances) are not compared.

    Args:
        form: what to call it.
        filter: the filter; its declared outputs are compared, or all of them.
        params: its parameters, float64.
        inputs: its inputs, float64, time first.

    Raises:
        TypeError: where the filter falls back to float64, for then nothing would be tested.
    """
    exact = _compared(filter, run_filter(filter, params, inputs))
    rounded = _compared(filter, try_filter(filter, *halved((params, inputs))))
    found = [_strays(form, name, exact[name], rounded[name]) for name in exact]
    if not found:
        raise TypeError(f"{type(filter).__name__} has no output that can be compared")
    return max(found, key=lambda each: (each.share != each.share, each.share))


def halved(tree: Any) -> Any:
    """Arrays in single precision; a number beyond it is infinite, and counts as such."""
    with np.errstate(over="ignore"):
        return jax.tree.map(_half, tree)


def _half(leaf: Any) -> np.ndarray:
    array = np.asarray(leaf)
    return array.astype(np.float32) if array.dtype.kind == "f" else array


def _compared(filter: Any, outputs: Any) -> dict[str, tuple[np.ndarray, Channel | None]]:
    """The outputs by name, with their facts; whole numbers and truth values are left out."""
    if hasattr(bare(filter), "outputs"):
        facts = channel_facts(filter, "outputs")
        declared: dict[str, tuple[np.ndarray, Channel | None]] = {
            name: (np.asarray(output(filter, outputs, name)), fact)
            for name, fact in facts.items()
            if fact.kind != "detail"
        }
        return {name: pair for name, pair in declared.items() if pair[0].dtype.kind == "f"}
    leaves = jax.tree_util.tree_leaves_with_path(outputs)
    arrays = {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in leaves}
    return {name: (array, None) for name, array in arrays.items() if array.dtype.kind == "f"}


def _strays(
    form: str,
    name: str,
    exact: tuple[np.ndarray, Channel | None],
    rounded: tuple[np.ndarray, Channel | None],
) -> SinglePrecision:
    (right, fact), (near, _) = exact, rounded
    if near.dtype != np.float32:
        raise TypeError(f"the output {name!r} is {near.dtype} for float32 inputs")
    with np.errstate(invalid="ignore"):  # infinity minus infinity: equal, as is missing to missing
        deviation = np.abs(_difference(near.astype(float), right, fact))
    alike = (near == right) | (np.isnan(near) & np.isnan(right))
    deviation[np.isnan(deviation)] = np.inf
    deviation[alike] = 0.0
    sample = int(np.unravel_index(np.argmax(deviation), deviation.shape)[0])
    largest, scale = float(deviation.max()), _scale(right, fact)
    share = largest / scale if largest else 0.0
    warning = ""
    if not share < HARMLESS:
        of = f" of the output {name!r}" if fact is not None else ""
        warning = (
            f"in single precision the {form} form deviates by {100 * share:.3g} % of {scale:.3g}"
            f"{of} at sample {sample}; run it in double precision or use a fixed-gain form"
        )
    rms = float(np.sqrt(np.mean(deviation**2)))
    return SinglePrecision(form, name, largest, share, sample, rms, warning)


def _difference(near: np.ndarray, right: np.ndarray, fact: Channel | None) -> np.ndarray:
    """The difference: of angles within half a turn, of quaternions whatever their sign."""
    if fact is not None and fact.kind == "attitude":
        turned = np.sum(near * right, axis=-1, keepdims=True) < 0
        near = np.where(turned, -near, near)
    apart: np.ndarray = near - right
    if fact is not None and fact.kind == "angle":
        apart = apart - 2 * np.pi * np.round(apart / (2 * np.pi))
    return apart


def _scale(right: np.ndarray, fact: Channel | None) -> float:
    if fact is not None and fact.kind == "attitude":
        return 1.0
    finite = right[np.isfinite(right)]
    if not finite.size:
        return 1.0
    return float(np.ptp(finite)) or float(np.abs(finite[0])) or 1.0
