"""The commands that tune and check: run, fit, worker and check."""

from pathlib import Path
from typing import Annotated

import typer

from tuner.cli.options import (
    By,
    DropRepeats,
    DryRun,
    Filter,
    Force,
    From,
    Jobs,
    Json,
    Logs,
    Maps,
    Model,
    Out,
    Rate,
    Recordings,
    Resume,
    Seed,
    Storage,
    Time,
    To,
    Truths,
)


def run(
    ctx: typer.Context,
    study: Annotated[
        str,
        typer.Argument(metavar="STUDY", help="A study's name, or a study.toml of an earlier run."),
    ],
    logs: Logs = None,
    filter: Filter = None,
    model: Model = None,
    map: Maps = None,
    truth: Truths = None,
    rate_hz: Rate = None,
    time: Time = None,
    by: By = None,
    drop_repeats: DropRepeats = None,
    from_s: From = None,
    to_s: To = None,
    sets: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="A setting of the study."),
    ] = None,
    claims: Annotated[
        list[str] | None,
        typer.Option(
            "--claim", metavar="NAME", help="Check only this row of the comparison; * for any."
        ),
    ] = None,
    out: Out = None,
    seed: Seed = None,
    storage: Storage = None,
    jobs: Jobs = None,
    resume: Resume = False,
    dry_run: DryRun = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run a study, on its own data or on a log.

    Writes a folder with results, report and exports.
    """
    from tuner.cli.request import request_from
    from tuner.cli.run import execute

    raise typer.Exit(execute(request_from(study, ctx.params)))


def fit(
    ctx: typer.Context,
    logs: Recordings,
    filter: Filter = None,
    model: Model = None,
    map: Maps = None,
    truth: Truths = None,
    rate_hz: Rate = None,
    time: Time = None,
    by: By = None,
    drop_repeats: DropRepeats = None,
    from_s: From = None,
    to_s: To = None,
    start: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Initial value of the search.")
    ] = None,
    fix: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Hold a parameter.")
    ] = None,
    bound: Annotated[
        list[str] | None, typer.Option(metavar="NAME=LOW..HIGH", help="Range of the search.")
    ] = None,
    options: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="A filter's option; held_out, against."),
    ] = None,
    objective: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="Objective; unset: the error or the likelihood; two: a front."
        ),
    ] = None,
    solver: Annotated[
        str, typer.Option(metavar="NAME", help="Solver; see tuner list solvers.")
    ] = "l-bfgs-b",
    starts: Annotated[int, typer.Option(min=1, metavar="N", help="Starts of the search.")] = 4,
    hold_out: Annotated[
        bool, typer.Option(show_default=False, help="Judge a second fit on held-out data, or not.")
    ] = True,
    out: Out = None,
    seed: Seed = None,
    storage: Storage = None,
    jobs: Jobs = None,
    resume: Resume = False,
    dry_run: DryRun = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Tune a filter on recordings of your own.

    Writes a folder with results, report and exports.
    """
    from tuner.cli.pairs import wishes
    from tuner.cli.request import request_from
    from tuner.cli.run import execute

    raise typer.Exit(execute(request_from("fit", ctx.params, wishes(ctx.params))))


def worker(
    study: Annotated[str, typer.Option(metavar="NAME", help="The run, as tuner run names it.")],
    storage: Annotated[
        str,
        typer.Option(metavar="URL", envvar="TUNER_STORAGE", help="Database of the run."),
    ],
    logs: Annotated[
        list[Path] | None,
        typer.Option("--log", metavar="FILE", help="Its recordings, if not in this folder."),
    ] = None,
    filter: Annotated[
        str | None, typer.Option(metavar="FILE.py:CLASS", help="Its filter, if it is a file.")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, metavar="N", help="Processes on this machine.")] = 1,
    leashed: Annotated[bool, typer.Option("--leashed", hidden=True)] = False,
) -> None:
    """Work on a run of another machine, until it is solved."""
    from tuner.cli.filter_option import FilterOption
    from tuner.cli.worker import Worker, execute

    request = Worker(storage, study, tuple(logs or ()), FilterOption(filter), jobs, leashed)
    raise typer.Exit(execute(request))


def check(
    ctx: typer.Context,
    run: Annotated[
        Path | None,
        typer.Argument(metavar="RUN", help="Folder of a fit, whose values are checked."),
    ] = None,
    logs: Logs = None,
    filter: Filter = None,
    model: Model = None,
    sets: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter in use, or an option of the filter.",
        ),
    ] = None,
    map: Maps = None,
    truth: Truths = None,
    rate_hz: Rate = None,
    time: Time = None,
    by: By = None,
    drop_repeats: DropRepeats = None,
    from_s: From = None,
    to_s: To = None,
    objective: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Objective; unset: the error or the likelihood."),
    ] = None,
    json: Json = False,
) -> None:
    """Check values in use on a recording that they were not tuned on."""
    from tuner.cli.check import show
    from tuner.cli.request import request_from

    raise typer.Exit(show(run, request_from("fit", ctx.params), objective))
