"""A run's result as a report."""

from pathlib import Path

from tuner.names import counted
from tuner.report.answer import bars, follows, values
from tuner.report.blocks import Report
from tuner.report.report_json import Kept
from tuner.report.sections import sections
from tuner.report.verdict import verdict, worth
from tuner.report.words import number
from tuner.run.result import Result


def report_of(result: Result, kept: Kept, folder: Path) -> Report:
    """The report of a run.

    Args:
        result: what it found.
        kept: what it kept for its report.
        folder: where its files are.
    """
    return Report(
        title=_title(result, kept),
        about=_about(result, kept),
        paper=kept.paper if result.fit is None and kept.published else "",
        verdict=verdict(result, published=kept.published),
        values=values(result),
        follows=follows(result),
        worth="" if result.fit is None else worth(result.fit),
        bars=bars(result),
        sections=[*sections(result, kept, folder)],
        made=_made(result),
    )


def _title(result: Result, kept: Kept) -> str:
    if result.fit is None:
        return kept.title or result.study
    name = result.tuned[0]["name"] if result.tuned else result.fit.filter
    words = name.replace("_", " ")
    return f"{words[:1].upper()}{words[1:]} on {result.log.name}"


def _about(result: Result, kept: Kept) -> list[str]:
    log = result.log
    facts = []
    if result.fit is not None:
        facts += [f"filter {result.fit.filter}", f"objective {result.fit.objective}"]
    if log.samples:
        rate = f" at {number(log.rate_hz)} Hz" if log.rate_hz else ""
        facts.append(counted(log.samples, "sample") + rate)
    if kept.recordings > 1:
        facts.append(counted(kept.recordings, "recording"))
    return facts


def _made(result: Result) -> str:
    versions = result.tuned[0].get("versions", {}) if result.tuned else {}
    own = f" {versions['filter-tuner']}" if "filter-tuner" in versions else ""
    return f"Made by filter-tuner{own}. All numbers are in result.json beside this file."
