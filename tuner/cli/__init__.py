"""The command line: results on stdout, everything else on stderr."""

import gc
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from tuner.cli.help_of_study import add_settings

app = typer.Typer(
    name="tuner",
    help="Tunes filters by optimisation: finds Q, R and gains, says how far they can be trusted, "
    "compares them with published values and exports them.",
    rich_markup_mode=None,
    add_completion=True,
    pretty_exceptions_enable=False,
)

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]
Force = Annotated[bool, typer.Option("--force", help="Replace existing files.")]
Maps = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=COLUMN", help="Channel: column[,column...][*factor][:unit]."),
]
Truths = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=COLUMN", help="True value of an output."),
]
Recordings = Annotated[
    list[Path], typer.Argument(metavar="LOG", help="Recordings, in any format of docs/logs.md.")
]
Logs = Annotated[
    list[Path] | None,
    typer.Option("--log", metavar="FILE", help="Recordings, in any format of docs/logs.md."),
]
Filter = Annotated[
    str | None,
    typer.Option(metavar="NAME|FILE.py:CLASS", help="Name of a filter, or FILE.py:CLASS."),
]
Model = Annotated[Path | None, typer.Option(metavar="FILE.toml", help="A model of your own.")]
Rate = Annotated[float | None, typer.Option("--rate", metavar="HZ", help="Sample rate of the log.")]
Time = Annotated[
    str | None, typer.Option(metavar="COLUMN", help="Time column; several: DATE,CLOCK.")
]
By = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMN|restart", help="Column that separates recordings; restart: the time."
    ),
]
DropRepeats = Annotated[
    bool | None,
    typer.Option("--drop-repeats", help="Leave out rows that repeat the previous time."),
]
From = Annotated[
    float | None, typer.Option("--from", metavar="S", help="Leave out what is earlier, s.")
]
To = Annotated[float | None, typer.Option("--to", metavar="S", help="Leave out what is later, s.")]
Out = Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for the results.")]
Seed = Annotated[
    int | None,
    typer.Option(min=0, max=2**31 - 1, metavar="N", help="Seed of all random numbers; else 0."),
]
Storage = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        envvar="TUNER_STORAGE",
        help="Database shared by processes; else SQLite in the folder.",
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(min=1, metavar="N", help="Number of processes; unset: threads."),
]
Resume = Annotated[bool, typer.Option("--resume", help="Resume the interrupted run in --out.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Print the plan, and stop.")]


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        print(f"filter-tuner {version('filter-tuner')}")
        raise typer.Exit


@app.callback()
def everywhere(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version.", callback=_version, is_eager=True),
    ] = False,
    memory: Annotated[
        str | None,
        typer.Option(metavar="SIZE", help="Memory limit, such as 4GB; in any position."),
    ] = None,
    traceback: Annotated[
        bool, typer.Option("--traceback", help="Show where an error came from; in any position.")
    ] = False,
) -> None:
    """Options of every command; of the last two the line is freed before it is read."""


@app.command("list")
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
    """List what there is, or what a filter takes, keeps and returns."""
    from tuner.cli.listing import show

    show(what, name, json=json, md=md)


@app.command()
def columns(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A log of any format.")],
    json: Json = False,
) -> None:
    """Show what a log holds: its columns, clocks, rates and units."""
    from tuner.cli.columns import show

    show(log, json=json)


@app.command()
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
    from tuner.cli.request import asked
    from tuner.cli.run import execute

    raise typer.Exit(execute(asked(study, ctx.params)))


@app.command()
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
    from tuner.cli.request import asked
    from tuner.cli.run import execute

    raise typer.Exit(execute(asked("fit", ctx.params, wishes(ctx.params))))


@app.command()
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

    asked = Worker(storage, study, tuple(logs or ()), FilterOption(filter), jobs, leashed)
    raise typer.Exit(execute(asked))


@app.command()
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


@app.command()
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


@app.command()
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
    from tuner.cli.request import asked

    raise typer.Exit(show(run, asked("fit", ctx.params), objective))


@app.command()
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


@app.command()
def show(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="Folder of a run, or its result.json.")
    ],
    json: Json = False,
) -> None:
    """Show what a finished run found, again."""
    from tuner.cli.show import show

    show(run, json=json)


@app.command()
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


@app.command()
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


@app.command()
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


@app.command()
def doctor(json: Json = False) -> None:
    """Check the installation."""
    from tuner.cli.doctor import show

    raise typer.Exit(show(json))


def main() -> None:
    """Run the command line, with one line on stderr and exit code 2 for what a user can mend."""
    if "_TUNER_COMPLETE" in os.environ:  # a shell asks how a line may go on
        app(prog_name="tuner")
    from tuner.cli.process_exit import exit_process
    from tuner.stop import heed, interrupt

    # Looking for cycles among a million objects of JAX takes a tenth of a fit.
    gc.set_threshold(100_000, 50, 100)
    heed(interrupt)
    exit_process(invoke(sys.argv[1:], alone=True))


def invoke(arguments: list[str], *, alone: bool = False) -> int:
    """Run the command line with given arguments and return its exit code.

    Args:
        arguments: its words.
        alone: whether the process does nothing else, so that a bound on memory may be put on it.
    """
    from tuner.cli.common_options import CommonOptions
    from tuner.cli.exit_code import exit_code_of

    asked = CommonOptions.of(arguments)

    def run() -> int:
        with asked.bounded(alone=alone):
            return _commanded(asked.rest or ["--help"])

    return exit_code_of(run, with_traceback=asked.traceback)


def _commanded(arguments: list[str]) -> int:
    """Run a command by hand: typer's own way ends the process in its own words."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("tuner", arguments) as context:
            return int(command.invoke(context) or 0)
    except typer.Exit as ended:
        add_settings(arguments)
        return ended.exit_code
    except typer.Abort:
        raise KeyboardInterrupt from None
