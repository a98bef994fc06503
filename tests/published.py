"""Numbers of Kownacki 2010 and of its independent recalculation, which ours have to reproduce.

The signal D1 is deterministic, so that every implementation filters the same samples.
"""

import numpy as np
import pytest

T = 1e-4
STEP = 0.2

# R and Q: tables 1 and 2 of the paper
ACC_1, ACC_2 = (1.8472e-4, 1.1859e-8), (5.8631e-13, 1.3458e-11)
GYRO_1, GYRO_2 = (1.3872e-6, 2.4907e-9), (1.9148e-10, 1.9674e-7)


def as_printed(text):
    """Equal to a printed number in all digits given: within half a unit of the last one."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    half = 0.5 * 10.0 ** (int(exponent or 0) - decimals)
    return pytest.approx(float(text), rel=0, abs=half * (1 + 1e-9))


def step_signal(samples, at):
    return STEP * (np.arange(samples) >= at)


def d1_noise():
    k = np.arange(20001)
    return 1e-3 * np.sin(2 * np.pi * 50 * k * T) + 5e-4 * np.sin(2 * np.pi * 333 * k * T + 1)


def d1_step():
    return step_signal(20001, 5000)
