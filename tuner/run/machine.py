"""A tuned filter as C: in both precisions, with its numbers fixed or to be set."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import NamedTuple

from tuner.code.document import files
from tuner.code.files import Files
from tuner.code.form import Form, Ready, ready
from tuner.code.literal import Precision
from tuner.code.names import identifier
from tuner.code.size import Size, size
from tuner.export.tuned import Tuned
from tuner.problem.exported import Trial
from tuner.run.code_files import VARIANTS, Variant, kept
from tuner.run.result import CodeRecord
from tuner.run.threads import at_once


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
    records: list[Callable[[], CodeRecord]] = []
    # Both compilers, JAX's of the trial and that of C, work without the interpreter's lock.
    with at_once(2) as pool:
        precisions = dict.fromkeys(variant.precision for variant in VARIANTS)
        ready = {one: pool.submit(_ready, tuned, trials, one) for one in precisions}
        for variant in VARIANTS:
            include = f"{tuned.name}.h"
            names = [f"{kept(tuned.name, variant)}{end}" for end in (".h", ".c", "_selftest.c")]
            try:
                code = _code(tuned, ready[variant.precision].result(), variant, include)
            except ValueError as error:
                record = partial(_refused, tuned.name, variant, str(error))
            else:
                texts = zip(names, code.files.in_order, strict=True)
                found |= {name: text.encode("ascii") for name, text in texts}
                measured = None
                if not variant.tunable:
                    measured = pool.submit(size, code.files.header, code.files.source, include)
                record = partial(_record, tuned.name, variant, names[0], code, measured)
            if not variant.tunable:
                records.append(record)
        return found, [record() for record in records]


def _refused(name: str, variant: Variant, why: str) -> CodeRecord:
    return CodeRecord(
        problem=name, precision=variant.precision, file="", forms=[], operations=0, refused=why
    )


def _record(
    name: str, variant: Variant, file: str, code: Code, size: Future[Size | None] | None
) -> CodeRecord:
    measured = None if size is None else size.result()
    return CodeRecord(
        problem=name,
        precision=variant.precision,
        file=file,
        forms=list(code.forms),
        operations=next(iter(code.forms.values())).implementation.operations,
        code_bytes=None if measured is None else measured.code,
        stack_bytes=None if measured is None else measured.stack,
    )
