"""A chart as shapes: paths in a square of 10,000 units, ticks and a legend.

The square is stretched to whatever place there is, and lines and points keep their width: so a
picture is as legible on a phone as on paper, and zooming is looking at a part of the square.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tuner.report.axis import FULL, ROOM, Axis, Tick
from tuner.report.report_json import KeptChart, KeptLine
from tuner.report.words import label, number

ROLES = {
    "measured": "muted",
    "truth": "ink",
    "before": "c1",
    "tuned": "c0",
    "knee": "c1",
    "rejected": "c4",
}
"""Lines that look the same in all pictures, by their labels."""
PAIRED = {"whiteness": "half first", "spread": "half second"}
"""Pictures that stand side by side where there is room."""
COLOURS = 8
DASHED = 4
"""So many curves of a figure are told apart by dashes as well; more would be hard to follow."""


@dataclass(frozen=True)
class Shape:
    """One path, or several, that are drawn alike.

    Attributes:
        kind: curve, points, limit, band, spot or fill.
        look: class of its colour.
        path: as SVG has it.
        label: of the legend, "" for none.
        dash: number of its dashes, 0 for none.
        fill: opacity of a filled contour.
    """

    kind: str
    look: str
    path: str
    label: str = ""
    dash: int = 0
    fill: str = ""


@dataclass(frozen=True)
class Drawing:
    """A picture, ready to be put on a page.

    Attributes:
        name: of its file.
        title, note: what was found, and what is to be seen.
        description: the picture in words, for those who do not see it.
        x, y: the axes.
        x_label, y_label: their labels.
        x_ticks, y_ticks: the numbers beside them.
        shapes: from the lowest to the uppermost.
        keys: legend entries of a map: an opacity with what it means.
        ends: of a map, the lowest and the highest number.
        cells: of a map, its numbers, for those who hover.
        z_label: of a map.
        joined: charts of the same name zoom together.
        aspect: width over height where both axes have one scale; 0 where they have not.
        place: whether it stands beside another one: half first, half second, or "".
    """

    name: str
    title: str
    note: str
    description: str
    x: Axis
    y: Axis
    x_label: str
    y_label: str
    x_ticks: list[Tick]
    y_ticks: list[Tick]
    shapes: list[Shape]
    keys: list[tuple[str, str]] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")
    cells: str = ""
    z_label: str = ""
    joined: str = ""
    aspect: float = 0.0
    place: str = ""

    @property
    def legend(self) -> list[Shape]:
        """The entries of its legend; none where there is one thing alone."""
        named = [shape for shape in self.shapes if shape.label]
        return named if len(named) > 1 or self.keys else []

    @property
    def width(self) -> int:
        """Letters of the longest number at the left."""
        return max((len(tick.text) for tick in self.y_ticks), default=1)


def drawn(chart: KeptChart) -> Drawing:
    """A chart as shapes."""
    lines = chart.lines
    numbers = _numbers(lines) if chart.numbered else None
    if numbers is not None:
        lines = [_placed(line, numbers) for line in lines]
    x, y = _x_axis(chart, lines), _y_axis(chart, lines)
    if chart.equal:
        x, y = _alike(x, y)
    x_ticks = x.ticks() if numbers is None else _named(x, numbers)
    return Drawing(
        name=chart.name,
        title=label(chart.title),
        note=label(chart.note),
        description=_description(chart),
        x=x,
        y=y,
        x_label=label(chart.x_label),
        y_label=label(chart.y_label),
        x_ticks=x_ticks,
        y_ticks=y.ticks(5),
        shapes=[*shapes(lines, x, y, dashed=chart.part == "figures")],
        aspect=(x.high - x.low) / (y.high - y.low) if chart.equal else 0.0,
        place=PAIRED.get(chart.name, ""),
        joined="time" if chart.part in ("signal", "innovations") and _timed(chart) else "",
    )


def shapes(lines: Sequence[KeptLine], x: Axis, y: Axis, *, dashed: bool = False) -> Iterator[Shape]:
    """Lines as paths: bands lowest, then limits, points and curves."""
    order = {"band": 0, "limit": 1, "points": 2, "curve": 3}
    looks = _looks(lines)
    curves = [line for line in lines if line.drawn == "curve" and len(line.x) > 1]
    dashes = dashed and 1 < len(curves) <= DASHED
    pairs = list(zip(lines, looks, strict=True))
    for line, look in sorted(pairs, key=lambda each: order[each[0].drawn]):
        dash = curves.index(line) % DASHED if dashes and line in curves else 0
        yield replace(_shape(line, look, x, y), label=label(line.label), dash=dash)


def _looks(lines: Sequence[KeptLine]) -> list[str]:
    """A colour for each line; a band has that of the curve which follows it."""
    taken = {ROLES[line.label] for line in lines if line.label in ROLES}
    found, next_one = [], 0
    for line in lines:
        if line.label in ROLES:
            found.append(ROLES[line.label])
        elif line.drawn == "limit":
            found.append("muted")
        elif line.drawn == "band":
            found.append(f"c{next_one % COLOURS}")
        else:
            while f"c{next_one % COLOURS}" in taken:
                next_one += 1
            found.append(f"c{next_one % COLOURS}")
            next_one += 1
    return found


def _shape(line: KeptLine, look: str, x: Axis, y: Axis) -> Shape:
    across, up = x.at(_array(line.x)), FULL - y.at(_array(line.y))
    if line.drawn == "band" and line.upper is not None:
        top = FULL - y.at(_array(line.upper))
        return Shape("band", look, band(across, up, top), line.label)
    if line.drawn == "points" or np.isfinite(across).sum() == 1:
        kind = "points" if line.drawn == "points" and len(across) > 60 else "spot"
        return Shape(kind, look, dots(across, up), line.label)
    return Shape("limit" if line.drawn == "limit" else "curve", look, path(across, up), line.label)


def path(x: np.ndarray, y: np.ndarray) -> str:
    """Points joined by lines, broken where one is missing.

    >>> import numpy as np
    >>> path(np.array([0.0, 1.0, 2.0]), np.array([5.0, 6.25, np.nan]))
    'M0 5 1 6.2'
    """
    there = np.isfinite(x) & np.isfinite(y)
    parts, last = [], False
    for a, b, ok in zip(x, y, there, strict=True):
        if ok:
            parts.append(f"{'' if last else 'M'}{_short(a)} {_short(b)}")
        last = bool(ok)
    return " ".join(parts)


def dots(x: np.ndarray, y: np.ndarray) -> str:
    """A line of no length at each point: round ends make it a dot that keeps its size."""
    there = np.isfinite(x) & np.isfinite(y)
    return "".join(f"M{_short(a)} {_short(b)}h.1" for a, b in zip(x[there], y[there], strict=True))


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> str:
    """The area between two lines."""
    there = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
    if not there.any():
        return ""
    x, low, high = x[there], low[there], high[there]
    return path(np.append(x, x[::-1]), np.append(high, low[::-1])) + "z"


def _short(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _array(values: list[float | None]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values])


def _all(lines: Iterable[KeptLine], *parts: str) -> np.ndarray:
    given = [getattr(line, part) for line in lines for part in parts]
    return np.concatenate([_array(each) for each in given if each is not None] or [np.zeros(0)])


def _x_axis(chart: KeptChart, lines: Sequence[KeptLine]) -> Axis:
    if chart.numbered:
        count = len(_numbers(chart.lines))
        return Axis(-0.6, count - 0.4)
    tight = _timed(chart) or all(line.drawn in ("curve", "band", "limit") for line in lines)
    return Axis.over(_all(lines, "x"), log="x" in chart.log, room=0.0 if tight else ROOM)


def _y_axis(chart: KeptChart, lines: Sequence[KeptLine]) -> Axis:
    return Axis.over(_all(lines, "y", "upper"), log="y" in chart.log, room=ROOM)


def _alike(x: Axis, y: Axis) -> tuple[Axis, Axis]:
    """Both with one scale, the shorter one longer where a picture would be all too long."""
    across, up = x.high - x.low, y.high - y.low
    return _longer(x, 0.6 * up), _longer(y, 0.5 * across)


def _longer(axis: Axis, least: float) -> Axis:
    lacking = max(least - (axis.high - axis.low), 0.0) / 2
    return Axis(axis.low - lacking, axis.high + lacking)


def _timed(chart: KeptChart) -> bool:
    return chart.x_label.startswith("time")


def _numbers(lines: Iterable[KeptLine]) -> list[float]:
    return sorted({x for line in lines for x in line.x if x is not None})


def _placed(line: KeptLine, numbers: list[float]) -> KeptLine:
    at = {value: float(i) for i, value in enumerate(numbers)}
    x = [None if value is None else at[value] for value in line.x]
    return line.model_copy(update={"x": x, "drawn": "points"})


def _named(x: Axis, numbers: list[float]) -> list[Tick]:
    step = max(1, len(numbers) // 16)
    places = x.at(np.arange(len(numbers), dtype=float)) / FULL
    return [
        Tick(float(place), f"{value:g}")
        for place, value in list(zip(places, numbers, strict=True))[::step]
    ]


def _description(chart: KeptChart) -> str:
    """A description of the drawing in words."""
    x = _all(chart.lines, "x")
    there = x[np.isfinite(x)]
    over = f" from {number(there.min())} to {number(there.max())}" if len(there) else ""
    parts = [_range(line) for line in chart.lines if line.label]
    return f"Chart of {label(chart.y_label)} over {label(chart.x_label)}{over}. {'; '.join(parts)}."


def _range(line: KeptLine) -> str:
    values = _all([line], "y", "upper")
    there = values[np.isfinite(values)]
    if not len(there):
        return f"{line.label}: nothing"
    low, high = number(there.min()), number(there.max())
    return f"{line.label}: {low}" + ("" if low == high else f" to {high}")
