"""tuner export --to px4 and others: noise of a run in the file of another filter or program."""

import math
import sys
from pathlib import Path

from tuner.atomic import write_bytes
from tuner.cli.export_request import ExportRequest
from tuner.cli.exported import at_rate, check_converged, choose, tuned_of
from tuner.export import Tuned
from tuner.firmware import FileRequest, Target, Wish, amounts, read_maps
from tuner.firmware.choice import Axes
from tuner.names import counted
from tuner.run.result import Result, read_result

_AXES: dict[str, Axes] = {"largest": "largest", "rms": "rms"}


def write_firmware(run: Path, target: Target, request: ExportRequest) -> None:
    """Write what of a run has a meaning there; what was changed or left out goes to stderr.

    Raises:
        ValueError: where the target is another filter and that was not accepted, and for numbers
            that have no meaning there, or more than one.
    """
    file_request = _request_of(run, target, request)
    if target.filter and not request.approximate:
        names = ", ".join(dict.fromkeys(each.filter for each in file_request.tuned))
        raise ValueError(
            f"{target.filter} is another filter than {names}, so these are initial values to be "
            "tried; --accept-approximate writes them"
        )
    text = target.written(file_request)
    notes = list(text.notes)
    if request.output == "-":
        sys.stdout.write(text.text)
    else:
        path = Path(request.output or target.file)
        write_bytes(path, text.text.encode("ascii"), overwrite=request.force)
        notes.append(f"wrote {path}: {counted(text.numbers, 'parameter')}")
    print(*notes, sep="\n", end="\n" * bool(notes), file=sys.stderr)


def _request_of(run: Path, target: Target, request: ExportRequest) -> FileRequest:
    axes = _AXES.get(request.axes or "")
    if request.axes is not None and axes is None:
        raise ValueError(f"--axes is {request.axes!r}; give {' or '.join(_AXES)}")
    if request.densities and not target.of_model:
        raise ValueError(f"--density does not apply to {target.name}; leave it out")
    rate = request.rate_hz
    if rate is not None and not 0 < rate < math.inf:
        raise ValueError(f"--rate is {rate:g}; give a positive number of samples a second")
    result = read_result(run)
    tuned = _tuned(run, result, target, request)
    parameters, limits = _parameters(result, tuned)
    found = tuple(amounts(tuned, result.findings, limits))
    log_rate = result.log.rate_hz
    log_rate = log_rate if log_rate and math.isfinite(log_rate) else 0.0
    return FileRequest(
        tuned, found, parameters, Wish(read_maps(request.maps), axes), rate, log_rate
    )


def _parameters(
    result: Result, tuned: tuple[Tuned, ...]
) -> tuple[dict[str, bool], dict[tuple[str, str], float]]:
    """Parameters, by the amounts' names, with whether they were searched for; and upper limits."""
    found, limits = {}, {}
    for one in tuned:
        prefix = f"{one.name}." if len(tuned) > 1 else ""
        for solution in result.solutions:
            if (solution.problem, solution.solver) != (one.name, one.provenance.solver):
                continue
            for name, parameter in solution.parameters.items():
                found[f"{prefix}{name}"] = parameter.interval is not None
                low, high = parameter.interval or (1.0, None)
                if not low:
                    limits[one.name, name] = math.inf if high is None else high
    return found, limits


def _tuned(run: Path, result: Result, target: Target, request: ExportRequest) -> tuple[Tuned, ...]:
    """All that converged, or the one that was chosen; at the rate asked for, if it matters."""
    tuned = tuned_of(result)
    if request.problem is not None or target.of_model:
        tuned = [choose(tuned, request.problem)]
    for each in tuned:
        check_converged(each, request)
    if not target.of_model or request.rate_hz is None:
        return tuple(tuned)
    return (at_rate(run, result, tuned[0], request.rate_hz, request).tuned,)
