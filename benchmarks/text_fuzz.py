"""Fuzzed text logs for the reader in C: python -m benchmarks.text_fuzz [SECONDS] [SEED].

The reader is compiled with the sanitizers of addresses and of undefined behaviour, which end it
at the first byte out of bounds, and gets each block in memory of exactly its size. Numbers are
those of Python to the bit, and what is no plain number, by a regular expression, is none. Nothing
is compared where a block is left to another reader; how many of those are plain is printed.
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

from tuner.data.logs import compiled

NUMBER = re.compile(rb"-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
OPTIONS = ("-std=gnu11", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
LETTERS = b"0123456789" * 3 + b"....---++eE,,\n\n \t\0\xff/:"
AT_ONCE, MOST = 400, 2**53
FOUND, NOT_PLAIN, IN_DOUBT = range(3)


@dataclass(frozen=True)
class Block:
    """A text, with the rows and the width that are asked for."""

    text: bytes
    delimiter: bytes
    rows: int
    width: int


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
    lambda draw: f"0.{'0' * draw.randint(0, 30)}{draw.getrandbits(draw.randint(1, 63))}",
    lambda draw: f"{draw.randint(2**50, 2**53) / 2 ** draw.randint(1, 3):.2f}5",
    lambda draw: draw.choice(ODD),
)
"""Ways to write plain numbers, many of which are hard to round."""


def block(draw: random.Random) -> Block:
    """A block of plain numbers, of which half are damaged."""
    delimiter = draw.choice(",;\t| ")
    width, rows = draw.choice([1, 1, 2, 3, 10, 40]), draw.choice([0, 1, 2, 5, 30])
    kinds = draw.sample(KINDS, draw.choice([1, 2, 3]))
    lines = [delimiter.join(draw.choice(kinds)(draw) for _ in range(width)) for _ in range(rows)]
    text = bytearray("".join(f"{line}\n" for line in lines).encode())
    if draw.randrange(2):
        for _ in range(draw.choice([1, 1, 2, 8])):
            damage(draw, text)
    asked = text.count(b"\n")
    if not draw.randrange(20):
        asked, width = draw.randint(0, 60), draw.randint(0, 60)
    return Block(bytes(text), delimiter.encode(), asked, width)


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


def right(one: Block) -> np.ndarray | None:
    """The numbers by Python, ``(width, rows)``; None where they are not plain."""
    lines = one.text.split(b"\n")
    if lines.pop() or not one.text or len(lines) != one.rows:
        return None
    rows = [line.split(one.delimiter) for line in lines]
    if any(len(row) != one.width for row in rows):
        return None
    if not all(NUMBER.fullmatch(cell) for row in rows for cell in row):
        return None
    values = np.array([[float(cell) for cell in row] for row in rows]).T
    return None if (np.abs(values) >= MOST).any() else np.ascontiguousarray(values)


def answers(program: Path, blocks: list[Block]) -> list[tuple[int, bytes]]:
    """Status and numbers of each block.

    Raises:
        RuntimeError: with what a sanitizer says.
    """
    heads = (struct.pack("4Q", len(b.text), b.delimiter[0], b.rows, b.width) for b in blocks)
    asked = b"".join(head + b.text for head, b in zip(heads, blocks, strict=True))
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
        size = 8 * one.rows * one.width if status == FOUND else 0
        found.append((status, ran.stdout[at + 1 : at + 1 + size]))
        at += 1 + size
    return found


def judge(one: Block, status: int, values: bytes) -> str:
    """A word for what was done with a block.

    Raises:
        AssertionError: where it was wrong.
    """
    wanted = right(one)
    if status == IN_DOUBT:
        return "left to another reader" if wanted is None else "plain, left to another reader"
    if status == NOT_PLAIN:
        assert wanted is None, one
        return "not plain"
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
        subprocess.run(["cc", *OPTIONS, where, str(source), "-o", str(program)], check=True)
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
