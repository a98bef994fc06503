"""Operations that scalars do not have, told by name."""


class NoCounterpartError(ValueError):
    """An operation that scalars do not have."""


def no_counterpart(name: str) -> NoCounterpartError:
    """The error that names an operation."""
    words = _KNOWN.get(name, name)
    return NoCounterpartError(f"{words} has no counterpart among scalars")


_KNOWN = {
    "while": "a while loop, which takes as long as its data want (while),",
    "sort": "sorting (sort)",
    "fft": "a Fourier transform (fft)",
    "pure_callback": "a call of Python (pure_callback)",
    "io_callback": "a call of Python (io_callback)",
    **{
        name: f"solving a system of equations in the step ({name})"
        for name in ("custom_linear_solve", "lu", "triangular_solve", "cholesky")
    },
    **{name: f"a decomposition ({name})" for name in ("eigh", "eig", "svd", "qr", "schur")},
}
