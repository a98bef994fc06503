"""C that copies one half of a symmetric matrix to the other, four rows by four columns at once."""

from collections.abc import Iterable

_MIRROR = """\
#ifndef __has_builtin
#define __has_builtin(x) 0
#endif
#if __has_builtin(__builtin_shufflevector)
typedef double four __attribute__((vector_size(32), aligned(8)));

static inline void mirror_four(double *below, double *above, int row)
{
    const four a = *(four *)below, b = *(four *)(below + row);
    const four c = *(four *)(below + 2 * row), d = *(four *)(below + 3 * row);
    const four e = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const four f = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const four g = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const four h = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    const four p = __builtin_shufflevector(e, g, 0, 1, 4, 5);
    const four q = __builtin_shufflevector(f, h, 0, 1, 4, 5);
    const four r = __builtin_shufflevector(e, g, 2, 3, 6, 7);
    const four s = __builtin_shufflevector(f, h, 2, 3, 6, 7);
    *(four *)above = p;
    if (below == above) {
        *(four *)(above + row) = __builtin_shufflevector(b, q, 0, 5, 6, 7);
        *(four *)(above + 2 * row) = __builtin_shufflevector(c, r, 0, 1, 6, 7);
    } else {
        *(four *)(above + row) = q;
        *(four *)(above + 2 * row) = r;
        *(four *)(above + 3 * row) = s;
    }
}
#endif

static inline void mirror(double *m, int row, int size)
{
    int i = 0;
#if __has_builtin(__builtin_shufflevector)
    for (; i + 4 <= size; i += 4)
        for (int j = 0; j <= i; j += 4) mirror_four(m + row * i + j, m + row * j + i, row);
#endif
    for (; i < size; i++)
        for (int j = 0; j < i; j++) m[row * j + i] = m[row * i + j];
}
"""


def mirrors(statements: Iterable[str]) -> list[str]:
    """The function ``mirror``, where statements call it.

    It takes a matrix's memory, the length of its rows there, and their number, and copies what is
    below the diagonal to what is above it.

    >>> mirrors(["a = b;"]), len(mirrors(["mirror(m1, 8, 6);"]))
    ([], 1)
    """
    return [_MIRROR] if any("mirror(" in text for text in statements) else []
