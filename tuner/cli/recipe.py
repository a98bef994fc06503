"""The study.toml of a run: what was asked for, so that it can be run again."""

import hashlib
import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tuner.names import unknown

LARGEST_SEED = 2**31 - 1


class _Entries(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class LogEntries(_Entries):
    """Which logs, and how they are read; no folder, for a recipe may be passed on."""

    files: list[str] = Field(min_length=1)
    sha256: list[str]
    map: list[str]
    truth: list[str] = []
    rate_hz: float | None = None
    time: str | None = None
    by: str | None = None
    from_s: float | None = None
    to_s: float | None = None

    @model_validator(mode="after")
    def _each_has_its_own(self) -> "LogEntries":
        if len(self.files) != len(self.sha256):
            raise ValueError(
                f"{len(self.files)} files and {len(self.sha256)} sha256; each file has its own"
            )
        return self


class Recipe(_Entries):
    """A study with its settings, seed and log, and the claims that are tried alone; none: all."""

    study: str
    seed: int = Field(0, ge=0, le=LARGEST_SEED)
    settings: dict[str, Any] = {}
    claims: list[str] = []
    log: LogEntries | None = None

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
        return Recipe.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise ValueError(f"{path} is not there; name a study or a study.toml") from None
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    except ValidationError as error:
        raise ValueError(f"{path.name} is no study.toml: {_first(error)}") from None
    except ValueError as error:
        raise ValueError(f"{path.name} is no study.toml: {error}") from None


def _first(error: ValidationError) -> str:
    first = error.errors()[0]
    *outer, name = (str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        known = LogEntries.model_fields if outer else Recipe.model_fields
        return str(unknown("entry", name, known))
    return f"{'.'.join([*outer, name])}: {first['msg']}"


def logs_beside(path: Path, log: LogEntries) -> tuple[Path, ...]:
    """The logs that a study.toml names: in this folder, or beside it.

    Raises:
        ValueError: where one is in neither, or another file has its name.
    """
    pairs = zip(log.files, log.sha256, strict=True)
    return tuple(_log_beside(path, name, digest) for name, digest in pairs)


def _log_beside(path: Path, name: str, digest: str) -> Path:
    for folder in (Path(), path.parent):
        file = folder / name
        if file.is_file():
            with file.open("rb") as stream:
                found = hashlib.file_digest(stream, "sha256").hexdigest()
            if found != digest:
                raise ValueError(
                    f"{file} is not the log of {path.name}: its SHA-256 differs; "
                    "to run it all the same, name it with --log"
                )
            return file
    raise ValueError(f"the log {name} of {path} is not here; say where with --log FILE")
