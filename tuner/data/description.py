"""A record as lines for a terminal."""

from collections.abc import Iterator

import numpy as np

from tuner.data.logs.error import counted
from tuner.data.logs.findings import find_values
from tuner.data.logs.report import aligned, evenness, gaps_told
from tuner.data.record import Record, Signal

_HEADER = ("channel", "column", "unit", "Hz", "missing", "mean", "std", "min", "max", "step")
_TRUTH = "truth "
_AXES = {2: "xy", 3: "xyz", 4: "wxyz"}


def describe_record(record: Record) -> list[str]:
    """What a record holds: files, clocks, each channel in SI, and what was taken for granted."""
    rows: list[tuple[str, ...]] = [_HEADER]
    notes: list[str] = []
    for prefix, signals in (("", record.channels), (_TRUTH, record.truth)):
        for name, signal in signals.items():
            for row, note in _rows(prefix + name, signal):
                rows.append(row)
                notes += [note] if note else []
    files = [
        f"{s.name}: {counted(s.samples, 'sample')} at {s.rate_hz:.6g} Hz" for s in record.sources
    ]
    return [*files, *_clocks(record), *aligned(rows), *notes, *record.notes]


def _clocks(record: Record) -> list[str]:
    """One line for each clock that is not even, with the first channel that has it."""
    seen: dict[int, str] = {}
    for name, signal in (*record.channels.items(), *record.truth.items()):
        clock = signal.running
        if not clock.even and id(clock) not in seen:
            kept = evenness(clock.jitter) if clock.steady else _spread(signal)
            seen[id(clock)] = f"time of {name}: {kept}, {gaps_told(clock.gaps)}"
    return list(seen.values())


def _spread(signal: Signal) -> str:
    low, high = np.quantile(np.diff(signal.times), [0.05, 0.95])
    return f"uneven, steps of {low:.3g} to {high:.3g} s"


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


def _row(
    label: str, source: str, signal: Signal, values: np.ndarray
) -> tuple[tuple[str, ...], str]:
    if np.isnan(values).all():
        return (label, source, signal.unit or "-", "0", str(len(values)), *("-",) * 5), ""
    found = find_values(label, source, signal.unit, values)
    mean, low, high = (f"{x:.6g}" for x in (found.mean, found.minimum, found.maximum))
    step = "-" if found.resolution is None else f"{found.resolution:.4g}"
    rest = (f"{signal.rate_hz:.4g}", str(found.missing), mean, f"{found.std:.4g}", low, high, step)
    note = f"{label}: constant, {found.mean:.6g} in every sample" if found.constant else ""
    if found.saturated and not label.startswith(_TRUTH):
        note = (
            f"{label}: {found.saturated} samples rest at the end of the range; "
            "the sensor may have been saturated"
        )
    return (label, source, signal.unit or "-", *rest), note
