"""Sine and cosine of one angle together, in C, without a call."""

import math

HEAD = """\
typedef double two __attribute__((vector_size(16)));
typedef struct { double sine, cosine; } pair;

static __attribute__((noinline, cold)) pair by_library(double x)
{
    const pair both = {sin(x), cos(x)};
    return both;
}
"""
_TEXT = """
static inline __attribute__((always_inline)) pair circular(double x)
{{
#if defined __FMA__ || defined __ARM_FEATURE_FMA
    double r = x;
    int q = 0;
    if (!(fabs(x) < {eighth})) {{
        if (!(fabs(x) < {largest})) {{
            return by_library(x);
        }}
        const double k = __builtin_rint(x * {turns});
        r = __builtin_fma(-k, {low}, __builtin_fma(-k, {high}, x));
        q = (int)k;
    }}
    const double z = r * r, w = z * z;
    const two zz = {{z, z}}, ww = {{w, w}};
    const two series = {series};
    const double s = r + r * z * series[0];
    const double c = 1.0 - (0.5 * z - w * series[1]);
    pair both = {{s, c}};
    if (__builtin_expect(q != 0, 0)) {{
        const double one = (q & 1) ? c : s, other = (q & 1) ? s : c;
        both.sine = (q & 2) ? -one : one;
        both.cosine = ((q + 1) & 2) ? -other : other;
    }}
    return both;
#else
    return by_library(x);
#endif
}}
"""
_LARGEST = 1e5
"""The largest angle whose distance from a multiple of a quarter turn two numbers still tell."""
_LOW = 6.123233995736766e-17
"""A quarter turn less its double."""


def sines() -> str:
    """A type ``pair`` and a function ``circular`` from an angle to its sine and cosine.

    The angle is reduced to at most an eighth of a turn, where the series are exact to rounding.
    NaN, infinity and many turns go to the library.
    """
    signs = [(-1) ** k for k in range(1, 9)]
    sine = [s / math.factorial(2 * k + 1) for k, s in enumerate(signs, 1)]
    cosine = [-s / math.factorial(2 * k + 2) for k, s in enumerate(signs, 1)]
    return HEAD + _TEXT.format(
        largest=_LARGEST,
        eighth=repr(math.pi / 4),
        turns=repr(2 / math.pi),
        high=repr(math.pi / 2),
        low=_LOW,
        series=_series(list(zip(sine, cosine, strict=True))),
    )


def _series(factors: list[tuple[float, float]]) -> str:
    """Two series in z at once, by pairs of terms: half as many operations wait for one another."""
    terms = [f"(two){{{one!r}, {other!r}}}" for one, other in factors]
    text = ""
    for k in reversed(range(0, len(terms), 2)):
        both = f"({terms[k]} + zz * {terms[k + 1]})"
        text = f"{both} + ww * ({text})" if text else both
    return text
