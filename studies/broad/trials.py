"""The benchmark's published recordings, read from the user's folder and checked."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from filters import Channel, Mahony, channel_facts
from tuner.data.logs.formats import open_table
from tuner.data.logs.table import Loaded, Table
from tuner.data.reading import read_record
from tuner.data.record import Record
from tuner.data.source import Source

GRAVITY = 9.81
NEEDED = ("imu_acc", "imu_gyr", "opt_quat", "movement", "sampling_rate")
MOVES = Channel("", "whether the sensor moves, so that the sample counts")
PLACE = Channel("m", "optical, in earth axes", ("x", "y", "z"))
SHORTEST = 1.0
"""Shortest rest phase before the movement, s, in which a filter can start."""
APART = 5.0
"""Largest angle between the truth's vertical and the accelerometers' at rest, deg."""

AccUnit = Literal["m/s^2", "g"]
GyrUnit = Literal["rad/s", "deg/s"]


@dataclass(frozen=True, eq=False)
class Trial:
    """One recording.

    Attributes:
        name: its file's, without the ending.
        acceleration: specific force, m/s^2, ``(N, 3)``.
        rate: angular rate, rad/s, ``(N, 3)``.
        field: magnetic field in any unit, ``(N, 3)``; NaN where it is missing; None without any.
        start: attitude by gravity and field, sensor to earth with y to magnetic north, ``(4,)``,
            at the first sample that has both; None where no field is known before the movement.
        truth: optical attitude, sensor to earth, ``(N, 4)``; NaN where it is missing or the sensor
            rests, so that it does not count.
        place: optical, of the sensor in earth axes, m, ``(N, 3)``; NaN where it is missing; None
            without any.
        rate_hz: sample rate.
        source: the file.
    """

    name: str
    acceleration: np.ndarray
    rate: np.ndarray
    field: np.ndarray | None
    start: np.ndarray | None
    truth: np.ndarray
    place: np.ndarray | None
    rate_hz: float
    source: Source

    @property
    def disturbed(self) -> bool:
        """Whether its name says so."""
        return "_disturbed_" in self.name


def halved(trial: Trial) -> Trial:
    """A trial at half the rate: means of pairs of samples, with the later one's truth."""
    pairs = len(trial.rate) // 2
    mean = lambda part: part[: 2 * pairs].reshape(pairs, 2, 3).mean(axis=1)  # noqa: E731
    return replace(
        trial,
        acceleration=mean(trial.acceleration),
        rate=mean(trial.rate),
        truth=trial.truth[1 : 2 * pairs : 2],
        field=None if trial.field is None else mean(trial.field),
        place=None if trial.place is None else trial.place[1 : 2 * pairs : 2],
        rate_hz=trial.rate_hz / 2,
    )


def read(folder: str, acc_unit: AccUnit, gyr_unit: GyrUnit, seconds: float | None) -> list[Trial]:
    """All trials of a folder, by name.

    Args:
        folder: with the benchmark's .mat files.
        acc_unit, gyr_unit: of the files.
        seconds: only so much of each from its beginning; None for all.

    Raises:
        ValueError: for a folder without trials, and for a trial that cannot be used: says why.
    """
    paths = sorted(Path(folder).glob("*.mat")) if folder else []
    if not paths:
        where = f"in {folder}" if folder else "without a folder"
        raise ValueError(
            f"there are no recordings {where}; give the folder of the benchmark's .mat files, "
            "--set folder=PATH"
        )
    trials = [_read(path, acc_unit, gyr_unit, seconds) for path in paths]
    rates = sorted({trial.rate_hz for trial in trials})
    if len(rates) > 1:
        raise ValueError(
            f"the trials have sample rates from {rates[0]:g} to {rates[-1]:g} Hz; give those of "
            "one rate, for their parameters are shared"
        )
    return trials


def _read(path: Path, acc_unit: AccUnit, gyr_unit: GyrUnit, seconds: float | None) -> Trial:
    table = open_table(path)
    names = table.names
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise ValueError(
            f"{path.name} has no {', '.join(missing)}; a trial has {', '.join(NEEDED)}"
        )
    rate_hz = _rate(path.name, np.ravel(_array(table, "sampling_rate")))
    fields = ["mag=imu_mag"] if _holds(table, "imu_mag") else []
    places = ["place=opt_pos:m"] if _holds(table, "opt_pos") else []
    record = read_record(
        path,
        [f"gyr=imu_gyr:{gyr_unit}", f"acc=imu_acc:{acc_unit}", "moves=movement", *fields, *places],
        truth=["att=opt_quat"],
        inputs=channel_facts(Mahony, "inputs") | {"moves": MOVES, "place": PLACE},
        outputs={"att": channel_facts(Mahony, "outputs")["att"]},
        rate_hz=rate_hz,
    )
    return _checked(path.stem, record, seconds)


def _holds(table: Table, name: str) -> bool:
    """Whether a table has an array with any number in it."""
    if name not in table.names:
        return False
    raw = _array(table, name)
    return raw.dtype.kind != "f" or bool(np.isfinite(raw).any())


def _array(table: Table, name: str) -> np.ndarray:
    return Loaded.of(table.load((name,))).raw[name]


def _rate(name: str, rates: np.ndarray) -> float:
    if rates.size != 1:
        raise ValueError(f"{name} has {rates.size} numbers as sampling_rate; give one, in Hz")
    rate_hz = float(rates[0])
    if not 0 < rate_hz < np.inf:
        raise ValueError(f"{name} has a sampling_rate of {rate_hz:g} Hz; it must be positive")
    return rate_hz


def _checked(name: str, record: Record, seconds: float | None) -> Trial:
    source = record.sources[0]
    rate_hz = source.rate_hz
    count = None if seconds is None else max(round(seconds * rate_hz), 1)
    signals = {**record.channels, **record.truth}
    parts = {key: signal.values[:count] for key, signal in signals.items()}
    acc, gyr, truth, moving = parts["acc"], parts["gyr"], parts["att"], parts["moves"] > 0
    for what, values in (("imu_acc", acc), ("imu_gyr", gyr)):
        if np.isnan(values).any():
            first = int(np.argwhere(np.isnan(values))[0][0])
            raise ValueError(f"{what} of {name} has no number at sample {first}; fill or cut it")
    if not moving.any():
        raise ValueError(
            f"{name} never moves (movement is false throughout), so nothing can be judged; take "
            "more of it, or leave it out"
        )
    begins = int(np.argmax(moving))
    if begins < SHORTEST * rate_hz:
        raise ValueError(
            f"{name} rests for {begins / rate_hz:.2g} s before its movement; {SHORTEST:g} s are "
            "needed for a filter to begin"
        )
    length = np.linalg.norm(truth, axis=1, keepdims=True)
    truth = np.where(length > 0, truth, np.nan) / np.where(length > 0, length, 1.0)
    if np.isnan(truth[moving]).any(axis=1).all():
        raise ValueError(f"opt_quat of {name} is NaN throughout the movement: there is no truth")
    _check_force(name, acc[:begins])
    _check_axes(name, acc[:begins], truth[:begins])
    _check_rate(name, gyr, truth, rate_hz)
    masked = np.where(moving[:, None], truth, np.nan)
    field = parts.get("mag")
    start = None if field is None else _start(acc[:begins], field)
    source = replace(source, samples=len(acc))
    return Trial(name, acc, gyr, field, start, masked, parts.get("place"), rate_hz, source)


def _start(acc: np.ndarray, field: np.ndarray) -> np.ndarray | None:
    """The attitude at rest that gravity and the field point to, at the first sample with both."""
    east = np.cross(field[: len(acc)], acc)
    known = np.flatnonzero((east**2).sum(axis=1) > 0)  # false for NaN
    if not known.size:
        return None
    up, east = acc[known[0]], east[known[0]]
    axes = np.array([axis / np.linalg.norm(axis) for axis in (east, np.cross(up, east), up)])
    return np.asarray(Rotation.from_matrix(axes).as_quat(scalar_first=True))


def _check_force(name: str, acc: np.ndarray) -> None:
    size = float(np.median(np.linalg.norm(acc, axis=1)))
    if 0.9 < size < 1.1:
        raise ValueError(
            f"the accelerometers of {name} read {size:.3g} at rest, which is in g, not m/s^2; "
            "say so with --set acc_unit=g"
        )
    if not 0.9 * GRAVITY < size < 1.1 * GRAVITY:
        raise ValueError(
            f"the accelerometers of {name} read {size:.4g} m/s^2 at rest, and gravity is "
            f"{GRAVITY:g}; check their unit and their scale"
        )


def _check_axes(name: str, acc: np.ndarray, truth: np.ndarray) -> None:
    """At rest the accelerometers point up, in the truth's earth axes."""
    seen = ~np.isnan(truth).any(axis=1)
    if not seen.any():
        return
    turned = Rotation.from_quat(truth[seen], scalar_first=True)
    up = turned.apply(acc[seen]).mean(axis=0)
    angle = float(np.degrees(np.arctan2(np.hypot(up[0], up[1]), up[2])))
    if angle > APART:
        raise ValueError(
            f"the accelerometers of {name} at rest are {angle:.0f} deg off the truth's vertical; "
            "give opt_quat as (w, x, y, z), sensor to earth, z up"
        )


def _check_rate(name: str, gyr: np.ndarray, truth: np.ndarray, rate_hz: float) -> None:
    """The gyroscopes' rate against the truth's, over a tenth of a second each."""
    step = max(round(0.1 * rate_hz), 1)
    picked = truth[::step]
    count = len(picked) - 1
    size = np.linalg.norm(gyr[: step * count].reshape(count, step, 3).mean(axis=1), axis=1)
    known = ~np.isnan(picked).any(axis=1)
    filled = np.where(known[:, None], picked, [1.0, 0.0, 0.0, 0.0])
    turns = Rotation.from_quat(filled, scalar_first=True)
    optical = (turns[:-1].inv() * turns[1:]).magnitude() * rate_hz / step
    seen = known[:-1] & known[1:] & (optical > 0.2)
    if not seen.any():
        return
    ratio = float(np.median(size[seen] / optical[seen]))
    if 0.8 < ratio < 1.25:
        return
    if 0.8 < ratio / np.degrees(1.0) < 1.25:
        raise ValueError(
            f"the gyroscopes of {name} read {ratio:.3g} times the rate of the truth, so they are "
            "in deg/s, not rad/s; say so with --set gyr_unit=deg/s"
        )
    raise ValueError(
        f"the gyroscopes of {name} read {ratio:.3g} times the rate of the truth; check their unit, "
        "and sampling_rate"
    )
