"""A record as lines for a terminal."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tuner.data.findings import find
from tuner.data.logs.clock import Clock
from tuner.data.signal import Floats, Signal
from tuner.data.source import Source
from tuner.names import counted

_GAPS_SHOWN = 5
_HEADER = ("channel", "column", "unit", "Hz", "missing", "mean", "std", "min", "max", "step")
_TRUTH = "truth "
_AXES = {2: "xy", 3: "xyz", 4: "wxyz"}


class Parts(NamedTuple):
    """A record in words.

    Attributes:
        files: these and their clocks, a line each.
        rows: a table of the channels; the first row heads it.
        notes: remarks on the channels.
    """

    files: list[str]
    rows: list[tuple[str, ...]]
    notes: list[str]


def described(
    sources: Sequence[Source], channels: Mapping[str, Signal], truth: Mapping[str, Signal]
) -> list[str]:
    """A record in lines: files, clocks, and each channel in SI with remarks on it.

    >>> z = Signal(np.array([1.0, 3.0]), np.array([0.0, 0.5]), "m", "height")
    >>> print("\\n".join(described([Source("log.csv", "", 2, 2.0)], {"z": z}, {})))
    log.csv: 2 samples at 2 Hz
    channel  column  unit  Hz  missing  mean  std  min  max  step
    z        height  m      2        0     2    1    1    3     2
    """
    parts = in_parts(sources, channels, truth)
    return [*parts.files, *_aligned(parts.rows), *parts.notes]


def in_parts(
    sources: Sequence[Source], channels: Mapping[str, Signal], truth: Mapping[str, Signal]
) -> Parts:
    """The same in parts, its table not aligned."""
    signals = {**channels, **{_TRUTH + name: signal for name, signal in truth.items()}}
    rows: list[tuple[str, ...]] = [_HEADER]
    notes: list[str] = []
    for name, signal in signals.items():
        for row, note in _rows(name, signal):
            rows.append(row)
            notes += [note] if note else []
    files = [f"{s.name}: {counted(s.samples, 'sample')} at {s.rate_hz:.6g} Hz" for s in sources]
    return Parts([*files, *_clocks(signals)], rows, notes)


def _clocks(signals: Mapping[str, Signal]) -> list[str]:
    """Remarks on each clock, with the first channel that has it."""
    first: dict[int, tuple[str, Signal, Clock]] = {}
    for name, signal in signals.items():
        clock = signal.running
        first.setdefault(id(clock if signal.clock else signal), (name, signal, clock))
    return [line for name, signal, clock in first.values() for line in _clock(name, signal, clock)]


def _clock(name: str, signal: Signal, clock: Clock) -> Iterator[str]:
    """Lines on a clock: its steps, and where its first gaps are."""
    facts = [clock.source] if clock.source else []
    if clock.origin is not None or not clock.even:
        facts += [
            _evenness(clock.jitter) if clock.steady else _spread(signal),
            _of_gaps(clock.gaps),
        ]
    if facts:
        yield f"time of {name}: {', '.join(facts)}"
    yield from (f"  {seconds:.4g} s after row {row}" for row, seconds in clock.gaps[:_GAPS_SHOWN])
    if len(clock.gaps) > _GAPS_SHOWN:
        yield f"  and {len(clock.gaps) - _GAPS_SHOWN} more"


def _evenness(jitter: float) -> str:
    return "even" if jitter < 1e-6 else f"jitter up to {100 * jitter:.2g} % of a step"


def _spread(signal: Signal) -> str:
    low, high = np.quantile(np.diff(signal.times), [0.05, 0.95])
    return f"uneven, steps of {low:.3g} to {high:.3g} s"


def _of_gaps(gaps: Sequence[tuple[int, float]]) -> str:
    """The number of gaps of a clock, and the longest."""
    if not gaps:
        return "no gaps"
    longest = max(seconds for _, seconds in gaps)
    return f"{counted(len(gaps), 'gap')} (rows count from 0), longest {longest:.4g} s"


def _rows(name: str, signal: Signal) -> Iterator[tuple[tuple[str, ...], str]]:
    """A line and a note for each axis."""
    columns = signal.values[:, None] if signal.values.ndim == 1 else signal.values
    width = columns.shape[1]
    parts = signal.source.split(",")
    for axis in range(width):
        label = f"{name}.{_AXES.get(width, '0123456789')[axis % 10]}" if width > 1 else name
        source = parts[axis] if len(parts) == width else f"{signal.source}[{axis}]"
        source = signal.source if width == 1 else source
        yield _row(label, source, signal, columns[:, axis])


def _row(label: str, source: str, signal: Signal, values: Floats) -> tuple[tuple[str, ...], str]:
    if np.isnan(values).all():
        return (label, source, signal.unit or "-", "0", str(len(values)), *("-",) * 5), ""
    found = find(values)
    mean, low, high = (f"{x:.6g}" for x in (found.mean, found.minimum, found.maximum))
    step = "-" if found.resolution is None else f"{found.resolution:.4g}"
    rest = (f"{signal.rate_hz:.4g}", str(found.missing), mean, f"{found.std:.4g}", low, high, step)
    note = f"{label}: constant, {found.mean:.6g} in every sample" if found.constant else ""
    if found.saturated and not label.startswith(_TRUTH):
        note = (
            f"{label}: {counted(found.saturated, 'sample')} at the end of the range; "
            "the sensor may have been saturated"
        )
    return (label, source, signal.unit or "-", *rest), note


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Columns of equal width: three of words to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        words = [cell.ljust(width) for cell, width in zip(row[:3], widths[:3], strict=True)]
        numbers = [cell.rjust(width) for cell, width in zip(row[3:], widths[3:], strict=True)]
        lines.append("  ".join(words + numbers))
    return lines
