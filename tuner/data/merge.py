"""Channels of different rates on one clock, and recordings side by side."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tuner.data.logs.clock import Clock
from tuner.data.logs.error import LogError, quoted
from tuner.data.record import Record
from tuner.data.signal import Floats, Signal
from tuner.limits import check_amount
from tuner.names import counted

_FASTER = 2.0
_NEAR_S = 0.1
_SAME_RATE = 1e-3
_COLUMNS, _OF_EACH = 25, 18
"""Numbers a sample that a fit holds at the same time, as measured: times, terms of the objective
and what is compared with them, and for each measured number what a filter makes of it."""


@dataclass(frozen=True, eq=False)
class Timeline:
    """Arrays as a filter runs over them: N samples of one clock, or of k clocks side by side.

    Attributes:
        times: since the record's start, s, ``(N,)`` or ``(N, k)``; NaN past a recording's end.
        dt: seconds since the previous sample, as ``times``; the first, and those past the end, are
            the median step.
        rate_hz: samples per second where one step stands for all; None where ``dt`` counts.
        channels: in SI, ``(N, ...)`` or ``(N, k, ...)``; NaN where nothing was measured.
        truth: the same.
        units: of the channels.
        notes: what was left out or moved, a sentence each.
        counts: number of samples of each of k recordings; None where there is only one.
    """

    times: Floats
    dt: Floats
    rate_hz: float | None
    channels: Mapping[str, Floats]
    truth: Mapping[str, Floats]
    units: Mapping[str, str]
    notes: tuple[str, ...] = ()
    counts: tuple[int, ...] | None = None

    @property
    def step(self) -> float:
        """The usual seconds from one sample to the next."""
        return float(np.nanmedian(self.dt)) if self.rate_hz is None else 1.0 / self.rate_hz


def timeline(record: Record) -> Timeline:
    """Put all channels on the clock of the one with the most samples that hold a number.

    A sample of another channel goes to the nearest instant of that clock, where it is within half
    a step. Where this would move samples by more than 0.1 s and the clock is less than twice as
    fast, all instants of both are taken instead. The truth goes where the channels are.

    Raises:
        LogError: for channels or truth that never overlap in time.

    >>> imu = {"gyr": np.arange(6) / 10.0, "baro": np.array([0.012, 0.49])}
    >>> record = Record.of({"gyr": np.ones(6), "baro": [3.0, 4.0]}, times=imu)
    >>> merged = timeline(record)
    >>> merged.channels["baro"].tolist(), round(merged.rate_hz, 9)
    ([3.0, nan, nan, nan, nan, 4.0], 10.0)
    """
    everything = [*_labelled(record)]
    label, base = max(record.channels.items(), key=lambda item: item[1].present.sum())
    _check_overlap(label, base, everything)
    base = _own_clock(base)
    instants, step = base.times, base.running.step
    for _, signal in _other(record.channels, base):
        if not _follows(signal, instants, step):
            instants = np.union1d(instants, signal.times)
            step = float(np.median(np.diff(instants)))
    channels: dict[str, Floats] = {}
    truth: dict[str, Floats] = {}
    notes: list[str] = []
    for (kind, name), signal in everything:
        values, note = _snapped(signal, instants, step)
        (truth if kind else channels)[name] = values
        notes += [f"{kind}{name}: {note}"] if note else []
    own = len(instants) == len(base.times)
    rate = _rate(base.running) if own else None
    return Timeline(
        instants,
        _steps(instants, rate),
        rate,
        channels,
        truth,
        {name: signal.unit for name, signal in record.channels.items()},
        tuple(notes),
    )


def stacked(timelines: Sequence[Timeline]) -> Timeline:
    """Recordings side by side, the shorter ones padded with NaN.

    Raises:
        LogError: where they do not have the same channels.
        ValueError: where memory does not hold them all at the length of the longest.

    >>> short, long = (Record.of({"z": np.ones(n)}, rate_hz=10.0) for n in (2, 4))
    >>> both = stacked([timeline(short), timeline(long)])
    >>> both.channels["z"].shape, both.counts, both.rate_hz
    ((4, 2), (2, 4), 10.0)
    """
    if not timelines:
        raise LogError("there are no recordings to stack; give at least one")
    first = timelines[0]
    for other in timelines[1:]:
        for ours, theirs in ((first.channels, other.channels), (first.truth, other.truth)):
            if ours.keys() != theirs.keys():
                raise LogError(
                    f"one recording has {quoted(sorted(ours))} and another "
                    f"{quoted(sorted(theirs))}; give all of them the same channels"
                )
    _check_size(timelines)
    rate = _one_rate([line.rate_hz for line in timelines])
    counts = tuple(len(line.times) for line in timelines)
    shape = max(counts), len(counts)
    if rate is None:
        steps = _padded([line.dt for line in timelines], [line.step for line in timelines])
    else:
        steps = np.broadcast_to(1.0 / rate, shape)  # one number for all
    numbered = enumerate(timelines, 1)
    notes = (f"recording {number}: {note}" for number, line in numbered for note in line.notes)
    return Timeline(
        _padded([line.times for line in timelines]),
        steps,
        rate,
        {name: _padded([line.channels[name] for line in timelines]) for name in first.channels},
        {name: _padded([line.truth[name] for line in timelines]) for name in first.truth},
        first.units,
        tuple(notes),
        counts,
    )


def _labelled(record: Record) -> Iterator[tuple[tuple[str, str], Signal]]:
    for kind, signals in (("", record.channels), ("truth ", record.truth)):
        for name, signal in signals.items():
            yield (kind, name), signal


def _other(channels: Mapping[str, Signal], base: Signal) -> Iterator[tuple[str, Signal]]:
    """The channels of other clocks, each clock once."""
    seen = [base.times]
    for name, signal in channels.items():
        if not any(_same(signal.times, times) for times in seen):
            seen.append(signal.times)
            yield name, signal


def _same(times: Floats, others: Floats) -> bool:
    return times is others or (len(times) == len(others) and bool((times == others).all()))


def _own_clock(base: Signal) -> Signal:
    """A channel without the rows that only others have, where that makes its times even."""
    present = base.present
    if present.all() or present.sum() < 3:
        return base
    own = Signal(base.values[present], base.times[present], base.unit, base.source)
    better = own.running.even and own.running.jitter < base.running.jitter
    return own if better else base


def _check_overlap(
    label: str, base: Signal, everything: list[tuple[tuple[str, str], Signal]]
) -> None:
    """Refuse channels that were never measured while the base was."""
    half = 0.5 * base.running.step
    low, high = float(base.times[0]) - half, float(base.times[-1]) + half
    for key, signal in everything:
        times = signal.times[signal.present]
        if not ((times >= low) & (times <= high)).any():
            raise LogError(
                f"{label} ({base.times[0]:.6g} to {base.times[-1]:.6g} s) and {''.join(key)} "
                f"({times[0]:.6g} to {times[-1]:.6g} s) do not overlap; give recordings of the "
                "same time, on one clock"
            )


def _follows(signal: Signal, instants: Floats, step: float) -> bool:
    """Whether a channel can move to another one's instants without losing its own."""
    times = signal.times[signal.present]
    distance = np.abs(times - instants[_nearest(times, instants)])
    near = distance[distance <= _half(step)]
    moved = float(near.max(initial=0.0))
    return moved <= _NEAR_S or len(instants) >= _FASTER * len(times)


def _half(step: float) -> float:
    return 0.5 * step * (1.0 + 1e-6)  # an instant midway between two, whatever its last digit


def _nearest(times: Floats, instants: Floats) -> np.ndarray:
    """The rows of the instants that are nearest to times."""
    right = np.searchsorted(instants, times).clip(1, len(instants) - 1)
    earlier = times - instants[right - 1] <= instants[right] - times
    return np.asarray(right - earlier)


def _snapped(signal: Signal, instants: Floats, step: float) -> tuple[Floats, str]:
    """A channel's samples at the instants, NaN where it has none, and the number of lost ones."""
    if _same(signal.times, instants):
        return signal.values, ""
    kept = np.flatnonzero(signal.present)
    times = signal.times[kept]
    rows = _nearest(times, instants)
    distance = np.abs(times - instants[rows])
    near = distance <= _half(step)
    # Of several with the same nearest instant, the nearest is written last, so it stays.
    order = np.argsort(-distance[near], kind="stable")
    values = np.full((len(instants), *signal.values.shape[1:]), np.nan)
    values[rows[near][order]] = signal.values[kept[near][order]]
    matched = len(np.unique(rows[near]))
    return values, _note(len(kept), matched, int((~near).sum()))


def _note(count: int, matched: int, far: int) -> str:
    lost = []
    if far:
        lost.append(f"{far} of {counted(count, 'sample')} have no instant within half a step")
    if count - far > matched:
        lost.append(
            f"{count - far - matched} of {counted(count, 'sample')} share one with a nearer"
        )
    return f"{' and '.join(lost)}, and are left out" if lost else ""


def _rate(clock: Clock) -> float | None:
    return clock.rate_hz if clock.even else None


def _steps(instants: Floats, rate: float | None) -> Floats:
    if rate is not None:
        return np.full(len(instants), 1.0 / rate)
    steps = np.diff(instants)
    return np.concatenate([[np.median(steps)], steps])


def _one_rate(rates: Sequence[float | None]) -> float | None:
    """The common rate, where all agree within a thousandth."""
    known = [rate for rate in rates if rate is not None]
    if len(known) < len(rates):
        return None
    mean = float(np.mean(known))
    return mean if np.ptp(known) <= _SAME_RATE * mean else None


def _check_size(timelines: Sequence[Timeline]) -> None:
    """Refuse recordings of which a long one makes the others too long for a fit."""
    longest = max(len(line.times) for line in timelines)
    first = timelines[0]
    values = (*first.channels.values(), *first.truth.values())
    width = sum(math.prod(value.shape[1:]) for value in values)
    check_amount(
        f"{len(timelines)} recordings side by side, of which the longest has {longest} samples,",
        8 * longest * len(timelines) * (_COLUMNS + _OF_EACH * width),
        "leave out the longest, or cut it into several",
        copies=1,
    )


def _padded(arrays: Sequence[Floats], fills: Sequence[float] | None = None) -> Floats:
    """Arrays side by side along a second axis, padded to the length of the longest."""
    length = max(map(len, arrays))
    padded = np.empty((length, len(arrays), *arrays[0].shape[1:]))
    for lane, array in enumerate(arrays):
        padded[: len(array), lane] = array
        padded[len(array) :, lane] = np.nan if fills is None else fills[lane]
    return padded
