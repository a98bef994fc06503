"""The formats, and writing and reading in any of them."""

import difflib
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tuner.atomic import WriteError, write_bytes
from tuner.export import csv, header, json, mat, matlab, npz, toml
from tuner.export.error import ExportError
from tuner.export.tuned import Tuned


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: its name for the user.
        suffix: of its files, with the dot.
        dump: writes it.
        load: reads it.
        about: it in a phrase.
        text: whether its files are text.
    """

    name: str
    suffix: str
    dump: Callable[[Tuned], bytes]
    load: Callable[[bytes], Tuned]
    about: str
    text: bool = True


_FORMATS = {
    format.name: format
    for format in (
        Format("json", ".json", json.dump, json.load, "values and units as JSON"),
        Format("toml", ".toml", toml.dump, toml.load, "values and units as TOML"),
        Format("npz", ".npz", npz.dump, npz.load, "NumPy arrays, by numpy.load", text=False),
        Format("csv", ".csv", csv.dump, csv.load, "one number a row, for spreadsheets"),
        Format("mat", ".mat", mat.dump, mat.load, "MATLAB and Octave, by load", text=False),
        Format("matlab", ".m", matlab.dump, matlab.load, "a script of MATLAB and Octave"),
        Format("c", ".h", header.dump, header.load, "the filter in C, with a self-test"),
    )
}

FORMATS = tuple(_FORMATS)


def suffix(format: str) -> str:
    """The suffix of the format's files, with the dot.

    Raises:
        ExportError: where there is no such format.

    Example:
        >>> suffix("c")
        '.h'
    """
    return _known(format).suffix


def about(format: str) -> str:
    """The format in a phrase.

    Raises:
        ExportError: where there is no such format.

    Example:
        >>> about("csv")
        'one number a row, for spreadsheets'
    """
    return _known(format).about


def is_text(format: str) -> bool:
    """Whether the format's files are text.

    Raises:
        ExportError: where there is no such format.

    Example:
        >>> is_text("c"), is_text("npz")
        (True, False)
    """
    return _known(format).text


def dump(tuned: Tuned, format: str) -> bytes:
    """The file's bytes; the same for the same filter, on every day and machine.

    Args:
        tuned: what to write.
        format: one of :data:`FORMATS`.

    Raises:
        ExportError: where there is no such format.

    Example:
        >>> from tuner.export import Provenance, Quantity
        >>> import numpy as np
        >>> source = Provenance("demo", "step", "grid", "optimal", 0, "", "", ())
        >>> gain = Quantity("K1", np.array(0.25), "", "Gain on the rate.")
        >>> tuned = Tuned("gyro", "FixedGainFilter", (gain,), "discrete", 0.01, (), source)
        >>> dump(tuned, "csv").decode().splitlines()[-1]
        '"K1","","",0.25,"","Gain on the rate."'
        >>> load(dump(tuned, "c"), "c") == tuned
        True
    """
    return _known(format).dump(tuned)


def load(data: bytes, format: str) -> Tuned:
    """Read what :func:`dump` wrote, equal to the bit; nothing in it is ever run.

    Args:
        data: the file's bytes.
        format: one of :data:`FORMATS`.

    Raises:
        ExportError: where there is no such format, or the bytes are damaged or not of its kind.

    Example:
        >>> load(b"{}", "json")
        Traceback (most recent call last):
        tuner.export.error.ExportError: no tuned filter can be read as json (the list of \
quantities is missing or not a list); export it again
    """
    known = _known(format)
    try:
        return known.load(data)
    except Exception as error:  # readers of foreign bytes can raise anything
        reason = textwrap.shorten(str(error) or type(error).__name__, 200, placeholder=" ...")
        raise ExportError(
            f"no tuned filter can be read as {format} ({reason.rstrip('.')}); export it again"
        ) from error


def write(tuned: Tuned, path: Path | str, format: str, *, overwrite: bool = False) -> Path:
    """Write a file, whole or not at all.

    Args:
        tuned: what to write.
        path: the file, under this very name; its folder must exist.
        format: one of :data:`FORMATS`.
        overwrite: whether a file that is there may be replaced.

    Returns:
        The path.

    Raises:
        ExportError: where there is no such format, the file exists and may not be replaced, or
            it cannot be written; an existing file is then unchanged.

    Example:
        >>> write(tuned, folder / f"{tuned.name}{suffix('c')}", "c")  # doctest: +SKIP
        PosixPath('out/gyro.h')
    """
    data = dump(tuned, format)
    try:
        write_bytes(Path(path), data, overwrite=overwrite)
    except WriteError as error:
        raise ExportError(str(error)) from error
    return Path(path)


def read_back(tuned: Tuned, path: Path | str, format: str) -> Tuned:
    """Read a file that was just written, and compare it with what it should hold.

    Args:
        tuned: what was written.
        path: the file.
        format: one of :data:`FORMATS`.

    Raises:
        ExportError: where the file does not hold the same, to the bit.
    """
    found = load(Path(path).read_bytes(), format)
    if found != tuned:
        raise ExportError(
            f"{path} does not hold what was written; the disk may be damaged: choose another place"
        )
    return found


def _known(name: str) -> Format:
    if name not in _FORMATS:
        near = difflib.get_close_matches(name.lower(), FORMATS) or FORMATS
        raise ExportError(f"there is no format {name!r}; there are {', '.join(near)}")
    return _FORMATS[name]
