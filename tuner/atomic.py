"""Files that appear whole or not at all, and never in place of another by mistake."""

import contextlib
import errno
import os
import secrets
from pathlib import Path

_NO_LINKS = {errno.EPERM, errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP}


class WriteError(ValueError):
    """A file could not be written, told in one sentence; nothing is left behind.

    Example:
        >>> raise WriteError("gyro.h exists; give another name, or replace it with --force")
        Traceback (most recent call last):
        tuner.atomic.WriteError: gyro.h exists; give another name, or replace it with --force
    """


def write_bytes(path: Path, data: bytes, *, overwrite: bool = False) -> None:
    """Write a file through a temporary one in the same folder, onto the disk itself.

    Args:
        path: the file; its folder must exist.
        data: its contents.
        overwrite: whether a file that is there may be replaced. Where it may not, it stays as
            it is even if another process writes it at the same moment.

    Raises:
        WriteError: where the file exists and may not be replaced, or cannot be written.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     write_bytes(Path(folder) / "gains.txt", b"K1 = 0.25")
        ...     (Path(folder) / "gains.txt").read_text()
        'K1 = 0.25'
    """
    if not overwrite and os.path.lexists(path):
        raise _exists(path)
    # The name is not built from the file's own, which may already have the longest length.
    temporary = path.parent / f".tuner-{secrets.token_hex(8)}.tmp"
    try:
        _spill(temporary, data)
        if overwrite:
            os.replace(temporary, path)
        else:
            _place(temporary, path)
    except FileExistsError as error:
        raise _exists(path) from error
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise WriteError(f"{path} cannot be written ({reason}); choose another place") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    _sync_folder(path.parent)


def _exists(path: Path) -> WriteError:
    return WriteError(f"{path} exists; give another name, or replace it with --force")


def _spill(temporary: Path, data: bytes) -> None:
    """Write a new file and wait until the disk has it."""
    with temporary.open("xb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def _place(temporary: Path, path: Path) -> None:
    """Give the file its name unless that exists: a link fails where a rename replaces."""
    try:
        os.link(temporary, path)
    except OSError as error:
        if error.errno not in _NO_LINKS:
            raise
        _place_without_links(temporary, path)


def _place_without_links(temporary: Path, path: Path) -> None:
    """The same for memory cards and network drives: take the name first, then fill it."""
    path.open("xb").close()
    try:
        os.replace(temporary, path)
    except BaseException:
        path.unlink()
        raise


def _sync_folder(folder: Path) -> None:
    """Make the new name survive a power cut, where the system can sync folders."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
