"""A tuned filter as C: in both precisions, with its numbers fixed or to be set."""

from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any, NamedTuple

from tuner.code.document import sources
from tuner.code.files import Files
from tuner.code.form import Form, Prepared, prepared
from tuner.code.implementation import Implementation
from tuner.code.literal import Precision
from tuner.code.names import identifier
from tuner.code.reference import Reference
from tuner.code.selftest import selftest
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
    found = _prepared(tuned, trials, variant.precision)
    return _written(tuned, found, variant, include).tested(_tried(found))


class _Written(NamedTuple):
    """Header and source, with each form by its name, before there is a self-test."""

    include: str
    header: str
    source: str
    forms: Mapping[str, Implementation]

    def tested(self, references: Mapping[str, Reference]) -> Code:
        forms = {name: Form(code, references[name]) for name, code in self.forms.items()}
        test = selftest(self.include, list(forms.values()))
        return Code(Files(self.header, self.source, test), forms)


def _prepared(
    tuned: Tuned, trials: Mapping[str, Trial], precision: Precision
) -> dict[str, Prepared]:
    if not trials:
        raise ValueError(
            f"{tuned.name} is a design without a filter that runs on samples, so there is no C for "
            "it; give the design a sample time"
        )
    found = dict[str, Prepared]()
    for name, trial in trials.items():
        with _traced_in(trial.filter, precision):
            found[name] = prepared(*trial, precision)
    return found


def _tried(
    found: Mapping[str, Prepared], before: Mapping[str, Reference] | None = None
) -> dict[str, Reference]:
    tried = dict[str, Reference]()
    for name, one in found.items():
        with _traced_in(one.filter, one.traced.precision):
            tried[name] = one.tried((before or {}).get(name))
    return tried


@contextmanager
def _traced_in(filter: Any, precision: Precision) -> Iterator[None]:
    try:
        yield
    except TypeError as error:  # of JAX, for a filter that insists on its own precision
        raise ValueError(
            f"{type(filter).__name__} cannot be traced in {precision} "
            f"({str(error).splitlines()[0][:120]}); give its numbers no type of their own"
        ) from error


def _written(
    tuned: Tuned, found: Mapping[str, Prepared], variant: Variant, include: str
) -> _Written:
    stem, forms = tuned.name.lower(), dict[str, Implementation]()
    for name, one in found.items():
        own = f"{stem}_{identifier(name)}" if forms else stem
        forms[name] = one.implementation(own, tunable=variant.tunable)
    return _Written(include, *sources(tuned, include, list(forms.values())), forms)


def in_all_variants(
    tuned: Tuned, trials: Mapping[str, Trial]
) -> tuple[dict[str, bytes], list[CodeRecord]]:
    """A tuned filter in every variant, as files of a run's folder, and what is told of them.

    What has no code is told with the reason: it ends no run.
    """
    found, records = dict[str, bytes](), list[CodeRecord]()
    # Both compilers, JAX's of the trial and that of C, work without the interpreter's lock.
    with at_once(2) as pool, at_once(1) as compiler:
        precisions = dict.fromkeys(variant.precision for variant in VARIANTS)
        ready = {one: pool.submit(_prepared, tuned, trials, one) for one in precisions}
        tried = dict[Precision, Future[dict[str, Reference]]]()
        for precision, own in ready.items():
            before = next(reversed(tried.values()), None)
            tried[precision] = pool.submit(_tried_after, own, before)
        begun = [_begun(tuned, ready[v.precision], v, compiler) for v in VARIANTS]
        for variant, part in zip(VARIANTS, begun, strict=True):
            try:
                texts, record = part.finished(tuned.name, variant, tried[variant.precision])
            except ValueError as error:
                texts, record = {}, _refused(tuned.name, variant, str(error))
            found |= texts
            if not variant.tunable:
                records.append(record)
    return found, records


def _tried_after(
    ready: Future[dict[str, Prepared]], before: Future[dict[str, Reference]] | None
) -> dict[str, Reference]:
    """Test samples in one precision after those in another: most of its single steps serve again.

    Both at once would take longer: each waits for the other's turn in the interpreter.
    """
    found = before.result() if before is not None and before.exception() is None else None
    return _tried(ready.result(), found)


class _Begun(NamedTuple):
    """A variant that is written, or why it is not; and its size."""

    written: _Written | ValueError
    size: Future[Size | None] | None = None

    def finished(
        self, name: str, variant: Variant, tried: Future[dict[str, Reference]]
    ) -> tuple[dict[str, bytes], CodeRecord]:
        if isinstance(self.written, ValueError):
            raise self.written
        names = [f"{kept(name, variant)}{end}" for end in (".h", ".c", "_selftest.c")]
        code = self.written.tested(tried.result())
        pairs = zip(names, code.files.in_order, strict=True)
        texts = {name: text.encode("ascii") for name, text in pairs}
        return texts, _record(name, variant, names[0], code, self.size)


def _begun(
    tuned: Tuned, ready: Future[dict[str, Prepared]], variant: Variant, compiler: Executor
) -> _Begun:
    try:
        written = _written(tuned, ready.result(), variant, f"{tuned.name}.h")
    except ValueError as error:
        return _Begun(error)
    if variant.tunable:
        return _Begun(written)
    return _Begun(written, compiler.submit(size, written.header, written.source, written.include))


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
