"""Figures as files: the data as CSV, and a picture of it."""

import io
from typing import TYPE_CHECKING

import numpy as np

from tuner.run.figure import Chart, Figure, Line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.lines import Line2D
    from matplotlib.transforms import Bbox

MANY = 6
"""A legend of more entries than this stands beside the axes."""
FEW = 50
"""So many points at most are drawn large."""
WIDTH = 0.7
"""Share of the distance between numbers over which the points of several lines spread."""


def table(figure: Figure) -> bytes:
    """The figure's data as CSV: one row per point, with the curve's label; a map row by row."""
    rows = ["label,x,y"]
    if isinstance(figure, Chart):
        lines = figure.lines
    else:
        rows = ["label,x,y,z"]
        grid = (
            (x, y, figure.z[i, j]) for i, x in enumerate(figure.x) for j, y in enumerate(figure.y)
        )
        rows += [f"{_quoted(figure.z_label)},{x:.10g},{y:.10g},{z:.10g}" for x, y, z in grid]
        lines = figure.marks
    more = "" if isinstance(figure, Chart) else ","
    for line in lines:
        points = zip(np.ravel(line.x), np.ravel(line.y), strict=True)
        rows += [f"{_quoted(line.label)},{x:.10g},{y:.10g}{more}" for x, y in points]
    return ("\n".join(rows) + "\n").encode()


def picture(figure: Figure) -> bytes:
    """The figure as a PNG."""
    canvas = new_canvas((8, 5))
    draw(figure, canvas, canvas.subplots())
    return _png(canvas)


def new_canvas(inches: tuple[float, float]) -> "Canvas":
    """An empty picture, which no window shows."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=inches, dpi=110, layout="constrained")
    FigureCanvasAgg(canvas)
    return canvas


def draw(figure: Figure, canvas: "Canvas", axes: "Axes") -> None:
    """The figure on some axes of a picture."""
    axes.set(title=figure.title, xlabel=figure.x_label, ylabel=figure.y_label)
    axes.title.set_fontsize(11)
    if isinstance(figure, Chart):
        _draw_chart(figure, axes)
    else:
        filled = axes.contourf(figure.x, figure.y, figure.z.T, levels=40, cmap="viridis")
        canvas.colorbar(filled, label=figure.z_label)
        _draw_lines(figure.marks, axes, on_map=True)
    _explain(canvas, axes)


def _explain(canvas: "Canvas", axes: "Axes") -> None:
    """The legend: within the axes where it covers no curve, or else beside them."""
    entries = len(axes.get_legend_handles_labels()[0])
    if entries > MANY:
        canvas.legend(fontsize=8, loc="outside right upper")
    elif entries:
        # Left to its default, which is the same, matplotlib warns where finding it took a second.
        legend = axes.legend(fontsize=8, framealpha=0.9, loc="best")
        if axes.collections:  # a map's right side is its colours'
            return
        canvas.draw_without_rendering()
        box = legend.get_window_extent()
        if any(_covered(line, box) for line in axes.lines):
            legend.remove()
            axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _covered(line: "Line2D", box: "Bbox") -> bool:
    """Whether a box on the picture covers some of a curve, or one of a row of points."""
    drawn = line.get_transform().transform_path(line.get_path())
    if line.get_linestyle() == "None":
        return bool(box.count_contains(drawn.vertices))
    return bool(drawn.intersects_bbox(box, filled=False))


def _draw_chart(chart: Chart, axes: "Axes") -> None:
    if chart.numbered:
        _draw_numbered(chart.lines, axes)
    else:
        _draw_lines(chart.lines, axes, on_map=False)
    axes.grid(alpha=0.3)
    if "x" in chart.log:
        axes.set_xscale("log")
    if "y" in chart.log:
        axes.set_yscale("log")


def _draw_numbered(lines: tuple[Line, ...], axes: "Axes") -> None:
    """Points above each number that occurs, in its order; those of all lines side by side."""
    numbers = np.unique([x for line in lines for x in line.x if np.isfinite(x)])
    turned = 0 if len(numbers) <= 25 else 90
    labels = [f"{number:g}" for number in numbers]
    axes.set_xticks(np.arange(len(numbers)), labels, fontsize=7, rotation=turned)
    for i, line in enumerate(lines):
        known = np.isfinite(line.x)
        aside = WIDTH * ((i + 0.5) / len(lines) - 0.5)
        at, marker = np.searchsorted(numbers, line.x[known]), "osD^vP*X"[i % 8]
        axes.plot(at + aside, line.y[known], marker, label=line.label, ms=5, mec="k", mew=0.5)


def _draw_lines(lines: tuple[Line, ...], axes: "Axes", *, on_map: bool) -> None:
    colours = ["#d62728", "#ffffff", "#ff9f1c"] if on_map else None
    curves = 0
    for i, line in enumerate(lines):
        if line.drawn == "limit":
            axes.plot(line.x, line.y, "--", label=line.label, color="0.4", lw=1.0, zorder=3)
            continue
        if line.drawn == "band" and line.upper is not None:
            axes.fill_between(line.x, line.y, line.upper, label=line.label, color="0.85", zorder=0)
            continue
        if line.drawn == "points":
            size = 2.5 if np.size(line.x) > FEW else 5.0
            axes.plot(line.x, line.y, "os^Dv"[i % 5], label=line.label, ms=size, alpha=0.7)
            continue
        # Thinner dashes over thicker lines: curves that coincide all stay visible.
        style = "o" if np.size(line.x) == 1 else ("-", "--", ":", "-.")[curves % 4]
        width = max(2.2 - 0.3 * curves, 1.0)
        curves += 1
        colour = colours[i % len(colours)] if colours else None
        axes.plot(line.x, line.y, style, label=line.label, color=colour, lw=width, ms=7, mec="k")


def _png(canvas: "Canvas") -> bytes:
    buffer = io.BytesIO()
    canvas.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text
