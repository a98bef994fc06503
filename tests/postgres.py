"""A private PostgreSQL server on a socket of its own, from Debian's package."""

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

USER = "tuner"
FAST = ("fsync=off", "full_page_writes=off", "synchronous_commit=off")
"""The server holds nothing that has to outlive a test."""


def programs() -> Path | None:
    """Where the newest server's programs are; None where there are none."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=_version)
    if found:
        return found[-1].parent
    own = shutil.which("initdb")
    return None if own is None else Path(own).resolve().parent


@contextmanager
def server() -> Iterator[str]:
    """Start a server and yield its URL; skips with a message where there is none.

    It listens on a socket alone, which no other user may enter.
    """
    bin_ = programs()
    if bin_ is None:
        pytest.skip("no PostgreSQL here: apt install postgresql")
    pytest.importorskip("psycopg", reason="no psycopg here: pip install 'filter-tuner[postgres]'")
    folder = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))  # sockets have short names
    as_user = _other_user(folder)
    try:
        data = folder / "data"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.STDOUT, "timeout": 120}
        init = [bin_ / "initdb", "-D", data, "-U", USER, "-A", "trust", "-N", "-E", "UTF8"]
        subprocess.run(init, check=True, env=_plain(), **as_user, **quiet)
        options = [f"-c listen_addresses='' -k {folder}", *(f"-c {each}" for each in FAST)]
        start = [bin_ / "pg_ctl", "-D", data, "-w", "-l", folder / "log", "-o", " ".join(options)]
        subprocess.run([*start, "start"], check=True, env=_plain(), **as_user, **quiet)
        try:
            yield f"postgresql+psycopg://{USER}@/postgres?host={folder}"
        finally:
            stop = [bin_ / "pg_ctl", "-D", data, "-m", "immediate", "stop"]
            subprocess.run(stop, check=False, env=_plain(), **as_user, **quiet)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _plain() -> dict[str, str]:
    """No settings of the user's own client or language."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PG")}
    return kept | {"LC_ALL": "C"}


def _other_user(folder: Path) -> dict[str, object]:
    """PostgreSQL refuses to run as root: then as the package's own user."""
    if os.getuid() != 0:
        return {}
    try:
        user = pwd.getpwnam("postgres")
    except KeyError:
        pytest.skip("root cannot run PostgreSQL, and there is no user postgres")
    os.chown(folder, user.pw_uid, user.pw_gid)
    return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}


def _version(path: Path) -> float:
    return float(path.parts[-3])
