"""The origin of data: the name and the digest in results and exports."""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from tuner.data.logs.blocks import Blocks
from tuner.files import opened

_LARGE = 1 << 20
"""Bytes of a file from which a thread of its own is worth its start."""
_AS_WRITTEN = {"extra": "forbid"}
"""A result's JSON has these fields of it and no others."""


@dataclass(frozen=True)
class Source:
    """The data on which a problem was tuned.

    Attributes:
        name: the file's name, or that of the simulated data.
        sha256: of the file's bytes, or of the simulated samples and their rate; of the model
            where there are none.
        samples: number of samples; 0 for a design, which needs none.
        rate_hz: sample rate; 0 for a design, and where sample times vary.
    """

    __pydantic_config__ = _AS_WRITTEN

    name: str
    sha256: str
    samples: int
    rate_hz: float

    @classmethod
    def simulated(cls, name: str, made: Sequence[np.ndarray], rate_hz: float) -> "Source":
        """The source of simulated records.

        Args:
            name: what was simulated.
            made: one array ``(N, k, ...)`` or several, of k records of N samples each; a single
                record may be ``(N,)``.
            rate_hz: sample rate.

        Raises:
            ValueError: where there is no record.

        >>> Source.simulated("two steps", [np.zeros((500, 2, 3))], 100.0).samples
        1000
        """
        if not made:
            raise ValueError(f"{name}: there are no records to name")
        digest = _digest((rate_hz, *made))
        return cls(name, digest, int(np.prod(made[0].shape[:2])), rate_hz)

    @classmethod
    def joined(cls, name: str, parts: Iterable["Source"]) -> "Source":
        """Several sources as one, at the rate of the first, in their order; one stays as it is.

        Raises:
            ValueError: where there is none.

        >>> parts = [Source.simulated(name, [np.ones(5)], 10.0) for name in "ab"]
        >>> Source.joined("both", parts).samples
        10
        """
        known = tuple(parts)
        if not known:
            raise ValueError(f"{name}: there are no sources to join")
        if len(known) == 1:
            return known[0]
        digest = _digest((part.sha256, part.samples, part.rate_hz) for part in known)
        return cls(name, digest, sum(part.samples for part in known), known[0].rate_hz)

    @classmethod
    def model(cls, name: str, numbers: Iterable[object], rate_hz: float = 0.0) -> "Source":
        """A model without data, by its numbers: arrays, and objects whose text is complete.

        >>> one, other = (Source.model("gain", [np.array([1.0 + e])]) for e in (0.0, 1e-12))
        >>> one.sha256 == other.sha256
        False
        """
        return cls(name, _digest(numbers), 0, rate_hz)


def file_digest(path: Path) -> str:
    """The SHA-256 of a file's bytes; of a folder that of the names and digests of its files."""
    if path.is_dir():
        files = sorted(file for file in path.rglob("*") if file.is_file())
        entries = [f"{file.relative_to(path).as_posix()} {file_digest(file)}\n" for file in files]
        return hashlib.sha256("".join(entries).encode()).hexdigest()
    with opened(path) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextmanager
def file_digests(
    paths: Sequence[Path], blocks: Sequence[Blocks | None] | None = None
) -> Iterator[list[Callable[[], str]]]:
    """Functions that give the digests of files: of large ones a thread computes them meanwhile.

    Args:
        paths: the files.
        blocks: for each, the blocks that its reader passes on, which are not read again.
    """
    shared = blocks or [None] * len(paths)
    pool = ThreadPoolExecutor(1)
    try:
        yield [_begun(pool, *one) for one in zip(paths, shared, strict=True)]
    finally:
        for one in shared:
            if one is not None:
                one.close()
        pool.shutdown(wait=False, cancel_futures=True)


def _begun(pool: ThreadPoolExecutor, path: Path, blocks: Blocks | None) -> Callable[[], str]:
    if not path.is_file() or path.stat().st_size < _LARGE:
        return cache(partial(file_digest, path))
    if blocks is None:
        return pool.submit(file_digest, path).result
    digest = pool.submit(_digest_along, path, blocks)

    def end() -> str:
        blocks.close()
        return digest.result()

    return end


def _digest_along(path: Path, blocks: Blocks) -> str:
    """The digest of a file of which blocks are read by another, the rest here."""
    digest = hashlib.sha256()
    with opened(path) as stream:
        for at, block in blocks:
            while stream.tell() < at and (before := stream.read(min(at - stream.tell(), _LARGE))):
                digest.update(before)
            if stream.tell() == at:
                digest.update(block)
                stream.seek(at + len(block))
        while rest := stream.read(_LARGE):
            digest.update(rest)
    return digest.hexdigest()


def _digest(parts: Iterable[object]) -> str:
    """A digest that differs where anything differs: numbers to the bit, shapes, order."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(_bytes(part))
    return digest.hexdigest()


def _bytes(part: object) -> bytes:
    """Bytes with their kind and length before them, so that 1, 23 is not 12, 3."""
    if isinstance(part, list | tuple):
        kind, own = "list", b"".join(map(_bytes, part))
    elif hasattr(part, "__array__") and np.ndim(part):
        array = np.asarray(part)
        kind, own = f"{array.dtype.str}{array.shape}", array.tobytes()
    else:
        kind, own = "text", repr(part.item() if hasattr(part, "item") else part).encode()
    return f"{kind}:{len(own)}:".encode() + own
