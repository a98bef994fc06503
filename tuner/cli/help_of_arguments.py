"""Arguments in help as LOG..., not as {LOG}... <list[Path]>."""

from typing import Any


def with_plain_arguments(command: Any) -> Any:
    """The command of typer, whose help names arguments without braces and Python's types.

    >>> import typer
    >>> from tuner.cli import app
    >>> command = with_plain_arguments(typer.main.get_command(app))
    >>> with command.make_context("tuner", ["--help"], resilient_parsing=True) as context:
    ...     compare = command.get_command(context, "compare")
    >>> with compare.make_context("tuner compare", [], resilient_parsing=True) as context:
    ...     lines = compare.get_help(context).splitlines()
    >>> lines[0], [line.split()[0] for line in lines if "RUN" in line][1]
    ('Usage: tuner compare [OPTIONS] RUN...', 'RUN...')
    """
    for each in getattr(command, "commands", {}).values():
        for parameter in each.params:
            if parameter.param_type_name == "argument":
                _name_plainly(parameter)
    return command


def _name_plainly(argument: Any) -> None:
    """Typer has no setting for this: its own methods are replaced, of this argument alone."""
    name = f"{argument.metavar}..." if argument.nargs != 1 else argument.metavar
    usage = name if argument.required else f"[{name}]"
    argument.display_type_rich = lambda ctx: None
    argument._rich_display_name = lambda: name
    argument._usage_display_name = lambda: usage
