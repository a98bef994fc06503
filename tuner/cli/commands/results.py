"""The commands on a finished run: compare, show, report, export and dashboard."""

from pathlib import Path
from typing import Annotated

import typer

from tuner.cli.options import Force, Json, Storage


def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN", help="Folders of runs, or their result.json."),
    ],
    tol: Annotated[
        str | None, typer.Option(metavar="5%", help="Tolerance instead of each row's own.")
    ] = None,
    json: Json = False,
    md: Annotated[bool, typer.Option("--md", help="A Markdown table.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Comma-separated values.")] = False,
) -> None:
    """Compare runs with their paper, or fits with each other.

    Ends with exit code 1 where a row is outside its tolerance.
    """
    from tuner.cli.compare import show

    raise typer.Exit(show(runs, tol, json=json, md=md, csv=csv))


def show(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Folder of a run, or its result.json.")
    ],
    json: Json = False,
) -> None:
    """Show what a finished run found, again."""
    from tuner.cli.show import show

    show(run, json=json)


def report(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Folder of a run, or its result.json.")
    ],
    to: Annotated[
        str | None, typer.Option(metavar="FORM", help="html, md, or pdf by a browser.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="FILE|-", help="In the run's folder; - is stdout."),
    ] = None,
    force: Force = False,
) -> None:
    """Write the report of a finished run again, as one file."""
    from tuner.cli.report import write

    write(run, to, output, force=force)


def export(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Folder of a run, or its result.json.")
    ],
    to: Annotated[str | None, typer.Option(metavar="FORMAT", help="Name of a format.")] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE|-", help="- is stdout.")
    ] = None,
    problem: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Which one, where the run has several."),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="For another sample rate: Q, K, alpha, beta.")
    ] = None,
    density: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="With --rate: a variance that grows with the rate."),
    ] = None,
    filter: Annotated[
        str | None,
        typer.Option(metavar="FILE.py:CLASS", help="With --rate: the filter, if it is a file."),
    ] = None,
    precision: Annotated[
        str | None,
        typer.Option(metavar="WORD", help="With --to c: double, or float for small processors."),
    ] = None,
    tunable: Annotated[
        bool, typer.Option("--tunable", help="With --to c: parameters that can be set.")
    ] = False,
    map: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=KEY", help="Firmware parameter of a number: R=EKF2_BARO_NOISE."),
    ] = None,
    axes: Annotated[
        str | None,
        typer.Option(metavar="WORD", help="One number for several axes: largest or rms."),
    ] = None,
    approximate: Annotated[
        bool,
        typer.Option("--accept-approximate", help="Write initial values for another filter."),
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace the file; export what did not converge.")
    ] = False,
) -> None:
    """Write a tuned filter as a file, or show it at another rate.

    The file is read back and compared.
    """
    from tuner.cli.export import write
    from tuner.cli.export_request import ExportRequest
    from tuner.cli.filter_option import FilterOption

    request = ExportRequest(
        to=to,
        output=output,
        problem=problem,
        rate_hz=rate,
        densities=tuple(density or ()),
        filter_option=FilterOption(filter),
        force=force,
        precision=precision,
        tunable=tunable,
        maps=tuple(map or ()),
        axes=axes,
        approximate=approximate,
    )
    write(run, request)


def dashboard(
    run: Annotated[Path | None, typer.Argument(metavar="RUN", help="Folder of a run.")] = None,
    storage: Storage = None,
    port: Annotated[
        int, typer.Option(min=1024, max=65535, metavar="N", help="Port of this machine.")
    ] = 8080,
) -> None:
    """Show the trials of samplers in a browser."""
    from tuner.cli.dashboard import serve

    serve(run, storage, port)
