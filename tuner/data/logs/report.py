"""Findings as lines for a terminal, and as plain values for JSON."""

import dataclasses
from typing import Any

from tuner.data.logs.error import counted
from tuner.data.logs.findings import ChannelFindings, Findings
from tuner.data.logs.log import Log

_GAPS_TOLD = 5
_HEADER = ("channel", "column", "unit", "mean", "std", "min", "max", "step")


def describe(log: Log | Findings) -> list[str]:
    """What was found, in lines for a terminal.

    Example:
        >>> channel = ChannelFindings("omega", "gx", "deg/s", 0.1, 0.5, -2.0, 2.0, None, 0, False)
        >>> found = Findings(1000, 9.99, 100.0, "--rate", None, (), None, (channel,))
        >>> print("\\n".join(describe(found)))
        1000 samples, 9.99 s at 100 Hz (--rate)
        channel  column  unit   mean  std  min  max  step
        omega    gx      deg/s   0.1  0.5   -2    2     -
    """
    findings = log.findings if isinstance(log, Log) else log
    name = f"{log.name}: " if isinstance(log, Log) else ""
    head = (
        f"{name}{counted(findings.samples, 'sample')}, {findings.duration_s:.6g} s at "
        f"{findings.rate_hz:.6g} Hz ({findings.rate_source})"
    )
    rows = [_HEADER, *map(_row, findings.channels)]
    return [head, *_time_lines(findings), *aligned(rows), *_notes(findings)]


def to_dict(log: Log | Findings) -> dict[str, Any]:
    """What was found as JSON knows it; of a log also its name and checksum, never its samples.

    Example:
        >>> found = Findings(1000, 9.99, 100.0, "--rate", None, (), None, ())
        >>> to_dict(found)["rate_source"]
        '--rate'
    """
    if isinstance(log, Log):
        return {"name": log.name, "sha256": log.sha256, **to_dict(log.findings)}
    plain = dataclasses.asdict(log)
    plain["gaps"] = [list(gap) for gap in log.gaps]
    plain["channels"] = list(plain["channels"])
    plain["notes"] = list(log.notes)
    return plain


def _row(channel: ChannelFindings) -> tuple[str, ...]:
    step = "-" if channel.resolution is None else f"{channel.resolution:.4g}"
    numbers = (channel.mean, channel.std, channel.minimum, channel.maximum)
    return (
        channel.name, channel.source, channel.unit or "-", *(f"{x:.4g}" for x in numbers), step
    )  # fmt: skip


def aligned(rows: list[tuple[str, ...]]) -> list[str]:
    """Columns of equal width: three of words to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        words = [cell.ljust(width) for cell, width in zip(row[:3], widths[:3], strict=True)]
        numbers = [cell.rjust(width) for cell, width in zip(row[3:], widths[3:], strict=True)]
        lines.append("  ".join(words + numbers))
    return lines


def _time_lines(findings: Findings) -> list[str]:
    if findings.jitter is None:
        return []
    lines = [
        f"time {findings.time_column!r}: {evenness(findings.jitter)}, {gaps_told(findings.gaps)}"
    ]
    lines += [f"  {seconds:.4g} s after row {row}" for row, seconds in findings.gaps[:_GAPS_TOLD]]
    hidden = len(findings.gaps) - _GAPS_TOLD
    return lines + ([f"  and {hidden} more"] if hidden > 0 else [])


def evenness(jitter: float) -> str:
    """How evenly a clock runs."""
    return "even" if jitter < 1e-6 else f"jitter up to {100 * jitter:.2g} % of a step"


def gaps_told(gaps: tuple[tuple[int, float], ...]) -> str:
    """How many gaps a clock has, and the longest."""
    if not gaps:
        return "no gaps"
    longest = max(seconds for _, seconds in gaps)
    count = counted(len(gaps), "gap")
    return f"{count} (rows count from 0), longest {longest:.4g} s"


def _notes(findings: Findings) -> list[str]:
    saturated = [
        f"{channel.name}: {channel.saturated} samples rest at the end of the range; "
        "the sensor may have been saturated"
        for channel in findings.channels
        if channel.saturated
    ]
    told = [f"{channel.name}: {channel.note}" for channel in findings.channels if channel.note]
    return [*findings.notes, *told, *saturated]
