"""tuner export: one tuned filter of a run as a file, read back; at another rate if asked for."""

import sys
from pathlib import Path

from tuner import export
from tuner.cli.export_c import write_c
from tuner.cli.export_firmware import write_firmware
from tuner.cli.exported import at_rate, check_converged, choose, tuned_of
from tuner.cli.wanted import Wanted, path_of
from tuner.export import Tuned
from tuner.firmware import TARGETS
from tuner.names import unknown
from tuner.run.result import read_result
from tuner.shown import hand_out


def write(run: Path, wanted: Wanted) -> None:
    """Write a tuned filter of a run, read it back and compare it with what the run found.

    Raises:
        ValueError: for an unknown problem or format, a run that exports nothing, a solution that
            did not converge, a file that is there already, one that was written wrong, and a filter
            that there is not at another rate.
    """
    if wanted.to is None and wanted.rate_hz is None:
        formats = "|".join([*export.FORMATS, *TARGETS])
        raise ValueError(
            f"give the format, --to {formats}, or --rate HZ to see the numbers at another rate"
        )
    if wanted.to != "c" and (wanted.precision or wanted.tunable):
        raise ValueError("--precision and --tunable need --to c")
    if wanted.to is not None and wanted.to not in (*export.FORMATS, *TARGETS):
        raise unknown("format", wanted.to, [*export.FORMATS, *TARGETS])
    if wanted.to in TARGETS:
        write_firmware(run, TARGETS[wanted.to], wanted)
        return
    if wanted.maps or wanted.axes or wanted.approximate:
        raise ValueError(f"--map, --axes and --accept-approximate need --to {'|'.join(TARGETS)}")
    result = read_result(run)
    tuned = choose(tuned_of(result), wanted.problem)
    check_converged(tuned, wanted)
    found = None
    if wanted.rate_hz is not None:
        found = at_rate(run, result, tuned, wanted.rate_hz, wanted)
        tuned = found.tuned
    elif wanted.densities:
        raise ValueError("--density needs --rate HZ")
    if wanted.to == "c":
        write_c(run, result, tuned, found, wanted)
    elif wanted.to is not None:
        _write(tuned, wanted.to, wanted)


def _write(tuned: Tuned, to: str, wanted: Wanted) -> None:
    data = export.dump(tuned, to)
    if wanted.output == "-":
        hand_out(data, sys.stdout)
        return
    path = path_of(tuned, to, wanted)
    export.write(tuned, path, to, overwrite=wanted.force)
    export.read_back(tuned, path, to)
    print(f"wrote {path}: {len(tuned.quantities)} quantities, read back equal", file=sys.stderr)
