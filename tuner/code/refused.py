"""Operations without a counterpart among scalars, refused by name."""

from typing import Any


class NoCounterpartError(ValueError):
    """An operation without a counterpart among scalars."""


def no_counterpart(name: str) -> NoCounterpartError:
    """The error that names an operation."""
    words = _KNOWN.get(name, name)
    return NoCounterpartError(f"{words} has no counterpart among scalars")


def check_type(name: str, dtype: Any) -> None:
    """Refuse an operation whose result is neither real, nor whole with a sign, nor a truth value.

    Raises:
        NoCounterpartError: names it.
    """
    if name == "convert_element_type" and dtype.kind == "c":  # its consumer is refused
        return
    if dtype.kind not in "fib" or (dtype.kind == "i" and dtype.itemsize < 4):
        raise NoCounterpartError(f"{name} of numbers of {dtype} has no counterpart among scalars")


_KNOWN = {
    "while": "a while loop, which takes as long as its data want (while),",
    "sort": "sorting (sort)",
    "fft": "a Fourier transform (fft)",
    "pure_callback": "a call of Python (pure_callback)",
    "io_callback": "a call of Python (io_callback)",
    "reduce_precision": "rounding to fewer digits (reduce_precision)",
    **{
        name: f"drawing random numbers ({name})"
        for name in ("random_seed", "random_wrap", "random_bits", "random_unwrap", "threefry2x32")
    },
    **{
        name: f"solving a system of equations in the step ({name})"
        for name in ("custom_linear_solve", "lu", "triangular_solve", "cholesky")
    },
    **{name: f"a decomposition ({name})" for name in ("eigh", "eig", "svd", "qr", "schur")},
}
