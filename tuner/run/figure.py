"""Figures as data; :mod:`tuner.run.drawing` makes pictures of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

Drawn: TypeAlias = Literal["curve", "points", "limit", "band"]


@dataclass(frozen=True, eq=False)
class Line:
    """A curve, ``x`` and ``y`` of shape ``(N,)``; a single point is drawn as a mark.

    Attributes:
        label: what the legend calls it.
        x, y: its points.
        drawn: as one of the curves; as points that are not joined; as a limit, thin and grey; or as
            a band up to ``upper``.
        upper: of a band, its upper edge, ``(N,)``.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    drawn: Drawn = field(default="curve", kw_only=True)
    upper: np.ndarray | None = field(default=None, kw_only=True)


def merged(lines: Sequence[Line], share: float = 0.01) -> tuple[Line, ...]:
    """Curves that coincide as one, which is called by the names of all.

    Args:
        lines: curves over the same ``x``.
        share: of the range of all of them; curves that are nowhere further apart coincide.

    >>> x = np.arange(3.0)
    >>> flat, same, up = Line("a", x, 0 * x), Line("b", x, 0 * x + 1e-3), Line("c", x, x)
    >>> [line.label for line in merged([flat, up, same])]
    ['a; b', 'c']
    """
    together: list[list[Line]] = []
    known = [line.y[np.isfinite(line.y)] for line in lines]
    span = np.ptp(np.concatenate(known)) if any(y.size for y in known) else 0.0
    for line in lines:
        for group in together:
            off = np.abs(line.y - group[0].y) if line.y.shape == group[0].y.shape else [np.inf]
            if np.nanmax(off, initial=0.0) <= share * span:
                group.append(line)
                break
        else:
            together.append([line])
    return tuple(
        replace(group[0], label="; ".join(line.label for line in group)) for group in together
    )


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves over one pair of axes.

    Attributes:
        name: file stem, "fig9_gyro".
        title: one line above the picture.
        x_label, y_label: the axes, with units.
        lines: the curves, drawn in order.
        log: which axes are logarithmic, "", "x", "y" or "xy".
        numbered: whether x are numbers of things, not a quantity: points at equal distances, each
            labelled with its number, and not joined.
        equal: whether both axes have the same scale, as for poles and tracks.
    """

    name: str
    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    log: str = ""
    numbered: bool = False
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Map:
    """A quantity over a plane, drawn as filled contours.

    Attributes:
        name: file stem.
        title: one line above the picture.
        x_label, y_label, z_label: the axes and the quantity, with units.
        x, y: the axes' values, ``(n,)`` and ``(m,)``.
        z: the quantity, ``(n, m)``.
        marks: points and curves on the plane.
        log: which of the three are logarithmic, "", "xyz" or some of it.
    """

    name: str
    title: str
    x_label: str
    y_label: str
    z_label: str
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    marks: tuple[Line, ...] = ()
    log: str = ""


Figure = Chart | Map
