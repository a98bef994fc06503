"""Checks that channels are physically possible, without a model."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tuner.data.frames import frame_of
from tuner.data.logs.error import LogError
from tuner.data.merge import Timeline
from tuner.data.signal import Floats

if TYPE_CHECKING:
    from filters.declared import Channel

_GRAVITY = 9.80665
_REST_S = 0.5
_RANGE_RAD_S = 40.0  # sensors end at 2000 deg/s, 34.9 rad/s
_DEGREES = 180.0 / np.pi
_MAP = "write {name}=...:{unit}"


class _Scale(NamedTuple):
    """The unit that a factor between a sensor's numbers and SI suggests."""

    factor: float
    unit: str


_FORCES = tuple(_Scale(*pair) for pair in ((1.0, "g"), (1e3, "mg"), (980.665, "gal")))


def check_plausibility(
    line: Timeline, inputs: "Mapping[str, Channel]", outputs: "Mapping[str, Channel] | None" = None
) -> tuple[str, ...]:
    """Refuse channels that physics excludes, and say what looks strange.

    Args:
        line: the channels on one clock, of one recording.
        inputs: the facts of a filter's inputs.
        outputs: the facts of its outputs.

    Returns:
        Warnings, one sentence each.

    Raises:
        LogError: for accelerometers that read 1 at rest, gyroscopes in degrees, and truth in
            another frame, each with the way out.
    """
    warnings = []
    acc = _three(line.channels, inputs, "m/s^2")
    gyr = _three(line.channels, inputs, "rad/s")
    attitudes = _attitudes(line, outputs or {})
    if acc is not None:
        warnings.append(check_accelerometer(*acc, line.dt))
    if gyr is not None:
        check_gyroscope(*gyr)
        if acc is not None:
            check_turning(*gyr, acc[1], line.dt)
        for name, truth in attitudes.items():
            check_rate(*gyr, name, truth, line.dt)
    if acc is not None:
        for name, truth in attitudes.items():
            check_frame(name, truth, acc[1])
    return tuple(warning for warning in warnings if warning)


def check_accelerometer(name: str, acc: Floats, dt: Floats, way_out: str = _MAP) -> str:
    """Judge an accelerometer in m/s^2, ``(N, 3)``, by what it reads at rest.

    Args:
        name: the channel.
        acc: specific force.
        dt: sample times, s, ``(N,)``.
        way_out: the advice to the user, with {name} and {unit}.

    Returns:
        A warning where it usually reads gravity, but not where it is calmest; else nothing.

    Raises:
        LogError: where it reads 1, gravity in another unit, nothing, or something else.

    >>> still = np.tile([0.0, 0.0, 1.0], (100, 1))
    >>> check_accelerometer("acc", still, np.full(100, 0.01))
    Traceback (most recent call last):
    tuner.data.logs.error.LogError: acc reads 1 m/s^2 at rest, which looks like g; write acc=...:g
    >>> check_accelerometer("acc", still * 9.81, np.full(100, 0.01))
    ''
    """
    norm = _at_rest(acc, dt)
    if norm is None or 0.9 * _GRAVITY < norm < 1.1 * _GRAVITY:
        return ""
    usual = float(np.nanmedian(np.linalg.norm(acc, axis=1)))
    if 0.8 * _GRAVITY < usual < 1.2 * _GRAVITY:  # a fall or a steady push is calm, too
        return f"{name} reads {norm:.3g} m/s^2 where it is calmest, and {usual:.3g} usually"
    near = [scale for scale in _FORCES if 0.9 * scale.factor < norm < 1.1 * scale.factor]
    if near:
        units = " or ".join(scale.unit for scale in near)
        raise LogError(
            f"{name} reads {norm:.3g} m/s^2 at rest, which looks like {units}; "
            f"{way_out.format(name=name, unit=near[0].unit)}"
        )
    if norm < 0.1 * _GRAVITY:
        raise LogError(
            f"{name} reads {norm:.3g} m/s^2 at rest, so gravity was taken out of it; map the "
            "specific force, which reads 9.8 at rest"
        )
    raise LogError(
        f"{name} reads {norm:.3g} m/s^2 at rest, where 9.8 is right; give its unit, or the factor "
        f"to m/s^2 as in {name}=...*{_GRAVITY / norm:.4g}"
    )


def check_gyroscope(name: str, gyr: Floats, way_out: str = _MAP) -> None:
    """Refuse rates, rad/s ``(N, 3)``, that no gyroscope of 2000 deg/s can measure.

    Args:
        name: the channel.
        gyr: rates.
        way_out: the advice to the user, with {name} and {unit}.

    Raises:
        LogError: with the way out.
    """
    rate = np.abs(gyr[~np.isnan(gyr).any(axis=1)])
    fast = float(np.quantile(rate.max(axis=1), 0.99)) if len(rate) else 0.0
    if fast > _RANGE_RAD_S:
        raise LogError(
            f"{name} reaches {fast:.3g} rad/s, {fast * _DEGREES:.3g} deg/s, beyond what gyroscopes "
            f"measure, so it looks like deg/s; {way_out.format(name=name, unit='deg/s')}"
        )


def check_turning(name: str, gyr: Floats, acc: Floats, dt: Floats) -> None:
    """Refuse rates that turn some 57 times as fast as gravity does in sensor axes.

    Without acceleration, the specific force f obeys df/dt = -w x f. The slope between both
    sides, over spans long enough to see beyond the noise, is 1 where w is in rad/s, 1/57.3 where
    degrees are taken for radians, and 57.3 where it is the other way around.

    Args:
        name: the channel of the rates.
        gyr: rates, ``(N, 3)``.
        acc: specific force, ``(N, 3)``.
        dt: sample times, s, ``(N,)``.

    Raises:
        LogError: with the way out.
    """
    span = max(1, round(0.2 / float(np.median(dt))))
    force, turn = _blocks(acc, span), _blocks(gyr, span)
    if len(force) < 10:
        return
    seen = (force[2:] - force[:-2]) / (2 * span * float(np.median(dt)))
    expected = -np.cross(turn[1:-1], force[1:-1])
    good = ~np.isnan(seen).any(axis=1) & ~np.isnan(expected).any(axis=1)
    seen, expected = seen[good], expected[good]
    product = float((seen * expected).sum())
    power, total = float((expected**2).sum()), float((seen**2).sum())
    if product < 0.7 * np.sqrt(power * total) or power == 0.0:
        return  # the rotation explains too little of the measured change to tell a unit
    slope = product / power
    if 0.5 < slope * _DEGREES < 2.0:
        raise LogError(
            f"{name} turns {1 / slope:.3g} times as fast as gravity does in the accelerometer's "
            f"axes, so it looks like deg/s; write {name}=...:deg/s"
        )
    if 0.5 < slope / _DEGREES < 2.0:
        raise LogError(
            f"{name} turns {1 / slope:.3g} times as fast as gravity does in the accelerometer's "
            f"axes, so rad/s were taken for deg/s; write {name}=...:rad/s"
        )


def check_rate(name: str, gyr: Floats, truth_name: str, truth: Floats, dt: Floats) -> None:
    """Refuse rates, ``(N, 3)``, that are 57 times those of a true attitude, ``(N, 4)``.

    Raises:
        LogError: with the way out.
    """
    rows = np.flatnonzero(~np.isnan(truth).any(axis=1))
    if len(rows) < 10:
        return
    turns = np.abs((truth[rows[1:]] * truth[rows[:-1]]).sum(axis=1))
    sizes = np.linalg.norm(truth[rows], axis=1)
    turns = 2 * np.arccos(np.clip(turns / (sizes[1:] * sizes[:-1]), 0.0, 1.0))
    # Summed between the truth's instants, so that shaking does not count.
    vectors = np.cumsum(np.nan_to_num(gyr) * dt[:, None], axis=0)[rows]
    true, ours = float(turns.sum()), float(np.linalg.norm(np.diff(vectors, axis=0), axis=1).sum())
    if true < np.radians(20) or true < np.radians(1.0) * float(dt[rows[0] : rows[-1]].sum()):
        return  # it hardly moves: the rates are mostly noise and bias
    if 20.0 < ours / true < 200.0:
        raise LogError(
            f"{name} turns {ours / true:.3g} times as much as {truth_name}, so it looks like "
            f"deg/s; write {name}=...:deg/s"
        )


def check_frame(name: str, truth: Floats, acc: Floats) -> None:
    """Refuse a true attitude, ``(N, 4)``, that does not turn gravity's reaction up.

    Raises:
        LogError: with the rotation that would fit, where there is one.
    """
    frame = frame_of(truth, acc)
    if frame is None or frame.fits:
        return
    up = np.array2string(frame.up, precision=2, suppress_small=True, separator=", ")
    way_out = f"write {name}={frame.columns} for its columns q0 to q3"
    if not frame.columns:
        way_out = "give truth and sensors in the same axes"
    if frame.meaning:
        raise LogError(
            f"{name} turns gravity's reaction to {up}, not up; it fits as {frame.meaning}: "
            f"{way_out}"
        )
    raise LogError(
        f"{name} turns gravity's reaction to {up}, not up, and neither its conjugate nor turned "
        "axes fit; check that it belongs to this recording"
    )


def _three(
    channels: Mapping[str, Floats], declared: "Mapping[str, Channel]", unit: str
) -> tuple[str, Floats] | None:
    """The one channel of three axes in a unit."""
    found = [
        (name, channels[name])
        for name, fact in declared.items()
        if fact.unit == unit and len(fact.axes) == 3 and name in channels
    ]
    return found[0] if found else None


def _attitudes(line: Timeline, outputs: "Mapping[str, Channel]") -> dict[str, Floats]:
    return {
        name: line.truth[name]
        for name, fact in outputs.items()
        if fact.kind == "attitude" and name in line.truth
    }


def _at_rest(acc: Floats, dt: Floats) -> float | None:
    """The mean norm over the calmest half second; None where nothing is calm."""
    span = max(4, round(_REST_S / float(np.median(dt))))
    whole = acc[~np.isnan(acc).any(axis=1)]
    count = len(whole) // span
    if not count:
        return None
    blocks = whole[: count * span].reshape(count, span, 3)
    size = np.linalg.norm(blocks.mean(axis=1), axis=1)
    noise = np.sqrt(blocks.var(axis=1).sum(axis=1))
    calm = int(np.argmin(noise))
    largest = float(np.median(np.linalg.norm(whole, axis=1)))
    return float(size[calm]) if noise[calm] <= 0.05 * max(largest, 1.0) else _not_calm(whole)


def _not_calm(whole: Floats) -> float | None:
    """Without any rest, the median norm still tells gravity from a tenth or a hundredth of it."""
    norm = np.linalg.norm(whole, axis=1)
    low, median, high = np.quantile(norm, [0.05, 0.5, 0.95])
    return float(median) if high - low < 0.5 * median else None


def _blocks(values: Floats, span: int) -> Floats:
    """Means over blocks of so many samples, ``(M, 3)``."""
    count = len(values) // span
    return np.asarray(values[: count * span].reshape(count, span, 3).mean(axis=1))
