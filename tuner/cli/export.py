"""tuner export: one tuned filter of a run as a file, read back."""

import json
import sys
from pathlib import Path

from tuner import export
from tuner.export import Tuned
from tuner.names import unknown
from tuner.run.result import Result, read_result


def write(run: Path, to: str, output: str | None, *, problem: str | None, force: bool) -> None:
    """Write a tuned filter of a run, read it back and compare it with what the run found.

    Raises:
        ValueError: for an unknown problem or format, a run that exports nothing, a solution that
            did not converge, a file that is there already, or one that was written wrong.
    """
    result = read_result(run)
    tuned = _choose(result, problem)
    status = tuned.provenance.status
    if status != "converged" and not force:
        raise ValueError(
            f"the solution of {tuned.name} is {status!r}, not converged; --force exports it anyway"
        )
    data = export.dump(tuned, to)
    if output == "-":
        sys.stdout.buffer.write(data)
        return
    path = Path(output) if output else Path(f"{tuned.name}{export.suffix(to)}")
    export.write(tuned, path, to, overwrite=force)
    export.read_back(tuned, path, to)
    print(f"wrote {path}: {len(tuned.quantities)} quantities, read back equal", file=sys.stderr)


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
