"""Dates and times of day as text, in ISO 8601 and other usual forms."""

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

ORDERS = {"dmy": "day, month, year", "mdy": "month, day, year", "ymd": "year, month, day"}
SHORT = {"h-min": "hours and minutes", "min-s": "minutes and seconds"}
"""Possible meanings of ``12:30``."""

Ticks = NDArray[np.int64]

_MONTHS = ("jan", "feb", "m..?r", "apr", "ma[iy]", "jun",
           "jul", "aug", "sep", "o[ck]t", "nov", "de[cz]")  # fmt: skip
_NAME = "|".join(_MONTHS)
_TIME = r"(?P<H>\d{1,3}):(?P<M>\d\d)(?::(?P<S>\d\d)(?:[.,:](?P<f>\d{1,9})\d*)?)?"
_SHORT_TIME = r"(?P<M>\d{1,3}):(?P<S>\d\d)[.,](?P<f>\d{1,9})\d*"
_PLAIN_TIME = r"(?P<H>\d\d)(?P<t>[-_.]?)(?P<M>\d\d)(?P=t)(?P<S>\d\d)(?:[.,](?P<f>\d{1,9})\d*)?"
_BEHIND = (
    r"(?: ?(?P<half>[ap])\.?m\.?)?(?: ?(?:z|utc|gmt)| ?(?P<sign>[-+])(?P<Z>\d\d):?(?P<z>\d\d)?)?"
)
_DATES = (
    r"(?P<y>\d{4})(?P<s>[-/.])(?P<m>\d{1,2})(?P=s)(?P<d>\d{1,2})",
    r"(?P<a>\d{1,2})(?P<s>[-/.])(?P<b>\d{1,2})(?P=s)(?P<c>\d{4}|\d\d)",
    rf"(?P<d>\d{{1,2}})[-/. ]*(?P<name>{_NAME})[a-z]*[-/., ]*(?P<y>\d{{4}})",
    rf"(?P<name>{_NAME})[a-z]*\.? (?P<d>\d{{1,2}}),? (?P<y>\d{{4}})",
)
_PLAIN_DATE = r"(?P<y>(?:19|20)\d\d)(?P<m>[01]\d)(?P<d>[0-3]\d)"
_FORMS = [
    re.compile(form)
    for form in (
        *_DATES,
        *(f"{date}[t_, ]+{time}{_BEHIND}" for date in _DATES for time in (_TIME, _PLAIN_TIME)),
        *(f"{_PLAIN_DATE}[-t_ ]?{time}{_BEHIND}" for time in (_TIME, _PLAIN_TIME)),
        _TIME + _BEHIND,
        _SHORT_TIME,
    )
]
_SHAPES = 500
_DAY = 86_400_000_000_000
_LENGTHS = {"H": _DAY // 24, "M": 60_000_000_000, "S": 1_000_000_000}


@dataclass(frozen=True, eq=False)
class Moments:
    """The times of samples.

    Attributes:
        ticks: ns since 1970, or since midnight where no date is written, ``(N,)``.
        missing: where there is no time, ``(N,)``.
        dated, timed: whether a date and a time of day are written.
        step: ns of the last digit that is written.
        readings: possible meanings of the column, ``(N,)`` each, by the word that chooses each;
            the first is ``ticks``. Empty where there is but one meaning.
    """

    ticks: Ticks
    missing: NDArray[np.bool_]
    dated: bool
    timed: bool
    step: int
    readings: dict[str, Ticks]


def is_moment(text: str) -> bool:
    """Whether a cell is a date, a time of day, or both.

    >>> [is_moment(t) for t in ("2024-03-30T22:15:00Z", "30.03.2024", "22:15:00", "21.5", "on")]
    [True, True, True, False, False]
    """
    return _form(text.strip().lower()) is not None


def read_moments(cells: NDArray[np.bytes_], chosen: str | None = None) -> Moments:
    """Read a column of dates or times.

    Args:
        cells: as they are written, ``(N,)``.
        chosen: the meaning where there are several, a key of ``ORDERS`` or ``SHORT``.

    >>> moments = read_moments(np.array([b"3/4/2024 22:15", b"4/4/2024 22:16"]))
    >>> {word: np.diff(ticks).tolist() for word, ticks in moments.readings.items()}
    {'dmy': [86460000000000], 'mdy': [2678460000000000]}
    """
    fields, missing = _fields(cells)
    of_day = fields["f"] + _DAY // 2 * fields["half"]
    of_day += sum(length * fields[name] for name, length in _LENGTHS.items())
    of_day -= fields["sign"] * (_LENGTHS["H"] * fields["Z"] + _LENGTHS["M"] * fields["z"])
    dated, timed = bool(fields["y"].any() or fields["c"].any()), bool(fields["timed"].any())
    if dated:
        readings = _dates(fields, missing, chosen)
    elif timed and not fields["seconds"].any():
        readings = _short(of_day, chosen)
        of_day = 0 * of_day
    else:
        readings = {"": np.zeros(len(cells), np.int64)}
    known = {word: np.where(missing, 0, ticks + of_day) for word, ticks in readings.items()}
    ticks = next(iter(known.values()))
    return Moments(ticks, missing, dated, timed, _step(fields), known if len(known) > 1 else {})


def _fields(cells: NDArray[np.bytes_]) -> tuple[dict[str, Ticks], NDArray[np.bool_]]:
    """The numbers in all cells by their names in the forms, and where cells have none."""
    text = cells.view(np.uint8).reshape(len(cells), -1).copy()
    text[(text >= ord("A")) & (text <= ord("Z"))] |= 0x20
    shape = np.where((text >= ord("0")) & (text <= ord("9")), ord("0"), text)
    names = [*"abcymdHMSfZz", "sign", "half", "timed", "seconds", "decimals", "dots", "short"]
    fields = {name: np.zeros(len(cells), np.int64) for name in names}
    missing = np.zeros(len(cells), bool)
    left = np.arange(len(cells))
    for _ in range(_SHAPES):
        if not len(left):
            break
        same = (shape[left] == shape[left[0]]).all(axis=1)
        rows, left = left[same], left[~same]
        form = _form(text[rows[0]].tobytes().rstrip(b"\0").decode("latin-1"))
        if form is None:
            missing[rows] = True
        else:
            _take(fields, rows, text[rows], form)
    missing[left] = True
    return fields, missing


def _take(
    fields: dict[str, Ticks], rows: NDArray[np.intp], text: NDArray[np.uint8], form: re.Match[str]
) -> None:
    """The numbers of cells of one form."""
    for name, found in form.groupdict().items():
        if name in fields and name not in {"half", "sign"} and found is not None:
            first, last = form.span(name)
            digits = text[:, first:last].astype(np.int64) - ord("0")
            fields[name][rows] = digits @ 10 ** np.arange(last - first)[::-1]
    found = form.groupdict()
    if found.get("f"):
        fields["decimals"][rows] = len(found["f"])
        fields["f"][rows] *= 10 ** (9 - len(found["f"]))
    if found.get("name"):
        word = found["name"]
        fields["m"][rows] = next(k for k, name in enumerate(_MONTHS, 1) if re.match(name, word))
    if found.get("half"):
        noon = fields["H"][rows] == 12
        fields["half"][rows] = ~noon if found["half"] == "p" else -noon.astype(np.int64)
    if found.get("sign"):
        fields["sign"][rows] = -1 if found["sign"] == "-" else 1
    fields["timed"][rows] = found.get("M") is not None
    fields["seconds"][rows] = found.get("S") is not None
    fields["dots"][rows] = found.get("s") == "."
    fields["short"][rows] = len(found.get("c") or "") == 2


def _dates(
    fields: dict[str, Ticks], missing: NDArray[np.bool_], chosen: str | None
) -> dict[str, Ticks]:
    """The days in ns since 1970, in every order that makes dates of all cells."""
    plain = fields["c"] + fields["a"] > 0
    year = np.where(plain, 0, fields["y"])
    orders = ["dmy", "mdy", *(["ymd"] if fields["short"].any() else [])]
    if fields["dots"][plain].all():
        orders = ["dmy"]
    if chosen in ORDERS:
        orders = [chosen]
    found, wrong = {}, {}
    for order in orders:
        parts = dict(zip(order, (fields[name] for name in "abc"), strict=True))
        years = np.where(
            fields["short"] > 0, 2000 + parts["y"] - 100 * (parts["y"] > 69), parts["y"]
        )
        days, bad = _days(
            np.where(plain, years, year),
            np.where(plain, parts["m"], fields["m"]),
            np.where(plain, parts["d"], fields["d"]),
        )
        found[order], wrong[order] = _DAY * days, bad & ~missing
    right = [order for order in orders if not wrong[order].any()]
    if not right:
        right = [min(orders, key=lambda order: int(wrong[order].sum()))]
        missing |= wrong[right[0]]
    return {order: found[order] for order in right if plain.any()} or {"": found[right[0]]}


def _days(year: Ticks, month: Ticks, day: Ticks) -> tuple[Ticks, NDArray[np.bool_]]:
    """Days since 1970, and which dates there are not."""
    wrong = (month < 1) | (month > 12) | (year < 1)
    months = 12 * (year - 1970) + np.clip(month, 1, 12) - 1
    first = months.astype("M8[M]").astype("M8[D]").astype(np.int64)
    length = (months + 1).astype("M8[M]").astype("M8[D]").astype(np.int64) - first
    return first + day - 1, wrong | (day < 1) | (day > length)


def _short(of_day: Ticks, chosen: str | None) -> dict[str, Ticks]:
    """Two numbers with a colon between them."""
    readings = dict(zip(SHORT, (of_day, of_day // 60), strict=True))
    return {chosen: readings[chosen]} if chosen in readings else readings


def _step(fields: dict[str, Ticks]) -> int:
    """The step of the last digit, ns."""
    if decimals := int(fields["decimals"].max()):
        return int(10 ** (9 - decimals))
    if fields["seconds"].any():
        return _LENGTHS["S"]
    return _LENGTHS["M"] if fields["timed"].any() else _DAY


@lru_cache(1024)
def _form(text: str) -> re.Match[str] | None:
    """The form of a cell in small letters; None where it is no time."""
    return next((match for form in _FORMS if (match := form.fullmatch(text))), None)
