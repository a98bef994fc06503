"""Figures as files: the data as CSV, and a picture of it."""

import io
import re
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.export.cells import inert
from tuner.run.figure import Chart, Figure, Line, Map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as Canvas

MANY = 8
"""A legend of more entries than this stands beside the axes, of fewer above them."""
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c6d31")
"""Of curves: told apart by people who see colours otherwise, too (Okabe and Ito 2008)."""
ON_MAP = ("#d62728", "#ffffff", "#ff9f1c")
"""Of marks on a map, whose colours go from dark blue over green to yellow."""
FEW = 50
"""So many points at most are drawn large."""
LEVELS = 40
"""Steps of colour of a map."""
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
    axes.set(xlabel=typeset(figure.x_label), ylabel=typeset(figure.y_label))
    axes.spines[["top", "right"]].set_visible(False)
    if "x" in figure.log:
        axes.set_xscale("log")
    if "y" in figure.log:
        axes.set_yscale("log")
    if isinstance(figure, Chart):
        _draw_chart(figure, axes)
    else:
        _draw_map(figure, canvas, axes)
    for axis in (axes.xaxis, axes.yaxis):
        _number(axis)
    entitle(axes, figure.title, _explain(canvas, axes))


def _number(axis: "Axis") -> None:
    """Plain numbers at a logarithmic axis of less than two decades, instead of 2 x 10^-1."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    low, high = axis.get_view_interval()
    if axis.get_scale() != "log" or not 0 < low < high < 100 * low:
        return
    if high < 4 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)))
    else:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:.3g}"))
    axis.set_minor_formatter(NullFormatter())


def typeset(text: str) -> str:
    """A text with its powers and roots as mathematics has them.

    >>> typeset("noise, (rad/s)^2 s, sigma^-1, deg/sqrt(h)")
    'noise, (rad/s)² s, sigma⁻¹, deg/√h'
    """
    raised = re.sub(r"\^(-?\d+)", lambda power: power[1].translate(_RAISED), text)
    return re.sub(r"sqrt\((\w+)\)", r"√\1", raised)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _draw_map(figure: Map, canvas: "Canvas", axes: "Axes") -> None:
    from matplotlib.colors import LogNorm

    low, high = np.nanmin(figure.z), np.nanmax(figure.z)
    logarithmic = "z" in figure.log and 0 < low < high
    levels = np.geomspace(low, high, LEVELS) if logarithmic else LEVELS
    norm = LogNorm(low, high) if logarithmic else None
    filled = axes.contourf(figure.x, figure.y, figure.z.T, levels=levels, cmap="viridis", norm=norm)
    ticks = np.geomspace(low, high, 6) if logarithmic else None
    canvas.colorbar(filled, label=typeset(figure.z_label), ticks=ticks, format="%.3g")
    _draw_lines(figure.marks, axes, ON_MAP)


def entitle(axes: "Axes", title: str, above: float = 0.0) -> None:
    """A title over some axes, left, over so many points of legend; in lines that fit."""
    words = re.sub(r" (?==)|(?<=[\d=]) (?=\S{1,8}(?:\s|$))", "\N{NO-BREAK SPACE}", typeset(title))
    text = axes.set_title(words, loc="left", pad=6 + above, fontsize=11, fontweight="bold")
    canvas = axes.get_figure(root=True)
    if canvas is None:
        return
    # Matplotlib's own wrapping takes no place in the layout.
    available = axes.get_window_extent().width
    width = text.get_window_extent(_renderer(canvas)).width
    if width > available:
        text.set_text(fill(words, int(len(words) * available / width)))


def _explain(canvas: "Canvas", axes: "Axes") -> float:
    """The legend: never over a curve. Its height above the axes, in points; 0 beside them."""
    entries = len(axes.get_legend_handles_labels()[0])
    if entries > MANY:
        axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    if not 0 < entries <= MANY:
        return 0.0
    lay_out(canvas)
    available = axes.get_window_extent().width
    for columns in range(entries, 0, -1):
        legend = axes.legend(
            fontsize=8,
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=columns,
            frameon=False,
            borderaxespad=0.2,
        )
        box = legend.get_window_extent(_renderer(canvas))
        if columns == 1 or box.width <= available:
            break
    return float(box.height) * 72 / canvas.dpi


def lay_out(canvas: "Canvas") -> None:
    """Give the axes their places, without drawing anything."""
    engine = canvas.get_layout_engine()
    if engine is not None:
        engine.execute(canvas)


def _renderer(canvas: "Canvas") -> Any:
    """The renderer that measures texts."""
    return canvas.canvas.get_renderer()  # type: ignore[attr-defined]


def _draw_chart(chart: Chart, axes: "Axes") -> None:
    if chart.numbered:
        _draw_numbered(chart.lines, axes)
    else:
        _draw_lines(chart.lines, axes, COLOURS)
    axes.grid(alpha=0.25, lw=0.6)
    if chart.equal:
        axes.set_aspect("equal", adjustable="datalim")


def _draw_numbered(lines: tuple[Line, ...], axes: "Axes") -> None:
    """Points above each number that occurs, in its order; those of all lines side by side."""
    numbers = np.unique([x for line in lines for x in line.x if np.isfinite(x)])
    turned = 0 if len(numbers) <= 25 else 90
    labels = [f"{number:g}" for number in numbers]
    axes.set_xticks(np.arange(len(numbers)), labels, fontsize=7, rotation=turned)
    axes.set_xlim(-0.6, len(numbers) - 0.4)  # a number's points may all stand on one side of it
    for i, line in enumerate(lines):
        known = np.isfinite(line.x)
        aside = WIDTH * ((i + 0.5) / len(lines) - 0.5)
        at, marker = np.searchsorted(numbers, line.x[known]), "osD^vP*X"[i % 8]
        axes.plot(
            at + aside,
            line.y[known],
            marker,
            label=line.label,
            ms=5,
            color=COLOURS[i % len(COLOURS)],
        )


def _draw_lines(lines: tuple[Line, ...], axes: "Axes", colours: tuple[str, ...]) -> None:
    """Bands behind the curves that follow them, in their colour; single points over all."""
    curves = points = marks = 0
    for line in lines:
        colour, label = colours[(curves + points + marks) % len(colours)], typeset(line.label)
        if line.drawn == "limit":
            axes.plot(line.x, line.y, "--", label=label, color="0.4", lw=1.0, zorder=3)
        elif line.drawn == "band" and line.upper is not None:
            fill = axes.fill_between(line.x, line.y, line.upper, label=label, color=colour)
            fill.set(alpha=0.2, lw=0, zorder=0)
        elif line.drawn == "points":
            size, marker = 2.5 if np.size(line.x) > FEW else 5.0, "os^Dv"[points % 5]
            (drawn,) = axes.plot(line.x, line.y, marker, label=label, color=colour, ms=size)
            drawn.set(alpha=0.7, markeredgewidth=0)
            points += 1
        elif np.size(line.x) == 1:
            # Smaller ones over larger ones: marks that coincide all stay visible.
            size, marker = max(11.0 - 2.0 * marks, 4.0), "os^Dv"[marks % 5]
            axes.plot(line.x, line.y, marker, label=label, color=colour, ms=size, mec="k", zorder=4)
            marks += 1
        else:
            # Thinner dashes over thicker lines: curves that coincide all stay visible.
            style, width = ("-", "--", ":", "-.")[curves % 4], max(2.2 - 0.3 * curves, 1.0)
            axes.plot(line.x, line.y, style, label=label, color=colour, lw=width)
            curves += 1


def _png(canvas: "Canvas") -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    buffer = io.BytesIO()
    lay_out(canvas)  # it settles in two passes
    lay_out(canvas)
    canvas.set_layout_engine("none")
    # As Figure.savefig, which goes through everything once before it draws.
    FigureCanvasAgg(canvas).print_png(buffer, metadata={"Software": None})
    return buffer.getvalue()


def _quoted(text: str) -> str:
    text = inert(text)
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n\r') else text
