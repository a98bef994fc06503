"""Small valid logs of every format, from which bad ones are made."""

import gzip
import io
import struct
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.mutate import Random, bytes_of

ROWS = 64
TIMES = 0.01 * np.arange(ROWS)
VALUES = np.sin(np.arange(ROWS)).round(4)
_READ = ("columns", "run", "fit")


def text(delimiter: str = ",", point: str = ".") -> bytes:
    """A text log."""
    rows = [f"{t:.2f}{delimiter}{v}" for t, v in zip(TIMES, VALUES, strict=True)]
    return "\n".join([f"t{delimiter}gx", *rows, ""]).replace(".", point).encode()


def npz(save: Any = np.savez) -> bytes:
    """An archive of arrays."""
    stream = io.BytesIO()
    save(stream, t=TIMES, gx=VALUES, fs=np.array(100.0))
    return stream.getvalue()


def mat(**options: Any) -> bytes:
    """A MAT file of version 5."""
    from scipy.io import savemat

    stream = io.BytesIO()
    cells = np.array([VALUES, "text"], object)
    savemat(stream, {"t": TIMES, "gx": VALUES, "s": {"a": TIMES, "b": {"c": cells}}}, **options)
    return b"MATLAB 5.0 MAT-file".ljust(116) + stream.getvalue()[116:]  # without the day


def hdf5(**options: Any) -> bytes:
    """A MAT file of version 7.3."""
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file.create_dataset("t", data=TIMES)
        file.create_dataset("s/gx", data=VALUES, **options)
    return stream.getvalue()


def archive() -> bytes:
    """A zip file of text logs."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr(zipfile.ZipInfo("Gyroscope.csv"), text())
        packed.writestr(zipfile.ZipInfo("meta/device.csv"), "name,value\nx,1\n")
    return stream.getvalue()


def arrow(kind: str) -> bytes:
    """A Parquet or Feather file."""
    import pyarrow as pa
    from pyarrow import feather, parquet

    table, stream = pa.table({"t": TIMES, "gx": VALUES}), io.BytesIO()
    write = parquet.write_table if kind == "parquet" else feather.write_feather
    write(table, stream)
    return stream.getvalue()


def ulog() -> bytes:
    """A PX4 ULog of one topic."""

    def message(kind: bytes, body: bytes) -> bytes:
        return struct.pack("<H", len(body)) + kind + body

    parts = [b"ULog\x01\x12\x35\x01", bytes(8), message(b"B", bytes(40))]
    parts += [message(b"F", b"gyro:uint64_t timestamp;float x;"), message(b"A", bytes(3) + b"gyro")]
    rows = [struct.pack("<HQf", 0, 4000 * k, float(v)) for k, v in enumerate(VALUES)]
    return b"".join(parts + [message(b"D", row) for row in rows])


def dataflash() -> bytes:
    """An ArduPilot log."""

    def described(number: int, size: int, *texts: bytes) -> bytes:
        return b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, size, *texts)

    rows = [b"\xa3\x95\x0a" + struct.pack("<Qf", 2500 * k, float(v)) for k, v in enumerate(VALUES)]
    heads = described(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    return heads + described(10, 15, b"IMU", b"Qf", b"TimeUS,GyrX") + b"".join(rows)


def bag(kind: str) -> bytes:
    """A ROS bag of one number."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    first = kind == "bag"
    store: Any = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    number, name = store.types["std_msgs/msg/Float64"], "std_msgs/msg/Float64"
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "log")
        plugins = rosbag2.StoragePlugin
        writer: Any = rosbag1.Writer(place) if first else rosbag2.Writer(
            place, version=9, storage_plugin=plugins.MCAP if kind == "mcap" else plugins.SQLITE3
        )  # fmt: skip
        with writer:
            connection = writer.add_connection("/x", name, typestore=store)
            write = store.serialize_ros1 if first else store.serialize_cdr
            for k, value in enumerate(VALUES):
                writer.write(connection, 10**7 * (k + 1), write(number(float(value)), name))
        found = place if first else next(f for f in place.iterdir() if f.suffix != ".yaml")
        return found.read_bytes()


FORMATS: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "csv": ("log.csv", text, ""),
    "csv with semicolons": ("log.csv", lambda: text(";", ","), ""),
    "text with blanks": ("log.txt", lambda: text(" "), ""),
    "utf-16": ("log.csv", lambda: text().decode().encode("utf-16"), ""),
    "gz": ("log.csv.gz", lambda: gzip.compress(text()), ""),
    "npz": ("log.npz", npz, ""),
    "npz, packed": ("log.npz", lambda: npz(np.savez_compressed), ""),
    "mat": ("log.mat", mat, ""),
    "mat, packed": ("log.mat", lambda: mat(do_compression=True), ""),
    "zip": ("log.zip", archive, ""),
    "dataflash": ("log.bin", dataflash, ""),
    "hdf5": ("log.mat", hdf5, "h5py"),
    "hdf5, packed": ("log.h5", lambda: hdf5(compression="gzip", chunks=(16,)), "h5py"),
    "parquet": ("log.parquet", lambda: arrow("parquet"), "pyarrow"),
    "feather": ("log.feather", lambda: arrow("feather"), "pyarrow"),
    "ulog": ("log.ulg", ulog, "pyulog"),
    "bag": ("log.bag", lambda: bag("bag"), "rosbags"),
    "mcap": ("log.mcap", lambda: bag("mcap"), "rosbags"),
    "db3": ("log.db3", lambda: bag("db3"), "rosbags"),
}
"""A file's name, the maker of its bytes, and the package whose reader runs apart."""


def cases(random: Random) -> Iterator[Case]:
    """An endless series of damaged logs; those that need a separate process come less often."""
    seeds = {
        kind: (name, make(), bool(package))
        for kind, (name, make, package) in FORMATS.items()
        if not package or find_spec(package)
    }
    kinds = [kind for kind, (_, _, apart) in seeds.items() for _ in range(1 if apart else 6)]
    while True:
        kind = kinds[int(random.integers(len(kinds)))]
        name, data, _ = seeds[kind]
        yield Case(f"log: {kind}", _words(random, name), {name: bytes_of(random, data)})


def _words(random: Random, name: str) -> list[str]:
    """A way to read it."""
    way = _READ[int(random.choice(3, p=(0.8, 0.15, 0.05)))]
    if way == "columns":
        return ["columns", name, *(["--json"] if random.random() < 0.5 else [])]
    maps = ["--map", "omega=gx" if way == "run" else "z=gx", "--rate", "100", "--dry-run"]
    if way == "run":
        return ["run", "kownacki2010", "--log", name, *maps]
    return ["fit", name, "--filter", "local-level", *maps]
