"""A private PostgreSQL server on a socket of its own, from Debian's package."""

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

USER = "tuner"
FAST = ("fsync=off", "full_page_writes=off", "synchronous_commit=off")
"""Settings without durability: data of a test or a drill need not survive a crash."""


class NoServerError(Exception):
    """There is no PostgreSQL here that can be started; says why, and the way out."""


@contextmanager
def server() -> Iterator[str]:
    """Start a server and yield its URL; it listens on a socket that no other user may enter.

    Raises:
        NoServerError: where it cannot be started.
    """
    programs = _programs()
    folder = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))  # sockets have short names
    try:
        data, as_user = folder / "data", _other_user(folder)
        made = [programs / "initdb", "-D", data, "-U", USER, "-A", "trust", "-N", "-E", "UTF8"]
        _run(made, as_user)
        options = [f"-c listen_addresses='' -k {folder}", *(f"-c {each}" for each in FAST)]
        control = [programs / "pg_ctl", "-D", data, "-w", "-l", folder / "log"]
        _run([*control, "-o", " ".join(options), "start"], as_user)
        try:
            yield f"postgresql+psycopg://{USER}@/postgres?host={folder}"
        finally:
            _run([*control, "-m", "immediate", "stop"], as_user)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _programs() -> Path:
    """Where the newest server's programs are."""
    if find_spec("psycopg") is None:
        raise NoServerError("no psycopg here: pip install 'filter-tuner[postgres]'")
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=_version)
    own = found[-1] if found else shutil.which("initdb")
    if own is None:
        raise NoServerError("no PostgreSQL here: apt install postgresql")
    return Path(own).resolve().parent


def _run(command: list[Any], as_user: dict[str, Any]) -> None:
    plain = {name: value for name, value in os.environ.items() if not name.startswith("PG")}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.STDOUT, "timeout": 120}
    given = {"env": plain | {"LC_ALL": "C"}, **as_user, **quiet}
    subprocess.run(list(map(str, command)), check=True, **given)


def _other_user(folder: Path) -> dict[str, Any]:
    """PostgreSQL refuses to run as root: then as the user of the package."""
    if os.getuid() != 0:
        return {}
    try:
        user = pwd.getpwnam("postgres")
    except KeyError:
        raise NoServerError("root runs no PostgreSQL, and there is no user postgres") from None
    os.chown(folder, user.pw_uid, user.pw_gid)
    return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}


def _version(path: Path) -> float:
    return float(path.parts[-3])
