"""Text logs: CSV, TXT and TSV, plain or gzip-compressed."""

import csv
import os
import zlib
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from tuner.data.logs.block import Block, read_rows, tidied
from tuner.data.logs.error import LogError
from tuner.data.logs.kinds import Chosen
from tuner.data.logs.layout import Layout, read_layouts
from tuner.data.logs.parts import Part, mend, read_part, reader_of, text_of
from tuner.data.logs.store import Store
from tuner.data.logs.stream import lines
from tuner.data.logs.table import Loaded, Raw, Table, together
from tuner.names import counted

_AT_ONCE = min(4, os.cpu_count() or 1)
_NEWLINE = ord("\n")


def open_csv(path: Path) -> Table:
    """Open a text log with or without a header.

    Delimiter (tab, semicolon, comma, bar or blanks), decimal mark, lines above the names, units
    below them and letters are found from the first lines; lines that start with ``#`` or ``%``
    are comments. Nameless columns are called column1, column2, ... It is compressed where its
    bytes say so. Where rows are of several kinds, ``IMU,...`` and ``GPS,...``, the columns are
    called ``IMU/name``, and each kind has a clock of its own.

    Raises:
        LogError: where the file is damaged, is no text or holds no numbers; loading raises it
            for ragged rows and for text in a column of numbers.
    """
    with _as_log_error(path):
        layouts = read_layouts(path)
    tables = [_table(layout, f"{kind}/" if kind else "") for kind, layout in layouts.items()]
    if len(tables) == 1:
        return tables[0]
    return together(path.name, tables, "text with rows of several kinds")


def _table(layout: Layout, prefix: str) -> Table:
    """The table of the rows of one kind."""
    heads = (tidied(layout, head + b"\n").rstrip(b"\n") for head in layout.heads)
    layout = replace(layout, heads=frozenset(heads))

    def index(name: str) -> int:
        return layout.names.index(name.removeprefix(prefix))

    def kind(word: str) -> Table:
        return _table(replace(layout, chosen=Chosen(layout.words[word], word)), f"{word}/")

    def load(names: Sequence[str]) -> Loaded:
        with _as_log_error(layout.path):
            return _load(layout, {name: index(name) for name in names})

    def place(row: int) -> str:
        return f"line {_line_number(layout, row)}"

    def labels(name: str) -> Raw:
        with _as_log_error(layout.path):
            return _words(layout, index(name))

    return Table(
        layout.path.name,
        tuple(prefix + name for name in layout.names),
        load,
        place,
        numbered=True,
        texts=frozenset(prefix + name for name in layout.texts),
        labels=labels,
        kinds={} if layout.chosen else {word: partial(kind, word) for word in layout.words},
        prefix=prefix,
        moments=frozenset(prefix + name for name in layout.moments),
        units={prefix + name: unit for name, unit in layout.units.items()},
        notes=layout.notes,
    )


@contextmanager
def _as_log_error(path: Path) -> Iterator[None]:
    """Turn the exceptions of a damaged file into a sentence."""
    try:
        yield
    except (OSError, EOFError, zlib.error, csv.Error) as error:
        raise LogError(
            f"{path.name}: the file cannot be read ({error}); copy or export it again"
        ) from error


def _blocks(layout: Layout) -> Iterator[Block]:
    """The lines below the names."""
    left, number = layout.above, 1
    held: Block | None = None
    for text in lines(layout.path, layout.encoding):
        skipped = 0
        while left and skipped < len(text):
            skipped = (text.find(b"\n", skipped) + 1) or len(text)
            left, number = left - 1, number + 1
        if rest := text[skipped:]:
            if held is not None:
                yield held
            held = Block(rest, number)
            number += int(np.count_nonzero(np.frombuffer(rest, np.uint8) == _NEWLINE))
    if held is not None:
        yield replace(held, last=True)


def _load(layout: Layout, places: Mapping[str, int]) -> Loaded:
    """Some columns, and notes on them."""
    dates = [place for place in places.values() if layout.names[place] in layout.moments]
    others = [place for place in places.values() if layout.names[place] not in layout.moments]
    written: dict[int, list[Raw]] = {place: [] for place in dates}
    store = Store(layout.path.stat().st_size, len(others))
    known: dict[bytes, tuple[float, str] | None] = {}
    left_out: Counter[str] = Counter()
    cell_notes: Counter[str] = Counter()
    for part in _in_turn(layout, dates, others):
        left_out.update(part.left_out)
        mend(layout, part, others, known, cell_notes)
        for place, cells in part.dates.items():
            written[place].append(cells)
        store.add(part.values, part.whole, part.size)
    found = dict(zip(others, store.columns(), strict=True))
    found |= {place: _together(cells) for place, cells in written.items()}
    notes = [f"{counted(number, what)} left out" for what, number in left_out.items()]
    notes += [f"{what} in {counted(number, 'cell')}" for what, number in cell_notes.items()]
    return Loaded({name: found[place] for name, place in places.items()}, tuple(notes))


def _together(cells: list[Raw]) -> Raw:
    return np.concatenate(cells) if cells else np.empty(0, "S1")


def _in_turn(layout: Layout, dates: list[int], others: list[int]) -> Iterator[Part]:
    """The blocks one after another, of which a few are worked on at a time."""
    read = reader_of(layout, dates, others)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        waiting: deque[Future[Part]] = deque()
        for block in _blocks(layout):
            waiting.append(pool.submit(read_part, layout, block, dates, others, read))
            if len(waiting) > _AT_ONCE:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _words(layout: Layout, column: int) -> Raw:
    """One column as it is written."""
    grids = (read_rows(layout, block).grid for block in _blocks(layout))
    cells = [cell for grid in grids for cell in grid.cells(column)]
    return np.array([text_of(layout, cell) for cell in cells])


def _line_number(layout: Layout, row: int) -> int:
    """The line of a row of numbers, counted from 1; read again, since only errors ask for it."""
    for block in _blocks(layout):
        found = read_rows(layout, block).lines
        if row < len(found):
            return found[row]
        row -= len(found)
    return row
