"""The single axes of a recording at rest."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tuner.data.logs.error import LogError
from tuner.data.record import Record
from tuner.data.signal import Floats, Signal
from tuner.data.source import Source
from tuner.data.stillness import check_at_rest
from tuner.data.units import Unit
from tuner.names import counted

LEAST = 100
"""The fewest samples that determine a noise."""
_GAP = 1.5  # of the usual step


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a sensor at rest.

    Attributes:
        name: of its rows and files.
        values: in SI, mean removed, ``(N,)``.
        rate_hz: of its samples.
        unit: SI.
        written: the unit that the user gave, or SI.
        source: of the record.
    """

    name: str
    values: Floats
    rate_hz: float
    unit: str
    written: str
    source: Source

    @property
    def seconds(self) -> float:
        """Duration of the record."""
        return len(self.values) / self.rate_hz

    @property
    def scale(self) -> float:
        """Factor from SI to the user's unit."""
        return 1.0 if self.written == self.unit else 1 / Unit.of(self.written).factor


def axes_of(records: tuple[Record, ...]) -> tuple[Axis, ...]:
    """Every axis of a recording, at rest and without gaps.

    Raises:
        ValueError: for none or several recordings, gaps, missing samples, constant or short
            channels, and motion; each with the way out.
    """
    if len(records) != 1:
        has = f"there are {len(records)}" if records else "there is none"
        raise ValueError(
            f"rest takes one recording, and {has}; give --log FILE --map NAME=COLUMN:UNIT"
        )
    (record,) = records
    return tuple(
        _axis(record, name, signal, column)
        for key, signal in record.channels.items()
        for name, column in _columns(key, signal)
    )


def _columns(name: str, signal: Signal) -> Iterator[tuple[str, Floats]]:
    if signal.values.ndim == 1:
        yield name, signal.values
        return
    for label, column in zip(_labels(signal), signal.values.T, strict=True):
        yield f"{name}_{label}", column


def _labels(signal: Signal) -> list[str]:
    count = signal.values.shape[1]
    return list("xyz") if count == 3 else [str(i + 1) for i in range(count)]


def _axis(record: Record, name: str, signal: Signal, values: Floats) -> Axis:
    label = f"{record.name} ({name})"
    _check_whole(label, signal, values)
    rate = signal.running.rate_hz
    if len(values) < LEAST:
        raise LogError(
            f"{label} has {counted(len(values), 'sample')}; its noise takes {LEAST} or more"
        )
    if np.ptp(values) == 0:
        raise LogError(
            f"{label} is constant, {values[0]:g} in every sample; map a column that changes"
        )
    check_at_rest(label, values, rate, float(signal.times[0]))
    source = replace(record.sources[0], samples=len(values), rate_hz=rate)
    centred = values - values.mean()
    return Axis(name, centred, rate, signal.unit, signal.written or signal.unit, source)


def _check_whole(label: str, signal: Signal, values: Floats) -> None:
    """Refuse gaps and missing samples, and name the longest part without any."""
    missing = int(np.isnan(values).sum())
    if signal.running.even and not missing:
        return
    times, step = signal.times, signal.running.step
    breaks = np.flatnonzero(np.diff(times) > _GAP * step)
    cuts = np.unique(
        np.concatenate([[-1], breaks + 0.5, np.flatnonzero(np.isnan(values)), [len(values)]])
    )
    at = int(np.argmax(np.diff(cuts)))
    first, last = int(np.floor(cuts[at])) + 1, int(np.ceil(cuts[at + 1])) - 1
    what = f"misses {counted(missing, 'sample')}" if missing else "has gaps or an uneven clock"
    if last - first < LEAST:
        raise LogError(f"{label} {what}, and no part of {LEAST} samples has none; record it again")
    raise LogError(
        f"{label} {what}, and an Allan deviation takes even samples; the longest part without: "
        f"--from {times[first]:.9g} --to {times[last]:.9g}"
    )
