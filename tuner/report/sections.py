"""The sections of a report, in their order."""

from collections.abc import Iterator
from pathlib import Path

from tuner.report.blocks import Section
from tuner.report.fit_blocks import determined, innovations, signal
from tuner.report.pictures import pictures
from tuner.report.report_json import Kept
from tuner.report.run_blocks import again, data, files, rows, search
from tuner.run.result import Result


def sections(result: Result, kept: Kept, folder: Path) -> Iterator[Section]:
    """Those that have anything to say, in their order."""
    own = "Is the filter consistent?"
    claims = ("Comparison", "Against the paper") if kept.published else ("Claims", "Claims")
    sure = (
        ("Certainty", "What the data determine") if result.fit else ("Findings", "What was found")
    )
    made = (
        ("signal", "Signal", "The signal", signal(result, kept)),
        ("innovations", "Innovations", own, innovations(result, kept)),
        ("paper", *claims, rows(result)),
        ("determined", *sure, determined(result, kept)),
        ("figures", "Figures", "Figures", pictures(kept, "figures")),
        ("search", "Search", "The search", search(result, kept)),
        ("data", "Data", "The data", data(result, kept)),
        ("files", "Files", "Files", files(result, folder)),
        ("again", "Again", "Run it again", again(result, folder)),
    )
    for key, short, title, blocks in made:
        content = [*blocks]
        if content:
            yield Section(key, short, title, content)
