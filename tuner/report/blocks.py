"""The parts of a report: sections with tables, pictures, sentences and commands."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from tuner.report.drawing import Drawing
from tuner.report.verdict import Verdict


@dataclass(frozen=True)
class Words:
    """Sentences, a paragraph each."""

    paragraphs: Sequence[str]
    kind: str = "words"


@dataclass(frozen=True)
class Listed:
    """Sentences of equal rank."""

    items: Sequence[str]
    kind: str = "listed"


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        title: what it is of.
        head: heads of its columns.
        rows: cells of text; what stands below a cell's first line is smaller.
        numeric: columns of numbers, by place.
        verdicts: the column whose cells say how a row went; None without.
        folded: whether it is shown when it is asked for.
    """

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: frozenset[int] = frozenset()
    verdicts: int | None = None
    folded: bool = False
    kind: str = "table"


@dataclass(frozen=True)
class Picture:
    """A picture."""

    drawing: Drawing
    kind: str = "picture"


@dataclass(frozen=True)
class Commands:
    """Lines to be copied into a terminal."""

    lines: Sequence[str]
    kind: str = "commands"


@dataclass(frozen=True)
class Bar:
    """One of several values side by side.

    Attributes:
        name, text: what stands at its ends.
        share: its length, 0 to 1.
        look: class of its colour.
    """

    name: str
    text: str
    share: float
    look: str


@dataclass(frozen=True)
class Bars:
    """Values side by side.

    Attributes:
        title: what was found.
        bars: they.
        note: how they were found.
    """

    title: str
    bars: Sequence[Bar]
    note: str = ""
    kind: str = "bars"


Block: TypeAlias = Words | Listed | Table | Picture | Commands | Bars


@dataclass(frozen=True)
class Section:
    """A section with its blocks.

    Attributes:
        key: its anchor.
        short: what the navigation calls it.
        title: its heading.
        blocks: what stands in it.
    """

    key: str
    short: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Value:
    """A tuned number.

    Attributes:
        name, value, unit: with the number in digits.
        interval: its interval in words.
        kind: of the interval.
        meaning: of the number.
        doubt: why it is not to be relied on; "".
        low, high: where the interval begins and ends on a scale from 0 to 1; None without.
        at: where the value lies there.
    """

    name: str
    value: str
    unit: str
    interval: str
    kind: str
    meaning: str
    doubt: str = ""
    low: float | None = None
    high: float | None = None
    at: float = 0.5


@dataclass(frozen=True)
class Report:
    """All of it.

    Attributes:
        title: what was tuned on what.
        about: short facts that stand below the title.
        paper: the citation of a study.
        verdict: the answer.
        values: tuned numbers.
        follows: numbers that follow from them: name, value with unit, meaning.
        worth: before and after in a sentence.
        bars: before and after on what was held out; None without.
        sections: the rest.
        made: a line at the end.
    """

    title: str
    about: Sequence[str]
    paper: str
    verdict: Verdict
    values: Sequence[Value]
    follows: Sequence[tuple[str, str, str]]
    worth: str
    bars: Bars | None
    sections: Sequence[Section]
    made: str = ""
