"""Time columns that hold dates and times of day."""

from collections.abc import Sequence

import numpy as np

from tuner.data.logs.mapping import Mapping
from tuner.data.logs.moments import ORDERS, SHORT, Moments, Ticks, read_moments
from tuner.data.logs.table import Raw
from tuner.data.logs.values import Columns, check_finite

_DAY_NS = 86_400 * 10**9
_FEW = 100


def date_and_time(columns: Columns, name: str) -> list[str]:
    """A column of dates or times of day with the one of the other kind, where there is one."""
    table = columns.table
    mine = _kind(columns.raw[name])
    found: dict[str, str] = {}
    for other in table.names:
        if other in table.moments and other in columns.raw:
            found.setdefault(_kind(columns.raw[other]), other)
    if mine == "date" and "time" in found:
        return [name, found["time"]]
    return [found["date"], name] if mine == "time" and "date" in found else [name]


def _kind(column: Raw) -> str:
    moments = read_moments(column[:_FEW])
    return ("date" if moments.dated else "") + ("time" if moments.timed else "")


def read_dates(
    columns: Columns, mapping: Mapping, parts: Sequence[Mapping]
) -> tuple[Moments, tuple[str, ...]]:
    """Dates or times of day, and what was assumed of them.

    Raises:
        LogError: where some are missing, or are ambiguous.
    """
    column = columns.raw[mapping.column]
    if mapping.unit not in (None, *ORDERS, *SHORT):
        raise columns.error(
            mapping,
            f"holds {_first(column)!r}, and {mapping.unit!r} is no order of it; "
            f"use {', '.join((*ORDERS, *SHORT))} or none",
        )
    moments = read_moments(column, mapping.unit)
    check_finite(columns, mapping, np.where(moments.missing, np.nan, 0.0))
    notes = _meanings(columns, mapping, parts, moments)
    return moments, notes


def _first(column: Raw) -> str:
    return str(column[0].decode(errors="replace"))


def _meanings(
    columns: Columns, mapping: Mapping, parts: Sequence[Mapping], moments: Moments
) -> tuple[str, ...]:
    """The assumption for ambiguous dates; refused where their readings have different steps."""
    words = list(moments.readings)
    if not words:
        return ()
    first = _first(columns.raw[mapping.column])
    orders = " or ".join(f"{(ORDERS | SHORT)[word]} (:{word})" for word in words)
    steps = [np.diff(ticks) for ticks in moments.readings.values()]
    if all((step == steps[0]).all() for step in steps):
        return (f"{first!r} may be {orders}, with the same steps; taken as :{words[0]}",)
    meant = (p.column + f":{words[0]}" * (p is mapping) for p in parts)
    raise columns.error(
        mapping, f"holds {first!r}, {orders}; say which, such as --time '{','.join(meant)}'"
    )


def past_midnight(ticks: Ticks) -> tuple[Ticks, int]:
    """Times of day that go on past midnight, and the number of midnights."""
    back = np.diff(ticks, prepend=ticks[0]) < -_DAY_NS // 2
    return ticks + np.cumsum(back) * _DAY_NS, int(back.sum())
