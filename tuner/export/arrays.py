"""The document of NPZ and MAT: the quantities as named arrays, and all the rest as JSON text."""

import json
import reprlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tuner.export.document import head, label, mapping, sequence, tuned_from
from tuner.export.tuned import Quantity, Tuned

META = "tuner_meta"


def meta(tuned: Tuned) -> str:
    """The head and the quantities' names, units, meanings and shapes, in ASCII."""
    return json.dumps(head(tuned) | {"quantities": [label(q) for q in tuned.quantities]})


def from_arrays(meta: object, arrays: Mapping[str, NDArray[np.float64]]) -> Tuned:
    """The tuned filter from the parsed text of :func:`meta` and the arrays.

    Raises:
        ValueError: one sentence, where they do not form one.
    """
    if not isinstance(meta, dict):
        raise ValueError("the text beside its arrays is not a mapping")
    labels = sequence("the list of quantities", meta.get("quantities"))
    quantities = [labelled(entry, arrays) for entry in labels]
    mapping("the set of arrays", dict(arrays), [quantity.name for quantity in quantities])
    return tuned_from({key: meta[key] for key in meta if key != "quantities"}, quantities)


def labelled(given: object, arrays: Mapping[str, NDArray[np.float64]]) -> Quantity:
    """The quantity from its :func:`~tuner.export.document.label` and its array.

    Raises:
        ValueError: one sentence, where there is no such array, or not of this shape; MATLAB
            has matrices only, so a column stands for a vector and 1 x 1 for a number.
    """
    entry = mapping("a quantity", given, ["name", "unit", "meaning", "shape"])
    name, shape = entry["name"], tuple(sequence("a shape", entry["shape"]))
    if name not in arrays:
        raise ValueError(f"there are no numbers for {reprlib.repr(name)}")
    if arrays[name].shape not in (shape, (*shape, 1, 1)[:2]):
        raise ValueError(f"{name!r} is not of the shape {shape} that is written beside it")
    return Quantity(name, arrays[name].reshape(shape), entry["unit"], entry["meaning"])
