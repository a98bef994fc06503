"""JSON: one line for each field and each quantity, so that differences read well."""

import json
from typing import Any

from tuner.export.document import head
from tuner.export.plain import from_plain, plain_quantities
from tuner.export.tuned import Tuned


def dump(tuned: Tuned) -> bytes:
    """A JSON object in UTF-8; numbers have the digits that give the same float64 again."""
    lines = [f"{_text(key)}: {_text(value)}" for key, value in head(tuned).items()]
    quantities = ",".join(f"\n    {_text(quantity)}" for quantity in plain_quantities(tuned))
    lines.append(f'"quantities": [{quantities}\n  ]')
    return ("{\n  " + ",\n  ".join(lines) + "\n}\n").encode()


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote, or a person who knows its schema."""
    return from_plain(json.loads(data))


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
