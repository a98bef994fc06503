"""Units as text, and their products and powers: ``unit^2/s^3``, ``(m/s)^2`` and so on.

Unlike :mod:`tuner.data.units` this knows no units, only names.
"""

import re
from collections.abc import Mapping

Powers = dict[str, float]
_TERM = re.compile(r"([^\W\d_]+)(?:\^(-?\d+(?:\.\d+)?))?")
_GROUP = re.compile(r"\(([^()]+)\)(?:\^(\d+))?")


def powers_of(text: str) -> Powers | None:
    """The powers of the names in a unit; None where it has another form.

    >>> powers_of("unit^2/s^3"), powers_of("(rad/s)^2/s"), powers_of("unit^2, unit/s")
    ({'unit': 2.0, 's': -3.0}, {'rad': 2.0, 's': -3.0}, None)
    """
    found: Powers = {}
    for place, part in enumerate(_GROUP.sub(_expanded, text).split("/")):
        for word in part.split():
            term = _TERM.fullmatch(word)
            if term is None and word != "1":
                return None
            if term is not None:
                power = float(term[2] or 1) * (-1 if place else 1)
                found[term[1]] = found.get(term[1], 0.0) + power
    return {name: power for name, power in found.items() if power}


def _expanded(group: re.Match[str]) -> str:
    """A unit without its brackets; unchanged where it cannot be read."""
    inner = powers_of(group[1])
    if inner is None:
        return group[0]
    return " ".join(f"{n}^{p:g}" for n, p in raised(inner, float(group[2] or 1)).items())


def raised(powers: Mapping[str, float], to: float) -> Powers:
    """The powers of a power.

    >>> raised({"m": 2.0, "s": -1.0}, 0.5)
    {'m': 1.0, 's': -0.5}
    """
    return {name: power * to for name, power in powers.items()}


def per(powers: Mapping[str, float], name: str, power: float = 1.0) -> Powers:
    """The powers of a unit over a power of a name.

    >>> per({"m": 2.0, "s": -3.0}, "s", -1)
    {'m': 2.0, 's': -2.0}
    """
    found = dict(powers) | {name: powers.get(name, 0.0) - power}
    return {name: power for name, power in found.items() if power}


def written(powers: Mapping[str, float]) -> str:
    """The text of a unit, from its powers.

    >>> written({"rad": 1.0, "s": -0.5}), written({"s": -1.0}), written({"rad": 2.0, "s": 1.0})
    ('rad/s^0.5', '1/s', 'rad^2 s')
    """
    above = [_power(name, power) for name, power in powers.items() if power > 0]
    below = [_power(name, -power) for name, power in powers.items() if power < 0]
    if not above and not below:
        return ""
    return "/".join([" ".join(above) or "1", *below])


def _power(name: str, power: float) -> str:
    return name if power == 1 else f"{name}^{power:g}"
