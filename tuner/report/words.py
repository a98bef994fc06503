"""Numbers and units as a printed page has them."""

import math
import re

from tuner.rounding import outward

_RAISED = str.maketrans("0123456789-+.", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺·")
MINUS = "\N{MINUS SIGN}"
HARD = "\N{NO-BREAK SPACE}"
TIMES = "\N{MULTIPLICATION SIGN}"


def number(value: float | None, digits: int = 4, *, zeros: bool = False) -> str:
    """A number to so many digits; powers of ten where it is very large or small.

    Args:
        value: the number; None for a dash.
        digits: how many.
        zeros: whether zeros at the end stay, where a number stands beside others.

    >>> number(0.00012345), number(-3.0), number(101322.0), number(float("inf")), number(None)
    ('1.234×10⁻⁴', '−3', '101322', '∞', '–')
    >>> number(1.0, 3), number(1.0, 3, zeros=True)
    ('1', '1.00')
    """
    if value is None or math.isnan(value):
        return "\N{EN DASH}"
    if math.isinf(value):
        return f"{MINUS if value < 0 else ''}∞"
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)) + 1e-12)
    if -4 < size < max(digits, 6):
        text = f"{value:.{max(digits - 1 - size, 0)}f}"
        text = text if zeros or "." not in text else text.rstrip("0").rstrip(".")
    else:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        if "." in mantissa and not zeros:
            mantissa = mantissa.rstrip("0").rstrip(".")
        text = f"{mantissa}{TIMES}10{raised(str(int(power)))}"
    return text.replace("-", MINUS)


def raised(text: str) -> str:
    """Digits and signs as superscripts.

    >>> raised("-12")
    '⁻¹²'
    """
    return text.translate(_RAISED)


def unit(text: str) -> str:
    """A unit with raised powers.

    >>> unit("m^2/s^3"), unit("deg/sqrt(h)"), unit("(rad/s)^2"), unit("1")
    ('m²/s³', '°/√h', '(rad/s)²', '')
    """
    if text == "1":
        return ""
    with_roots = re.sub(r"sqrt\(([^()]*)\)", r"√\1", label(text))
    return with_roots.replace("*", "·")


def label(text: str) -> str:
    """Text with raised powers and signs for degrees.

    >>> label("innovation x, m^2/s"), label("rate, deg/s"), label("0.5 deg"), label("S 30 deg^2")
    ('innovation x, m²/s', 'rate, °/s', '0.5°', 'S 30 deg²')
    """
    with_degrees = re.sub(r"(?<=\d) deg\b(?!\^)|\bdeg\b(?!\^)", "°", text)
    return re.sub(r"\^(-?[\d.]+)", lambda found: raised(found[1]), with_degrees)


def amount(value: float | None, of: str, digits: int = 4) -> str:
    """A number with its unit, which stay on one line.

    >>> amount(2.5, "m^2").replace(HARD, " "), amount(5.0, "deg"), amount(0.1, "")
    ('2.5 m²', '5°', '0.1')
    """
    if of == "deg":
        return number(value, digits) + unit(of)
    return (
        f"{number(value, digits)}{HARD}{unit_text}"
        if (unit_text := unit(of))
        else number(value, digits)
    )


def between(low: float, high: float) -> str:
    """Two shares in per cent, as a range.

    >>> between(0.13, 0.19).replace(HARD, " ")
    '13 to 19 %'
    """
    one, other = percent(low), percent(high)
    return one if one == other else f"{one.removesuffix('%').rstrip()} to {other}"


def interval(ends: tuple[float | None, float | None] | None, digits: int = 3) -> str:
    """An interval in words, rounded outward; one end alone where the other is not known.

    >>> interval((1.0, 2.5)), interval((0.0, 2e-4)), interval((3.0, None))
    ('1.00 to 2.50', 'below 2×10⁻⁴', 'above 3')
    """
    if ends is None:
        return ""
    low, high = outward(*ends, digits)
    if high is None or high == math.inf:
        return f"above {number(low, digits)}"
    if low in (None, 0.0, -math.inf):
        return f"below {number(high, digits)}"
    return f"{number(low, digits, zeros=True)} to {number(high, digits, zeros=True)}"


def percent(share: float | None) -> str:
    """A share in per cent.

    >>> [percent(share).replace(HARD, " ") for share in (0.1234, -0.001, 0.9994, 2e-7)]
    ['12 %', '−0.1 %', '99.9 %', '2×10⁻⁵ %']
    """
    if share is None or not math.isfinite(share):
        return "\N{EN DASH}"
    value = 100 * share
    text = f"{value:.1f}" if 99 <= abs(value) < 100 else f"{value:.0f}"
    return f"{text.replace('-', MINUS) if abs(value) >= 10 else number(value, 2)}{HARD}%"


def size(count: int) -> str:
    """Bytes as people read them.

    >>> size(312), size(20_480), size(3_500_000)
    ('312 B', '20 kB', '3.5 MB')
    """
    if count < 1000:
        return f"{count} B"
    return f"{count / 1000:.0f} kB" if count < 1_000_000 else f"{count / 1e6:.1f} MB"


def sentence(text: str) -> str:
    """With a capital letter, where it begins with a word and no name, and a full stop.

    >>> sentence("all is well"), sentence("q_bias is not determined")
    ('All is well.', 'q_bias is not determined.')
    """
    stripped = text.strip()
    first = stripped.partition(" ")[0].rstrip(",:;")
    word = first == "a" or (len(first) > 1 and first.replace("-", "").isalpha())
    capital = stripped[:1].upper() if word else stripped[:1]
    return stripped and capital + stripped[1:] + ("" if stripped[-1] in ".!?" else ".")


def listed(parts: list[str]) -> str:
    """Things with commas and an "and".

    >>> listed(["q"]), listed(["q", "R"]), listed(["q", "R", "P"])
    ('q', 'q and R', 'q, R and P')
    """
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def joined(parts: list[str]) -> str:
    """Clauses with commas, the last one with an "and".

    >>> joined(["it is better"]), joined(["it is better", "all starts agree"])
    ('it is better', 'it is better, and all starts agree')
    """
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])}, and {parts[-1]}"
