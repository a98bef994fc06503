"""The study.toml of a run: what was asked for, so that it can be run again."""

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tuner.data.source import file_digest
from tuner.files import leads_out
from tuner.names import listed, unknown
from tuner.run.settings import reason_of
from tuner.toml import read_toml

LARGEST_SEED = 2**31 - 1
LARGEST_FILE = 10_000_000
"""Bytes of a study.toml."""


class _Entries(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class LogEntries(_Entries):
    """Which logs, and how they are read: a log's options, by name. No folder above the recipe's.

    Attributes:
        files: the recordings, in the recipe's folder or below.
        sha256: what they have to be; none: anything.
        map, truth, rate_hz, time, by, drop_repeats, from_s, to_s: as :func:`tuner.read_records`
            takes them, and as ``--map``, ``--truth``, ``--rate`` and so on say them.
    """

    files: list[str] = []
    sha256: list[str] = []
    map: list[str] = []
    truth: list[str] = []
    rate_hz: float | None = None
    time: str | None = None
    by: str | None = None
    drop_repeats: bool | None = None
    from_s: float | None = None
    to_s: float | None = None

    @model_validator(mode="after")
    def _each_has_its_own(self) -> "LogEntries":
        if self.sha256 and len(self.files) != len(self.sha256):
            raise ValueError(
                f"{len(self.files)} files and {len(self.sha256)} sha256; each file has its own"
            )
        return self

    @classmethod
    def of_options(cls, options: Mapping[str, Any]) -> "LogEntries":
        """How logs are read, from a command's options."""
        given = {name: options[name] for name in HOW if options.get(name) not in (None, (), [])}
        plain = {n: list(v) if isinstance(v, tuple) else v for n, v in given.items()}
        return cls.model_validate(plain)

    def over(self, other: "LogEntries") -> "LogEntries":
        """How logs are read: as told here, and where nothing is told as in another recipe."""
        given = {name: getattr(self, name) for name in self._given()}
        return other.model_copy(update=given)

    @property
    def options(self) -> list[str]:
        """The options of a command line that say the same."""
        return [f"--{_UNIT.sub('', name).replace('_', '-')}" for name in self._given()]

    def _given(self) -> list[str]:
        fields = type(self).model_fields
        return [name for name in HOW if getattr(self, name) != fields[name].default]


HOW = tuple(name for name in LogEntries.model_fields if name not in ("files", "sha256"))
"""The entries that say how a log is read."""
_UNIT = re.compile("_(hz|s)$")


class Recipe(_Entries):
    """A study with its settings, seed and log, and the claims that are tried alone; none: all."""

    study: str
    seed: int = Field(0, ge=0, le=LARGEST_SEED)
    settings: dict[str, Any] = {}
    claims: list[str] = []
    log: LogEntries | None = None

    @model_validator(mode="after")
    def _log_has_files(self) -> "Recipe":
        if self.log is not None and not self.log.files:
            raise ValueError('the log names no file; name at least one, files = ["log.csv"]')
        return self

    @classmethod
    def of(
        cls,
        study: str,
        settings: BaseModel,
        *,
        seed: int,
        log: LogEntries | None,
        claims: Iterable[str] = (),
    ) -> "Recipe":
        """The recipe of a run; what is not set is left out."""
        given = {n: v for n, v in settings.model_dump(mode="json").items() if v is not None}
        return cls(study=study, seed=seed, settings=given, claims=list(claims), log=log)

    def to_toml(self) -> bytes:
        """The text of a study.toml."""
        import tomli_w

        left_out = set() if self.claims else {"claims"}
        return tomli_w.dumps(self.model_dump(exclude_none=True, exclude=left_out)).encode()


def read_recipe(path: Path) -> Recipe:
    """Read a study.toml.

    Raises:
        ValueError: where the file is not one, or names what a study.toml does not have.
    """
    try:
        return Recipe.model_validate(read_document(path))
    except ValidationError as error:
        raise ValueError(f"{path.name} is not a study.toml: {listed(faults_of(error))}") from None


def read_document(path: Path) -> dict[str, Any]:
    """The contents of a study.toml, not yet checked.

    Raises:
        ValueError: for a file that is not there, is too large, or is no TOML.
    """
    try:
        return read_toml(path, LARGEST_FILE, "study.toml")
    except FileNotFoundError:
        raise ValueError(f"{path} does not exist; name a study or a study.toml") from None
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise ValueError(f"{path.name} is not a study.toml: {error}") from None


def faults_of(error: ValidationError) -> Iterator[str]:
    """The mistakes in a recipe, one by one."""
    return map(_fault, error.errors())


def _fault(error: Mapping[str, Any]) -> str:
    """One thing that is wrong, and where."""
    where = [str(part) for part in error["loc"]]
    if error["type"] == "extra_forbidden":
        known = LogEntries.model_fields if len(where) > 1 else Recipe.model_fields
        return str(unknown("entry", where[-1], known))
    reason = reason_of(error)
    return f"{'.'.join(where)}: {reason}" if where else reason


def logs_beside(path: Path, log: LogEntries) -> tuple[Path, ...]:
    """The logs that a study.toml names: in this folder, or beside it.

    Raises:
        ValueError: where one is in neither, or another file has its name.
    """
    digests = log.sha256 or [""] * len(log.files)
    return tuple(_log_beside(path, *pair) for pair in zip(log.files, digests, strict=True))


def _log_beside(path: Path, name: str, digest: str) -> Path:
    """The log of a name, with the digest where one is told.

    Raises:
        ValueError: where it is not there, is another one, or lies above the recipe: files that are
            passed on read nothing else of a machine.
    """
    relative = PurePath(name)
    if not relative.parts or relative.is_absolute() or ".." in relative.parts:
        raise ValueError(
            f"the log {name} of {path} leads out of its folder, where no study.toml looks; if you "
            f"mean it, name it with --log {name}"
        )
    folders = [folder for folder in (path.parent, Path()) if (folder / name).exists()]
    there = [folder / name for folder in folders]
    if any(leads_out(folder / name, folder) for folder in folders):
        raise ValueError(
            f"the log {name} of {path} is a link that leads out of its folder; if you mean it, "
            f"name it with --log {name}"
        )
    for file in there:
        if not digest or file_digest(file) == digest:
            return file
    if there:
        raise ValueError(
            f"{there[0]} is not the log of {path.name}: its SHA-256 differs; "
            "to run it nevertheless, name it with --log"
        )
    raise ValueError(f"the log {name} of {path} is not here; say where with --log FILE")
