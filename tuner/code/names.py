"""Names for C and C++: ASCII, not reserved, and unique."""

import re
import unicodedata
from collections.abc import Collection

_C = """auto break case char const continue default do double else enum extern float for goto if
inline int long register restrict return short signed sizeof static struct switch typedef union
unsigned void volatile while alignas alignof bool constexpr false nullptr static_assert
thread_local true typeof typeof_unqual"""
_CPP = """and and_eq asm atomic_cancel bitand bitor catch char8_t char16_t char32_t class co_await
co_return co_yield compl concept const_cast consteval constinit decltype delete dynamic_cast
explicit export friend import module mutable namespace new noexcept not not_eq operator or or_eq
private protected public reinterpret_cast requires static_cast template this throw try typeid
typename using virtual wchar_t xor xor_eq"""
_LIBRARY = """abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh div erf erfc
exp exp2 expm1 fabs fdim floor fma fmax fmin fmod frexp gamma hypot ilogb index
isfinite isgreater isinf isless isnan isnormal isunordered j0 j1 jn ldexp lgamma log
log10 log1p log2 logb lrint lround main modf nan nearbyint nextafter pow remainder
rint round scalbn signbit signgam significand sin sinh sqrt tan tanh tgamma time
trunc y0 y1 yn errno linux unix complex imaginary I NULL NAN INFINITY HUGE_VAL
HUGE_VALF HUGE_VALL M_PI M_E DOMAIN SING OVERFLOW UNDERFLOW near far interrupt
vector pixel state in out tables params found"""
_MATH = """float_t double_t math_errhandling fpclassify isgreaterequal islessequal islessgreater
FP_NAN FP_INFINITE FP_ZERO FP_NORMAL FP_SUBNORMAL FP_FAST_FMA FP_ILOGB0 FP_ILOGBNAN MATH_ERRNO
MATH_ERREXCEPT M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI M_SQRT2
M_SQRT1_2 MAXFLOAT drem finite gamma_r lgamma_r llrint llround nexttoward pow10 remquo scalb
scalbln sincos exp10"""
TAKEN = frozenset(
    f"{_C} {_CPP} {_LIBRARY} {_MATH}".split()
    + [f"{name}{end}" for name in f"{_LIBRARY} {_MATH}".split() for end in "fl" if name.islower()]
)
"""Words of the languages, names of their libraries and of compilers, and those of our own."""


def identifier(name: str, taken: Collection[str] = ()) -> str:
    """A valid name in C and C++.

    Args:
        name: any text.
        taken: names in use.

    >>> identifier("double"), identifier("σ_z"), identifier("x", {"x"}), identifier("*/")
    ('double_', 'sigma_z', 'x_2', 'a')
    """
    text = "".join(map(_ascii, unicodedata.normalize("NFKC", name)))
    text = re.sub(r"_+", "_", text).strip("_")[:48] or "a"
    text = f"a{text}" if text[0].isdigit() else text
    text = f"{text}_" if text in TAKEN or (text.upper() in TAKEN and text.isupper()) else text
    if text not in taken:
        return text
    return next(new for n in range(2, len(taken) + 3) if (new := f"{text}_{n}") not in taken)


def _ascii(letter: str) -> str:
    if letter.isascii():
        return letter if letter.isalnum() else "_"
    plain = unicodedata.normalize("NFKD", letter)[0]
    if plain.isascii() and plain.isalnum():
        return plain
    words = unicodedata.name(letter, "").split()
    return words[-1].lower() if "LETTER" in words and words[-1].isalnum() else "_"


def in_comment(text: str, longest: int = 96) -> str:
    """Text that stays inside a comment, on one line, in ASCII.

    >>> in_comment("a */ b ??/ c")
    'a * / b ? ?/ c'
    """
    words = " ".join("".join(map(_spelt, text)).split())
    words = re.sub(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)", " ", words).rstrip("\\")
    return words if len(words) <= longest else f"{words[: longest - 4]} ..."


def _spelt(letter: str) -> str:
    if letter.isascii():
        return letter if letter.isprintable() else " "
    known = {"\N{DEGREE SIGN}": "deg", "\N{SUPERSCRIPT TWO}": "^2", "\N{MICRO SIGN}": "u"}
    return known.get(letter) or _ascii(letter)
