"""The paper's sensors, its three filters, and its hand-made parameters."""

from typing import Literal, TypeAlias, get_args

from filters import TiltKalman

DT = 0.05
SAMPLES = 480
ACC_VARIANCE = (1.68e-5, 1.67e-5, 1.68e-5)
"""Of the accelerometers at rest, g^2 (section 5); that of az is not printed, and taken as ax's."""
GYR_VARIANCE = (0.0032, 0.0040, 0.0031)
"""Of the gyroscopes at rest (section 5), in a unit that the paper does not give."""
AT_REST = {"M_theta": 0.733, "M_phi": 0.909}
"""Largest errors of the two-step filter in Experiment 1, deg (section 5)."""
HEURISTIC = {
    "q1": 1.0,
    "r_nom": 0.05,
    "r3": 1.0,
    "alpha1": 0.4,
    "alpha2": 10.0,
    "delta": 0.005,
    "r_big": 5.0,
}
"""Section 5: "rather heuristic choices based on trial-and-error"."""

GyroUnit: TypeAlias = Literal["deg/s", "rad/s"]
GYRO_UNITS: tuple[GyroUnit, ...] = get_args(GyroUnit)
STANDARD, SIMPLE, TWO_STEP = (
    TiltKalman(DT, "standard"),
    TiltKalman(DT, "simple"),
    TiltKalman(DT, "two-step"),
)
FILTERS = {"standard": STANDARD, "simple": SIMPLE, "two_step": TWO_STEP}
