"""A key of a firmware's file."""

from dataclasses import dataclass
from typing import Literal

from tuner.firmware.amount import Amount, Read, density, deviation

Kind = Literal["density", "step", "deviation"]


@dataclass(frozen=True)
class Key:
    """A parameter of a firmware that is the size of a noise.

    Attributes:
        name: in the firmware.
        unit: of the noise: of its number, but for a density.
        kind: ``density``: the root N of a density, in unit/sqrt(Hz); ``step``: N / sqrt(T), the
            deviation of what is constant over a prediction of T seconds; ``deviation``: of a
            measurement.
        low: least number that the firmware takes.
        high: greatest one.
        export: its meaning, as findings call it; "" where no filter declares it.
        note: the firmware's further use of it.
    """

    name: str
    unit: str
    kind: Kind
    low: float = 0.0
    high: float = float("inf")
    export: str = ""
    note: str = ""

    def of(self, amount: Amount, T: float) -> Read | None:
        """The number for an amount; None where units contradict it.

        Args:
            amount: the size of the noise.
            T: time of a prediction, s.
        """
        if self.kind == "deviation":
            return deviation(amount, self.unit)
        read = density(amount, self.unit)
        if read is None or self.kind == "density":
            return read
        return Read(read.value / T**0.5, f"{read.how} / sqrt({T:.6g} s)")

    @property
    def measured_in(self) -> str:
        """The unit of the number."""
        return f"{self.unit}/sqrt(Hz)" if self.kind == "density" else self.unit

    @property
    def ends(self) -> str:
        """The range that the firmware takes, as text."""
        if self.high == float("inf"):
            return f"{self.low:g} and more"
        return f"{self.low:g} to {self.high:g}"
