"""NPZ: numpy's archive, each quantity an array, and the rest as JSON text. Never pickles."""

import io
import json
import zipfile

import numpy as np
from numpy.typing import NDArray

from tuner.export.arrays import META, from_arrays, meta
from tuner.export.tuned import Tuned


def dump(tuned: Tuned) -> bytes:
    """A ZIP archive as ``np.savez`` writes it, but without the time of day."""
    arrays: dict[str, NDArray[np.generic]] = {q.name: q.value for q in tuned.quantities}
    arrays[META] = np.array(meta(tuned))
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            archive.writestr(_member(f"{name}.npy"), _npy(array))
    return stream.getvalue()


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise ValueError("it is a single array")
        arrays = {name: archive[name] for name in archive.files}
    text = arrays.pop(META, None)
    if text is None or text.dtype.kind != "U" or text.shape != ():
        raise ValueError(f"it has no text {META!r}")
    return from_arrays(json.loads(str(text)), arrays)


def _member(name: str) -> zipfile.ZipInfo:
    """An entry that is the same on every machine and every day."""
    member = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    member.create_system = 3
    member.external_attr = 0o644 << 16
    return member


def _npy(array: NDArray[np.generic]) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array, allow_pickle=False)
    return stream.getvalue()
