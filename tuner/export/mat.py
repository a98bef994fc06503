"""MAT v5: each quantity a variable of MATLAB, and all the rest in ``tuner_meta``."""

import io
import json

import numpy as np
from numpy.typing import NDArray

from tuner.data.mat import variables
from tuner.export.arrays import META, from_arrays, meta
from tuner.export.document import Document, head
from tuner.export.tuned import Tuned

_JSON = "tuner_json"
# scipy writes the day and the system here, which would make equal files differ.
_TEXT = b"MATLAB 5.0 MAT-file, written by filter-tuner".ljust(116)


def dump(tuned: Tuned) -> bytes:
    """After ``load`` MATLAB has ``R``, ``P0`` ... as matrices, vectors as columns.

    ``tuner_meta`` is for people; the text ``tuner_json`` is read back.
    """
    from scipy.io import savemat

    contents: Document = {quantity.name: quantity.value for quantity in tuned.quantities}
    contents |= {META: _struct(tuned), _JSON: meta(tuned)}
    stream = io.BytesIO()
    savemat(stream, contents, oned_as="column")
    return _TEXT + stream.getvalue()[len(_TEXT) :]


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote, or MATLAB after it, compressed or not."""
    matrices, texts = variables(data)
    if _JSON not in texts:
        raise ValueError(f"it has no text {_JSON!r}")
    return from_arrays(json.loads(texts[_JSON]), matrices)


def _struct(tuned: Tuned) -> Document:
    """The metadata as MATLAB shows them."""
    given = head(tuned)
    return given | {
        "states": _cells([[state] for state in given["states"]]),
        "versions": _cells([[*pair] for pair in given["versions"].items()]),
        "units": {quantity.name: quantity.unit for quantity in tuned.quantities},
        "meanings": {quantity.name: quantity.meaning for quantity in tuned.quantities},
    }


def _cells(rows: list[list[str]]) -> NDArray[np.object_]:
    """A cell array, for texts of different lengths."""
    cells = np.empty((len(rows), len(rows[0]) if rows else 0), object)
    for i, row in enumerate(rows):
        cells[i] = row
    return cells
