"""A map as filled contours."""

import json
from itertools import pairwise
from typing import Any, cast

import numpy as np

from tuner.report.axis import FULL, Axis
from tuner.report.drawing import Drawing, Shape, shapes
from tuner.report.report_json import KeptMap
from tuner.report.words import label, number

STEPS = 12
"""Colours of a map whose levels nobody chose."""
STRONG, FAINT = 0.92, 0.05
"""How much of its colour the best place has, and the worst."""
FINE = 120
"""A map of fewer points along a side is drawn smooth."""


def contoured(kept: KeptMap) -> Drawing:
    """A map as shapes."""
    x = Axis.over(np.array(kept.x), log="x" in kept.log)
    y = Axis.over(np.array(kept.y), log="y" in kept.log)
    z = np.array([[np.nan if v is None else v for v in row] for row in kept.z])
    levels = _levels(kept, z)
    fills = [_tint(i, len(levels) - 1) for i in range(len(levels) - 1)]
    across, up, fine = _smooth(x.at(np.array(kept.x)), FULL - y.at(np.array(kept.y)), z)
    filled = _filled(across, up, fine, levels, fills)
    marks = [*_outline(kept, across, up, fine), *shapes(kept.lines, x, y)]
    keys = [
        (fill, _range(low, high, last=i == len(fills) - 1))
        for i, (fill, low, high) in enumerate(zip(fills, levels[:-1], levels[1:], strict=True))
    ]
    z_label = label(kept.z_label)
    return Drawing(
        name=kept.name,
        title=label(kept.title),
        note=label(kept.note),
        description=f"Map of {z_label} over {label(kept.x_label)} and {label(kept.y_label)}.",
        x=x,
        y=y,
        x_label=label(kept.x_label),
        y_label=label(kept.y_label),
        x_ticks=x.ticks(),
        y_ticks=y.ticks(5),
        shapes=[*filled, *marks],
        keys=keys,
        ends=(number(levels[0], 3), number(levels[-1], 3)),
        cells=_cells(kept, x, y, z),
        z_label=z_label,
    )


def _levels(kept: KeptMap, z: np.ndarray) -> list[float]:
    there = z[np.isfinite(z)]
    if not len(there):
        return [0.0, 1.0]
    low, high = float(there.min()), float(there.max())
    if kept.levels:
        inside = [level for level in kept.levels if low < level < high]
        return [min(low, kept.levels[0]), *inside, high]
    if low == high:
        return [low, low + 1.0]
    if low > 0 and "z" in kept.log:
        return [float(each) for each in np.geomspace(low, high, STEPS + 1)]
    return [float(each) for each in np.linspace(low, high, STEPS + 1)]


def _smooth(
    across: np.ndarray, up: np.ndarray, z: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """More points between few, by cubic splines; as it is where one is missing."""
    if min(z.shape) < 4 or not np.isfinite(z).all():
        return across, up, z
    from scipy.interpolate import RectBivariateSpline

    sides = [np.linspace(0, n - 1, max(FINE, n)) for n in z.shape]
    rows, columns = (np.arange(n, dtype=float) for n in z.shape)
    fine = RectBivariateSpline(rows, columns, z)(*sides)
    fine = np.clip(fine, z.min(), z.max())
    return np.interp(sides[0], rows, across), np.interp(sides[1], columns, up), fine


def _filled(
    across: np.ndarray, up: np.ndarray, z: np.ndarray, levels: list[float], fills: list[str]
) -> list[Shape]:
    from contourpy import FillType, contour_generator

    made = contour_generator(across, up, np.ma.masked_invalid(z.T), fill_type=FillType.OuterOffset)
    found = []
    # Where z lies at the lowest level itself, it would not be filled.
    edges = [2 * levels[0] - levels[1], *levels[1:]]
    for fill, low, high in zip(fills, edges[:-1], edges[1:], strict=True):
        if not high > low:
            continue
        polygons, offsets, *_ = cast("Any", made.filled(low, high))
        parts = [
            _closed(points[begin:end])
            for points, cuts in zip(polygons, offsets, strict=True)
            for begin, end in pairwise(cuts)
        ]
        if parts:
            found.append(Shape("fill", "c0", "".join(parts), fill=fill))
    return found


def _outline(kept: KeptMap, across: np.ndarray, up: np.ndarray, z: np.ndarray) -> list[Shape]:
    """The line of one level."""
    if kept.outline is None:
        return []
    from contourpy import contour_generator

    level, words = kept.outline
    made = contour_generator(across, up, np.ma.masked_invalid(z.T))
    lines = cast("list[np.ndarray]", made.lines(level))
    found = "".join(_open(points) for points in lines)
    return [Shape("curve", "ink", found, words)] if found else []


def _closed(points: np.ndarray) -> str:
    return f"{_open(points)}z"


def _open(points: np.ndarray) -> str:
    return "M" + " ".join(f"{a:.0f} {b:.0f}" for a, b in points)


def _tint(i: int, count: int) -> str:
    """How much colour: the best is strong, what is worse ever fainter."""
    return f"{STRONG - (STRONG - FAINT) * i / max(count - 1, 1):.2f}"


def _range(low: float, high: float, *, last: bool) -> str:
    return f"above {number(low, 3)}" if last else f"{number(low, 3)} to {number(high, 3)}"


def _cells(kept: KeptMap, x: Axis, y: Axis, z: np.ndarray) -> str:
    """Places of columns and rows, and the numbers there, as JSON."""
    rows = [[None if not np.isfinite(v) else float(f"{v:.4g}") for v in row] for row in z]
    across = [round(float(v)) for v in x.at(np.array(kept.x))]
    up = [round(float(v)) for v in FULL - y.at(np.array(kept.y))]
    return json.dumps({"x": across, "y": up, "z": rows}, separators=(",", ":"))
