"""Phone loggers: a zip file or folder with one text file per sensor, each on its own clock."""

import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path, PurePosixPath

from tuner.data.logs.csv import open_csv
from tuner.data.logs.error import LogError, quoted
from tuner.data.logs.home import Home
from tuner.data.logs.table import Loaded, Raw, Table, together
from tuner.data.logs.zipped import DAMAGE, MOST, check_index, check_sizes
from tuner.files import leads_out
from tuner.limits import unpacked

TEXTS = (".csv", ".txt", ".tsv", ".dat")
_NESTED = (".zip", ".gz", ".7z", ".tar", ".tgz", ".bz2", ".xz")
_BLOCK = 1 << 20


def is_archive(path: Path) -> bool:
    """Whether a zip file holds text files, or other archives, and no arrays of numpy."""
    try:
        check_index(path)
        with zipfile.ZipFile(path) as archive:
            endings = {PurePosixPath(name.lower()).suffix for name in archive.namelist()}
    except DAMAGE:
        return False
    return ".npy" not in endings and bool(endings & {*TEXTS, *_NESTED})


def open_archive(path: Path) -> Table:
    """Open a zip file of text files: columns ``Gyroscope/x``, the file's name before each.

    It is unpacked into a folder that lasts as long as the table. A file that unpacks to more than
    256 MiB and a hundred times its size is refused before and while it is read; so are names that
    lead out of the folder, and archives in the archive.

    Raises:
        LogError: where it is damaged or refused, or holds no text file with numbers.
    """
    home = Home()
    try:
        with zipfile.ZipFile(path) as archive:
            members = _checked(path, archive.infolist())
            budget = unpacked(path.stat().st_size)
            files = {}
            for number, member in enumerate(members):
                file = Path(home.path, f"{number}{PurePosixPath(member.filename).suffix}")
                budget -= _unpack(path, archive, member, file, budget)
                files[member.filename] = file
    except DAMAGE as error:
        if isinstance(error, LogError):
            raise
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LogError(f"{path.name}: the zip file is damaged ({reason}); copy it again") from error
    return _together(path, files, "zip file of text files", home)


def open_folder(path: Path) -> Table:
    """Open a folder of text files, such as an unpacked zip.

    Raises:
        LogError: where it holds no text file with numbers.
    """
    held = list(islice(path.rglob("*"), MOST + 1))
    if len(held) > MOST:
        raise LogError(f"{path.name}: the folder holds more than {MOST} files; name one of them")
    found = sorted(f for f in held if f.suffix.lower() in TEXTS and f.is_file())
    for file in found:
        if leads_out(file, path):
            raise LogError(
                f"{path.name}: {file.name!r} is a link that leads out of the folder; name the file "
                "itself"
            )
    files = {file.relative_to(path).as_posix(): file for file in found}
    return _together(path, files, "folder of text files", None)


def _checked(path: Path, members: Sequence[zipfile.ZipInfo]) -> list[zipfile.ZipInfo]:
    """The text files of an archive, if none of its members is suspicious."""
    chosen = []
    for member in members:
        name = PurePosixPath(member.filename.replace("\\", "/"))
        if name.is_absolute() or ".." in name.parts or ":" in "".join(name.parts[:1]):
            raise LogError(
                f"{path.name}: the zip file holds {member.filename[:60]!r}, which leads out of it; "
                "pack the log's files alone"
            )
        if name.suffix.lower() in _NESTED:
            raise LogError(
                f"{path.name}: the zip file holds the archive {member.filename[:60]!r}; unpack it "
                "and name that one"
            )
        hidden = name.name.startswith(".") or "__MACOSX" in name.parts
        if name.suffix.lower() in TEXTS and not hidden and not member.is_dir():
            chosen.append(member)
    check_sizes(path, chosen, "the zip file")
    if len(chosen) > MOST:
        raise LogError(f"{path.name}: the zip file holds more than {MOST} text files; pack fewer")
    return chosen


def _unpack(
    path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo, file: Path, budget: int
) -> int:
    """Unpack one file and return its size, whatever size was declared."""
    size = 0
    with archive.open(member) as packed, file.open("wb") as plain:
        while block := packed.read(_BLOCK):
            size += len(block)
            if size > budget:
                raise LogError(f"{path.name}: {member.filename!r} unpacks to more than it declares")
            plain.write(block)
    return size


@dataclass(frozen=True, eq=False)
class _Sensor:
    """One file of several.

    Attributes:
        table: its columns under their own names.
        name: of the file in the archive.
        prefix: the prefix of its columns' names.
        home: the folder that is removed with its last user.
    """

    table: Table
    name: str
    prefix: str
    home: Home | None

    def load(self, names: Sequence[str]) -> Loaded:
        """Columns by their names with prefix."""
        own = [name.removeprefix(self.prefix) for name in names]
        with _named(self):
            found = Loaded.of(self.table.load(own))
        raw = {self.prefix + name: column for name, column in found.raw.items()}
        return Loaded(raw, tuple(f"{self.name}: {note}" for note in found.notes))

    def labels(self, name: str) -> Raw:
        """A column as text."""
        assert self.table.labels is not None
        return self.table.labels(name.removeprefix(self.prefix))

    def place(self, row: int) -> str:
        """The place of a row."""
        return f"{self.table.place(row)} of {self.name}"

    def prefixed(self, archive: str, kind: str) -> Table:
        """Its columns under their names in the archive."""
        return replace(
            self.table,
            file=archive,
            names=tuple(self.prefix + name for name in self.table.names),
            load=self.load,
            place=self.place,
            numbered=False,
            texts=frozenset(self.prefix + name for name in self.table.texts),
            moments=frozenset(self.prefix + name for name in self.table.moments),
            units={self.prefix + name: unit for name, unit in self.table.units.items()},
            labels=self.labels if self.table.labels is not None else None,
            format=kind,
            prefix=self.prefix + self.table.prefix,
            notes=tuple(f"{self.name}: {note}" for note in self.table.notes),
        )


@contextmanager
def _named(sensor: _Sensor) -> Iterator[None]:
    """Replace the file's name in the folder by that in the archive."""
    try:
        yield
    except LogError as error:
        raise LogError(str(error).replace(sensor.table.file, sensor.name)) from error


def _together(path: Path, files: dict[str, Path], kind: str, home: Home | None) -> Table:
    """One table of all text files that hold numbers."""
    tables: list[Table] = []
    left: dict[str, str] = {}
    common = _common(list(files))
    for name, file in files.items():
        prefix = f"{PurePosixPath(name.removeprefix(common)).with_suffix('')}/"
        try:
            found = open_csv(file)
            parts = found.groups or (found,)
            tables += [_Sensor(t, name, prefix, home).prefixed(path.name, kind) for t in parts]
        except LogError as error:
            left[name] = str(error).replace(file.name, name)
    if not tables:
        first = next(iter(left.values()), "there is none at all")
        raise LogError(f"{path.name}: the {kind} holds none with numbers ({first}); name a log")
    if len(tables) == 1:
        return tables[0]
    notes = (f"{quoted(left)} left out: no columns of numbers",) if left else ()
    return together(path.name, tables, kind, notes)


def _common(names: list[str]) -> str:
    """The folder that all files are in, with a slash; ``""`` where there is none."""
    folders = [PurePosixPath(name).parts[:-1] for name in names]
    common = []
    for parts in zip(*folders, strict=False):
        if len(set(parts)) > 1:
            break
        common.append(f"{parts[0]}/")
    return "".join(common)
