"""A recording: channels in SI, each with its times, the truth, and the sources."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from tuner.data.description import described
from tuner.data.logs.clock import Clock, judged
from tuner.data.logs.error import LogError, quoted, suggest
from tuner.data.signal import Floats, Signal
from tuner.data.source import Source
from tuner.data.units import change
from tuner.names import counted

if TYPE_CHECKING:
    from filters.declared import Channel

Times: TypeAlias = ArrayLike | Mapping[str, ArrayLike] | None


@dataclass(frozen=True, eq=False)
class Reading:
    """The way in which a record was read from its files.

    Attributes:
        arguments: of :func:`tuner.read_records`, by the names that a study.toml has for them.
        channels, truth: the mappings that were read; a changed record holds other ones.
    """

    arguments: Mapping[str, object]
    channels: Mapping[str, Signal]
    truth: Mapping[str, Signal]


@dataclass(frozen=True, eq=False)
class Record:
    """One recording.

    Attributes:
        name: its name.
        channels: measurements, by the names of a filter's inputs.
        truth: true values, by the names of its outputs.
        sources: the files.
        notes: what was assumed, a sentence each.
        reading: how it was read from its files; None for arrays.
    """

    name: str
    channels: Mapping[str, Signal]
    truth: Mapping[str, Signal]
    sources: tuple[Source, ...]
    notes: tuple[str, ...] = ()
    reading: "Reading | None" = None

    @classmethod
    def of(
        cls,
        channels: Mapping[str, ArrayLike],
        *,
        rate_hz: float | None = None,
        times: Times = None,
        units: Mapping[str, str] | None = None,
        truth: Mapping[str, ArrayLike] | None = None,
        truth_times: Times = None,
        inputs: "Mapping[str, Channel] | None" = None,
        outputs: "Mapping[str, Channel] | None" = None,
        name: str = "arrays",
    ) -> "Record":
        """A record of arrays.

        Args:
            channels: each ``(N,)`` or ``(N, k)``; NaN is a missing sample.
            rate_hz: samples per second of all; or
            times: in seconds, rising, ``(N,)``: of all, or by channel.
            units: by channel and output; SI where none is given.
            truth: by output, like the channels.
            truth_times: like ``times``; the same as those if left out.
            inputs: what the channels should be in; any SI unit if left out.
            outputs: the same for the truth.
            name: the record's name.

        Raises:
            LogError: for unknown units, arrays of unequal lengths, and times that do not rise.

        >>> record = Record.of({"rate": [0.0, 90.0]}, rate_hz=50.0, units={"rate": "deg/s"})
        >>> record.channels["rate"].values.round(6).tolist(), record.channels["rate"].unit
        ([0.0, 1.570796], 'rad/s')
        """
        truth, units = truth or {}, units or {}
        if not channels:
            raise LogError("the record has no channels; give at least one array")
        if stray := [key for key in units if key not in channels and key not in truth]:
            raise LogError(f"a unit of {stray[0]!r} is given; {suggest(stray[0], list(channels))}")
        later = times if truth_times is None else truth_times
        given = _signals(channels, rate_hz, times, units, inputs)
        wanted = _signals(
            truth, None if truth_times is not None else rate_hz, later, units, outputs
        )
        start = min(float(s.times[0]) for s, _ in (*given.values(), *wanted.values()))
        notes = [f"{key}: {note}" for key, (_, note) in (given | wanted).items() if note]
        moved = {key: replace(s, times=s.times - start) for key, (s, _) in given.items()}
        to_be = {key: replace(s, times=s.times - start) for key, (s, _) in wanted.items()}
        source = _made(name, [*moved.values(), *to_be.values()])
        return cls(name, moved, to_be, (source,), tuple(notes))

    @property
    def read_as(self) -> Mapping[str, object] | None:
        """The arguments that read it from its files; None for arrays, and for a changed record."""
        known = self.reading
        if known is None or known.channels is not self.channels or known.truth is not self.truth:
            return None
        return known.arguments

    @property
    def digest(self) -> str:
        """The checksum of all sources together; that of the file where there is only one."""
        if len(self.sources) == 1:
            return self.sources[0].sha256
        return hashlib.sha256("".join(s.sha256 for s in self.sources).encode()).hexdigest()

    def describe(self) -> list[str]:
        """The contents of the record, in lines for a terminal."""
        return [*described(self.sources, self.channels, self.truth), *self.notes]

    def _repr_html_(self) -> str:
        return f"<b>{escape(self.name)}</b><pre>{escape(chr(10).join(self.describe()))}</pre>"

    def __repr__(self) -> str:
        def listed(signals: Mapping[str, Signal]) -> str:
            return ", ".join(
                f"{key} {s.values.shape} {s.unit or '-'} at {s.rate_hz:.4g} Hz"
                for key, s in signals.items()
            )

        truth = f"; truth {listed(self.truth)}" if self.truth else ""
        return f"<Record {self.name!r}: {listed(self.channels)}{truth}>"


def _signals(
    arrays: Mapping[str, ArrayLike],
    rate_hz: float | None,
    times: Times,
    units: Mapping[str, str],
    declared: "Mapping[str, Channel] | None",
) -> dict[str, tuple[Signal, str]]:
    """Arrays in SI on their own times, each with what was assumed."""
    made = {}
    for name, given in arrays.items():
        if declared is not None and name not in declared:
            raise LogError(f"there is no channel {name!r}: {suggest(name, list(declared))}")
        values = _array(name, given)
        clock = _clock(name, len(values), rate_hz, times)
        wanted = declared[name].unit if declared else "unit"
        made[name] = _signal(name, values, clock, units.get(name), wanted)
    return made


def _array(name: str, values: ArrayLike) -> Floats:
    """A channel's array, with NaN for what is not finite."""
    array = np.array(values, np.float64)
    if array.ndim not in (1, 2) or len(array) < 2:
        raise LogError(f"{name!r} has shape {array.shape}; give (N,) or (N, k), N of at least 2")
    array[~np.isfinite(array)] = np.nan
    if np.isnan(array).all():
        raise LogError(f"{name!r} is missing in all {len(array)} samples; leave it out")
    return array


def _clock(
    name: str,
    samples: int,
    rate_hz: float | None,
    times: ArrayLike | Mapping[str, ArrayLike] | None,
) -> tuple[Clock, float]:
    """The clock of a channel, and its first time."""
    own = times.get(name) if isinstance(times, Mapping) else times
    if (own is None) == (rate_hz is None):
        raise LogError(f"{name!r} needs either a rate_hz or times; give one of them")
    if own is None:
        if not (rate_hz and 0.0 < rate_hz < np.inf):
            raise LogError(f"rate_hz is {rate_hz:g}; it must be positive and finite")
        return Clock.rated(samples, float(rate_hz)), 0.0
    seconds = np.asarray(own, np.float64)
    if seconds.shape != (samples,):
        raise LogError(
            f"{name!r} has {counted(samples, 'sample')} and times {seconds.shape}; give as many"
        )
    steps = np.diff(seconds)
    if not (steps > 0).all() or not np.isfinite(seconds).all():
        row = int(np.argmin(steps > 0)) + 1
        raise LogError(
            f"the times of {name!r} do not rise at row {row} (counted from 0); sort them"
        )
    return judged(seconds - seconds[0]), float(seconds[0])


def _signal(
    name: str, values: Floats, clock: tuple[Clock, float], unit: str | None, wanted: str
) -> tuple[Signal, str]:
    """A channel in SI, and what was assumed."""
    runs, first = clock
    try:
        into = change(unit, wanted)
    except ValueError as error:
        raise LogError(f"{name!r} {error}") from error
    note = into.note if unit is not None else ""  # arrays are in SI unless a unit is given
    return Signal(into(values), runs.seconds + first, into.unit, name, runs, unit or ""), note


def _made(name: str, signals: Sequence[Signal]) -> Source:
    digest = hashlib.sha256(b"".join(s.values.tobytes() + s.times.tobytes() for s in signals))
    return Source(name, digest.hexdigest(), len(signals[0].times), signals[0].rate_hz)


def check_channels(channels: Mapping[str, object], needed: "Mapping[str, object]") -> None:
    """Refuse a record that lacks a channel.

    Raises:
        LogError: with the missing ones.

    >>> check_channels({"gyr": None}, {"gyr": None, "acc": None})
    Traceback (most recent call last):
    tuner.data.logs.error.LogError: no column is mapped to 'acc'; write --map acc=COLUMN
    """
    missing = [name for name in needed if name not in channels]
    if missing:
        raise LogError(f"no column is mapped to {quoted(missing)}; write --map {missing[0]}=COLUMN")
