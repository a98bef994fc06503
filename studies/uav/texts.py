"""The texts of a flight, read from zip files or folders: tables of numbers, up to a size.

Nothing is unpacked; every text is read into memory.
"""

import io
import zipfile
import zlib
from pathlib import Path

import numpy as np

BIGGEST = 64 * 2**20
"""The largest text that is read, bytes."""


def texts(folder: str, name: str) -> dict[str, bytes]:
    """The flight's files by name, each at most :data:`BIGGEST` long."""
    if not folder:
        raise ValueError(
            "there are no flights without a folder; give the folder of the zips, --set folder=PATH"
        )
    if Path(name).name != name:
        raise ValueError(f"{name!r} is not a flight's name; give it without folder and ending")
    wanted = ("IMU.txt", "GPS.txt", "ATT.txt", "timing.txt")
    packed, plain = Path(folder) / f"{name}.zip", Path(folder) / name
    if packed.is_file():
        found = _unzipped(packed, wanted)
    elif plain.is_dir():
        there = [plain / file for file in wanted if (plain / file).is_file()]
        found = {path.name: _bounded(name, path.name, path.stat().st_size, path) for path in there}
    else:
        raise ValueError(
            f"{folder} has neither {name}.zip nor a folder {name}; give the folder of the flights, "
            "--set folder=PATH, and their names, --set tuned=NAME"
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
        raise ValueError(f"{packed.name} is not a readable zip: {error}") from None


def _bounded(name: str, file: str, size: int, source: Path | zipfile.ZipFile) -> bytes:
    """A file's bytes; its declared size is not trusted."""
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


def table(name: str, file: str, data: bytes, width: int) -> np.ndarray:
    """A text's numbers, ``(N, at least width)``, all finite."""
    try:
        text = data.decode("ascii")
        rows = np.loadtxt(io.StringIO(text), ndmin=2) if text.strip() else np.zeros((0, width))
    except (ValueError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} of {name} is not a table of numbers: {error}") from None
    if not len(rows) or rows.shape[1] < width:
        raise ValueError(
            f"{file} of {name} has {len(rows)} rows of {rows.shape[1]} numbers; at least {width} "
            "are needed in each"
        )
    if not np.isfinite(rows).all():
        first = int(np.argwhere(~np.isfinite(rows))[0][0])
        raise ValueError(f"{file} of {name} has no number in row {first}; fill or cut it")
    return rows
