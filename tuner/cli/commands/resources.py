"""The commands that need no run: list, columns, init, example and doctor."""

from pathlib import Path
from typing import Annotated

import typer

from tuner.cli.options import Force, Json


def list_(
    what: Annotated[
        str,
        typer.Argument(
            metavar="WHAT", help="studies, filters, objectives, solvers, formats or settings."
        ),
    ] = "studies",
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="Name of a filter; with settings, of a study."),
    ] = None,
    json: Json = False,
    md: Annotated[bool, typer.Option("--md", help="A Markdown page of filters.")] = False,
) -> None:
    """List studies, filters, objectives, solvers or formats, or show a filter's facts."""
    from tuner.cli.listing import show

    show(what, name, json=json, md=md)


def columns(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A log of any format.")],
    json: Json = False,
) -> None:
    """Show what a log holds: its columns, clocks, rates and units."""
    from tuner.cli.columns import show

    show(log, json=json)


def init(
    kind: Annotated[
        str, typer.Option(metavar="KIND", help="level, tracking, robot or pendulum.")
    ] = "level",
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="Instead of stdout.")
    ] = None,
    force: Force = False,
) -> None:
    """Write a commented model of your own to begin with."""
    from tuner.cli.init import show

    show(kind, output, force=force)


def example(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="level, rest, tracks or vario.")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE|-", help="Instead of KIND.csv.")
    ] = None,
    force: Force = False,
) -> None:
    """Write a simulated log to try things on."""
    from tuner.cli.example import show

    show(kind, output, force=force)


def doctor(json: Json = False) -> None:
    """Check the installation."""
    from tuner.cli.doctor import show

    raise typer.Exit(show(json))
