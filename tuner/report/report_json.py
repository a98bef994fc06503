"""The file ``report.json`` of a run: its pictures as few points, and its sentences."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final, Literal

import numpy as np
from pydantic import Field

from tuner.data.description import in_parts
from tuner.data.record import Record
from tuner.report.thinning import rounded, rows
from tuner.run.figure import Chart, Drawn, Line, Map
from tuner.run.fit_record import Recorded
from tuner.run.report_figure import Part, ReportFigure

POINTS = 50_000
"""Of all pictures together, about; a report stays small enough for a mail."""
FEWEST, MOST = 150, 2000
"""Points of a line."""
RECORDS = 3
"""So many recordings are described."""
SCHEMA: Final = "tuner.report/1"
CELLS = 48
"""Of a map, along each side."""


class KeptLine(Recorded):
    """A line of few points; null where it breaks.

    Attributes:
        label, drawn, x, y, upper: as of :class:`tuner.run.figure.Line`.
        of: how many points there were.
    """

    label: str
    drawn: Drawn
    x: list[float | None]
    y: list[float | None]
    upper: list[float | None] | None = None
    of: int


class KeptChart(Recorded):
    """A :class:`tuner.run.figure.Chart` and its place in the report."""

    kind: Literal["chart"] = "chart"
    part: Part
    name: str
    title: str
    note: str
    x_label: str
    y_label: str
    log: str
    numbered: bool
    equal: bool = False
    lines: list[KeptLine]


class KeptMap(Recorded):
    """A :class:`tuner.run.figure.Map` and its place in the report."""

    kind: Literal["map"] = "map"
    part: Part
    name: str
    title: str
    note: str
    x_label: str
    y_label: str
    z_label: str
    x: list[float]
    y: list[float]
    z: list[list[float | None]]
    log: str = ""
    levels: list[float]
    outline: tuple[float, str] | None = None
    lines: list[KeptLine]


class KeptRecord(Recorded):
    """A recording as it was read.

    Attributes:
        about: its files and clocks, and what there is to say of its channels, a line each.
        rows: a table of its channels; the first row heads it.
    """

    about: list[str]
    rows: list[list[str]]


class Kept(Recorded):
    """The contents of a report beside the result.

    Attributes:
        title, paper: of the study.
        notes: what should be known of the data and the problem.
        records: the first recordings.
        recordings: how many there are.
        pictures: in their order.
    """

    schema_: Literal["tuner.report/1"] = Field(alias="schema")
    title: str = ""
    paper: str = ""
    notes: list[str] = Field(default_factory=list)
    records: list[KeptRecord] = Field(default_factory=list)
    recordings: int = 0
    pictures: list[KeptChart | KeptMap] = Field(default_factory=list)

    @property
    def published(self) -> bool:
        """Whether the study is that of a paper: others say that theirs is none."""
        return not self.paper.startswith("none")

    def to_json(self) -> bytes:
        """JSON text as bytes."""
        return self.model_dump_json(by_alias=True).encode() + b"\n"


def nothing_kept() -> Kept:
    """A report without contents beside the result."""
    return Kept(schema=SCHEMA)


def kept_facts(title: str, paper: str, notes: Iterable[str], records: Sequence[Record]) -> Kept:
    """The facts of a study and its recordings, still without pictures."""
    return Kept(
        schema=SCHEMA,
        title=title,
        paper=paper,
        notes=[*notes],
        records=[_record(record) for record in records[:RECORDS]],
        recordings=len(records),
    )


def _record(record: Record) -> KeptRecord:
    parts = in_parts(record.sources, record.channels, record.truth)
    about = [line.strip() for line in (*parts.files, *parts.notes, *record.notes)]
    return KeptRecord(about=about, rows=[list(row) for row in parts.rows])


def kept_pictures(shown: Iterable[ReportFigure]) -> list[KeptChart | KeptMap]:
    """Figures of few points, so that all together stay small."""
    found = [*shown]
    count = sum(len(_lines(each)) for each in found)
    most = int(np.clip(POINTS / max(count, 1), FEWEST, MOST))
    return [
        _chart(each, most) if isinstance(each.figure, Chart) else _map(each, most) for each in found
    ]


def _lines(shown: ReportFigure) -> Sequence[Line]:
    figure = shown.figure
    return figure.lines if isinstance(figure, Chart) else figure.marks


def _chart(shown: ReportFigure, most: int) -> KeptChart:
    chart = shown.figure
    assert isinstance(chart, Chart)
    return KeptChart(
        part=shown.part,
        name=chart.name,
        title=chart.title,
        note=shown.note,
        x_label=chart.x_label,
        y_label=chart.y_label,
        log=chart.log,
        numbered=chart.numbered,
        equal=chart.equal,
        lines=[*_thinned(chart.lines, most, chart.log)],
    )


def _map(shown: ReportFigure, most: int) -> KeptMap:
    map_ = shown.figure
    assert isinstance(map_, Map)
    i, j = (_few(len(axis)) for axis in (map_.x, map_.y))
    return KeptMap(
        part=shown.part,
        name=map_.name,
        title=map_.title,
        note=shown.note,
        x_label=map_.x_label,
        y_label=map_.y_label,
        z_label=map_.z_label,
        x=[float(each) for each in map_.x[i]],
        y=[float(each) for each in map_.y[j]],
        z=[rounded(row, log=True) for row in np.asarray(map_.z, float)[np.ix_(i, j)]],
        log=map_.log,
        levels=list(shown.levels),
        outline=shown.outline,
        lines=[*_thinned(map_.marks, most, "xy")],
    )


def _few(count: int) -> np.ndarray:
    """Every so many of a map's rows, the last one included."""
    return np.unique(np.linspace(0, count - 1, min(count, CELLS)).astype(int))


def _thinned(lines: Iterable[Line], most: int, log: str) -> Iterator[KeptLine]:
    for line in lines:
        x, y = np.ravel(np.asarray(line.x, float)), np.ravel(np.asarray(line.y, float))
        upper = None if line.upper is None else np.ravel(np.asarray(line.upper, float))
        shown = rows(y if upper is None else upper - y, most)
        yield KeptLine(
            label=line.label,
            drawn=line.drawn,
            x=rounded(x[shown], log="x" in log),
            y=rounded(y[shown], log="y" in log),
            upper=None if upper is None else rounded(upper[shown], log="y" in log),
            of=len(x),
        )
