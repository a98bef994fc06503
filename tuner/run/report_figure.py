"""The figures of a run in its report, each with its finding."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from tuner.run.figure import Figure

Part: TypeAlias = Literal["signal", "innovations", "certificate", "search", "figures"]
"""Where in a report a figure belongs."""


@dataclass(frozen=True, eq=False)
class ReportFigure:
    """A figure of a report.

    Attributes:
        part: where it belongs.
        figure: the figure; its title says what was found.
        note: what is to be seen in it, and how it was made, in a sentence or two.
        levels: of a map, between which numbers a colour lies; none: at equal steps.
        outline: of a map, the level whose line is drawn, and what it is called; None: none.
    """

    part: Part
    figure: Figure
    note: str = ""
    levels: tuple[float, ...] = ()
    outline: tuple[float, str] | None = None
