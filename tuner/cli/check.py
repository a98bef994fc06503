"""tuner check: values in use on a recording, those of a run or of the command line."""

import json as json_
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

from objectives.kinds import kind_of
from tuner.certificate.solution import Status
from tuner.cli.filter_option import file_changes, refuse_code
from tuner.cli.pairs import words
from tuner.cli.request import Request, load_records
from tuner.cli.run import describe
from tuner.cli.settings import parse_settings
from tuner.cli.tables import console, number_text, show_grid
from tuner.data.record import Record
from tuner.names import unknown
from tuner.run.cache import use_cache
from tuner.run.check import Check
from tuner.run.filter_choice import FilterChoice
from tuner.run.fit_record import DiagnosticsRecord
from tuner.run.fit_study import STUDY, FitSettings
from tuner.run.own_file import own_file
from tuner.run.recipe import LogEntries, read_recipe
from tuner.run.result import read_result
from tuner.run.study import best
from tuner.run.summary import WORDS


@dataclass(frozen=True)
class InUse:
    """A filter with the values that it runs with.

    Attributes:
        filter_option: the filter.
        values: parameters by name.
        units: of those that a run tuned; they have to be the same here.
        options: fields of the filter's class.
        objective: its name, None for what there is.
        log: how the run read its recording; None without a run.
        notes: what should be known, a sentence each.
    """

    choice: FilterChoice
    values: Mapping[str, Any]
    units: Mapping[str, str]
    options: Mapping[str, Any]
    objective: str | None = None
    log: LogEntries | None = None
    notes: tuple[str, ...] = ()


def show(run: Path | None, request: Request, objective: str | None) -> int:
    """Print what a recording says about values in use; always 0, for a bad filter is a result.

    Raises:
        ValueError: for a run that is no fit, values that are missing or unknown, and recordings
            that do not fit the filter.
    """
    from tuner.run.check import check

    use_cache()
    used = _given(request) if run is None else _of_run(run, request)
    used = replace(used, objective=objective or used.objective)
    request = _filled(request, used)
    if not request.logs:
        raise ValueError("a check needs a recording; give it with --log FILE")
    records = load_records(STUDY, FitSettings.model_validate(used.choice.settings), request)
    describe(records)
    found = check(used.choice, records, used.values, options=used.options, objective=used.objective)
    _same_units(used, found)
    notes = [*found.posed.notes, *_notes(used, records)]
    print("".join(f"{note}\n" for note in notes), end="", file=sys.stderr)
    if request.json:
        print(json_.dumps(_document(used, found, notes), indent=1))
    else:
        _print(used, found)
    return 0


def _given(request: Request) -> InUse:
    """A filter with the values of the command line; --set names parameters and options alike."""
    from filters.declared import parameter_facts

    if not request.filter_option.named:
        raise ValueError("name the run whose values are checked, or give --filter NAME with --set")
    choice = parse_settings(FitSettings, (), request.filter_option.settings()).choice
    facts, options = parameter_facts(choice.cls), _options(choice.cls)
    given = words("--set", request.sets)
    for name in given:
        if name not in facts and name not in options:
            raise unknown(f"parameter or option of {choice.name}", name, [*facts, *options])
    values = {name: _value(name, value) for name, value in given.items() if name in facts}
    own = {name: value for name, value in given.items() if name not in facts}
    return InUse(choice, values, {}, own)


def _options(cls: type[Any]) -> list[str]:
    from dataclasses import fields

    from tuner.run.gate import NAMES

    return [*(each.name for each in fields(cls) if each.name != "dt"), *NAMES]


def _value(name: str, value: Any) -> Any:
    """A number, or lists of them."""
    import numpy as np

    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise ValueError(f"--set {name} is {value!r}; give a number") from None
    if isinstance(value, bool) or not np.isfinite(array).all():
        raise ValueError(f"--set {name} is {value!r}; give a finite number")
    return float(array) if array.ndim == 0 else array


def _of_run(run: Path, request: Request) -> InUse:
    """The filter that a fit tuned.

    Raises:
        ValueError: for a run of another study, one that found nothing, --set or another filter
            beside it, and one whose class is in a Python file that is not named.
    """
    result = read_result(run)
    option, own = request.filter_option, own_file(str(result.settings.get("filter")))
    same = own is not None and option.file is not None and option.file.reference == own.reference
    if request.sets or (option.named and not same):
        raise ValueError(f"{run} contains its filter and values; leave out --filter and --set")
    if result.study != STUDY.name:
        raise ValueError(
            f"{run} is a run of {result.study} and not of tuner fit; give its filter and values "
            "with --filter NAME --set NAME=VALUE"
        )
    refuse_code({"settings": result.settings}, option, run, f"tuner check {run}")
    settings = FitSettings.model_validate(result.settings | option.settings())
    choice = settings.choice
    solutions = {(s.problem, s.solver): s.solution() for s in result.solutions}
    found = best(choice.name.replace("-", "_"), solutions)
    if found.status is Status.FAILED:
        raise ValueError(f"{run} found no values ({found.message}); tune again")
    recipe = (run if run.is_dir() else run.parent) / "study.toml"
    untrusted = [] if found.status.trusted else [f"the run's values are {found.status.value!r}"]
    return InUse(
        choice,
        {name: parameter.value for name, parameter in found.parameters.items()},
        {name: parameter.unit for name, parameter in found.parameters.items()},
        settings.options,
        settings.objective,
        read_recipe(recipe).log if recipe.exists() else None,
        (*file_changes(result.settings, option), *untrusted),
    )


def _filled(request: Request, used: InUse) -> Request:
    """The request with what the run's recording was read by, where nothing else is told."""
    if used.log is None:
        return request
    whole = used.log.model_copy(update={"from_s": None, "to_s": None})
    return replace(request, reading=request.reading.over(whole))


def _same_units(used: InUse, found: Check) -> None:
    """Refuse values that were tuned in another unit than this recording's."""
    for name, kind in found.posed.problem.space.parameters:
        tuned = used.units.get(name, kind.unit)
        if tuned != kind.unit:
            raise ValueError(
                f"{name} was tuned in {tuned or 'no unit'} and this recording makes it "
                f"{kind.unit or 'no unit'}; give the channel the same unit with --map"
            )


def _notes(used: InUse, records: tuple[Record, ...]) -> Iterator[str]:
    yield from used.notes
    if used.log is not None:
        for part in {part.name: part for record in records for part in record.sources}.values():
            if part.sha256 in used.log.sha256:
                yield f"{part.name} is what the run was tuned on"


def _document(used: InUse, found: Check, notes: list[str]) -> dict[str, Any]:
    from dataclasses import asdict

    judged = found.diagnostics
    record = None if judged is None else DiagnosticsRecord.of(judged)
    return {
        "schema": "tuner.check/1",
        "filter": used.choice.name,
        "options": dict(used.options),
        "log": asdict(found.posed.source),
        "values": {
            name: {"value": found.values[name].tolist(), "unit": kind.unit}
            for name, kind in found.posed.problem.space.parameters
        },
        "objective": found.posed.objective,
        "unit": found.posed.unit,
        "value": found.error,
        "nats": found.value if kind_of(found.posed.problem.objective) == "likelihood" else None,
        "diagnostics": None if record is None else json_.loads(record.model_dump_json()),
        "notes": notes,
    }


def _print(used: InUse, found: Check) -> None:
    out, space = console(), found.posed.problem.space
    texts = [f"{n} = {_text(found.values[n])} {k.unit}".rstrip() for n, k in space.parameters]
    out.print(
        f"{used.choice.name} with {', '.join(texts)}", soft_wrap=True, highlight=False, markup=False
    )
    unit = f" {found.posed.unit}" if found.posed.unit else ""
    words = WORDS.get(found.posed.objective, found.posed.objective)
    out.print(f"{words} {found.error:.5g}{unit}", highlight=False)
    judged = found.diagnostics
    if judged is None:
        return
    if judged["size"].verdict != "not tried":
        out.print(
            f"NIS {judged.nis:.4g} ({judged.low:.3g} to {judged.high:.3g} expected); noise "
            f"variances times {judged.factor:.4g} ({judged.factor_low:.3g} to "
            f"{judged.factor_high:.3g}) are likeliest; lag one {judged.lag_one:+.3f}; "
            f"{judged.numbers} numbers",
            soft_wrap=True,
            highlight=False,
        )
    lines = [
        [f.test, f.verdict, number_text(_known(f.statistic)), _two_digits(_known(f.p)), f.what]
        for f in judged.findings
    ]
    show_grid("Diagnostics", [["test", "verdict", "statistic", "p", "what it means"], *lines])
    for each in judged.failed:
        out.print(each.sentence, style="yellow", soft_wrap=True, highlight=False, markup=False)


def _two_digits(p: float | None) -> str:
    return "-" if p is None else f"{p:.2g}"


def _known(number: float) -> float | None:
    """None where it was not tried."""
    return number if isfinite(number) else None


def _text(value: Any) -> str:
    return f"{float(value):.5g}" if value.ndim == 0 else str(value.tolist())
