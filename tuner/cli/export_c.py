"""tuner export --to c: the code that a run wrote, or that of another rate."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tuner import export
from tuner.cli.export_request import ExportRequest, output_path
from tuner.code.files import Files
from tuner.export import ExportError, Tuned
from tuner.run.code_files import Variant, kept, renamed, write
from tuner.run.result import Result
from tuner.terminal_text import write_to_stream

if TYPE_CHECKING:
    from tuner.run.at_rate import AtRate


def write_c(
    run: Path, result: Result, tuned: Tuned, at_rate: "AtRate | None", request: ExportRequest
) -> None:
    """Write header, source and self-test; the header alone and why, where there is no code.

    Raises:
        ValueError: for an unknown precision, a file that is there, and code that is not that of the
            run's numbers.
    """
    if request.precision not in (None, "double", "float"):
        raise ValueError(f"--precision is {request.precision!r}; give double or float")
    variant = Variant("float" if request.precision == "float" else "double", request.tunable)
    path = output_path(tuned, "c", request)
    try:
        files = _files(run, result, tuned, at_rate, variant, path)
    except ValueError as error:
        if request.precision or request.tunable or isinstance(error, ExportError):
            raise
        print(f"numbers only: {error}", file=sys.stderr)
        _numbers(tuned, path, request)
        return
    if request.output == "-":
        sys.stdout.write(files.whole)
        return
    paths = write(files, path, overwrite=request.force)
    export.read_back(tuned, path, "c")
    more = " and ".join(each.name for each in paths[1:])
    count = len(tuned.quantities)
    print(f"wrote {path}: {count} quantities, read back equal; {more}", file=sys.stderr)


def _numbers(tuned: Tuned, path: Path, request: ExportRequest) -> None:
    if request.output == "-":
        write_to_stream(export.dump(tuned, "c"), sys.stdout)
        return
    export.write(tuned, path, "c", overwrite=request.force)
    export.read_back(tuned, path, "c")
    print(f"wrote {path}: {len(tuned.quantities)} quantities, read back equal", file=sys.stderr)


def _files(
    run: Path,
    result: Result,
    tuned: Tuned,
    at_rate: "AtRate | None",
    variant: Variant,
    path: Path,
) -> Files:

    if at_rate is not None:
        from tuner.run.machine import code_of

        return code_of(tuned, at_rate.trials(), variant, path.name).files
    refused = [c.refused for c in result.code if c.problem == tuned.name and c.refused]
    stem = (run if run.is_dir() else run.parent) / kept(tuned.name, variant)
    paths = [stem.with_name(f"{stem.name}{end}") for end in (".h", ".c", "_selftest.c")]
    if not all(each.is_file() for each in paths):
        raise ValueError(
            refused[0] if refused else f"{run} has no C of {tuned.name}; run it again to have it"
        )
    texts = [each.read_text("ascii") for each in paths]
    if export.load(texts[0].encode(), "c") != tuned:
        raise ExportError(f"{paths[0]} was not written by this run; run it again")
    return Files(*(renamed(text, f"{tuned.name}.h", path.name) for text in texts))
