"""A run's folder: files written whole or not at all, and nothing overwritten unasked."""

import contextlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tuner.atomic import WriteError, write_bytes
from tuner.run.threads import at_once

OWN = (
    "study.toml",
    "environment.json",
    "progress.json",
    "result.json",
    "outputs.npz",
    "report.html",
    "report.json",
    "trials.sqlite3",
    "trials.sqlite3-journal",
    "trials.sqlite3-wal",
    "trials.sqlite3-shm",
)
"""The names of files that every run writes."""
_SIDE_BY_SIDE = 16
"""So many files at most are written at once."""
_BELOW = re.compile(r"(exports|figures)/[^/\\\0]+")


@dataclass(frozen=True)
class RunFolder:
    """Where a run keeps its files.

    Attributes:
        path: the folder.
        overwrite: whether files that are there already may be replaced.
    """

    path: Path
    overwrite: bool

    def write(self, name: str, data: bytes, *, replace: bool = False) -> str:
        """Write a file, in a folder below if its name says so, and return its name.

        Args:
            name: relative to the run's folder.
            data: its content.
            replace: whether this very file may be replaced, for files that grow with the run.

        Raises:
            WriteError: where it exists and may not be replaced, or cannot be written.
        """
        file = self.path / name
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise WriteError(
                f"the folder {file.parent} cannot be made ({error.strerror}); choose another --out"
            ) from None
        write_bytes(file, data, overwrite=self.overwrite or replace)
        return name

    def write_all(self, files: Mapping[str, bytes]) -> list[str]:
        """Write several files side by side, since each waits for the disk; return their names."""
        with at_once(min(len(files), _SIDE_BY_SIDE) or 1) as pool:
            return list(pool.map(self.write, files, files.values()))

    def clear(self) -> None:
        """Remove what a run wrote here before, and nothing else."""
        for name in (*self._artifacts(), *OWN):
            file = self.path / name
            if not file.parent.is_symlink():
                self.remove(name)
        for name in ("exports", "figures", "."):
            with contextlib.suppress(OSError):  # it holds files of others, or is not there
                (self.path / name).rmdir()

    def _artifacts(self) -> list[str]:
        """The files below folders that a finished run here says it wrote."""
        try:
            listed = json.loads((self.path / "result.json").read_bytes())["artifacts"]
            return [name for name in listed if _BELOW.fullmatch(name)]
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return []

    def remove(self, name: str) -> None:
        """Remove a file if it is there."""
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            (self.path / name).unlink()


def open_folder(path: Path | None, study: str, *, force: bool, resume: bool) -> RunFolder:
    """The folder for a run: the one that was asked for, or the next free one below ``runs``.

    It is made when the first file is written, so that a run that never begins leaves nothing.

    Raises:
        ValueError: where it holds files and neither force nor resume was given, where there is
            nothing to resume, or where it is no folder.
    """
    if resume and (path is None or not _interrupted(path)):
        raise ValueError("--resume needs --out with the folder of an interrupted run")
    chosen = path or _next_free(Path("runs"), study)
    if os.path.lexists(chosen) and not chosen.is_dir():
        raise ValueError(f"--out {chosen} is a file; name a folder")
    if not force and not resume and _occupied(chosen):
        raise ValueError(
            f"--out {chosen} is not empty; name another folder, or --force to replace its files"
        )
    return RunFolder(chosen, overwrite=force or resume)


def _interrupted(path: Path) -> bool:
    """Whether a run was begun there and is not finished."""
    begun = (path / "study.toml").is_file()
    return begun and ((path / "progress.json").is_file() or not (path / "result.json").exists())


def _occupied(path: Path) -> bool:
    try:
        return path.exists() and next(path.iterdir(), None) is not None
    except OSError as error:
        raise ValueError(f"--out {path} cannot be read: {error.strerror}") from None


def _next_free(root: Path, study: str) -> Path:
    number = 1
    while (root / f"{study}-{number:03d}").exists():
        number += 1
    return root / f"{study}-{number:03d}"
