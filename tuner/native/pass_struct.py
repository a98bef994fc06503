"""What C of both passes takes: sizes, functions, and addresses of memory in a struct."""

import ctypes

_SIZES = "n", "part", "width", "count"
_FUNCTIONS = "number", "judge", "pull"
_MEMORY = "z", "p", "by_p", "saved", "store", "kept", "end", "judged", "slope"


class Given(ctypes.Structure):
    """The struct.

    Attributes:
        n, part, width: numbers of samples, of those of a part that is stored, and of columns.
        count: number of the numbers that vary with a point.
        number, judge, pull: C functions of rows: these numbers from a point; the objective and its
            derivatives from the numbers at the end; the gradient from a point and ``by_p``.
        u: the record.
        z, p, by_p: a point, the numbers that vary with it, and the derivatives by these, which lie
            behind the point.
        saved, store: memory for the states where parts begin, and for what is stored of a part.
        kept, end: for the values kept of each sample, and for the numbers at the end.
        judged, slope: for the results of ``judge`` and ``pull``.
    """

    _fields_ = (
        *((name, ctypes.c_size_t) for name in _SIZES),
        *((name, ctypes.c_void_p) for name in (*_FUNCTIONS, "u", *_MEMORY)),
    )


STRUCT = f"""\
typedef void rows(size_t n, const double *x, double *y);

struct run {{
    size_t {", ".join(_SIZES)};
    rows {", ".join(f"*{name}" for name in _FUNCTIONS)};
    const double *u;
    double {", ".join(f"*{name}" for name in _MEMORY)};
}};
"""
"""The same in C."""
