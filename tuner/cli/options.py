"""Options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

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
