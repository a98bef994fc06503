"""Time of compilation and start, in fresh processes."""

import tempfile
from functools import partial

import numpy as np

from benchmarks.processes import measure, python
from benchmarks.table import Row, duration, number
from benchmarks.timing import interleave
from benchmarks.work import Work

PART = "Compilation and start"
HELP = (
    "import sys; sys.argv = ['tuner', '--help']; from tuner.cli import main; sys.exit(main() or 0)"
)
STARTS = {"tuner --help": HELP, "python": "pass", "import typer": "import typer"}
RUNS = 7


def rows(work: Work) -> list[Row]:
    """The 2-state filter's compilation, and the command line's first words."""
    return [*compiling(PART, "compiling", work.samples, 1.0), _help()]


def compiling(part: str, task: str, samples: int, target: float) -> list[Row]:
    """Compilation time of a worker's task, thrice in fresh processes, against a target in s."""
    found = [measure(task, samples=samples) for _ in range(3)]
    return [
        Row(
            part=part,
            what=f"compile {name}",
            figure=float(np.median([run[name] for run in found])),
            best=min(run[name] for run in found),
            unit="s",
            target=target,
            why="LLVM's time, which other work on the machine stretches",
        )
        for name in found[0]
    ]


def _help() -> Row:
    with tempfile.TemporaryDirectory() as folder:
        calls = {name: partial(python, code, folder) for name, code in STARTS.items()}
        times = interleave(calls, RUNS)
    ours = "tuner --help"
    others = [f"{name}: {duration(times.median(name))}" for name in STARTS if name != ours]
    above = times.best(ours) - times.best("import typer")
    return Row(
        part=PART,
        what=ours,
        ours=duration(times.median(ours)),
        against=", ".join(others),
        figure=1e3 * times.median(ours),
        best=1e3 * times.best(ours),
        unit="ms",
        target=150.0,
        note=f"{duration(max(above, 0.0))} above what importing typer alone takes",
        why=f"Python and typer alone take {number(1e3 * times.median('import typer'))} ms here",
    )
