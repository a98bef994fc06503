"""The request for an export on the command line."""

from dataclasses import dataclass, field
from pathlib import Path

from tuner import export
from tuner.cli.filter_option import FilterOption
from tuner.export import Tuned


@dataclass(frozen=True)
class ExportRequest:
    """The request for an export on the command line.

    Attributes:
        to: the format; None: no file.
        output: the file; None: named for the filter; ``-``: stdout.
        problem: which one, where a run has several.
        rate_hz: the sample rate; None: the one that it was tuned at.
        densities: parameters that grow with the rate.
        filter_option: the file of the filter's class, where it is from one.
        force: whether a file is replaced, and what did not converge is exported.
        precision: of a filter in C; None: double.
        tunable: whether the parameters of a filter in C can be set as it runs.
        maps: of a firmware's file: NAME=KEY, what a number is there.
        axes: of a firmware's file: what one number for several axes is, largest or rms.
        approximate: whether the numbers may go to another filter, to begin with.
    """

    to: str | None
    output: str | None = None
    problem: str | None = None
    rate_hz: float | None = None
    densities: tuple[str, ...] = ()
    filter_option: FilterOption = field(default_factory=FilterOption)
    force: bool = False
    precision: str | None = None
    tunable: bool = False
    maps: tuple[str, ...] = ()
    axes: str | None = None
    approximate: bool = False


def output_path(tuned: Tuned, to: str, request: ExportRequest) -> Path:
    """The file that is written."""
    at = "" if request.rate_hz is None else f"_{request.rate_hz:g}hz"
    return Path(request.output) if request.output else Path(f"{tuned.name}{at}{export.suffix(to)}")
