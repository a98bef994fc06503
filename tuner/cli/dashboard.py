"""tuner dashboard: the trials of samplers in a browser, by optuna-dashboard."""

from importlib.util import find_spec
from pathlib import Path

TRIALS = "trials.sqlite3"


def serve(run: Path | None, storage: str | None, port: int) -> None:
    """Serve the trials of a run, or of a database, until it is interrupted.

    Args:
        run: a run's folder.
        storage: the database's URL.
        port: of this machine alone; nobody else can look.

    Raises:
        ValueError: without either, without trials, and without optuna-dashboard.
    """
    url = storage or _of_run(run)
    if find_spec("optuna_dashboard") is None:
        raise ValueError(
            "the dashboard is an extra that is not installed: pip install 'filter-tuner[dashboard]'"
        )
    from optuna_dashboard import run_server

    run_server(url, host="localhost", port=port)


def _of_run(run: Path | None) -> str:
    if run is None:
        raise ValueError("name a run, tuner dashboard RUN, or give --storage URL")
    file = run / TRIALS
    if not file.is_file():
        raise ValueError(
            f"{run} holds no {TRIALS}: only samplers write trials, as by --solver tpe or --set "
            'solvers=["tpe"]'
        )
    return f"sqlite:///{file}"
