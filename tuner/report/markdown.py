"""A report as Markdown, for an issue, a wiki or a pull request."""

from collections.abc import Collection, Iterator, Sequence

from tuner.report.blocks import Bars, Block, Commands, Listed, Picture, Report, Table, Value, Words
from tuner.report.write import PAGE

_SPECIAL = str.maketrans({c: f"\\{c}" for c in "\\`*_{}[]<>#|~!"} | {"\n": " ", "\r": " "})


def markdown(report: Report, drawn: Collection[str] = ()) -> bytes:
    """The report's words and tables.

    Args:
        report: the report.
        drawn: names of pictures that are files below ``figures``; others are told by their titles.
    """
    return ("\n".join(_lines(report, drawn)) + "\n").encode("utf-8", "replace")


def plain(text: str) -> str:
    r"""Text that Markdown takes as it is.

    >>> print(plain("a_b <i>*x*</i>"))
    a\_b \<i\>\*x\*\</i\>
    """
    return text.translate(_SPECIAL)


def _lines(report: Report, drawn: Collection[str]) -> Iterator[str]:
    yield f"# {plain(report.title)}"
    yield ""
    if report.about:
        yield from (plain(" · ".join(report.about)), "")
    yield from (f"**{plain(report.verdict.head)}.** {plain(report.verdict.sentence)}", "")
    if report.values:
        yield from _table(
            ["parameter", "value", "interval", ""], [_value(v) for v in report.values]
        )
    if report.follows:
        head = ["follows", "value", "what it is"]
        yield from _table(head, [[plain(cell) for cell in row] for row in report.follows])
    if report.worth:
        yield from (plain(report.worth), "")
    if report.bars:
        yield from _bars(report.bars)
    for section in report.sections:
        yield from (f"## {plain(section.title)}", "")
        for block in section.blocks:
            yield from _block(block, drawn)
    yield plain(report.made)


def _value(value: Value) -> list[str]:
    text = f"{value.value} {value.unit}".rstrip()
    kind = f" ({value.kind})" if value.interval and value.kind else ""
    return [
        plain(value.name),
        f"**{plain(text)}**",
        plain(value.interval + kind),
        plain(value.doubt),
    ]


def _block(block: Block, drawn: Collection[str]) -> Iterator[str]:
    match block:
        case Words():
            for words in block.paragraphs:
                yield from (plain(words), "")
        case Listed():
            yield from (f"- {plain(words)}" for words in block.items)
            yield ""
        case Table():
            yield from (f"### {plain(block.title)}", "")
            rows = [[plain(cell) for cell in row] for row in block.rows]
            yield from _table(block.head, rows)
        case Picture():
            drawing = block.drawing
            note = f"{plain(drawing.note)} " if drawing.note else ""
            if drawing.name in drawn:
                yield f"**{plain(drawing.title)}** {note}".rstrip()
                yield from ("", f"![{plain(drawing.description)}](figures/{drawing.name}.png)", "")
            else:
                yield from (f"**{plain(drawing.title)}** {note}(picture in {PAGE})", "")
        case Commands():
            yield from ("```sh", *block.lines, "```", "")
        case Bars():
            yield from _bars(block)


def _bars(bars: Bars) -> Iterator[str]:
    yield from (f"### {plain(bars.title)}", "", plain(bars.note), "")
    yield from _table(["filter", "value"], [[plain(b.name), plain(b.text)] for b in bars.bars])


def _table(head: Sequence[str], rows: list[list[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    yield from (f"| {' | '.join(row)} |" for row in rows)
    yield ""
