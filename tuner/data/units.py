"""Units: what users write, in SI.

A unit is a product of powers of the names below: ``deg/s``, ``m/s^2``, ``m s-2``, ``uT``, ``°/h``.
Metric prefixes stand before the names that take them. Names are those in common use, so ``g``
is the standard gravity, ``G`` gauss, ``h`` an hour and ``min`` a minute.
"""

import difflib
import math
import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Powers = tuple[int, ...]
_BASES = ("kg", "m", "s", "A", "K", "rad")
_GRAVITY = 9.80665


@dataclass(frozen=True)
class Unit:
    """A unit as factor and offset to SI.

    Attributes:
        name: as it was written.
        factor: SI units in one of it.
        powers: of kg, m, s, A, K and rad; angles are a dimension of their own here, so that a
            rate differs from a frequency.
        offset: added after the factor; 0 except for temperatures.

    >>> Unit.of("deg/h").factor * 3600 * 180 == np.pi
    True
    >>> Unit.of("gal").si
    'm/s^2'
    """

    name: str
    factor: float
    powers: Powers
    offset: float = 0.0

    @classmethod
    def of(cls, text: str) -> "Unit":
        """The unit that a text names.

        Raises:
            ValueError: where it names none, with the near ones.
        """
        plain = _plain(text)
        if plain in _SHORT:
            plain = _SHORT[plain]
        if plain in ("", "1", "-"):
            return cls(text, 1.0, _powers(""))
        if alone := _named(plain):
            factor, powers, offset = alone
            return cls(text, factor, powers, offset)
        return _product(text, plain)

    @property
    def si(self) -> str:
        """The SI unit of its dimension: ``rad/s``, ``T``, ``""`` for none."""
        return _SI[self.powers] if self.powers in _SI else _written(self.powers)


def convert(values: ArrayLike, unit: str, to: str) -> NDArray[np.float64]:
    """Values of one unit in another.

    Args:
        values: in ``unit``; NaN stays NaN.
        unit: their unit.
        to: the unit to convert to.

    Raises:
        ValueError: for an unknown unit, with the near ones, and for units of two dimensions.

    >>> convert([180.0, 90.0], "deg/s", "rad/s").tolist() == [np.pi, np.pi / 2]
    True
    >>> convert(20.0, "degC", "K").item()
    293.15
    >>> convert(1.0, "g", "m")
    Traceback (most recent call last):
    ValueError: g is m/s^2 in SI, which is not m
    """
    array = np.asarray(values, np.float64)
    given, wanted = Unit.of(unit), Unit.of(to)
    if given.powers != wanted.powers:
        raise ValueError(f"{unit} is {given.si or 'a bare number'} in SI, which is not {to or 1}")
    if (given.factor, given.offset) == (wanted.factor, wanted.offset):
        return array
    if not (given.offset or wanted.offset):
        return array * (given.factor / wanted.factor)
    return (array * given.factor + given.offset - wanted.offset) / wanted.factor


class Change(NamedTuple):
    """The change of values into the unit in which a channel is declared.

    Attributes:
        factor: factor on the values.
        offset: added afterwards.
        unit: their unit afterwards.
        note: what was assumed; empty where nothing was.
    """

    factor: float
    offset: float
    unit: str
    note: str = ""

    def __call__(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values in the declared unit."""
        if (self.factor, self.offset) == (1.0, 0.0):
            return values
        return values * self.factor + self.offset


def change(unit: str | None, declared: str) -> Change:
    """From a user's unit into that of a channel's declaration.

    Where ``unit`` is part of the declaration, any unit will do: it is converted to SI, except for
    temperatures in degrees, which stay, and for unknown units, which stay and are noted.

    Args:
        unit: what the user wrote; None where nothing was.
        declared: the channel's unit.

    Raises:
        ValueError: for an unknown unit, and for one of another dimension.

    >>> change("deg/s", "rad/s").unit, change(None, "rad/s").note
    ('rad/s', 'no unit given, taken as rad/s')
    >>> change("g", "rad/s")
    Traceback (most recent call last):
    ValueError: is in 'g', m/s^2 in SI, where rad/s is needed
    """
    if re.search(r"\bunit\b", declared):
        return _any(unit)
    if unit is None:
        return Change(1.0, 0.0, declared, f"no unit given, taken as {declared}" * bool(declared))
    given, wanted = Unit.of(unit), Unit.of(declared)
    if given.powers != wanted.powers:
        si = f"{given.si} in SI" if given.si else "a bare number"
        raise ValueError(f"is in {unit!r}, {si}, where {declared or 'a bare number'} is needed")
    offset = (given.offset - wanted.offset) / wanted.factor
    return Change(given.factor / wanted.factor, offset, declared)


def _any(unit: str | None) -> Change:
    if unit is None:
        return Change(1.0, 0.0, "", "no unit given, left as it is")
    try:
        known = Unit.of(unit)
    except ValueError as error:
        return Change(1.0, 0.0, unit, f"left as it is, for {error}")
    if known.offset:
        return Change(1.0, 0.0, unit)
    return Change(known.factor, 0.0, known.si)


def _plain(text: str) -> str:
    """A text in keyboard characters only."""
    for sign, plain in _SIGNS.items():
        text = text.replace(sign, plain)
    return re.sub(r"(?<=\w) per (?=\w)", "/", " ".join(text.split()))


_SIGNS = {
    "°": "deg",
    "\N{MASCULINE ORDINAL INDICATOR}": "deg",
    "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u",
    "\N{MIDDLE DOT}": " ",
    "\N{DOT OPERATOR}": " ",
    "²": "^2",
    "³": "^3",
    "\N{SUPERSCRIPT MINUS}": "^-",
    "\N{SUPERSCRIPT ONE}": "1",
    "^-^": "^-",
    "**": "^",
    "*": " ",
}
# What is written without a sign between its names.
_SHORT = {
    "ms-2": "m/s^2",
    "ms^-2": "m/s^2",
    "mss": "m/s^2",
    "m/ss": "m/s^2",
    "ms-1": "m/s",
    "ms^-1": "m/s",
    "mps": "m/s",
    "mps2": "m/s^2",
    "dps/s": "deg/s^2",
    "degps": "deg/s",
    "rps": "rev/s",
    "kph": "km/h",
    "kmh": "km/h",
    "fps": "ft/s",
}


def _powers(text: str) -> Powers:
    """Powers from ``kg m^-1 s^-2``."""
    found = dict.fromkeys(_BASES, 0)
    for word in text.split():
        base, _, power = word.partition("^")
        found[base] += int(power or 1)
    return tuple(found.values())


def _atoms() -> dict[str, tuple[float, Powers, float]]:
    """Every name with factor, powers and offset; prefixed names where no other has that name."""
    made: dict[str, tuple[float, Powers, float]] = {}
    for names, factor, powers in _TABLE:
        for name in names.split():
            made[name] = (factor, _powers(powers), 0.0)
    made["degC"] = made["C"] = made["celsius"] = (1.0, _powers("K"), 273.15)
    made["degF"] = made["fahrenheit"] = (5 / 9, _powers("K"), 273.15 - 32 * 5 / 9)
    for name in _PREFIXED.split():
        factor, dimension, _ = made[name]
        for prefix, times in _PREFIXES.items():
            made.setdefault(prefix + name, (times * factor, dimension, 0.0))
    return made


_PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIXED = "m s T Pa V A rad deg dps bar gauss G Gs gal Gal g Hz N K sec second seconds"
_TABLE = (
    ("kg", 1.0, "kg"),
    ("N newton", 1.0, "kg m s^-2"),
    ("m meter meters metre metres", 1.0, "m"),
    ("ft foot feet", 0.3048, "m"),
    ("in inch inches", 0.0254, "m"),
    ("mi mile miles", 1609.344, "m"),
    ("nmi NM", 1852.0, "m"),
    ("s sec secs second seconds", 1.0, "s"),
    ("min minute minutes", 60.0, "s"),
    ("h hr hour hours", 3600.0, "s"),
    ("d day days", 86400.0, "s"),
    ("Hz", 1.0, "s^-1"),
    ("mph", 0.44704, "m s^-1"),
    ("kn kt kts knot knots", 1852.0 / 3600.0, "m s^-1"),
    ("g g0 gn gee", _GRAVITY, "m s^-2"),
    ("gal Gal", 1e-2, "m s^-2"),
    ("rad radian radians", 1.0, "rad"),
    ("deg degree degrees", math.pi / 180.0, "rad"),
    ("arcmin", math.pi / 10800.0, "rad"),
    ("arcsec", math.pi / 648000.0, "rad"),
    ("gon grad", math.pi / 200.0, "rad"),
    ("rev turn turns", 2.0 * math.pi, "rad"),
    ("dps", math.pi / 180.0, "rad s^-1"),
    ("rpm", 2.0 * math.pi / 60.0, "rad s^-1"),
    ("T tesla", 1.0, "kg s^-2 A^-1"),
    ("G Gs gauss", 1e-4, "kg s^-2 A^-1"),
    ("Pa pascal", 1.0, "kg m^-1 s^-2"),
    ("bar", 1e5, "kg m^-1 s^-2"),
    ("atm", 101325.0, "kg m^-1 s^-2"),
    ("mmHg torr", 101325.0 / 760.0, "kg m^-1 s^-2"),
    ("inHg", 3386.389, "kg m^-1 s^-2"),
    ("psi", 6894.757293168, "kg m^-1 s^-2"),
    ("A amp ampere", 1.0, "A"),
    ("V volt volts", 1.0, "kg m^2 s^-3 A^-1"),
    ("K kelvin", 1.0, "K"),
    ("% percent", 1e-2, ""),
    ("ppm", 1e-6, ""),
)
_SI = {
    _powers(powers): name
    for name, powers in {
        "": "",
        "Hz": "s^-1",
        "N": "kg m s^-2",
        "T": "kg s^-2 A^-1",
        "Pa": "kg m^-1 s^-2",
        "V": "kg m^2 s^-3 A^-1",
    }.items()
}
_ATOMS = _atoms()
_TERM = re.compile(r"([A-Za-z%][A-Za-z%]*0?|1)(?:\^?(-?\d+))?")


def _named(name: str) -> tuple[float, Powers, float] | None:
    """A name of the table; case is ignored where that is unambiguous."""
    if name in _ATOMS:
        return _ATOMS[name]
    alike = {_ATOMS[other] for other in _ATOMS if other.lower() == name.lower()}
    return alike.pop() if len(alike) == 1 else None


def _product(text: str, plain: str) -> Unit:
    """A unit of several names, or of one name with a power."""
    factor, powers = 1.0, np.zeros(len(_BASES), int)
    for place, part in enumerate(re.sub(r"[()]", " ", plain).split("/")):
        for word in part.replace(".", " ").split():
            term = _TERM.fullmatch(word)
            known = _named(term[1]) if term and term[1] != "1" else (1.0, _powers(""), 0.0)
            if term is None or known is None:
                raise _unknown(text, word)
            power = int(term[2] or 1) * (-1 if place else 1)
            factor *= known[0] ** power
            powers += power * np.array(known[1])
    return Unit(text, factor, tuple(powers.tolist()))


def _unknown(text: str, word: str) -> ValueError:
    near = difflib.get_close_matches(word, _ATOMS, n=4) if len(word) > 1 else []
    whole = difflib.get_close_matches(text, _COMMON, n=4, cutoff=0.5)
    found = list(dict.fromkeys(whole + near))
    hint = f"near ones are {', '.join(found)}" if found else f"there are {', '.join(_COMMON)}"
    return ValueError(f"unknown unit {text!r}; {hint}")


_COMMON = (
    "rad/s", "deg/s", "dps", "deg/h", "rpm", "m/s^2", "g", "mg", "m", "cm", "mm", "km", "ft",
    "m/s", "km/h", "kn", "uT", "mT", "gauss", "mgauss", "Pa", "hPa", "kPa", "mbar", "rad", "deg",
    "s", "ms", "us", "ns", "V", "A", "degC", "K", "%",
)  # fmt: skip


def _written(powers: Powers) -> str:
    """Powers of the base units as ``rad/s^2``."""
    above = [_power(base, p) for base, p in zip(_BASES, powers, strict=True) if p > 0]
    below = [_power(base, -p) for base, p in zip(_BASES, powers, strict=True) if p < 0]
    return "/".join([" ".join(above) or "1", *below])


def _power(base: str, power: int) -> str:
    return base if power == 1 else f"{base}^{power}"
