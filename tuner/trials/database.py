"""Optuna's database, opened by any number of processes at once, and its faults in one sentence."""

import contextlib
import random
import sqlite3
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import optuna
    from sqlalchemy import Engine

HEARTBEAT = 5
"""A trial that is worked on says so every so many seconds."""
GRACE = 30
"""One that has said nothing for so long is given to another process, s."""
PATIENCE = 60
"""A process waits so long for others that write to the same file, s."""
_RACES = ("already exists", "no such table", "is locked", "duplicate key", 'relation "', "UNIQUE")
"""The drivers' messages where two processes create the tables of one new database."""
_QUIET = Lock()
"""Python's filters of warnings are those of all threads."""


class DatabaseError(ValueError):
    """The database of ``--storage`` cannot be used, or was lost; in one sentence, no password."""


def open_storage(url: str) -> "optuna.storages.BaseStorage":
    """The database of a URL, with its tables; memory for "".

    Raises:
        DatabaseError: where it cannot be used.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)  # its own log off stderr
    if not url:
        return optuna.storages.InMemoryStorage()
    with as_database_error(url), _QUIET:
        return _opened(url)


def use_database(url: str) -> None:
    """Find out whether a database can be used; its tables are made.

    Raises:
        DatabaseError: where it cannot.
    """
    storage: Any = open_storage(url)
    close(storage)


def watched(url: str) -> "optuna.storages.RDBStorage":
    """The same database as Optuna's watch over trials of lost processes uses it."""
    import optuna

    with as_database_error(url), quiet():
        storage = optuna.storages.RDBStorage(
            url,
            engine_kwargs=_engine(url),
            heartbeat_interval=HEARTBEAT,
            grace_period=GRACE,
            heartbeat_stale_trial_callback=optuna.storages.RetryHeartbeatStaleTrialCallback(),
            skip_compatibility_check=True,
            skip_table_creation=True,
        )
    one_at_a_time(storage.engine)
    return storage


@contextmanager
def quiet() -> Iterator[None]:
    """Without the warnings that Optuna's heartbeat, its callback and its watch are experimental."""
    import optuna

    with _QUIET, warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        yield


@contextmanager
def as_database_error(url: str) -> Iterator[None]:
    """Raise what goes wrong with a database as one sentence.

    Raises:
        DatabaseError: for whatever Optuna, SQLAlchemy, Alembic or a driver raises.
    """
    if not url:
        yield
        return
    import optuna
    from alembic.util import CommandError
    from sqlalchemy.exc import SQLAlchemyError

    try:
        yield
    except (ImportError, SQLAlchemyError, CommandError, optuna.exceptions.OptunaError) as error:
        reason = _why(url, error)
        raise DatabaseError(f"the database of --storage cannot be used: {reason}") from None


def _opened(url: str) -> "optuna.storages.RDBStorage":
    """Open it; where another process makes its tables at that moment, again."""
    import optuna
    from sqlalchemy.exc import SQLAlchemyError

    _write_ahead(url)
    until = time.monotonic() + PATIENCE
    while True:
        try:
            storage = optuna.storages.RDBStorage(url, engine_kwargs=_engine(url))
        except (SQLAlchemyError, optuna.exceptions.StorageInternalError, AssertionError) as error:
            known = isinstance(error, AssertionError) or any(
                race in f"{error} {error.__cause__}" for race in _RACES
            )
            if not known or time.monotonic() > until:
                raise
            time.sleep(random.uniform(0.05, 0.25))
            continue
        except RuntimeError as error:  # tables of another version of Optuna
            raise DatabaseError(f"the database of --storage cannot be used: {error}") from None
        one_at_a_time(storage.engine)
        return storage


def _write_ahead(url: str) -> None:
    """Let a SQLite file keep its log beside it from the first table on."""
    if not (file := _sqlite_file(url)):
        return
    try:
        with contextlib.closing(sqlite3.connect(file, timeout=PATIENCE)) as connection:
            connection.execute("PRAGMA journal_mode=WAL")
    except sqlite3.OperationalError:
        pass  # what it is will be told as it is opened
    except sqlite3.DatabaseError as error:  # another file: SQLAlchemy would leave it open
        raise DatabaseError(f"the database of --storage cannot be used: {error}") from None


def merge_log(url: str) -> None:
    """Bring the log beside a SQLite file into it, which a process that was killed left there."""
    file = _sqlite_file(url)
    if not file or not Path(f"{file}-wal").exists():
        return
    with (
        contextlib.suppress(sqlite3.DatabaseError),  # it stays beside the file, and nothing is lost
        contextlib.closing(sqlite3.connect(file, timeout=1)) as connection,
    ):
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")


def _sqlite_file(url: str) -> str:
    """The path of a SQLite file; "" for other databases and for memory."""
    from sqlalchemy.engine import make_url

    if not url.startswith("sqlite"):
        return ""
    file = make_url(url).database or ""
    return "" if file == ":memory:" or file.startswith("file:") else file


def _engine(url: str) -> dict[str, Any]:
    return {"connect_args": {"timeout": PATIENCE}} if url.startswith("sqlite") else {}


def one_at_a_time(engine: "Engine") -> None:
    """Let every transaction on a SQLite file begin with the file's one lock.

    Otherwise two processes read the same state of a trial, and both write; or both hold what the
    other waits for. The log of what is written lies beside the file: no process that is killed
    harms it, and nothing waits for the disk at every step.
    """
    from sqlalchemy import event

    if engine.dialect.name != "sqlite" or engine.url.database in (None, "", ":memory:"):
        return
    engine.dispose()  # connections that were opened before this

    @event.listens_for(engine, "connect")
    def _by_hand(connection: Any, _record: Any) -> None:
        connection.isolation_level = None
        with contextlib.suppress(sqlite3.OperationalError):  # network drives take no such log
            connection.execute("PRAGMA journal_mode=WAL")
        connection.execute("PRAGMA synchronous=NORMAL")

    @event.listens_for(engine, "begin")
    def _begin(connection: Any) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")


def _why(url: str, error: BaseException) -> str:
    """The reason of a failure: the first line of the driver's message, without the password."""
    cause = error.__cause__ or error
    if isinstance(cause, ImportError) and "psycopg" in str(cause):
        return "PostgreSQL needs psycopg; pip install 'filter-tuner[postgres]'"
    words = str(getattr(cause, "orig", None) or cause).strip()
    # The URL may hold a password, and so may what follows the first line.
    reason = words.partition("\n")[0].strip() or type(error).__name__
    secret = _password(url)
    return reason.replace(secret, "***") if secret else reason


def _password(url: str) -> str:
    from sqlalchemy.engine import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        return str(make_url(url).password or "")
    except (ArgumentError, ValueError):
        return ""


def without_password(url: str) -> str:
    """A URL without its password."""
    from sqlalchemy.engine import make_url

    return make_url(url).render_as_string(hide_password=True)


def close(storage: "optuna.storages.BaseStorage") -> None:
    """Close the connections of this thread and those that are idle."""
    storage.remove_session()
    if hasattr(storage, "engine"):  # memory has none
        storage.engine.dispose()
