"""tuner export: one tuned filter of a run as a file, read back; at another rate if asked for."""

import sys
from pathlib import Path

from tuner import export
from tuner.cli.export_c import write_c
from tuner.cli.export_firmware import write_firmware
from tuner.cli.export_request import ExportRequest, output_path
from tuner.cli.exported import at_rate, check_converged, choose, tuned_of
from tuner.export import Tuned
from tuner.firmware import TARGETS
from tuner.names import unknown
from tuner.run.result import read_result
from tuner.terminal_text import write_to_stream


def write(run: Path, request: ExportRequest) -> None:
    """Write a tuned filter of a run, read it back and compare it with what the run found.

    Raises:
        ValueError: for an unknown problem or format, a run that exports nothing, a solution that
            did not converge, a file that is there already, one that was written wrong, and a filter
            that there is not at another rate.
    """
    if request.to is None and request.rate_hz is None:
        formats = "|".join([*export.FORMATS, *TARGETS])
        raise ValueError(
            f"give the format, --to {formats}, or --rate HZ to see the numbers at another rate"
        )
    if request.to != "c" and (request.precision or request.tunable):
        raise ValueError("--precision and --tunable need --to c")
    if request.to is not None and request.to not in (*export.FORMATS, *TARGETS):
        raise unknown("format", request.to, [*export.FORMATS, *TARGETS])
    if request.to in TARGETS:
        write_firmware(run, TARGETS[request.to], request)
        return
    if request.maps or request.axes or request.approximate:
        raise ValueError(f"--map, --axes and --accept-approximate need --to {'|'.join(TARGETS)}")
    result = read_result(run)
    tuned = choose(tuned_of(result), request.problem)
    check_converged(tuned, request)
    found = None
    if request.rate_hz is not None:
        found = at_rate(run, result, tuned, request.rate_hz, request)
        tuned = found.tuned
    elif request.densities:
        raise ValueError("--density needs --rate HZ")
    if request.to == "c":
        write_c(run, result, tuned, found, request)
    elif request.to is not None:
        _write(tuned, request.to, request)


def _write(tuned: Tuned, to: str, request: ExportRequest) -> None:
    data = export.dump(tuned, to)
    if request.output == "-":
        write_to_stream(data, sys.stdout)
        return
    path = output_path(tuned, to, request)
    export.write(tuned, path, to, overwrite=request.force)
    export.read_back(tuned, path, to)
    print(f"wrote {path}: {len(tuned.quantities)} quantities, read back equal", file=sys.stderr)
