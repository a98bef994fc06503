"""The command line: results on stdout, everything else on stderr."""

import gc
import os
import sys
from typing import Annotated

import typer

from tuner.cli.commands import resources, results, tuning
from tuner.cli.help_of_arguments import with_plain_arguments
from tuner.cli.help_of_study import add_settings

app = typer.Typer(
    name="tuner",
    help="Tunes filters by optimisation: finds Q, R and gains, says how far they can be trusted, "
    "compares them with published values and exports them.",
    rich_markup_mode=None,
    add_completion=True,
    pretty_exceptions_enable=False,
)


def _version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        print(f"filter-tuner {version('filter-tuner')}")
        raise typer.Exit


@app.callback()
def common_options(
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
    """Options of every command; the last two are taken out of the line before it is read."""


app.command("list")(resources.list_)
app.command("columns")(resources.columns)
app.command("run")(tuning.run)
app.command("fit")(tuning.fit)
app.command("worker")(tuning.worker)
app.command("init")(resources.init)
app.command("example")(resources.example)
app.command("check")(tuning.check)
app.command("compare")(results.compare)
app.command("show")(results.show)
app.command("report")(results.report)
app.command("export")(results.export)
app.command("dashboard")(results.dashboard)
app.command("doctor")(resources.doctor)


TURN = 5e-4
"""Time in s for which a thread of several keeps the interpreter."""


def main() -> None:
    """Run the command line, with one line on stderr and exit code 2 for what a user can mend."""
    if "_TUNER_COMPLETE" in os.environ:  # a shell asks how a line may go on
        app(prog_name="tuner")
    from tuner.cli.process_exit import exit_process
    from tuner.stop import heed, interrupt

    # XLA's word that a compilation takes long, which says nothing to a user; errors are raised.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    os.environ.setdefault("TUNER_PROGRAMS", "stored")
    # Looking for cycles among a million objects of JAX takes a fifth of a second and finds none.
    gc.set_threshold(1_000_000, 5, 100)
    # A search comes back from compiled code every millisecond, and waits so long at most for a
    # thread that imports or writes: 5 ms, Python's own, double its time.
    sys.setswitchinterval(TURN)
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

    options = CommonOptions.of(arguments)

    def run() -> int:
        with options.bounded(alone=alone):
            return _commanded(options.rest or ["--help"])

    return exit_code_of(run, with_traceback=options.traceback)


def _commanded(arguments: list[str]) -> int:
    """Run a command by hand: typer's own way ends the process in its own words."""
    command = with_plain_arguments(typer.main.get_command(app))
    try:
        with command.make_context("tuner", arguments) as context:
            return int(command.invoke(context) or 0)
    except typer.Exit as ended:
        add_settings(arguments)
        return ended.exit_code
    except typer.Abort:
        raise KeyboardInterrupt from None
