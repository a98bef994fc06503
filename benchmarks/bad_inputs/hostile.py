"""Malicious files: bombs, deep nesting, false headers, and entries that are not files."""

import gzip
import io
import struct
import zipfile
import zlib
from collections.abc import Iterator

from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.logs import mat, text
from benchmarks.bad_inputs.mutate import Random

_MIB = bytes(1 << 20)
_RUN = ("run", "kownacki2010", "--map", "omega=gx", "--rate", "100", "--dry-run", "--log")


def npy(shape: str, dtype: str = "<f8") -> bytes:
    """The header of an array with this type and shape."""
    head = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}}}".encode()
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head


def repeated(head: bytes, body: bytes, times: int, window: int) -> bytes:
    """Deflated bytes of a repeated part, packed once: a full flush forgets what came before."""
    packer = zlib.compressobj(9, zlib.DEFLATED, window)
    first = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH)
    again = packer.compress(body) + packer.flush(zlib.Z_FULL_FLUSH)
    return first + again * times + packer.flush()


def packed(name: str, head: bytes, mebibytes: int) -> bytes:
    """A zip file whose member unpacks to this many MiB of zeros; its checksum is wrong."""
    data, size = repeated(head, _MIB, mebibytes, -15), len(head) + (mebibytes << 20)
    entry = struct.pack("<HHHHHIIIHH", 20, 0, 8, 0, 33, 0, len(data), size, len(name), 0)
    local = b"PK\x03\x04" + entry + name.encode() + data
    central = b"PK\x01\x02\x14\x00" + entry + struct.pack("<HHHII", 0, 0, 0, 0, 0) + name.encode()
    end = struct.pack("<HHHHIIH", 0, 0, 1, 1, len(central), len(local), 0)
    return local + central + b"PK\x05\x06" + end


def gz(head: bytes, body: bytes, times: int) -> bytes:
    """A gzip file that repeats something."""
    return repeated(head, body, times, 31)


def matrix(kind: int, shape: tuple[int, ...], *inside: bytes) -> bytes:
    """A matrix of MAT v5."""

    def element(kind: int, body: bytes) -> bytes:
        return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)

    sizes = element(5, struct.pack(f"<{len(shape)}i", *shape))
    flags = element(6, struct.pack("<II", kind, 0))
    return element(14, flags + sizes + element(1, b"x") + b"".join(inside))


def mat_of(body: bytes) -> bytes:
    """A MAT file of one element."""
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + body


def mat_bomb(mebibytes: int, stored: int) -> bytes:
    """A packed matrix of zeros, each number one byte or eight."""
    size = mebibytes << 20
    numbers = struct.pack("<II", stored, size)
    plain = matrix(6, (1, size // (8 if stored == 9 else 1)), numbers)
    whole = plain[:4] + struct.pack("<I", len(plain) - 8 + size) + plain[8:]
    squeezed = repeated(whole, _MIB, mebibytes, 15)
    return mat_of(struct.pack("<II", 15, len(squeezed)) + squeezed)


def nested(depth: int) -> bytes:
    """Cells in cells."""
    inner = matrix(6, (1, 1), struct.pack("<II", 9, 8) + bytes(8))
    for _ in range(depth):
        inner = matrix(1, (1, 1), inner)
    return mat_of(inner)


def many(names: int) -> bytes:
    """A zip file of very many members."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for number in range(names):
            archive.writestr(f"{number}.npy", b"")
    return stream.getvalue()


def files() -> Iterator[tuple[str, str, bytes]]:
    """Hostile logs, each with its kind and its name."""
    for shape in ("(True,)", "(-1,)", "(2**70,)", "(10**15,)", "('a',)", "(1.5,)", "()", "(0,)",
                  "(3, 0)", "(" + "1, " * 70 + ")", "[" * 400):  # fmt: skip
        for dtype in ("<f8", "|O", "<U99999999", "<c16", "|V8", "<M8[ns]", "|S0"):
            stream = io.BytesIO()
            with zipfile.ZipFile(stream, "w") as archive:
                archive.writestr("gx.npy", npy(shape, dtype) + bytes(80))
            yield "claim: npz", "log.npz", stream.getvalue()
    shape = f"({3 << 27},)"
    yield "bomb: npz", "log.npz", packed("gx.npy", npy(shape), 3 << 10)
    yield "bomb: zip", "log.zip", packed("a.csv", b"t,gx\n", 2 << 10)
    yield "bomb: gz, one line", "log.csv.gz", gz(b"t,gx\n", b" " * (1 << 20), 1500)
    yield "bomb: gz, lines", "log.csv.gz", gz(b"t,gx\n", b"0,1\n" * (1 << 18), 1500)
    yield "bomb: gz in gz", "log.csv.gz", gzip.compress(gzip.compress(text()))
    for stored in (9, 2):
        yield "bomb: mat", "log.mat", mat_bomb(300, stored)
    for depth in (20, 30, 3000):
        yield "nest: mat", "log.mat", nested(depth)
    yield "claim: mat", "log.mat", mat_of(matrix(6, (1 << 30, 1 << 30), struct.pack("<II", 9, 8)))
    yield "many: zip", "log.zip", many(3_000)
    yield "one byte", "log.csv", b"1"
    yield "nothing", "log.csv", b""
    yield "zeros", "log.csv", bytes(1 << 16)
    yield "wide", "log.csv", b",".join([b"1"] * 200_000) + b"\n"
    yield "names", "log.csv", b"t,gx\x1b[2J,\xff,=cmd()\n" + b"0,1,2,3\n1,2,3,4\n"
    yield "big numbers", "log.csv", b"t,gx\n" + b"".join(b"%d,1e308\n" % k for k in range(90))
    yield "pickle", "log.npy", b"\x80\x04\x95" + bytes(40)
    yield "mat, cut", "log.mat", mat()[:150]


def cases(random: Random) -> Iterator[Case]:
    """Each of them once, then endless entries that are not files, in every place for a file."""
    for kind, name, data in files():
        yield Case(kind, ["columns", name], {name: data})
        if not kind.startswith("claim"):
            yield Case(kind, [*_RUN, name], {name: data})
    places = [
        ["columns", "x"], [*_RUN, "x"], ["run", "x.toml"], ["compare", "x"], ["check", "x"],
        ["export", "x", "--to", "json"], ["fit", "x", "--filter", "local-level", "--map", "z=gx"],
        ["fit", "good.csv", "--model", "x", "--map", "z=gx"],
        ["fit", "good.csv", "--filter", "x.py:C", "--map", "z=gx"],
        ["run", "kownacki2010", "--out", "x", "--dry-run"], ["run", "x.toml", "--resume"],
        ["compare", "x/result.json"], ["init", "-o", "x"],
    ]  # fmt: skip
    special = ("fifo", "folder", "loop", "device", "locked")
    while True:
        words = places[int(random.integers(len(places)))]
        name = next(w.partition(":")[0].partition("/")[0] for w in words if w.startswith("x"))
        kind = special[int(random.integers(len(special)))]
        yield Case(f"no file: {kind}", words, {"good.csv": text()}, {name: kind})
