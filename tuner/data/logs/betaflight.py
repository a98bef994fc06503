"""Betaflight's blackbox as CSV: lines about the flight stand above the names of the columns."""

import shutil
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from tuner.data.logs.csv import open_csv
from tuner.data.logs.error import LogError
from tuner.data.logs.home import Home
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Loaded, Raw, Table
from tuner.names import counted

MAGICS = (
    b"H Product:Blackbox", b'"H Product:Blackbox', b'"Product","Blackbox', b'"Firmware revision",',
    b'"Firmware type",', b"loopIteration,", b'"loopIteration",',
)  # fmt: skip
_FORMAT = "Betaflight blackbox CSV"
_MOST = 10_000
_TIMES = ("time", "time (us)")
_FEWEST = 3


def open_betaflight(path: Path) -> Table:
    """Open a file of blackbox_decode or the Blackbox Explorer: columns ``gyroADC[0]``.

    Times are in microseconds, whether the column says so or not.

    Raises:
        LogError: where it is the raw log, or no line names the columns.
    """
    above = _above(path)
    table, notes = _below(path, above) if above else (open_csv(path), ())
    time = Mapping("time", "time", unit="us") if "time" in table.names else table.time
    return replace(table, time=time, format=_FORMAT, notes=(*table.notes, *notes))


def _below(path: Path, above: int) -> tuple[Table, tuple[str, ...]]:
    """The table below some lines: that of a copy in which they are comments."""
    home = Home()
    plain = Path(home.path, path.name)
    with path.open("rb") as stream, plain.open("wb") as out:
        for _ in range(above):
            stream.readline()
            out.write(b"#\n")  # so that lines keep their numbers
        shutil.copyfileobj(stream, out)
    table = open_csv(plain)
    note = f"{counted(above, 'line')} about the flight above the names"
    return replace(table, load=partial(_load, home, table)), (note,)


def _load(_: Home, table: Table, names: Sequence[str]) -> dict[str, Raw] | Loaded:
    """Load from the copy, whose folder is held by this very call's first argument."""
    return table.load(names)


def _above(path: Path) -> int:
    """Number of lines above the names of the columns."""
    with path.open("rb") as stream:
        for number in range(_MOST):
            line = stream.readline(1 << 16)
            if not line:
                break
            if b"\0" in line or not _is_text(line):
                raise LogError(
                    f"{path.name}: this is a raw Betaflight log; decode it by blackbox_decode, and "
                    "name the CSV file that it writes"
                )
            cells = [cell.strip().strip('"') for cell in line.decode().split(",")]
            if len(cells) >= _FEWEST and set(cells) & set(_TIMES):
                return number
    raise LogError(
        f"{path.name}: no line of the Betaflight log names columns (loopIteration, time, ...); "
        "decode it again by blackbox_decode"
    )


def _is_text(line: bytes) -> bool:
    try:
        line.decode()
    except UnicodeDecodeError:
        return False
    return True
