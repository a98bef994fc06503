"""tuner show: what a finished run found, again."""

from pathlib import Path

from tuner.run.result import read_result


def show(run: Path, *, json: bool) -> None:
    """Print the tables and lines that the run ended with; or its result.json.

    Raises:
        ValueError: where that is no folder of a finished run.
    """
    result = read_result(run)
    if json:
        print(result.to_json(), end="")
        return
    from tuner.cli.tables import show_result

    show_result(result, run if run.is_dir() else run.parent)
