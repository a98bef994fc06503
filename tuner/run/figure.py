"""Figures as data; :mod:`tuner.run.drawing` makes pictures of them."""

from dataclasses import dataclass, field
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
    """

    name: str
    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    log: str = ""
    numbered: bool = False


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


Figure = Chart | Map
