"""The folders of compiled code between runs, and files in them that nobody else has written."""

import hashlib
import os
import platform
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path


def cache_folder() -> Path:
    """The folder of compiled code: ``TUNER_CACHE``, or the user's cache folder."""
    given = os.environ.get("TUNER_CACHE")
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(given) if given else Path(root) / "filter-tuner" / "jax"


def code_folder() -> Path:
    """The folder of compiled C: one in that of ``TUNER_CACHE``, or beside the user's."""
    return _beside("native")


def program_folder() -> Path:
    """The folder of programs that XLA compiled, in the same place."""
    return _beside("programs")


def _beside(name: str) -> Path:
    folder = cache_folder()
    return (folder if os.environ.get("TUNER_CACHE") else folder.parent) / name


def own(folder: Path) -> bool:
    """Whether a folder exists, or was made, that only this user may write to or replace."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        above = folder.parent.resolve()
        safe = all(_safe(one.stat()) for one in (above, *above.parents))
        return safe and _ours(folder.lstat(), stat.S_ISDIR) and os.access(folder, os.W_OK)
    except OSError:
        return False


def unaltered(file: Path) -> bytes | None:
    """The bytes of a file, if it belongs to this user and matches the end of its name."""
    try:
        if not _ours(file.lstat(), stat.S_ISREG):
            return None
        data = file.read_bytes()
    except OSError:
        return None
    return data if file.stem.endswith(f"-{digest(data)}") else None


def kept(folder: Path, key: str) -> bytes | None:
    """The bytes under a key in a folder that is :func:`own`; None where there are none."""
    found = (unaltered(file) for file in folder.glob(f"{key}-*.bin"))
    return next((data for data in found if data is not None), None)


def keep(folder: Path, key: str, data: bytes) -> None:
    """Write bytes under a key, for :func:`kept`; a full disk keeps nothing."""
    with suppress(OSError), tempfile.TemporaryDirectory(dir=folder) as name:
        made = Path(name, "made")
        made.write_bytes(data)
        made.chmod(0o600)
        made.replace(folder / f"{key}-{digest(data)}.bin")


def keep_alone(folder: Path, key: str, data: bytes) -> None:
    """The same, in place of what was under the key before."""
    before = [*folder.glob(f"{key}-*.bin")]
    keep(folder, key, data)
    for file in before:
        if not file.stem.endswith(f"-{digest(data)}"):
            with suppress(OSError):
                file.unlink()


def digest(data: bytes) -> str:
    """The first half of the SHA-256 of some bytes, which files of the cache are named by."""
    return hashlib.sha256(data).hexdigest()[:32]


def processor() -> str:
    """The processor that compiled code is for: JAX keys code by program and version alone.

    Home folders are shared by machines, and code for one may end a process on another.
    """
    can = platform.processor()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        can += next((line for line in lines if line.startswith(("flags", "Features"))), "")
    return f"{platform.machine()}-{hashlib.sha256(can.encode()).hexdigest()[:12]}"


def _ours(found: os.stat_result, kind: Callable[[int], bool]) -> bool:
    return kind(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022


def _safe(found: os.stat_result) -> bool:
    """Whether no other user may replace a folder's files."""
    trusted, sticky = found.st_uid in (0, os.getuid()), found.st_mode & stat.S_ISVTX
    return trusted and (not found.st_mode & 0o022 or bool(sticky))
