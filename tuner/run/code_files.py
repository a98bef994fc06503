"""Files of C: in which variants they are written, where a run keeps them, and writing them."""

from pathlib import Path
from typing import NamedTuple

from tuner.atomic import WriteError, write_bytes
from tuner.code.files import Files
from tuner.code.literal import Precision
from tuner.export import ExportError


class Variant(NamedTuple):
    """A way to write a filter.

    Attributes:
        precision: of its real numbers.
        tunable: whether its parameters can be set as it runs.
    """

    precision: Precision = "double"
    tunable: bool = False

    @property
    def folder(self) -> str:
        """Where a run keeps it, below its exports; "" for these themselves."""
        parts = ["float"] if self.precision == "float" else []
        return "-".join([*parts, "tunable"] if self.tunable else parts)


_PRECISIONS: tuple[Precision, ...] = ("double", "float")
VARIANTS = tuple(Variant(p, t) for p in _PRECISIONS for t in (False, True))


def kept(name: str, variant: Variant) -> str:
    """Where a run keeps a filter's code, relative to its folder, without suffix."""
    return "/".join(part for part in ("exports", variant.folder, name) if part)


def write(files: Files, header: Path, *, overwrite: bool) -> tuple[Path, ...]:
    """Write the header, the source and the self-test beside each other.

    Raises:
        ExportError: for a header with the source's name, and where one of the files is there and
            may not be replaced, or cannot be written; then none is new.
    """
    source = header.with_suffix(".c")
    if source == header:
        raise ExportError(f"{header} is the name of the source; name the header, such as gyro.h")
    paths = header, source, source.with_name(f"{source.stem}_selftest.c")
    done: list[Path] = []
    try:
        for path, text in zip(paths, files.in_order, strict=True):
            write_bytes(path, text.encode("ascii"), overwrite=overwrite)
            done.append(path)
    except WriteError as error:
        for path in () if overwrite else done:
            path.unlink(missing_ok=True)
        raise ExportError(str(error)) from error
    return paths


def renamed(text: str, before: str, after: str) -> str:
    """A source whose header has another name."""
    return text.replace(f'#include "{before}"', f'#include "{after}"')
