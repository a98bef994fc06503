"""Folders of runs with changed files."""

import json
from collections.abc import Iterator
from pathlib import Path

from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.logs import text
from benchmarks.bad_inputs.mutate import Random, bytes_of, document_of

_WAYS = (
    ["export", "r", "--to", "json", "-o", "x.json"],
    ["export", "r", "--to", "c", "-o", "-"],
    ["export", "r", "--to", "csv", "-o", "x.csv", "--force"],
    ["export", "r", "--rate", "50"],
    ["compare", "r"],
    ["show", "r"],
    ["show", "r", "--json"],
    ["report", "r", "-o", "x.html"],
    ["report", "r", "--to", "md", "-o", "-"],
    ["compare", "r", "--json"],
    ["compare", "r", "r", "--csv"],
    ["check", "r", "--log", "good.csv", "--map", "z=gx"],
    ["run", "r/study.toml", "--out", "r", "--resume", "--dry-run"],
    ["run", "r/study.toml", "--dry-run"],
)


def cases(random: Random, folders: list[dict[str, bytes]]) -> Iterator[Case]:
    """An endless series of runs with one changed file.

    Args:
        random: random numbers of the changes.
        folders: files by name of finished runs.
    """
    while True:
        files = dict(folders[int(random.integers(len(folders)))])
        name = str(
            random.choice(sorted(name for name in files if name.endswith((".json", ".toml"))))
        )
        document = name.endswith(".json") and random.random() < 0.8
        if document:
            changed = document_of(random, json.loads(files[name]))
            files[name] = json.dumps(changed).encode()
        else:
            files[name] = bytes_of(random, files[name])
        if random.random() < 0.1:
            del files[str(random.choice(sorted(files)))]
        words = _WAYS[int(random.integers(len(_WAYS)))]
        laid = {f"r/{name}": data for name, data in files.items()}
        yield Case("run that was changed", words, {**laid, "good.csv": text()})


def finished(folder: Path) -> dict[str, bytes]:
    """The files of a finished run."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.suffix in (".json", ".toml", ".h", ".c")
    }
