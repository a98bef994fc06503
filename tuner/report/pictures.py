"""The pictures that a run kept, as shapes."""

from collections.abc import Iterator

from tuner.report.blocks import Block, Picture
from tuner.report.contours import contoured
from tuner.report.drawing import Drawing, drawn
from tuner.report.report_json import Kept, KeptChart, KeptMap
from tuner.run.report_figure import Part


def pictures(kept: Kept, part: Part) -> Iterator[Block]:
    """The pictures of a part."""
    for each in kept.pictures:
        if each.part == part:
            yield Picture(picture(each))


def picture(kept: KeptChart | KeptMap) -> Drawing:
    """A picture of any kind as shapes."""
    return drawn(kept) if isinstance(kept, KeptChart) else contoured(kept)
