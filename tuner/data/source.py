"""Where data come from: the name and the digest that stand in results and exports."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Source:
    """Which data a problem was tuned on.

    Attributes:
        name: the file's name, or what was made up instead.
        sha256: of the file's bytes or of the made-up samples; of the model where there are none.
        samples: how many samples; 0 for a design, which needs none.
        rate_hz: sample rate; 0 for a design, and where samples come at any time.
    """

    name: str
    sha256: str
    samples: int
    rate_hz: float

    @classmethod
    def simulated(cls, name: str, made: Sequence[np.ndarray], rate_hz: float) -> "Source":
        """Made-up records.

        Args:
            name: what was made up.
            made: one array ``(N, k, ...)`` or several, of k records of N samples each; a single
                record may be ``(N,)``.
            rate_hz: sample rate.

        >>> Source.simulated("two steps", [np.zeros((500, 2, 3))], 100.0).samples
        1000
        """
        digest = hashlib.sha256(b"".join(array.tobytes() for array in made)).hexdigest()
        return cls(name, digest, int(np.prod(made[0].shape[:2])), rate_hz)

    @classmethod
    def joined(cls, name: str, parts: Iterable["Source"]) -> "Source":
        """Several sources as one, at the rate of the first; in their order.

        >>> parts = [Source.simulated(name, [np.ones(5)], 10.0) for name in "ab"]
        >>> Source.joined("both", parts).samples
        10
        """
        known = tuple(parts)
        digest = hashlib.sha256("".join(part.sha256 for part in known).encode()).hexdigest()
        return cls(name, digest, sum(part.samples for part in known), known[0].rate_hz)

    @classmethod
    def model(cls, name: str, numbers: Iterable[object], rate_hz: float = 0.0) -> "Source":
        """A model without data, by the text of its numbers."""
        text = "".join(map(repr, numbers))
        return cls(name, hashlib.sha256(text.encode()).hexdigest(), 0, rate_hz)
