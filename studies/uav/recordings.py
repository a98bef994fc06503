"""Flight recordings of InertialNav's kind, read from zip files or folders and checked.

A recording is a zip, or a folder, of text files of numbers: IMU.txt, GPS.txt, and where there are
any ATT.txt and timing.txt. Nothing is unpacked; every text is read into memory up to a size.
"""

import hashlib
import io
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

GRAVITY = 9.8
BIGGEST = 64 * 2**20
"""The largest text that is read, bytes."""
REST = 2.0
"""At its beginning the vehicle stands for so long, s."""
FASTEST_TURN = 35.0
"""No gyroscope of this kind measures more, rad/s: 2000 deg/s."""
LONGEST_GAP = 1.0
"""Between inertial samples, s."""
FIX = 3
"""GPS status with a position in three dimensions."""

AccUnit = Literal["m/s^2", "g"]
GyrUnit = Literal["rad/s", "deg/s"]
Units = tuple[AccUnit, GyrUnit]


@dataclass(frozen=True, eq=False)
class Recording:
    """What one flight's files hold, times in s.

    Attributes:
        name: of the zip or the folder.
        imu_t: times of the inertial samples, ``(N,)``.
        rate: gyroscopes, rad/s, axes forward, right, down, ``(N, 3)``.
        force: accelerometers, m/s^2, ``(N, 3)``; -g down at rest.
        gps_t: times at which the fixes came in, ``(M,)``.
        place: latitude and longitude, deg, and height, m, ``(M, 3)``.
        speed: over ground and down, m/s, ``(M, 2)``.
        attitude_t: times of the autopilot's attitude, ``(K,)``; K is 0 without any.
        attitude: the autopilot's (phi, theta, psi), rad, ``(K, 3)``: a reference, no truth.
        delays: how late the GPS tells speed and position, s.
        sha256: of the texts.
    """

    name: str
    imu_t: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    gps_t: np.ndarray
    place: np.ndarray
    speed: np.ndarray
    attitude_t: np.ndarray
    attitude: np.ndarray
    delays: tuple[float, float]
    sha256: str


def read(folder: str, name: str, units: Units, delays: tuple[float, float]) -> Recording:
    """One flight.

    Args:
        folder: where the zips, or folders of text files, are.
        name: of the flight: of its zip without the ending, or of its folder.
        units: of accelerometers and gyroscopes.
        delays: of the GPS's speed and position, s, where the flight has no timing.txt.

    Raises:
        ValueError: for a flight that is missing or cannot be used: says why, and what to do.
    """
    texts = _texts(folder, name)
    imu = _table(name, "IMU.txt", texts["IMU.txt"], 8)
    gps = _table(name, "GPS.txt", texts["GPS.txt"], 13)
    att = _table(name, "ATT.txt", texts["ATT.txt"], 5) if "ATT.txt" in texts else np.zeros((0, 5))
    if "timing.txt" in texts:
        delays = _delays(name, texts["timing.txt"])
    fixes = gps[gps[:, 1] == FIX]
    if len(fixes) < 10:
        raise ValueError(
            f"GPS.txt of {name} has {len(fixes)} positions with status {FIX}; 10 are needed, so "
            "give another flight"
        )
    acc = imu[:, 5:8] * (GRAVITY if units[0] == "g" else 1.0)
    gyr = np.radians(imu[:, 2:5]) if units[1] == "deg/s" else imu[:, 2:5]
    _check_times(name, imu[:, 0])
    _check_force(name, acc[imu[:, 0] < imu[0, 0] + 1e3 * REST])
    _check_rate(name, gyr)
    _check_place(name, fixes[:, 6:8])
    digest = hashlib.sha256(b"".join(texts[key] for key in sorted(texts)))
    return Recording(
        name=name,
        imu_t=imu[:, 0] / 1e3,
        rate=gyr,
        force=acc,
        gps_t=fixes[:, 0] / 1e3,
        place=fixes[:, 6:9],
        speed=fixes[:, [10, 12]],
        attitude_t=att[:, 0] / 1e3,
        attitude=np.radians(att[:, 2:5]),
        delays=delays,
        sha256=digest.hexdigest(),
    )


def _delays(name: str, data: bytes) -> tuple[float, float]:
    """Of the GPS's speed and position, s."""
    timing = _table(name, "timing.txt", data, 1).ravel()
    if len(timing) < 5 or not ((timing[3:5] >= 0) & (timing[3:5] < 5000)).all():
        raise ValueError(
            f"timing.txt of {name} has to hold start, alignment, end, and from the fourth number "
            "on the delays of GPS speed and position from 0 to 5000 ms; correct it, or leave it out"
        )
    return float(timing[3]) / 1e3, float(timing[4]) / 1e3


def _texts(folder: str, name: str) -> dict[str, bytes]:
    """The flight's files by name, each at most :data:`BIGGEST` long."""
    if not folder:
        raise ValueError(
            "there are no flights without a folder; give the folder of the zips, --set folder=PATH"
        )
    if Path(name).name != name:
        raise ValueError(f"{name!r} is no name of a flight; give it without folder and ending")
    wanted = ("IMU.txt", "GPS.txt", "ATT.txt", "timing.txt")
    packed, plain = Path(folder) / f"{name}.zip", Path(folder) / name
    if packed.is_file():
        found = _unzipped(packed, wanted)
    elif plain.is_dir():
        there = [plain / file for file in wanted if (plain / file).is_file()]
        found = {path.name: _bounded(name, path.name, path.stat().st_size, path) for path in there}
    else:
        raise ValueError(
            f"there is no flight {name} (neither {name}.zip nor a folder {name}) in {folder}; give "
            "the folder of the flights, --set folder=PATH, and their names, --set tuned=NAME"
        )
    missing = [file for file in wanted[:2] if file not in found]
    if missing:
        raise ValueError(f"{name} has no {' and no '.join(missing)}; a flight needs both files")
    return found


def _unzipped(packed: Path, wanted: tuple[str, ...]) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(packed) as archive:
            names = [info for info in archive.infolist() if info.filename in wanted]
            return {
                info.filename: _bounded(packed.name, info.filename, info.file_size, archive)
                for info in names
            }
    except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError) as error:
        raise ValueError(f"{packed.name} is no zip that can be read: {error}") from None


def _bounded(name: str, file: str, size: int, source: Path | zipfile.ZipFile) -> bytes:
    """A file's bytes; what it says of its size is not believed."""
    data = b""
    if size <= BIGGEST:
        stream = source.open(file) if isinstance(source, zipfile.ZipFile) else source.open("rb")
        with stream:
            data = stream.read(BIGGEST + 1)
    if max(size, len(data)) > BIGGEST:
        raise ValueError(
            f"{file} of {name} is larger than {BIGGEST // 2**20} MiB, which no such flight is; cut "
            "it into shorter ones"
        )
    return data


def _table(name: str, file: str, data: bytes, width: int) -> np.ndarray:
    """A text's numbers, ``(N, at least width)``, all finite."""
    try:
        text = data.decode("ascii")
        rows = np.loadtxt(io.StringIO(text), ndmin=2) if text.strip() else np.zeros((0, width))
    except (ValueError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} of {name} is no table of numbers: {error}") from None
    if not len(rows) or rows.shape[1] < width:
        raise ValueError(
            f"{file} of {name} has {len(rows)} rows of {rows.shape[1]} numbers; at least {width} "
            "are needed in each"
        )
    if not np.isfinite(rows).all():
        first = int(np.argwhere(~np.isfinite(rows))[0][0])
        raise ValueError(f"{file} of {name} has no number in row {first}; fill or cut it")
    steps = np.diff(rows[:, 0])
    if width > 1 and (steps <= 0).any():
        first = int(np.argmax(steps <= 0)) + 1
        raise ValueError(
            f"the time in {file} of {name} does not grow at row {first}; sort the rows and leave "
            "repeated ones out"
        )
    return rows


def _check_times(name: str, t: np.ndarray) -> None:
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if not 1 <= step <= 200:
        raise ValueError(
            f"the inertial samples of {name} are {step:.3g} ms apart if their time is in ms; 1 to "
            "200 is what they may be, so give it in ms"
        )
    gap = float(np.diff(t).max()) / 1e3
    if gap > LONGEST_GAP:
        at = float(t[np.argmax(np.diff(t))]) / 1e3
        raise ValueError(
            f"the inertial samples of {name} have a gap of {gap:.3g} s at {at:.4g} s; "
            f"{LONGEST_GAP:g} s can be bridged, so cut the flight there"
        )


def _check_force(name: str, acc: np.ndarray) -> None:
    size, down = float(np.median(np.linalg.norm(acc, axis=1))), float(acc[:, 2].mean())
    if 0.9 < size < 1.1:
        raise ValueError(
            f"the accelerometers of {name} read {size:.3g} at rest, which is in g, not m/s^2; "
            "say so with --set acc_unit=g"
        )
    if not 0.9 * GRAVITY < size < 1.1 * GRAVITY:
        raise ValueError(
            f"the accelerometers of {name} read {size:.4g} m/s^2 in the first {REST:g} s, and "
            f"gravity is {GRAVITY:g}; begin at rest, and check their unit and their scale"
        )
    if down > -0.8 * GRAVITY:
        raise ValueError(
            f"the third accelerometer of {name} reads {down:.3g} m/s^2 in the first {REST:g} s; "
            f"level, with axes forward, right, down, it reads {-GRAVITY:g}; turn the axes"
        )


def _check_rate(name: str, rate: np.ndarray) -> None:
    fastest = float(np.abs(rate).max())
    if fastest > FASTEST_TURN:
        raise ValueError(
            f"the gyroscopes of {name} read up to {fastest:.3g} rad/s, more than they can measure; "
            "if they are in deg/s, say so with --set gyr_unit=deg/s"
        )


def _check_place(name: str, place: np.ndarray) -> None:
    north, east = np.abs(place).max(axis=0)
    if north > 89 or east > 360:
        raise ValueError(
            f"GPS.txt of {name} has latitudes up to {north:.6g} and longitudes up to {east:.6g}; "
            "give both in degrees, and no flight at a pole"
        )
