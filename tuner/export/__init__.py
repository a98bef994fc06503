"""Tuned filters as files: written in seven formats, and read back to the bit."""

from tuner.export.error import ExportError
from tuner.export.formats import FORMATS, Format, dump, is_text, load, read_back, suffix, write
from tuner.export.tuned import Provenance, Quantity, Tuned

__all__ = [
    "FORMATS",
    "ExportError",
    "Format",
    "Provenance",
    "Quantity",
    "Tuned",
    "dump",
    "is_text",
    "load",
    "read_back",
    "suffix",
    "write",
]
