"""A form of a filter in C, flat or with loops, with its test samples."""

from collections.abc import Collection
from typing import Any, NamedTuple

import jax
import numpy as np

from filters import Lanes, Timed, TimedSample
from filters.declared import bare, channel_facts
from tuner.code.graph import TooLargeError
from tuner.code.implementation import Implementation
from tuner.code.implemented import implemented
from tuner.code.literal import Precision
from tuner.code.program import Program, as_graph
from tuner.code.reference import Reference, reference, selected_samples
from tuner.code.reference_filter import ReferenceFilter
from tuner.code.refused import NoCounterpartError
from tuner.code.trace import Traced, traced

_FORMULAS, _STATE = 30_000, 600


class Form(NamedTuple):
    """The written code, and the samples it is tested on."""

    implementation: Implementation
    reference: Reference


class Prepared(NamedTuple):
    """A traced filter, ready to be written and to be tried.

    Attributes:
        traced: the filter.
        program: its graph; None where that is too large, or has no counterpart.
        filter, params, inputs: what was traced, and a recording, time first.
    """

    traced: Traced
    program: Program | None
    filter: Any
    params: Any
    inputs: Any

    def implementation(self, stem: str, *, tunable: bool = False) -> Implementation:
        """The filter in C, without test samples.

        Args:
            stem: prefix of its types and functions.
            tunable: whether its parameters are adjustable.

        Raises:
            ValueError: for an operation that C has no counterpart for.
        """
        program = None if tunable else self.program
        note = getattr(self.filter, "note", "")
        return implemented(self.traced, stem, note, tunable=tunable, program=program)

    def tried(self, before: Reference | None = None) -> Reference:
        """Its test samples, with what it makes of them.

        Args:
            before: those in another precision, whose single steps are looked at first.
        """
        kept, precision = self.traced.kept, self.traced.precision
        given = self.filter, self.params, self.inputs, kept, precision, self.program
        return reference(*given, before)


class Ready(NamedTuple):
    """A traced filter with its test samples, ready to be written."""

    prepared: Prepared
    reference: Reference

    @property
    def traced(self) -> Traced:
        """The filter."""
        return self.prepared.traced

    @property
    def program(self) -> Program | None:
        """Its graph; None where that is too large, or has no counterpart."""
        return self.prepared.program

    def form(self, stem: str, *, tunable: bool = False) -> Form:
        """The filter in C; the arguments are those of :meth:`Prepared.implementation`."""
        return Form(self.prepared.implementation(stem, tunable=tunable), self.reference)


def form(
    stem: str,
    filter: Any,
    params: Any,
    inputs: Any,
    precision: Precision = "double",
    *,
    tunable: bool = False,
) -> Form:
    """A filter in C.

    Args:
        stem: what the names of its types and functions begin with.
        filter: the filter; of a batch one recording is written.
        params: its parameters.
        inputs: a recording, time first, which provides test samples.
        precision: of its real numbers.
        tunable: whether its parameters come in.

    Raises:
        ValueError: for a state that is too large, or an operation that C has no counterpart for.

    >>> from filters import AlphaBeta, AlphaBetaGains
    >>> gains = AlphaBetaGains(0.5, 0.1)
    >>> found = form("track", AlphaBeta(0.1), gains, np.arange(60.0), "float")
    >>> [field.name for field in found.implementation.outputs]
    ['position', 'velocity']
    """
    return ready(filter, params, inputs, precision).form(stem, tunable=tunable)


def ready(filter: Any, params: Any, inputs: Any, precision: Precision = "double") -> Ready:
    """A filter traced and run on test samples; the arguments are those of :func:`form`."""
    one = prepared(filter, params, inputs, precision)
    return Ready(one, one.tried())


def prepared(filter: Any, params: Any, inputs: Any, precision: Precision) -> Prepared:
    """A filter traced; the arguments are those of :func:`form`."""
    filter, inputs = one_record(filter, inputs)
    sample = jax.tree.map(lambda leaf: np.asarray(leaf)[0], inputs)
    whole = traced(filter, params, sample, precision, _wanted(filter))
    return Prepared(whole, formulas(whole), filter, params, inputs)


def run_ahead(filter: Any, params: Any, inputs: Any) -> None:
    """Compile what provides test samples in either precision, by running it."""
    filter, inputs = one_record(filter, inputs)
    for dtype in (np.float64, np.float32):
        ReferenceFilter(filter, params, dtype).run(selected_samples(inputs))


def formulas(traced: Traced) -> Program | None:
    """The graph of a filter; None where it is too large, or an operation has no counterpart."""
    if sum(field.size for field in traced.state) > _STATE:
        return None
    try:
        return as_graph(traced, most=_FORMULAS)
    except (TooLargeError, NoCounterpartError):
        return None


def write_form(
    stem: str,
    filter: Any,
    params: Any,
    sample: Any,
    precision: Precision,
    *,
    keep: Collection[str] | None,
    tunable: bool = False,
) -> Implementation:
    """A filter in C, without test samples.

    Args:
        stem: what the names of its types and functions begin with.
        filter: the filter.
        params: its parameters.
        sample: its inputs at one sample.
        precision: of its real numbers.
        keep: names of the outputs to be included; None: all.
        tunable: whether its parameters come in.

    Raises:
        ValueError: for a state that is too large, or an operation that C has no counterpart for.
    """
    whole, note = traced(filter, params, sample, precision, keep), getattr(filter, "note", "")
    return implemented(whole, stem, note, tunable=tunable)


def one_record(filter: Any, inputs: Any) -> tuple[Any, Any]:
    """The filter and inputs of one recording, from those of a batch."""
    if isinstance(filter, Lanes):
        return one_record(filter.filter, jax.tree.map(lambda leaf: leaf[:, 0], inputs))
    if isinstance(filter, Timed):
        inner, rest = one_record(filter.filter, inputs.inputs)
        return Timed(inner), TimedSample(inputs.dt, rest)
    return filter, inputs


def _wanted(filter: Any) -> Collection[str] | None:
    """The outputs that are not details; all of a filter that declares none."""
    own = bare(filter)
    if not hasattr(own, "outputs"):
        return None
    facts = channel_facts(own, "outputs")
    return [name for name, fact in facts.items() if fact.kind != "detail"] or None
