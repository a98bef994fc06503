"""The filter that a command line names, and the code that no input file may run."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tuner.run.own_file import OwnFile, own_file


@dataclass(frozen=True)
class FilterOption:
    """The filter that a command line names: by ``--filter``, by ``--model``, or not at all."""

    filter: str | None = None
    model: Path | None = None

    @property
    def named(self) -> bool:
        """Whether it names one."""
        return self.filter is not None or self.model is not None

    @property
    def file(self) -> OwnFile | None:
        """The Python file that it names, and so allows to run."""
        return None if self.filter is None else own_file(self.filter)

    def settings(self) -> dict[str, Any]:
        """The settings of a fit that choose the filter, in place of all others; none of them run.

        Raises:
            ValueError: for a file that cannot be read.
        """
        if not self.named:
            return {}
        model = None
        if self.model is not None:
            from tuner.model import read_model

            model = read_model(self.model)
        sha256 = None if self.file is None else self.file.sha256
        return {"filter": self.filter, "filter_sha256": sha256, "model": model}


def refuse_code(
    document: Mapping[str, Any], option: FilterOption, where: Path, command: str
) -> None:
    """Refuse a file whose settings name a Python file, unless a person names one as well.

    Args:
        document: what the file holds.
        option: what the command line names.
        where: the file, or its folder.
        command: what was asked for, such as ``tuner run study.toml``.

    Raises:
        ValueError: with the way out.
    """
    settings = document.get("settings")
    filter = settings.get("filter") if isinstance(settings, Mapping) else None
    file = own_file(filter) if isinstance(filter, str) else None
    if file is not None and not option.named:
        raise ValueError(
            f"{where} names the class {file.reference} of a Python file, and no input file runs "
            f"code; if it is yours, name it: {command} --filter {file.reference}"
        )


def file_changes(settings: Mapping[str, Any], option: FilterOption) -> list[str]:
    """A sentence where the file that is named is not what it was when settings were written."""
    file, before = option.file, settings.get("filter_sha256")
    if file is None or before is None or settings.get("filter") != file.reference:
        return []
    if file.sha256 == before:
        return []
    return [f"{file.path.name} has changed since: its SHA-256 is another one"]
