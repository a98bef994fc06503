"""Fuzzed text logs for the reader in C: python -m benchmarks.text_fuzz [SECONDS] [SEED].

The reader is compiled with the sanitizers of addresses and of undefined behaviour, which end it
at the first byte out of bounds, and gets each block in memory of exactly its size. Numbers are
those of Python to the bit, and what is no number, by a regular expression, is none. Nothing
is compared where a block is left to another reader; how many of those hold numbers is printed.
"""

import random
import re
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from tuner.compiler import compiler
from tuner.data.logs import compiled
from tuner.data.logs.compiled import Form

OPTIONS = ("-O2", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
LETTERS = b"0123456789" * 3 + b'....---++eE,,\n\n  \t\0\xff/:nan#%"'
AT_ONCE, MOST = 400, 2**53
FOUND, NOT_PLAIN, IN_DOUBT = range(3)


@dataclass(frozen=True)
class Block:
    """A text, how it is written, and the rows that are asked for."""

    text: bytes
    form: Form
    rows: int


def right(text: bytes, form: Form) -> np.ndarray | None:
    """The wanted columns by Python, ``(columns, rows)``; None where a reader has to refuse."""
    lines = text.split(b"\n")
    if lines.pop() or not text or form.delimiter == form.point:
        return None
    rows = [_cells(line, form.delimiter) for line in lines]
    if any(len(row) != form.width or row[0][:1] in (b"#", b"%") for row in rows):
        return None
    if form.width == 1 and [b""] in rows:
        return None
    others = set(range(form.width)) - set(form.columns)
    if any(b'"' in row[k] for row in rows for k in others):
        return None
    values = [[_number(row[k], form.point) for row in rows] for k in form.columns]
    if any(value is None for column in values for value in column):
        return None
    return np.array(values, float).reshape(len(form.columns), len(rows))


def _cells(line: bytes, delimiter: bytes) -> list[bytes]:
    if delimiter == b" ":
        return re.split(rb"[ \t]+", line.strip(b" \t"))
    blanks = b" " if delimiter == b"\t" else b" \t"
    return [cell.strip(blanks) for cell in line.split(delimiter)]


def _number(cell: bytes, point: bytes) -> float | None:
    """A number, NaN for a missing one, and None for anything else and what is too large."""
    mark = re.escape(point)
    if cell.lower() in (b"", b"nan"):
        return float("nan")
    if not re.fullmatch(rb"[-+]?(\d+%b?\d*|%b\d+)([eE][-+]?\d+)?" % (mark, mark), cell):
        return None
    value = float(cell.replace(point, b"."))
    return value if abs(value) < MOST else None


def any_double(draw: random.Random) -> float:
    """Any bits, or a number of a usual size where they are too large or too small."""
    (double,) = struct.unpack("d", struct.pack("Q", draw.getrandbits(64)))
    if 1e-260 < abs(double) < MOST:  # NaN compares false
        return float(double)
    return draw.uniform(-1, 1) * 10.0 ** draw.randint(-30, 15)


def between(draw: random.Random) -> str:
    """The digits next to the middle of two neighbours, where rounding turns."""
    double = 2.0 ** draw.uniform(-890, 53)
    middle = (Fraction(double) + Fraction(float(np.nextafter(double, 2.0 * MOST)))) / 2
    power = int(np.floor(np.log10(double))) - 18
    middle = middle * 10**-power if power < 0 else middle / 10**power
    return f"{int(middle) + draw.randint(-1, 2)}e{power}"


ODD = (
    "-0",
    "-.0",
    "5.",
    ".5",
    "0e999",
    "007",
    "1E+3",
    "0e-99999999999999999999",
    "1e-291",
    "5e-324",
)
KINDS: tuple[Callable[[random.Random], str], ...] = (
    lambda draw: repr(any_double(draw)),
    lambda draw: f"{any_double(draw):.{draw.randint(0, 20)}e}",
    lambda draw: f"{draw.gauss(0, 1):.17g}",
    lambda draw: f"{draw.uniform(-1000, 1000):.{draw.randint(1, 19)}f}",
    lambda draw: f"{draw.uniform(-1, 1):.9g}",
    lambda draw: str(draw.randint(1 - MOST, MOST - 1)),
    lambda draw: f"{'-' * draw.randrange(2)}{draw.getrandbits(63)}e-{draw.randint(4, 290)}",
    between,
    lambda draw: f"{between(draw).replace('e', f'{draw.getrandbits(draw.randint(1, 60))}e')}",
    lambda draw: f"{any_double(draw):.{draw.randint(19, 40)}e}",
    lambda draw: f"{draw.uniform(-1000, 1000):.{draw.randint(16, 30)}f}",
    lambda draw: f"{draw.gauss(0, 1):.20f}{'0' * draw.randint(0, 9)}{draw.randint(0, 9)}",
    lambda draw: f"0.{'0' * draw.randint(0, 30)}{draw.getrandbits(draw.randint(1, 63))}",
    lambda draw: f"{draw.randint(2**50, 2**53) / 2 ** draw.randint(1, 3):.2f}5",
    lambda draw: draw.choice(ODD),
    lambda draw: draw.choice(["", "nan", "NaN", "+1.5"]),
    lambda draw: draw.choice(["", "a", "a b", "on", "1"]),
)
"""Remedies to write plain numbers, many of which are hard to round."""


def block(draw: random.Random) -> Block:
    """A block of numbers, of which half are damaged."""
    delimiter, point = draw.choice([",.", ";.", "\t.", "|.", " .", ";,", "\t,", " ,"])
    width, rows = draw.choice([1, 1, 2, 3, 10, 40]), draw.choice([0, 1, 2, 5, 30])
    kinds = draw.sample(KINDS, draw.choice([1, 2, 3]))
    blanks = draw.choice(["", "", "", " ", "\t", "  "])
    lines = [
        f"{delimiter}{blanks}".join(draw.choice(kinds)(draw) for _ in range(width))
        for _ in range(rows)
    ]
    text = bytearray("".join(f"{line}\n" for line in lines).replace(".", point).encode())
    if draw.randrange(2):
        for _ in range(draw.choice([1, 1, 2, 8])):
            damage(draw, text)
    asked = text.count(b"\n")
    if not draw.randrange(20):
        asked, width = draw.randint(0, 60), draw.randint(0, 60)
    wanted = draw.sample(range(width), draw.choice([width, width, draw.randint(0, width)]))
    return Block(bytes(text), Form(delimiter.encode(), point.encode(), width, wanted), asked)


def damage(draw: random.Random, text: bytearray) -> None:
    """Change, add, take away or repeat some letters."""
    at = draw.randint(0, len(text))
    new = bytes(draw.choices(LETTERS, k=draw.choice([1, 1, 1, 2, 5])))
    kind = draw.randrange(5)
    if kind == 0:
        text[at : at + len(new)] = new
    elif kind == 1:
        text[at:at] = new
    elif kind == 2:
        del text[at : at + draw.choice([1, 1, 3, 40])]
    elif kind == 3:
        text[at:at] = text[at : at + draw.randint(1, 40)]
    else:
        del text[at:]


def answers(program: Path, blocks: list[Block]) -> list[tuple[int, bytes]]:
    """Status and numbers of each block.

    Raises:
        RuntimeError: with what a sanitizer says.
    """
    asked = b"".join(_asked(one) for one in blocks)
    ran = subprocess.run(
        [program],
        input=compiled.powers_of_ten().tobytes() + asked,
        capture_output=True,
        check=False,
    )
    if ran.returncode:
        raise RuntimeError(ran.stderr.decode(errors="replace"))
    found, at = [], 0
    for one in blocks:
        status = ran.stdout[at]
        size = 8 * one.rows * len(one.form.columns) if status == FOUND else 0
        found.append((status, ran.stdout[at + 1 : at + 1 + size]))
        at += 1 + size
    return found


def _asked(one: Block) -> bytes:
    form = one.form
    marks = form.delimiter[0], form.point[0]
    head = struct.pack("6Q", len(one.text), *marks, one.rows, form.width, len(form.columns))
    return head + compiled.places(form).tobytes() + one.text


def judge(one: Block, status: int, values: bytes) -> str:
    """A word for what was done with a block.

    Raises:
        AssertionError: where it was wrong.
    """
    wanted = right(one.text, one.form) if one.rows == one.text.count(b"\n") else None
    if status == IN_DOUBT:
        return "left to another reader" if wanted is None else "numbers, left to another reader"
    if status == NOT_PLAIN:
        assert wanted is None, one
        return "refused"
    assert wanted is not None, one
    assert values == wanted.tobytes(), one
    return "equal to the bit"


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    draw, told, size = random.Random(seed), Counter[str](), 0
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder, "text_fuzz")
        where = f"-I{Path(compiled.__file__).parent}"
        source = Path(__file__).with_suffix(".c")
        subprocess.run(
            [*compiler().command, *OPTIONS, where, str(source), "-o", str(program)], check=True
        )
        while time.monotonic() < end:
            blocks = [block(draw) for _ in range(AT_ONCE)]
            size += sum(len(one.text) for one in blocks)
            for one, answer in zip(blocks, answers(program, blocks), strict=True):
                told[judge(one, *answer)] += 1
    print(f"{told.total()} blocks, {size} bytes, seed {seed}: nothing out of bounds")
    for what, count in told.most_common():
        print(f"{what}: {count}")


if __name__ == "__main__":
    main()
