"""The paper's values of the filter, and its units."""

from typing import NamedTuple

import numpy as np

GRAVITY = 32.17404
"""Ft/s^2."""
PER_HOUR = float(np.radians(1.0)) / 3600
"""1 deg/h in rad/s."""
MICRO = 1e-6 * GRAVITY
"""1 ug in ft/s^2."""
PUBLISHED = {"K1": 0.08, "K2": 0.0125, "Q_k": 2e-9, "R_k": 100.0, "threshold": 2.5e-3}
"""The filter's parameters as the paper prints them."""
PRINTED = 0.07
"""Relative rounding error of a gain with one printed digit, .08."""
MISREAD = (("K1", 0.05),)
"""K1 = .08 may be a misread .05, for which (15) holds with K2 = .0125."""


class TwoGains(NamedTuple):
    """Two gains, and the time constants that (15), K1 = 2/tau and K1 K2 = 1/tau^2, has for them."""

    K1: float = PUBLISHED["K1"]
    K2: float = PUBLISHED["K2"]

    @property
    def tau_of_K1(self) -> float:
        """Time constant from K1, s."""
        return 2 / self.K1

    @property
    def tau_of_K2(self) -> float:
        """In s."""
        return 1 / (2 * self.K2)

    @property
    def agree(self) -> bool:
        """Whether both time constants agree to the printed digits."""
        return abs(self.tau_of_K1 / self.tau_of_K2 - 1) <= PRINTED
