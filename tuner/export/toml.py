"""TOML: for files that people read and change."""

import tomli_w

from tuner.export.document import head
from tuner.export.plain import from_plain, plain_quantities
from tuner.export.tuned import Tuned
from tuner.toml import parsed


def dump(tuned: Tuned) -> bytes:
    """A TOML document in UTF-8; numbers have the digits that give the same float64 again."""
    document = head(tuned)
    # Written last, because all of its keys are known: a truncated file is noticed.
    source = document.pop("provenance")
    document |= {"quantities": plain_quantities(tuned), "provenance": source}
    return tomli_w.dumps(document).encode()


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote, or a person who knows its schema."""
    return from_plain(parsed(data.decode()))
