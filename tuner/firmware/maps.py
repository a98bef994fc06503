"""A person's assignments of numbers to keys: NAME=KEY."""

from collections.abc import Collection, Iterable, Mapping, Sequence

from tuner.firmware.amount import Amount
from tuner.firmware.key import Key
from tuner.names import unknown


def read_maps(pairs: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Keys by name, from NAME=KEY[,KEY].

    Raises:
        ValueError: for a pair without "=", and a name or a key that comes twice.

    >>> read_maps(["R=EKF2_BARO_NOISE", "q=vx,vy"])
    {'R': ('EKF2_BARO_NOISE',), 'q': ('vx', 'vy')}
    """
    found: dict[str, tuple[str, ...]] = {}
    owners: dict[str, str] = {}
    for pair in pairs:
        name, _, text = (part.strip() for part in pair.partition("="))
        keys = tuple(key.strip() for key in text.split(","))
        if not name or not all(keys):
            raise ValueError(f"--map {pair} has no value; write --map NAME=KEY")
        if name in found:
            raise ValueError(f"--map names {name} twice; write --map {name}=KEY,KEY")
        for key in keys:
            if key in owners:
                both = name if owners[key] == name else f"{owners[key]} and {name}"
                raise ValueError(f"--map gives {key} twice, of {both}, and it is one; map it once")
            owners[key] = name
        found[name] = keys
    return found


def named(
    keys: Sequence[Key], amounts: Mapping[str, Amount], maps: Mapping[str, tuple[str, ...]]
) -> dict[str, Amount]:
    """Amounts by the keys that they are mapped to.

    Raises:
        ValueError: for an unknown name or key.
    """
    known = {key.name for key in keys}
    found = {}
    for name, wanted in maps.items():
        if name not in amounts:
            raise unknown("number", name, _important(amounts))
        for key in wanted:
            if key not in known:
                raise unknown("parameter", key, known)
            found[key] = amounts[name]
    return found


def _important(names: Collection[str]) -> Collection[str]:
    """Only the important names, where there are many."""
    return names if len(names) < 30 else [name for name in names if not name[-1].isdigit()]
