"""A tuned filter as C: in both precisions, with its numbers fixed or to be set."""

from collections.abc import Mapping
from functools import cache, partial
from typing import NamedTuple

from tuner.code.document import files
from tuner.code.files import Files
from tuner.code.form import Form, Ready, ready
from tuner.code.literal import Precision
from tuner.code.names import identifier
from tuner.code.size import size
from tuner.export.tuned import Tuned
from tuner.problem.exported import Trial
from tuner.run.code_files import VARIANTS, Variant, kept
from tuner.run.result import CodeRecord


class Code(NamedTuple):
    """The files that were written.

    Attributes:
        files: the text.
        forms: each form by its name.
    """

    files: Files
    forms: Mapping[str, Form]


def code_of(tuned: Tuned, trials: Mapping[str, Trial], variant: Variant, include: str) -> Code:
    """A tuned filter in C.

    Args:
        tuned: its numbers.
        trials: what runs on the machine, the main form first.
        variant: how it is written.
        include: name of the header's file.

    Raises:
        ValueError: in one sentence, where there is nothing that runs, or what it does has no
            counterpart in C.
    """
    return _code(tuned, _ready(tuned, trials, variant.precision), variant, include)


def _ready(tuned: Tuned, trials: Mapping[str, Trial], precision: Precision) -> dict[str, Ready]:
    if not trials:
        raise ValueError(
            f"{tuned.name} is a design without a filter that runs on samples, so there is no C for "
            "it; give the design a sample time"
        )
    found = dict[str, Ready]()
    for name, trial in trials.items():
        try:
            found[name] = ready(*trial, precision)
        except TypeError as error:  # of JAX, for a filter that insists on its own precision
            raise ValueError(
                f"{type(trial.filter).__name__} cannot be traced in {precision} "
                f"({str(error).splitlines()[0][:120]}); give its numbers no type of their own"
            ) from error
    return found


def _code(tuned: Tuned, found: Mapping[str, Ready], variant: Variant, include: str) -> Code:
    stem, forms = tuned.name.lower(), dict[str, Form]()
    for name, one in found.items():
        own = f"{stem}_{identifier(name)}" if forms else stem
        forms[name] = one.form(own, tunable=variant.tunable)
    return Code(files(tuned, include, list(forms.values())), forms)


def in_all_variants(
    tuned: Tuned, trials: Mapping[str, Trial]
) -> tuple[dict[str, bytes], list[CodeRecord]]:
    """A tuned filter in every variant, as files of a run's folder, and what is told of them.

    What has no code is told with the reason: it ends no run.
    """
    found: dict[str, bytes] = {}
    records = []
    in_precision = cache(partial(_ready, tuned, trials))
    for variant in VARIANTS:
        include = f"{tuned.name}.h"
        names = [f"{kept(tuned.name, variant)}{end}" for end in (".h", ".c", "_selftest.c")]
        try:
            code = _code(tuned, in_precision(variant.precision), variant, include)
        except ValueError as error:
            record = CodeRecord(
                problem=tuned.name,
                precision=variant.precision,
                file="",
                forms=[],
                operations=0,
                refused=str(error),
            )
        else:
            texts = zip(names, code.files.in_order, strict=True)
            found |= {name: text.encode("ascii") for name, text in texts}
            record = _record(tuned.name, variant, names[0], code, include)
        if not variant.tunable:
            records.append(record)
    return found, records


def _record(name: str, variant: Variant, file: str, code: Code, include: str) -> CodeRecord:
    measured = None
    if not variant.tunable:
        measured = size(code.files.header, code.files.source, include)
    return CodeRecord(
        problem=name,
        precision=variant.precision,
        file=file,
        forms=list(code.forms),
        operations=next(iter(code.forms.values())).written.operations,
        code_bytes=None if measured is None else measured.code,
        stack_bytes=None if measured is None else measured.stack,
    )
