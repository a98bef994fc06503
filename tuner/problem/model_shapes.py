"""Checks that the matrices of a model fit together."""

from typing import Any, TypeAlias

from filters import ExtendedModel, LinearModel

Fields: TypeAlias = dict[str, tuple[str, ...]]

_LINEAR: Fields = {
    "transition.F": ("nn",),
    "H": ("mn",),
    "R": ("m", "mm"),
    "transition.G": ("np",),
    "transition.Q": ("pp",),
    "transition.B": ("nq",),
    "x0": ("n", "ns"),
    "P0": ("nn",),
}
_EXTENDED: Fields = {"x0": ("n",), "P0": ("nn",), "R": ("m",)}
"""The letters of the axes by field; equal letters are equal sizes, and the first one decides."""


def check_model(name: str, params: Any) -> None:
    """Refuse a model of a Kalman filter whose matrices do not fit together.

    Args:
        name: of the problem.
        params: the parameters of its filter; only a LinearModel or an ExtendedModel is checked.

    Raises:
        ValueError: with the field, its shape and the one that is needed.
    """
    if isinstance(params, LinearModel):
        fields = _LINEAR
    elif isinstance(params, ExtendedModel):
        fields = _EXTENDED
    else:
        return
    sizes: dict[str, tuple[int, str]] = {}
    for field, ways in fields.items():
        value: Any = params
        for part in field.split("."):
            value = getattr(value, part)
        if value is not None:
            _check(name, field.rpartition(".")[2], tuple(value.shape), ways, sizes)


def _check(
    name: str,
    field: str,
    shape: tuple[int, ...],
    ways: tuple[str, ...],
    sizes: dict[str, tuple[int, str]],
) -> None:
    letters = next((way for way in ways if len(way) == len(shape)), None)
    if letters is None:
        needed = " or ".join(_axes(way, sizes) for way in ways)
        number = "2" if ways[-1][0] not in sizes else str(sizes[ways[-1][0]][0])
        way_out = (
            f"write {field} * jnp.eye({number})" if len(ways[-1]) == 2 else f"write {field}[None]"
        )
        raise ValueError(
            f"the {field} of {name} has shape {shape}, and {needed} is needed; "
            + (way_out if not shape else "give it that shape")
        )
    for letter, size in zip(letters, shape, strict=True):
        known, by = sizes.setdefault(letter, (size, field))
        if size != known:
            raise ValueError(
                f"the {field} of {name} has shape {shape}, and {_axes(letters, sizes)} is needed, "
                f"for {by} says that {letter} is {known}; mend one of them"
            )


def _axes(letters: str, sizes: dict[str, tuple[int, str]]) -> str:
    named = [str(sizes[letter][0]) if letter in sizes else letter for letter in letters]
    return f"({', '.join(named)}{',' if len(named) == 1 else ''})"
