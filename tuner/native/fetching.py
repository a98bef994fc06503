"""Reading ahead for a pass back, which a processor's own prediction serves badly."""

LINE = 8
"""Numbers in a line of a processor's cache."""
AHEAD = 2
"""Samples between the fetch of what is stored and its use."""


def fetching(statements: str, stored: int) -> str:
    """A sample's statements, with those among them that fetch what is stored of a sample to come.

    A processor has few lines under way at once, so the fetches are spread over the statements.

    Args:
        statements: of a sample in the pass back, in which ``store`` is where its numbers begin, and
            ``n`` the number of samples still to come; a nested line is indented.
        stored: numbers stored of a sample.

    >>> print(fetching("a = store[0];\\nb = store[1];", 9))
    const double *ahead = store - (n < 2 ? n : 2) * 9;
    __builtin_prefetch(ahead + 0);
    a = store[0];
    __builtin_prefetch(ahead + 8);
    b = store[1];
    """
    if not stored:
        return statements
    lines = statements.split("\n")
    begins = [k for k in range(len(lines)) if _begins(lines, k)]
    fetches: dict[int, list[str]] = {}
    count = -(-stored // LINE)
    for k in range(count):
        place = begins[k * len(begins) // count]
        fetches.setdefault(place, []).append(f"__builtin_prefetch(ahead + {LINE * k});")
    found = [f"const double *ahead = store - (n < {AHEAD} ? n : {AHEAD}) * {stored};"]
    for k, line in enumerate(lines):
        found += [*fetches.get(k, []), line]
    return "\n".join(found)


def _begins(lines: list[str], k: int) -> bool:
    """Whether a statement that is not nested begins at a line."""
    ended = k == 0 or lines[k - 1].endswith((";", "}"))
    return ended and lines[k] != "" and lines[k][0] not in " }"
