"""tuner export: one tuned filter of a run as a file, read back; at another rate if asked for."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tuner import export
from tuner.cli.export_c import write_c
from tuner.cli.tables import show_findings
from tuner.cli.wanted import Wanted, path_of
from tuner.cli.which import refuse_code
from tuner.export import Tuned
from tuner.names import unknown
from tuner.run.result import Result, read_result

if TYPE_CHECKING:
    from tuner.run.at_rate import AtRate


def write(run: Path, wanted: Wanted) -> None:
    """Write a tuned filter of a run, read it back and compare it with what the run found.

    Raises:
        ValueError: for an unknown problem or format, a run that exports nothing, a solution that
            did not converge, a file that is there already, one that was written wrong, and a filter
            that there is not at another rate.
    """
    if wanted.to is None and wanted.rate_hz is None:
        raise ValueError(
            f"give the format, --to {'|'.join(export.FORMATS)}, or --rate HZ to see the numbers at "
            "another rate"
        )
    if wanted.to != "c" and (wanted.precision or wanted.tunable):
        raise ValueError("--precision and --tunable say how C is written; give --to c with them")
    result = read_result(run)
    tuned = _choose(result, wanted.problem)
    status = tuned.provenance.status
    if status != "converged" and not wanted.force:
        raise ValueError(
            f"the solution of {tuned.name} is {status!r}, not converged; --force exports it anyway"
        )
    found = None
    if wanted.rate_hz is not None:
        found = _at_rate(run, result, tuned, wanted.rate_hz, wanted)
        tuned = found.tuned
    elif wanted.densities:
        raise ValueError("--density says what grows with the rate; give --rate HZ with it")
    if wanted.to == "c":
        write_c(run, result, tuned, found, wanted)
    elif wanted.to is not None:
        _write(tuned, wanted.to, wanted)


def _write(tuned: Tuned, to: str, wanted: Wanted) -> None:
    data = export.dump(tuned, to)
    if wanted.output == "-":
        sys.stdout.buffer.write(data)
        return
    path = path_of(tuned, to, wanted)
    export.write(tuned, path, to, overwrite=wanted.force)
    export.read_back(tuned, path, to)
    print(f"wrote {path}: {len(tuned.quantities)} quantities, read back equal", file=sys.stderr)


def _at_rate(run: Path, result: Result, tuned: Tuned, rate_hz: float, wanted: Wanted) -> "AtRate":
    """The filter at another rate; its numbers are shown where no file is asked for."""
    from tuner.cli.settings import parse_settings
    from tuner.run.cache import use_cache
    from tuner.run.study import find_study

    if not 0 < rate_hz < float("inf"):
        raise ValueError(f"--rate is {rate_hz:g}; give a positive number of samples a second")
    use_cache()
    study = find_study(result.study)
    if study.at_rate is None:
        raise ValueError(
            f"{tuned.name} of {result.study} holds for its own rate; tuner fit and tuner run "
            "design.toml tune filters that hold for any"
        )
    refuse_code(result.settings, wanted.which, run, f"tuner export {run} --rate {rate_hz:g}")
    chosen = wanted.which.settings() if wanted.which.named else {}
    settings = parse_settings(study.settings, (), result.settings | chosen)
    found = study.at_rate(settings, tuned, rate_hz, wanted.densities)
    for note in found.notes:
        print(note, file=sys.stderr)
    if wanted.to is None:
        show_findings(found.findings)
    return found


def _choose(result: Result, problem: str | None) -> Tuned:
    tuned = [export.load(json.dumps(one).encode(), "json") for one in result.tuned]
    if problem is None and len(tuned) == 1:
        return tuned[0]
    if not tuned:
        raise ValueError(
            f"the run of {result.study} tuned no filter that is exported; run it without --claim"
        )
    names = [one.name for one in tuned]
    if problem is None:
        raise ValueError(
            f"the run has several tuned filters; choose with --problem {'|'.join(names)}"
        )
    if problem not in names:
        raise unknown("problem", problem, names)
    return tuned[names.index(problem)]
