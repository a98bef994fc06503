"""The assignment of a run's numbers to a firmware's parameters: known, named, or suggested."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tuner.firmware.amount import Amount, Read
from tuner.firmware.key import Key
from tuner.firmware.maps import named

Axes = Literal["largest", "rms"]


class Setting(NamedTuple):
    """A parameter of the file.

    Attributes:
        key: which.
        value: the written number.
        found: the number by the conversion, which may lie beyond the key's ends.
        how: the conversion, a line for each amount.
    """

    key: Key
    value: float
    found: float
    how: tuple[str, ...]

    @property
    def warning(self) -> str:
        """The change that made the value fit; "" without one."""
        if self.value == self.found:
            return ""
        return (
            f"{self.key.name} would be {self.found:.6g} {self.key.measured_in}, and the firmware "
            f"takes {self.key.ends}: {self.value:.6g} is written"
        )


@dataclass(frozen=True)
class Wish:
    """A person's choices of keys for the numbers.

    Attributes:
        maps: keys by the amounts' names.
        axes: how one key combines several axes; None: not chosen.
    """

    maps: Mapping[str, tuple[str, ...]]
    axes: Axes | None = None


def settings(
    keys: Sequence[Key], amounts: Sequence[Amount], wish: Wish, T: float
) -> tuple[list[Setting], list[str]]:
    """The parameters, in the keys' order, and a sentence for each amount left out.

    Args:
        keys: of the firmware.
        amounts: of the run.
        wish: what a person says.
        T: time of a prediction, s.

    Raises:
        ValueError: for unknown names, contradicting units, and several numbers for
            one key.
    """
    by_name = {amount.name: amount for amount in amounts}
    by_key = named(keys, by_name, wish.maps)
    found, notes = [], []
    for key in keys:
        if key.name in by_key:
            found.append(_of_one(key, by_key[key.name], T))
            continue
        alike = [
            a for a in amounts if a.export and a.export == key.export and a.name not in wish.maps
        ]
        notes += [_unseen(amount, key) for amount in alike if not _is_seen(amount)]
        seen = [amount for amount in alike if _is_seen(amount)]
        if seen:
            found.append(_of_axes(key, seen, wish.axes, T))
    return found, notes


def candidates(
    keys: Sequence[Key], amounts: Iterable[Amount], wish: Wish, T: float
) -> Iterator[str]:
    """Suggestions for amounts of unknown meaning, by their units."""
    for amount in amounts:
        fit = [key.name for key in keys if key.of(amount, T) is not None]
        open_ = not (amount.export or amount.again or amount.name in wish.maps)
        if fit and open_ and amount.value > 0:
            text = f"{amount.unit}, {amount.meaning}" if amount.meaning else amount.unit
            yield (
                f"{amount.name} ({text}) may be {_or(fit)}: --map {amount.name}={fit[0]} if it is"
            )


def _of_one(key: Key, amount: Amount, T: float) -> Setting:
    return _setting(key, *_converted(key, amount, T))


def _of_axes(key: Key, amounts: Sequence[Amount], axes: Axes | None, T: float) -> Setting:
    if len(amounts) == 1:
        return _of_one(key, amounts[0], T)
    names = [amount.name for amount in amounts]
    if axes is None:
        raise ValueError(
            f"{_and(names)} each give {key.name}, which is one number for all of them; give "
            f"--axes largest or --axes rms, or one of them: --map {names[0]}={key.name}"
        )
    found = [_converted(key, amount, T) for amount in amounts]
    values = [value for value, _ in found]
    if axes == "largest":
        whole, words = max(values), "the largest of the axes"
    else:
        whole, words = float(np.sqrt(np.mean(np.square(values)))), "root of the axes' mean square"
    return _setting(key, whole, (words, *(line for _, lines in found for line in lines)))


def _converted(key: Key, amount: Amount, T: float) -> tuple[float, tuple[str, ...]]:
    """The number and the line that explains it."""
    if not (np.isfinite(amount.value) and amount.value > 0):
        raise ValueError(
            f"{amount.name} is {amount.value:g}, and {key.name} is the size of a noise; map a "
            "positive number"
        )
    read: Read | None = key.of(amount, T)
    if read is None:
        raise ValueError(
            f"{amount.name} is in {amount.unit or 'no unit'}, which is not a noise of "
            f"{key.measured_in} as {key.name} is; map another number, or tune with units"
        )
    line = f"{amount.name} = {amount.value:.6g} {amount.unit}"
    if read.how != amount.name:
        line = f"{read.how} = {read.value:.6g} {key.measured_in}, {line}"
    if amount.below is not None:
        line += f", which the record does not tell from 0{_limit(amount)}"
    return read.value, (line,)


def _setting(key: Key, found: float, how: tuple[str, ...]) -> Setting:
    return Setting(key, min(max(found, key.low), key.high), found, how)


def _is_seen(amount: Amount) -> bool:
    return amount.below is None and amount.value != 0


def _unseen(amount: Amount, key: Key) -> str:
    if not amount.value:
        return f"{amount.name} is left out: the record shows none{_limit(amount)}"
    return (
        f"{amount.name} is left out: the record does not tell it from 0{_limit(amount)}; --map "
        f"{amount.name}={key.name} writes {amount.value:.3g} all the same"
    )


def _limit(amount: Amount) -> str:
    if amount.below is None or np.isinf(amount.below):
        return ""
    return f", it is below {amount.below:.3g} {amount.unit}"


def _or(names: Sequence[str]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _and(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
