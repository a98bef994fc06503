"""Reading MAT v5 within bounds: on a damaged file scipy's reader can end the whole process."""

import math
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_CHAR, _DOUBLE, _UINT8 = 4, 6, 9  # classes of matrices; MATLAB's logical is the last
_MAX_BYTES = 1 << 28
# MATLAB packs the numbers of a double matrix into the smallest of these that holds them.
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
_TEXTS = {2: "latin-1", 4: "utf-16-native", 16: "utf-8", 17: "utf-16-native"}


def variables(data: bytes) -> tuple[dict[str, NDArray[np.float64]], dict[str, str]]:
    """The matrices and texts of a MAT v5 file; what is neither double nor byte is passed over.

    Raises:
        ValueError: one sentence, where the file is damaged or none of this kind.
        struct.error: where a size in it cannot be read.
        zlib.error: where a compressed variable is damaged.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[_HEADER - 2 : _HEADER])
    if order is None:
        raise ValueError("it has no header of a MAT v5 file")
    matrices: dict[str, NDArray[np.float64]] = {}
    texts: dict[str, str] = {}
    for body in _variables(data[_HEADER:], order):
        (_, flags), (_, sizes), (_, name), *rest = _elements(body, order)
        kind = struct.unpack_from(f"{order}I", flags)[0] & 0xFF
        if kind in (_DOUBLE, _UINT8):
            matrices[name.decode()] = _matrix(sizes, rest, order)
        elif kind == _CHAR:
            texts[name.decode()] = _text(rest, order)
    return matrices, texts


def _variables(data: bytes, order: str) -> Iterator[bytes]:
    """The bodies of the variables, compressed ones unpacked."""
    for kind, body in _elements(data, order):
        if kind == _COMPRESSED:
            unpacked = zlib.decompressobj().decompress(body, _MAX_BYTES)
            yield from _variables(unpacked, order)
        elif kind == _MATRIX:
            yield body


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """The elements that follow one another: the type and the bytes of each."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        at += 8
        if kind >> 16:  # a small element: size and type share four bytes, the data have the rest
            kind, size, at = kind & 0xFFFF, kind >> 16, at - 4
        body = data[at : at + size]
        if len(body) != size:
            raise ValueError("it ends too early")
        yield kind, body
        at += size
        if kind != _COMPRESSED:
            at += -at % 8


def _matrix(sizes: bytes, rest: list[tuple[int, bytes]], order: str) -> NDArray[np.float64]:
    shape = np.frombuffer(sizes, f"{order}i4").tolist()
    if len(rest) != 1 or rest[0][0] not in _NUMBERS:
        raise ValueError("it holds a matrix that is not of real numbers")
    kind, body = rest[0]
    numbers = np.frombuffer(body, order + _NUMBERS[kind]).astype(np.float64)
    if min(shape) < 0 or math.prod(shape) != numbers.size:
        raise ValueError("it holds a matrix with too many or too few numbers")
    return numbers.reshape(shape, order="F")


def _text(rest: list[tuple[int, bytes]], order: str) -> str:
    if len(rest) != 1 or rest[0][0] not in _TEXTS:
        raise ValueError("it holds a text of an unknown kind")
    kind, body = rest[0]
    return body.decode(_TEXTS[kind].replace("native", {"<": "le", ">": "be"}[order]))
