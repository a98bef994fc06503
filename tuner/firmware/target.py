"""A request for a firmware's file, and the statements common to all of them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from tuner.export.tuned import Tuned
from tuner.firmware.amount import Amount
from tuner.firmware.choice import Setting, Wish, candidates, settings
from tuner.firmware.key import Key


@dataclass(frozen=True)
class FileRequest:
    """A request for a firmware's file.

    Attributes:
        tuned: the filters whose numbers are exported.
        amounts: their numbers.
        parameters: of the filters, by name among the amounts, and whether they were searched for:
            then their meaning is asked for.
        wish: a person's choices.
        rate_hz: of the firmware's predictions; None: its own.
        log_rate_hz: of the record; 0: unknown.
    """

    tuned: tuple[Tuned, ...]
    amounts: tuple[Amount, ...]
    parameters: Mapping[str, bool]
    wish: Wish
    rate_hz: float | None = None
    log_rate_hz: float = 0.0

    @property
    def source(self) -> str:
        """The origin of the numbers."""
        names = ", ".join(each.name for each in self.tuned)
        first = self.tuned[0].provenance
        return f"{names} ({first.study}" + f", {first.log_name}" * bool(first.log_name) + ")"


class Text(NamedTuple):
    """A firmware's file.

    Attributes:
        text: ASCII.
        numbers: how many parameters it sets.
        notes: a sentence for each number changed or left out.
    """

    text: str
    numbers: int
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Target:
    """A firmware, or a program, with a file of its own.

    Attributes:
        name: for users.
        file: its file's usual name.
        about: it in a phrase.
        filter: the other filter that runs there; "" where numbers mean the same.
        written: the file.
        of_model: whether it takes the matrices of one filter, which change with the rate.
    """

    name: str
    file: str
    about: str
    filter: str
    written: Callable[[FileRequest], Text]
    of_model: bool = False


def keyed(
    request: FileRequest, keys: Sequence[Key], T: float, name: str
) -> tuple[list[Setting], tuple[str, ...]]:
    """The parameters, and notes.

    Args:
        request: the request.
        keys: of the firmware.
        T: time of its predictions, s.
        name: of the firmware, for messages.

    Raises:
        ValueError: where no number has a meaning there, and as ``settings`` of the choice.
    """
    found, notes = settings(keys, request.amounts, request.wish, T)
    searched = [amount for amount in request.amounts if request.parameters.get(amount.name)]
    ways = list(candidates(keys, searched, request.wish, T))
    if not found:
        ways = ways or list(candidates(keys, request.amounts, request.wish, T))
        more = "; ".join([*notes, *ways]) or "by their units none is the size of such a noise"
        raise ValueError(f"nothing says which numbers of {request.source} {name} takes: {more}")
    warnings = [setting.warning for setting in found if setting.warning]
    return found, (*warnings, *notes, *(f"left out: {way}" for way in ways))


def head(request: FileRequest, target: str, filter: str, notes: Iterable[str]) -> Iterator[str]:
    """Lines of comment above the numbers, without the sign that begins them."""
    yield f"Noise for {target}, written by filter-tuner from {request.source}"
    if filter:
        yield f"{filter} is another filter than the one that was tuned: values to begin with."
    yield from notes


def how(setting: Setting) -> Iterator[str]:
    """Lines of comment above a number."""
    yield f"{setting.key.name}: {'; '.join(setting.how)}"
    if setting.key.note:
        yield f"{setting.key.name}: {setting.key.note}"


def commented(lines: Iterable[str]) -> list[str]:
    """Comment lines that begin with #, in ASCII, whatever the text.

    >>> commented(["a\\nEKF2_X 1", ""])
    ['# a\\\\nEKF2_X 1', '#']
    """
    return [f"# {line.encode('unicode_escape').decode('ascii')}".rstrip() for line in lines]


def yaml_number(value: float) -> str:
    """A number with a decimal point, without which YAML reads 1e-05 as text and 1 as an integer.

    >>> yaml_number(1e-05), yaml_number(200.0), yaml_number(0.1)
    ('1.0e-05', '200.0', '0.1')
    """
    mantissa, e, exponent = repr(float(value)).partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}{e}{exponent}"
