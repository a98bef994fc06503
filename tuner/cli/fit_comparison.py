"""Fits side by side: what each is worth, what it found, and what it costs on a machine."""

from collections.abc import Callable, Sequence

from tuner.certificate.table import range_in_words
from tuner.cli.tables import number_text
from tuner.run.fit_record import FitRecord
from tuner.run.result import CodeRecord, ParameterRecord, Result


def comparison_table(names: Sequence[str], fits: Sequence[Result]) -> list[list[str]]:
    """A header, and a line a quantity with a cell for each fit."""
    lines = [[label, *map(cell, fits)] for label, cell in _JUDGED]
    found = [_parameters(result) for result in fits]
    every = dict.fromkeys(name for parameters in found for name in parameters)
    lines += [[name, *(parameters.get(name, "-") for parameters in found)] for name in every]
    lines += [[label, *map(cell, fits)] for label, cell in _COST]
    return [["", *names], *(line for line in lines if any(cell != "-" for cell in line[1:]))]


def _parameters(result: Result) -> dict[str, str]:
    return {name: _number(each) for name, each in result.solutions[0].parameters.items()}


def _number(parameter: ParameterRecord) -> str:
    value = parameter.value
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    found = parameter.parameter()
    limits = range_in_words(found.interval, found.interval_kind) if found.interval else ""
    return " ".join(part for part in (text, limits, parameter.unit) if part)


def _of_fit(cell: Callable[[FitRecord], str]) -> Callable[[Result], str]:
    return lambda result: "-" if result.fit is None else cell(result.fit)


def _held_out(name: str) -> Callable[[Result], str]:
    def cell(fit: FitRecord) -> str:
        held = fit.held_out
        return "-" if held is None else f"{number_text(getattr(held, name))} {fit.unit}".strip()

    return _of_fit(cell)


def _gain(fit: FitRecord) -> str:
    gain = fit.held_out and fit.held_out.gain
    if not gain or gain.low is None or gain.high is None:
        return "-"
    return f"{100 * gain.low:.3g} % to {100 * gain.high:.3g} %"


def _nis(fit: FitRecord) -> str:
    if not fit.diagnostics:
        return "-"
    tuned = fit.diagnostics[-1]
    return f"{number_text(tuned.nis)} ({number_text(tuned.low)} to {number_text(tuned.high)})"


def _failed(fit: FitRecord) -> str:
    if not fit.diagnostics:
        return "-"
    failed = [each.test for each in fit.diagnostics[-1].findings if each.verdict == "failed"]
    return ", ".join(failed) or "none"


def _float(cell: Callable[[CodeRecord], int | None]) -> Callable[[Result], str]:
    def shown(result: Result) -> str:
        code = next((c for c in result.code if c.precision == "float" and not c.refused), None)
        value = None if code is None else cell(code)
        return "-" if value is None else str(value)

    return shown


_JUDGED: tuple[tuple[str, Callable[[Result], str]], ...] = (
    ("filter", _of_fit(lambda fit: fit.filter)),
    ("status", lambda result: result.solutions[0].status.value),
    ("objective", _of_fit(lambda fit: fit.objective)),
    ("on all data", _of_fit(lambda fit: f"{number_text(fit.tuned)} {fit.unit}".strip())),
    ("held out", _of_fit(lambda fit: fit.held_out.what if fit.held_out else "-")),
    ("there, tuned", _held_out("tuned")),
    ("there, before", _held_out("start")),
    ("there, without filter", _held_out("unfiltered")),
    ("better by", _of_fit(_gain)),
    ("NIS (expected)", _of_fit(_nis)),
    ("failed tests", _of_fit(_failed)),
)
_COST: tuple[tuple[str, Callable[[Result], str]], ...] = (
    ("operations a sample", _float(lambda code: code.operations)),
    ("code as float, B", _float(lambda code: code.code_bytes)),
    ("stack as float, B", _float(lambda code: code.stack_bytes)),
)
