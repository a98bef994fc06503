"""A number that a study found beside its solutions: shown on the screen, kept in the result."""

from dataclasses import dataclass

from tuner.rounding import outward

_AS_WRITTEN = {"extra": "forbid"}
"""Read back from a result's JSON, it has these fields and no others."""


@dataclass(frozen=True)
class Finding:
    """One number that somebody takes from the run.

    Attributes:
        name: what it is called, "gyro.N".
        value: the number; None where there is none, and the meaning says why.
        unit: its unit, "" for none.
        meaning: what it is, and how it was found.
        low: lower 95 % limit; None where there is none.
        high: upper 95 % limit; None where there is none.
    """

    __pydantic_config__ = _AS_WRITTEN

    name: str
    value: float | None
    unit: str
    meaning: str
    low: float | None = None
    high: float | None = None

    @property
    def limits(self) -> str:
        """The 95 % limits as text, rounded outward; one alone where the other is not known.

        >>> Finding("K", 0.1, "", "", high=0.3).limits
        'below 0.3'
        """
        low, high = outward(self.low, self.high, 4)
        if low is not None and high is not None:
            return f"{low:.4g} to {high:.4g}"
        if high is not None:
            return f"below {high:.4g}"
        return "" if low is None else f"above {low:.4g}"
