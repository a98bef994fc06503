"""A traced filter in C, flat or with loops."""

from dataclasses import replace

from tuner.code.functions import implementation
from tuner.code.graph import TooLargeError
from tuner.code.implementation import Implementation
from tuner.code.looped import looped
from tuner.code.names import in_comment
from tuner.code.program import Program, as_graph
from tuner.code.refused import NoCounterpartError
from tuner.code.trace import Traced

FLAT = 1500
"""Most operations of a step that is written without loops."""
NUMBERS = 400
"""Most numbers in state, inputs and outputs of a step without loops."""
_GRAPH, _LARGEST = 6000, 20_000


def implemented(
    whole: Traced, stem: str, note: str, *, tunable: bool, program: Program | None = None
) -> Implementation:
    """The flat form where it is short, else one with loops, else the flat form after all.

    Args:
        whole: the filter.
        stem: what the names of its types and functions begin with.
        note: a sentence about it; "" for none.
        tunable: whether its parameters come in.
        program: its graph, where it was made.

    Raises:
        ValueError: for a state that is too large, or an operation that C has no counterpart for.
    """
    code = _either(whole, stem, tunable=tunable, program=program)
    if not note:
        return code
    return replace(code, declarations=[f"/* {in_comment(note, 200)} */", *code.declarations])


def _either(whole: Traced, stem: str, *, tunable: bool, program: Program | None) -> Implementation:
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
