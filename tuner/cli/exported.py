"""The part of a run that tuner export writes: all filters or one, also at another rate."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tuner import export
from tuner.cli.export_request import ExportRequest
from tuner.cli.filter_option import refuse_code
from tuner.cli.tables import show_findings
from tuner.export import Tuned
from tuner.names import unknown
from tuner.run.result import Result

if TYPE_CHECKING:
    from tuner.run.at_rate import AtRate


def tuned_of(result: Result) -> list[Tuned]:
    """All that a run exports.

    Raises:
        ValueError: where it exports nothing.
    """
    tuned = [export.load(json.dumps(one).encode(), "json") for one in result.tuned]
    if not tuned:
        raise ValueError(
            f"the run of {result.study} tuned no filter that is exported; run it without --claim"
        )
    return tuned


def choose(tuned: list[Tuned], problem: str | None) -> Tuned:
    """The one of a name, or the only one.

    Raises:
        ValueError: for an unknown name, and for none where there are several.
    """
    if problem is None and len(tuned) == 1:
        return tuned[0]
    names = [one.name for one in tuned]
    if problem is None:
        raise ValueError(
            f"the run has several tuned filters; choose with --problem {'|'.join(names)}"
        )
    if problem not in names:
        raise unknown("problem", problem, names)
    return tuned[names.index(problem)]


def check_converged(tuned: Tuned, request: ExportRequest) -> None:
    """Refuse what did not converge, unless it is asked for.

    Raises:
        ValueError: with the way to have it all the same.
    """
    status = tuned.provenance.status
    if status != "converged" and not request.force:
        raise ValueError(
            f"the solution of {tuned.name} is {status!r}, not converged; --force exports it anyway"
        )


def at_rate(
    run: Path, result: Result, tuned: Tuned, rate_hz: float, request: ExportRequest
) -> "AtRate":
    """The filter at another rate; its numbers are shown where no file is asked for.

    Raises:
        ValueError: for a rate that is none, and a filter that there is not at another rate.
    """
    from tuner.cli.settings import parse_settings
    from tuner.run.cache import use_cache
    from tuner.run.study import find_study

    if not 0 < rate_hz < float("inf"):
        raise ValueError(f"--rate is {rate_hz:g}; give a positive number of samples a second")
    use_cache()
    study = find_study(result.study)
    if study.at_rate is None:
        raise ValueError(
            f"{tuned.name} of {result.study} holds only for its own rate; tuner fit and tuner run "
            "design.toml tune filters for any rate"
        )
    refuse_code(
        result.settings, request.filter_option, run, f"tuner export {run} --rate {rate_hz:g}"
    )
    chosen = request.filter_option.settings() if request.filter_option.named else {}
    settings = parse_settings(study.settings, (), result.settings | chosen)
    found = study.at_rate(settings, tuned, rate_hz, request.densities)
    for note in found.notes:
        print(note, file=sys.stderr)
    if request.to is None:
        show_findings(found.findings)
    return found
