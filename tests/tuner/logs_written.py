"""Small logs of other programs, written here by the descriptions of their formats."""

import struct

import numpy as np

DESCRIBED = np.dtype("u1,u1,S4,S16,S64")


def ulog_message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog(topics, dropouts=()):
    """A PX4 ULog.

    Args:
        topics: ``(name, instance, array)``, structured arrays with a field timestamp in us.
        dropouts: their durations, ms.
    """
    kinds = {"u8": "uint64_t", "f4": "float", "f8": "double", "i4": "int32_t", "u1": "uint8_t"}
    out = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), ulog_message("B", bytes(40))]
    for name, array in {name: array for name, _, array in topics}.items():
        fields = []
        for field in array.dtype.names:
            base, shape = array.dtype[field].base, array.dtype[field].shape
            size = f"[{shape[0]}]" if shape else ""
            fields.append(f"{kinds[base.str[1:]]}{size} {field};")
        out.append(ulog_message("F", f"{name}:{''.join(fields)}".encode()))
    for number, (name, instance, _) in enumerate(topics):
        out.append(ulog_message("A", struct.pack("<BH", instance, number) + name.encode()))
    rows = [
        (int(row["timestamp"]), number, row.tobytes())
        for number, (_, _, array) in enumerate(topics)
        for row in array
    ]
    data = [ulog_message("D", struct.pack("<H", k) + body) for _, k, body in sorted(rows)]
    lost = [ulog_message("O", struct.pack("<H", ms)) for ms in dropouts]
    return b"".join([*out, *data, *lost])


def sensor_topics(samples=200):
    """A gyroscope twice at 250 Hz and a barometer at 20 Hz, as PX4 names them."""
    rng = np.random.default_rng(3)
    gyro = np.zeros(samples, [("timestamp", "<u8"), ("rad", "<f4", (3,)), ("clipped", "u1")])
    gyro["timestamp"] = 1_000_000 + 4000 * np.arange(samples)
    gyro["rad"] = rng.normal(size=(samples, 3))
    other = gyro.copy()
    other["timestamp"] += 7
    baro = np.zeros(samples // 10, [("timestamp", "<u8"), ("alt_m", "<f8")])
    baro["timestamp"] = 1_010_000 + 50_000 * np.arange(len(baro))
    baro["alt_m"] = rng.normal(size=len(baro))
    return [("gyro", 0, gyro), ("gyro", 1, other), ("baro", 0, baro)]


CODES = {
    "Q": "<u8", "B": "u1", "b": "i1", "f": "<f4", "d": "<f8", "c": "<i2", "L": "<i4", "N": "S16",
    "Z": "S64", "I": "<u4", "a": "32<i2",
}  # fmt: skip


def dataflash(kinds, units=(), mults=(), letters=()):
    """An ArduPilot DataFlash log.

    Args:
        kinds: ``{name: (codes, columns, rows)}``, numbers as they are stored.
        units: ``(letter, unit)``.
        mults: ``(letter, factor)``.
        letters: ``(name, letters of units, letters of factors)``.
    """
    numbers = {name: 10 + k for k, name in enumerate(kinds)}
    rows = [(9, numbers[name], unit, mult) for name, unit, mult in letters]
    described = {
        "FMTU": ("QBNN", "TimeUS,FmtType,UnitIds,MultIds", rows),
        "UNIT": ("QbZ", "TimeUS,Id,Label", [(9, ord(letter), unit) for letter, unit in units]),
        "MULT": ("Qbd", "TimeUS,Id,Mult", [(9, ord(letter), mult) for letter, mult in mults]),
    }
    out = [record(128, DESCRIBED, (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"))]
    found = []
    for name, (codes, columns, rows) in {**described, **kinds}.items():
        number = numbers.setdefault(name, 200 + len(numbers))
        dtype = np.dtype([(f"{k}", CODES[code]) for k, code in enumerate(codes)])
        out.append(record(128, DESCRIBED, (number, dtype.itemsize + 3, name, codes, columns)))
        found += [record(number, dtype, row) for row in rows]
    return b"".join(out + found)


def record(number, dtype, row):
    row = tuple(cell.encode() if isinstance(cell, str) else cell for cell in row)
    return b"\xa3\x95" + bytes([number]) + np.array(row, dtype).tobytes()


def flight(samples=100):
    """Two gyroscopes at 400 Hz, a barometer with a scaled temperature, and positions."""
    rng = np.random.default_rng(4)
    gyro = rng.normal(size=samples).astype(np.float32)
    times = 1_000_000 + 2500 * np.arange(samples)
    imu = [(t + i, i, g + i) for t, g in zip(times, gyro, strict=True) for i in (0, 1)]
    baro = [(t, 100.0 + k, 2512 + k) for k, t in enumerate(times[::20])]
    gps = [(t, k, 471_234_567 + k) for k, t in enumerate(times[::40])]
    kinds = {
        "IMU": ("QBf", "TimeUS,I,GyrX", imu),
        "BARO": ("Qfc", "TimeUS,Alt,Temp", baro),
        "GPS": ("QIL", "TimeUS,GMS,Lat", gps),
        "MSG": ("QZ", "TimeUS,Message", [(999, "hello, world")]),
    }
    units = [("s", "s"), ("E", "rad/s"), ("m", "m"), ("O", "degC"), ("#", "instance")]
    mults = [("F", 1e-6), ("C", 1e-3), ("B", 1e-2), ("0", 1.0), ("-", 0.0), ("G", 1e-7)]
    letters = [("IMU", "s#E", "F-0"), ("BARO", "smO", "F0B"), ("GPS", "ssD", "FCG")]
    return dataflash(kinds, [*units, ("D", "deglatitude")], mults, letters), gyro


def flight_text(gyro):
    """The same log as text, cut in its last line."""
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 10, 16, IMU, QBf, TimeUS,I,GyrX",
        "FMT, 11, 44, FMTU, QBNN, TimeUS,FmtType,UnitIds,MultIds",
        "FMT, 12, 76, UNIT, QbZ, TimeUS,Id,Label",
        "FMT, 13, 75, MSG, QZ, TimeUS,Message",
        "UNIT, 9, 69, rad/s",
        "UNIT, 9, 35, instance",
        "FMTU, 9, 10, s#E, F-0",
        "MSG, 999, hello, world",
    ]
    for k, value in enumerate(gyro):
        lines += [f"IMU, {1_000_000 + 2500 * k + i}, {i}, {value + i!s}" for i in (0, 1)]
    return "\n".join([*lines, "IMU, 12345"])
