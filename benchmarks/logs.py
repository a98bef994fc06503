"""Time for a ULog of 50 MB, from the file to two channels: python -m benchmarks.logs."""

import struct
import tempfile
import time
from pathlib import Path

import numpy as np

from tuner.data.reading import read_record

TOPICS = {
    "sensor_combined": (1, 12),
    "attitude": (1, 8),
    "actuators": (1, 16),
    "air_data": (10, 6),
    "imu": (1, 4),
}
"""Period in units of 4 ms, and number of floats."""
SAMPLES = 230_000


def message(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def written(path: Path) -> None:
    """Topics message by message, in the order of their times."""
    head = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), message("B", bytes(40))]
    head += [
        message("F", f"{name}:uint64_t timestamp;float[{width}] v;".encode())
        for name, (_, width) in TOPICS.items()
    ]
    head += [
        message("A", struct.pack("<BH", 0, number) + name.encode())
        for number, name in enumerate(TOPICS)
    ]
    rng = np.random.default_rng(0)
    rows: list[tuple[int, bytes]] = []
    for number, (every, width) in enumerate(TOPICS.values()):
        kinds = [
            ("size", "<u2"),
            ("kind", "u1"),
            ("topic", "<u2"),
            ("t", "<u8"),
            ("v", "<f4", width),
        ]
        array = np.zeros(SAMPLES // every, kinds)
        array["size"], array["kind"], array["topic"] = 10 + 4 * width, ord("D"), number
        array["t"] = 4000 * every * np.arange(len(array)) + number
        array["v"] = rng.standard_normal((len(array), width))
        rows += [(int(row["t"]), row.tobytes()) for row in array]
    rows.sort(key=lambda row: row[0])
    path.write_bytes(b"".join([*head, *(row for _, row in rows)]))


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "flight.ulg")
        written(path)
        for _ in range(3):
            start = time.perf_counter()
            record = read_record(path, ["omega=sensor_combined.v[0]", "z=air_data.v[1]"])
            seconds = time.perf_counter() - start
            size = path.stat().st_size / 1e6
            samples = len(record.channels["omega"].values)
            print(f"{size:.1f} MB, {samples} samples of omega: {seconds:.1f} s")


if __name__ == "__main__":
    main()
