"""Flight recordings of InertialNav's kind, as records in SI, checked.

A recording is a zip, or a folder, of text files of numbers: IMU.txt, GPS.txt, and where there are
any ATT.txt and timing.txt.
"""

from typing import NamedTuple

import numpy as np

from filters import Channel, GpsAidedKalman, channel_facts
from studies.uav.texts import table, texts
from tuner.data.geodesy import east, north
from tuner.data.logs import LogError
from tuner.data.plausibility import check_accelerometer, check_gyroscope
from tuner.data.record import Record
from tuner.data.signal import Floats
from tuner.data.units import convert

GRAVITY = 9.8
REST = 2.0
"""Duration of rest at the beginning, s."""
LONGEST_GAP = 1.0
"""Longest gap of inertial samples that is bridged, s."""
FIX = 3
"""GPS status with a position in three dimensions."""
ACC_UNIT, GYR_UNIT = (f"say so with --set {key}={{unit}}" for key in ("acc_unit", "gyr_unit"))

CHANNELS = {
    "gyr": channel_facts(GpsAidedKalman, "inputs")["gyr"],
    "acc": Channel("m/s^2", "specific force, -g down at rest", ("forward", "right", "down")),
    "position": Channel("m", "from the first fix", ("north", "east", "down")),
    "speed": Channel("m/s", "by the GPS", ("over ground", "down")),
    "angles": Channel("rad", "the autopilot's, a reference and no truth", ("phi", "theta", "psi")),
}
"""Channels of a flight's record, each on a clock of its own; angles are optional."""


class Units(NamedTuple):
    """Units of accelerometers and gyroscopes."""

    acc: str = "m/s^2"
    gyr: str = "rad/s"


class Delays(NamedTuple):
    """Delays of the GPS's speed and position, s."""

    speed: float
    position: float


class Recording(NamedTuple):
    """The content of one flight's files: :data:`CHANNELS`, and the delays of those of the GPS."""

    record: Record
    delays: Delays


def read(folder: str, name: str, units: Units, delays: Delays) -> Recording:
    """One flight.

    Args:
        folder: where the zips, or folders of text files, are.
        name: of the flight: of its zip without the ending, or of its folder.
        units: of accelerometers and gyroscopes.
        delays: for a flight without timing.txt.

    Raises:
        ValueError: for a flight that is missing or cannot be used: says why, and what to do.
    """
    files = texts(folder, name)
    imu = table(name, "IMU.txt", files["IMU.txt"], 8)
    gps = table(name, "GPS.txt", files["GPS.txt"], 13)
    fixes = gps[gps[:, 1] == FIX]
    if len(fixes) < 10:
        raise ValueError(
            f"GPS.txt of {name} has {len(fixes)} positions with status {FIX}; 10 are needed, so "
            "give another flight"
        )
    _check_place(name, fixes[:, 6:8])
    columns = {
        "gyr": (imu[:, 0], imu[:, 2:5]),
        "acc": (imu[:, 0], imu[:, 5:8]),
        "position": (fixes[:, 0], local(fixes[:, 6:9])),
        "speed": (fixes[:, 0], fixes[:, [10, 12]]),
    }
    if "ATT.txt" in files:
        att = table(name, "ATT.txt", files["ATT.txt"], 5)
        if len(att) > 1:
            columns["angles"] = att[:, 0], att[:, 2:5]
    if "timing.txt" in files:
        delays = _delays(name, files["timing.txt"])
    found = _record(name, columns, units)
    _check(found)
    return Recording(found, delays)


def _record(name: str, columns: dict[str, tuple[Floats, Floats]], units: Units) -> Record:
    """Channels in SI, from times in ms and values in the files' units."""
    try:
        return Record.of(
            {channel: values for channel, (_, values) in columns.items()},
            times={channel: convert(t, "ms", "s") for channel, (t, _) in columns.items()},
            units={"gyr": units.gyr, "acc": units.acc}
            | ({"angles": "deg"} if "angles" in columns else {}),
            inputs=CHANNELS,
            name=name,
        )
    except LogError as error:
        raise ValueError(f"flight {name}: {error}") from None


def local(place: Floats) -> Floats:
    """North, east, down of the first fix, m, ``(N, 3)``; right to 2 cm within 500 m.

    Args:
        place: latitude and longitude, deg, and height, m, ``(N, 3)``.
    """
    latitude, longitude, height = place.T
    along = north(latitude, latitude[0])
    across = east(longitude, latitude[0], longitude[0])
    return np.stack([along, across, height[0] - height], axis=1)


def _delays(name: str, data: bytes) -> Delays:
    """Delays of the GPS's speed and position."""
    timing = table(name, "timing.txt", data, 1).ravel()
    if len(timing) < 5 or not ((timing[3:5] >= 0) & (timing[3:5] < 5000)).all():
        raise ValueError(
            f"timing.txt of {name} has to hold start, alignment, end and two GPS delays of 0 to "
            "5000 ms; correct it, or leave it out"
        )
    return Delays(*convert(timing[3:5], "ms", "s").tolist())


def _check_place(name: str, place: Floats) -> None:
    highest, furthest = np.abs(place).max(axis=0)
    if highest > 89 or furthest > 360:
        raise ValueError(
            f"GPS.txt of {name} has latitudes up to {highest:.6g} and longitudes up to "
            f"{furthest:.6g}; give both in degrees, and no flight at a pole"
        )


def _check(record: Record) -> None:
    """Refuse physically impossible values, and gaps that cannot be bridged."""
    name, acc, gyr = record.name, record.channels["acc"], record.channels["gyr"]
    _check_times(name, acc.times)
    steps = np.diff(acc.times, prepend=acc.times[0] - acc.running.step)
    if strange := check_accelerometer(f"acc of {name}", acc.values, steps, ACC_UNIT):
        raise ValueError(strange)
    down = float(acc.values[acc.times < acc.times[0] + REST, 2].mean())
    if down > -0.8 * GRAVITY:
        raise ValueError(
            f"the third accelerometer of {name} reads {down:.3g} m/s^2 in the first {REST:g} s; "
            f"level, with axes forward, right, down, it reads {-GRAVITY:g}; turn the axes"
        )
    check_gyroscope(f"gyr of {name}", gyr.values, GYR_UNIT)


def _check_times(name: str, t: Floats) -> None:
    steps = np.diff(t)
    step, gap = float(np.median(steps)), float(steps.max())
    if not 1e-3 <= step <= 0.2:
        raise ValueError(
            f"the inertial samples of {name} are {1e3 * step:.3g} ms apart if their time is in ms, "
            "outside 1 to 200; give it in ms"
        )
    if gap > LONGEST_GAP:
        raise ValueError(
            f"the inertial samples of {name} have a gap of {gap:.3g} s at "
            f"{t[np.argmax(steps)]:.4g} s; {LONGEST_GAP:g} s can be bridged, so cut the flight "
            "there"
        )
