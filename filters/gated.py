"""An innovation gate for any filter: a measurement that is too unlikely is taken as missing."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.measurement_mask import (
    MeasuredEntries,
    MeasurementMask,
    check_innovations,
    with_fields,
)
from filters.protocol import AnyFilter

PATIENCE = 10
"""Refusals in a row after which the filter is doubted, and not the measurement."""


class GatedState(NamedTuple):
    """The filter's own state, and how often in a row each innovation was outside, ``(m,)``."""

    inner: Any
    outside: Array


def number_type(state: Any) -> Any:
    """The type of a state's numbers, in which refusals are counted as well."""
    kinds = {leaf.dtype for leaf in jax.tree.leaves(state)}
    return jnp.result_type(*(kind for kind in kinds if jnp.issubdtype(kind, jnp.floating)), 0.0)


@dataclass(frozen=True)
class Gated:
    """A filter that takes a measurement as missing where it is too far from what was predicted.

    A number whose innovation y of variance s has y^2 > gate^2 s is rejected: the state is that of
    the same step with this number missing (NaN). Where innovations are taken one after another,
    each is judged after those before it were taken or rejected, in the filter's own order; numbers
    that are one measurement (a direction of three parts) go together. Known inputs are never
    dropped. Measurements that start the filter, and do not count (variance 0), are not judged.

    A wrong start or an object that jumps must not lock the gate for ever: after
    ``patience`` refusals of an innovation in a row its numbers are taken, whatever they are, until
    one lies within the gate again. Meanwhile a filter with process noise widens its gate by itself.

    The outputs gain four arrays, ``(m,)``: ``offered`` and ``predicted``, the innovation and its
    variance before anything was rejected; ``rejected``, 1 where it was; and ``outside``, 1 where it
    lay outside the gate. ``innovation`` and ``variance`` are 0 where rejected, as where missing.
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, 5.4 (the gate).

    Attributes:
        filter: the filter; the gate is right only if its innovations' variances are.
        parts: which numbers its innovations are made of, by :func:`filters.measured_entries`.
        gate: in standard deviations; one correct number in 16,000 is beyond 4.
        patience: refusals in a row after which the next numbers are taken; 1 or more.

    >>> from filters import LevelSample, LocalLevel, LocalLevelNoise, measured_entries, run
    >>> level, noise = LocalLevel(dt=1.0), LocalLevelNoise(jnp.array(0.01), jnp.array(1.0))
    >>> record = LevelSample(jnp.array([5.0, 5.0, 4.9, 80.0, 5.1]))
    >>> outputs = run(Gated(level, measured_entries(level, noise, record)), noise, record)[1]
    >>> outputs.rejected[:, 0].tolist(), round(outputs.level[3].item(), 2)
    ([0.0, 0.0, 0.0, 1.0, 0.0], 4.97)
    """

    filter: AnyFilter
    parts: MeasuredEntries
    gate: float = 4.0
    patience: int = PATIENCE
    same_params = True

    def __post_init__(self) -> None:
        if not any(self.parts):
            raise ValueError(
                "no missing number takes an innovation away, so there is nothing to refuse; leave "
                "the gate out"
            )
        if not self.gate >= 1:
            raise ValueError(
                f"a gate of {self.gate:g} deviations rejects more than a third of what is right; "
                "give one from 3 to 6"
            )
        if self.patience < 1:
            raise ValueError(f"a patience of {self.patience} refuses nothing; give 1 or more")

    def init(self, params: Any) -> GatedState:
        """The filter's own start; nothing was rejected."""
        inner = self.filter.init(params)
        return GatedState(inner, jnp.zeros(len(self.parts), number_type(inner)))

    def step(self, params: Any, state: GatedState, inputs: Any) -> tuple[GatedState, Any]:
        """Take one sample, and take it again without its first wrong number while there is one."""
        mask = MeasurementMask(self.parts)
        gated = jnp.array([bool(part) for part in self.parts]) & (state.outside < self.patience)

        def tried(rejected: Array) -> tuple[Any, Any]:
            stepped: tuple[Any, Any] = self.filter.step(
                params, state.inner, mask.masked(inputs, rejected)
            )
            return stepped

        # Nothing is replaced here, so that the usual sample costs one step of the filter.
        first: tuple[Any, Any] = self.filter.step(params, state.inner, inputs)
        check_innovations(self.filter, first[1])
        y, s = first[1].innovation, first[1].variance
        none = jnp.zeros(len(self.parts), bool)

        def once(seen: "_Seen", _: None) -> tuple["_Seen", None]:
            wrong = gated & ~seen.rejected & self._beyond(*_judged(seen.stepped))
            return jax.lax.cond(wrong.any(), lambda: again(seen, wrong), lambda: seen), None

        def again(seen: "_Seen", wrong: Array) -> "_Seen":
            one = mask.together(wrong & (jnp.cumsum(wrong) == 1))
            now_y, now_s = _judged(seen.stepped)
            fresh = one & ~seen.rejected & (now_s != 0)
            rejected = seen.rejected | fresh
            return _Seen(
                tried(rejected),
                rejected,
                jnp.where(fresh, now_y, seen.offered),
                jnp.where(fresh, now_s, seen.predicted),
            )

        begun = _Seen(first, none, jnp.zeros_like(y), jnp.zeros_like(s))
        if len(self.parts) == 1:
            seen, _ = once(begun, None)
        else:
            seen, _ = jax.lax.scan(once, begun, None, length=len(self.parts))
        inner, output = seen.stepped
        rejected = seen.rejected
        offered = jnp.where(rejected, seen.offered, output.innovation)
        predicted = jnp.where(rejected, seen.predicted, output.variance)
        outside = self._beyond(offered, predicted)
        again_outside = jnp.where(outside, state.outside + 1, 0)
        counted = jnp.where(predicted != 0, again_outside, state.outside)
        kind = with_fields(type(output), ("offered", "predicted", "rejected", "outside"))
        flags = (rejected.astype(y.dtype), outside.astype(y.dtype))
        return GatedState(inner, counted), kind(*output, offered, predicted, *flags)

    def _beyond(self, y: Array, s: Array) -> Array:
        return (s > 0) & (y**2 > self.gate**2 * s)


class _Seen(NamedTuple):
    """The result of a sample so far."""

    stepped: tuple[Any, Any]
    rejected: Array
    offered: Array
    predicted: Array


def _judged(stepped: tuple[Any, Any]) -> tuple[Array, Array]:
    return stepped[1].innovation, stepped[1].variance
