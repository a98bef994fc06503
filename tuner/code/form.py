"""A form of a filter in C, flat or with loops, with its test samples."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import numpy as np

from filters import Lanes, Timed, TimedSample
from filters.declared import bare, channel_facts
from tuner.code.functions import implementation
from tuner.code.graph import TooLargeError
from tuner.code.implementation import Implementation
from tuner.code.literal import Precision
from tuner.code.looped import looped
from tuner.code.names import in_comment
from tuner.code.program import Program, as_graph
from tuner.code.reference import Reference, reference
from tuner.code.refused import NoCounterpartError
from tuner.code.trace import Traced, traced

FLAT = 1500
"""Most operations of a step that is written without loops."""
NUMBERS = 400
"""Most numbers in state, inputs and outputs of a step without loops."""
_GRAPH = 6000
_FORMULAS, _STATE = 30_000, 600
_LARGEST = 20_000


class Form(NamedTuple):
    """The written code, and the samples it is tested on."""

    implementation: Implementation
    reference: Reference


class Ready(NamedTuple):
    """A traced filter, ready to be written with constant or adjustable parameters.

    Attributes:
        traced: the filter.
        reference: its test samples.
        note: a sentence about this form; "" for none.
        program: its graph; None where that is too large, or has no counterpart.
    """

    traced: Traced
    reference: Reference
    note: str
    program: Program | None

    def form(self, stem: str, *, tunable: bool = False) -> Form:
        """The filter in C.

        Args:
            stem: prefix of its types and functions.
            tunable: whether its parameters are adjustable.

        Raises:
            ValueError: for an operation that C has no counterpart for.
        """
        program = None if tunable else self.program
        code = _implemented(self.traced, stem, tunable=tunable, program=program)
        return Form(_noted(code, self.note), self.reference)


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
    filter, inputs = one_record(filter, inputs)
    sample = jax.tree.map(lambda leaf: np.asarray(leaf)[0], inputs)
    whole = traced(filter, params, sample, precision, _wanted(filter))
    program = formulas(whole)
    data = reference(filter, params, inputs, whole.kept, precision, program)
    return Ready(whole, data, getattr(filter, "note", ""), program)


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
    code = _implemented(traced(filter, params, sample, precision, keep), stem, tunable=tunable)
    return _noted(code, getattr(filter, "note", ""))


def _noted(code: Implementation, note: str) -> Implementation:
    if not note:
        return code
    return replace(code, declarations=[f"/* {in_comment(note, 200)} */", *code.declarations])


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


def _implemented(
    whole: Traced, stem: str, *, tunable: bool, program: Program | None = None
) -> Implementation:
    """The flat form where it is short, else one with loops, else the flat form after all."""
    code = None
    numbers = sum(field.size for field in (*whole.state, *whole.inputs, *whole.outputs))
    try:
        if numbers > NUMBERS:
            raise TooLargeError("its arrays are loops of their own")
        if program is not None and len(program.graph.nodes) > _GRAPH:
            raise TooLargeError("its operations are loops")
        program = program or as_graph(whole, tunable=tunable, most=_GRAPH)
        code = implementation(program, stem, whole.values)
        if code.operations <= FLAT:
            return code
    except TooLargeError:
        pass
    try:
        return looped(whole, stem, tunable=tunable)
    except NoCounterpartError:
        if code is not None:
            return code
    return implementation(as_graph(whole, tunable=tunable, most=_LARGEST), stem, whole.values)
