"""The estimate without a filter: the last measurement, or a constant."""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from filters.declared import Channel, bare, channel_facts
from tuner.run.fit_problem import NO_TRUTH, Posed
from tuner.run.search_space import DEVIATION

LAST, MEAN = "the last measurement", "the constant mean"


class Predicted(NamedTuple):
    """The outputs of a predictor without filtering, ``(N, ..., m)`` each.

    Attributes:
        innovation, variance: as of a Kalman filter.
        offered, predicted: the same, under the names of a filter that may refuse some.
    """

    innovation: np.ndarray
    variance: np.ndarray
    offered: np.ndarray
    predicted: np.ndarray


def without_filter(posed: Posed, outputs: Any, tuned_on: np.ndarray) -> dict[str, Any]:
    """Outputs, by what stands for the filter; empty where nothing measured is of their kind.

    Against a truth the last measurement is the estimate. Where measurements are predicted, the last
    one or their mean predicts the next, with a variance that is learnt where it is tuned.

    Args:
        posed: the problem.
        outputs: the filter's own, whose innovations say what counts.
        tuned_on: the samples ``(N, 1)`` or recordings ``(1, k)`` that the filter was tuned on.
    """
    measured = _measured(posed)
    if measured is None:
        return {}
    if posed.objective not in NO_TRUTH:
        return {LAST: _as_output(posed, _held(measured))}
    counted = _counted(posed, outputs)
    if measured.shape != counted.shape:
        return {}
    known = counted & _over(counted, tuned_on)
    facts = channel_facts(bare(posed.problem.filter), "inputs")
    angle = any(facts[name].kind == "angle" for name in _like(posed))
    errors = {
        LAST: measured - _before(measured),
        MEAN: measured - _mean_of_parts(measured, known),
    }
    return {name: _predicted(each, counted, known, angle=angle) for name, each in errors.items()}


def _counted(posed: Posed, outputs: Any) -> np.ndarray:
    """Which of the filter's innovations count, in their shape."""
    innovation = np.asarray(outputs.innovation)
    seen = np.broadcast_to(~np.isnan(np.asarray(posed.problem.data.truth)), innovation.shape)
    variance = getattr(outputs, "predicted", getattr(outputs, "variance", np.ones(1)))
    return np.asarray(seen & (np.asarray(variance) != 0))


def _over(counted: np.ndarray, tuned_on: np.ndarray) -> np.ndarray:
    """A mask over samples or recordings in a shape ``(N, ..., m)``."""
    mask = tuned_on if counted.ndim > 2 else tuned_on[:, 0]
    return np.asarray(mask.reshape(mask.shape + (1,) * (counted.ndim - mask.ndim)))


def _judged(posed: Posed) -> Channel:
    return channel_facts(bare(posed.problem.filter), "outputs")[posed.output or "innovation"]


def _measured(posed: Posed) -> np.ndarray | None:
    """The measurements of the kind that is judged, ``(N, ..., m)``; None where there are none."""
    lead, parts = np.ndim(posed.timeline.dt), _parts(posed)
    like = {
        name: (values := np.asarray(posed.timeline.channels[name], float)).reshape(
            *values.shape[:lead], -1
        )
        for name in _like(posed)
    }
    alone = [values for values in like.values() if values.shape[-1] == parts]
    if len(alone) == 1:
        return alone[0]
    together = np.concatenate([*like.values()], axis=-1) if like else np.zeros(0)
    return together if together.shape[-1:] == (parts,) else None


def _like(posed: Posed) -> list[str]:
    """The channels in the unit of what is judged."""
    judged = _judged(posed)
    if judged.kind == "attitude" or not judged.unit:
        return []
    facts = channel_facts(bare(posed.problem.filter), "inputs")
    return [
        name
        for name in posed.timeline.channels
        if facts[name].unit == judged.unit and name != DEVIATION
    ]


def _parts(posed: Posed) -> int:
    """How many numbers are judged in a sample."""
    if posed.output:
        return int(np.prod(np.shape(posed.problem.data.truth)[np.ndim(posed.timeline.dt) :]))
    axes = len(_judged(posed).axes)
    return axes or 1


def _as_output(posed: Posed, estimate: np.ndarray) -> Any:
    """The estimate under the output's name, in its shape."""
    shaped = estimate.reshape(np.shape(posed.problem.data.truth))
    name = getattr(posed.problem.objective, "name", "")
    return namedtuple("Raw", [name])(shaped) if name else shaped


def _held(measured: np.ndarray) -> np.ndarray:
    """Each number until the next comes; NaN before the first."""
    rows = np.arange(len(measured)).reshape(-1, *[1] * (measured.ndim - 1))
    last = np.maximum.accumulate(np.where(np.isnan(measured), -1, rows), axis=0)
    held = np.take_along_axis(measured, np.maximum(last, 0), axis=0)
    return np.where(last < 0, np.nan, held)


def _before(measured: np.ndarray) -> np.ndarray:
    """The last number before each."""
    return np.concatenate([np.full_like(measured[:1], np.nan), _held(measured)[:-1]])


def _mean_of_parts(measured: np.ndarray, where: np.ndarray) -> np.ndarray:
    """The mean of each part over time and recordings."""
    axes = tuple(range(measured.ndim - 1))
    known = where & ~np.isnan(measured)
    total = np.where(known, measured, 0.0).sum(axis=axes)
    return np.asarray(total / np.maximum(known.sum(axis=axes), 1))


def _predicted(
    errors: np.ndarray, counted: np.ndarray, known: np.ndarray, *, angle: bool
) -> Predicted:
    """Errors with the variance that they have where they were tuned on; 0 where none counts."""
    if angle:
        errors = errors - 2 * np.pi * np.round(errors / (2 * np.pi))
    variance = _mean_of_parts(errors**2, known)
    counts = counted & ~np.isnan(errors) & (variance > 0)
    both = np.where(counts, errors, 0.0), np.where(counts, variance, 0.0)
    return Predicted(*both, *both)
