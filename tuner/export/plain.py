"""The document of JSON and TOML: the head, and the quantities as lists of numbers."""

import reprlib
from typing import Any

from tuner.export.document import Document, mapping, sequence, tuned_from
from tuner.export.tuned import Quantity, Tuned


def plain_quantities(tuned: Tuned) -> list[Document]:
    """The quantities, their numbers in lists of rows."""
    return [
        {
            "name": quantity.name,
            "value": quantity.value.tolist(),
            "unit": quantity.unit,
            "meaning": quantity.meaning,
        }
        for quantity in tuned.quantities
    ]


def from_plain(document: object) -> Tuned:
    """The tuned filter of a head with ``"quantities"`` beside it.

    Raises:
        ValueError: one sentence, where it is not one.
    """
    if not isinstance(document, dict):
        raise ValueError("the document is not a mapping")
    quantities = sequence("the list of quantities", document.get("quantities"))
    head = {key: value for key, value in document.items() if key != "quantities"}
    return tuned_from(head, map(_quantity, quantities))


def _quantity(given: object) -> Quantity:
    entry = mapping("a quantity", given, ["name", "value", "unit", "meaning"])
    return Quantity(**entry | {"value": _floats(entry["value"])})


def _floats(given: Any) -> Any:
    """The same without whole numbers: a person writes 1 where 1.0 is meant."""
    if isinstance(given, list):
        return [_floats(inner) for inner in given]
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f"{reprlib.repr(given)} is not a number")
    return float(given)
