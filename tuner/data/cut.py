"""A part of a recording, between two times."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tuner.data.logs.clock import Clock, judged
from tuner.data.logs.error import LogError
from tuner.data.record import Record
from tuner.data.signal import Signal


def cut(record: Record, from_s: float | None = None, to_s: float | None = None) -> Record:
    """The part of a recording between two times, both included; times still count from the start.

    Args:
        record: the recording; it stays as it is where neither time is given.
        from_s: s since the recording's start; None for its start.
        to_s: the same; None for its end.

    Raises:
        LogError: for times that are not in order, and a channel of which less than 2 samples are
            left.

    >>> part = cut(Record.of({"z": [1.0, 2.0, 3.0, 4.0]}, rate_hz=10.0), from_s=0.1, to_s=0.2)
    >>> part.channels["z"].values.tolist(), part.channels["z"].times.tolist()
    ([2.0, 3.0], [0.1, 0.2])
    """
    if from_s is None and to_s is None:
        return record
    low, high = -np.inf if from_s is None else from_s, np.inf if to_s is None else to_s
    for option, at in (("--from", from_s), ("--to", to_s)):
        if at is not None and not np.isfinite(at):
            raise LogError(f"{option} is {at:g} s; it must be finite")
    if not low < high:
        raise LogError(f"--from {low:g} is not before --to {high:g}; give seconds in their order")
    clocks: dict[int, Clock] = {}  # channels of one clock go on sharing it
    channels = {n: _part(record, n, s, low, high, clocks) for n, s in record.channels.items()}
    truth = {n: _part(record, n, s, low, high, clocks) for n, s in record.truth.items()}
    longest = _most_samples({**channels, **truth})
    sources = tuple(replace(source, samples=longest) for source in record.sources)
    text = " ".join(
        f"{word} {at:g} s" for word, at in (("from", from_s), ("to", to_s)) if at is not None
    )
    return replace(
        record,
        channels=channels,
        truth=truth,
        sources=sources,
        notes=(*record.notes, f"only the part {text}"),
    )


def _most_samples(signals: Mapping[str, Signal]) -> int:
    return max(len(signal.times) for signal in signals.values())


def _part(
    record: Record, name: str, signal: Signal, low: float, high: float, clocks: dict[int, Clock]
) -> Signal:
    # A time written with fewer digits than the clock has means the nearest sample.
    near = 1e-6 * signal.running.step
    rows = (signal.times >= low - near) & (signal.times <= high + near)
    if rows.sum() < 2 or not signal.present[rows].any():
        raise LogError(
            f"{record.name}: {name} was measured from {signal.times[0]:.6g} s to "
            f"{signal.times[-1]:.6g} s, and --from, --to leave {int(rows.sum())} samples of it; "
            "give another part"
        )
    values, times = signal.values[rows], signal.times[rows]
    values.flags.writeable = times.flags.writeable = False
    whole = signal.running
    clock = clocks.setdefault(id(signal.clock or signal), _clock(whole, rows))
    return replace(signal, values=values, times=times, clock=clock)


def _clock(clock: Clock, rows: np.ndarray) -> Clock:
    """The clock of the part; an even clock's step is known better from the whole."""
    seconds = clock.seconds[rows]
    if clock.even:
        return replace(clock, seconds=seconds - seconds[0])
    part = judged(seconds)
    return replace(part, origin=clock.origin, source=clock.source, notes=clock.notes)
