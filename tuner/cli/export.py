"""tuner export: one tuned filter of a run as a file, read back and scored."""

import json
import sys
from pathlib import Path

from tuner import export
from tuner.atomic import write_bytes
from tuner.export import Tuned
from tuner.names import unknown
from tuner.run.result import Result, read_result


def write(
    run: Path, to: str, output: str | None, *, problem: str | None, log: Path | None, force: bool
) -> None:
    """Write a tuned filter of a run and score what was written.

    Raises:
        ValueError: for an unknown problem or format, a solution that did not converge, or a file
            that is there already.
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
    folder = run if run.is_dir() else run.parent
    path = Path(output) if output else Path(f"{tuned.name}{export.suffix(to)}")
    export.write(tuned, path, to, overwrite=force)
    print(f"wrote {path}", file=sys.stderr)
    _score(folder, result, path, to, log)


def _choose(result: Result, problem: str | None) -> Tuned:
    tuned = [export.load(json.dumps(one).encode(), "json") for one in result.tuned]
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


def _score(folder: Path, result: Result, path: Path, to: str, log: Path | None) -> None:
    """Score the file on the run's data and add that to the result; say so where it cannot be."""
    from tuner.cli.again import plan_again
    from tuner.run.pipeline import score_export

    try:
        plan = plan_again(folder, log)
    except ValueError as error:
        print(f"not scored again: {error}", file=sys.stderr)
        return
    tuned = export.load(path.read_bytes(), to)
    problem = next(t.problem for t in plan.targets if t.problem.name == tuned.name)
    solution = next(
        s.solution()
        for s in result.solutions
        if (s.problem, s.solver) == (tuned.name, tuned.provenance.solver)
    )
    record = score_export(problem, solution.value, tuned, to, path.name)
    print(
        f"read back and scored: {record.score:.12g}, "
        f"{record.relative_change:+.1e} of the solution's value",
        file=sys.stderr,
    )
    grown = result.model_copy(update={"exports": [*result.exports, record]})
    write_bytes(folder / "result.json", grown.to_json().encode(), overwrite=True)
