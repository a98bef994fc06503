"""Records whose noise is known: by plain NumPy, many at once."""

from typing import Literal, get_args

import numpy as np

Noise = Literal["white", "coloured", "student 6", "student 4"]
NOISES: tuple[Noise, ...] = get_args(Noise)
COLOUR = 0.6
"""Correlation from sample to sample of coloured noise."""


def noise(rng: np.random.Generator, shape: tuple[int, int], kind: Noise) -> np.ndarray:
    """Noise of variance 1, ``(records, N)``; Student's of 6 or of 4 degrees of freedom."""
    if kind in ("student 6", "student 4"):
        freedom = int(kind[-1])
        heavy: np.ndarray = rng.standard_t(freedom, shape) * np.sqrt((freedom - 2) / freedom)
        return heavy
    drawn = rng.standard_normal(shape)
    if kind == "coloured":
        for k in range(1, shape[1]):
            drawn[:, k] = COLOUR * drawn[:, k - 1] + np.sqrt(1 - COLOUR**2) * drawn[:, k]
    return drawn


def local_levels(
    rng: np.random.Generator, count: int, length: int, q: float, R: float, kind: Noise = "white"
) -> np.ndarray:
    """A random walk and noise, ``(count, length)``; one sample per second."""
    level = np.sqrt(q) * rng.standard_normal((count, length)).cumsum(axis=1)
    return np.asarray(level + np.sqrt(R) * noise(rng, (count, length), kind))


def tracks(
    rng: np.random.Generator, count: int, length: int, q: float, R: float, kind: Noise = "white"
) -> np.ndarray:
    """Positions of a velocity that white noise changes, ``(count, length)``, one per second."""
    factor = np.linalg.cholesky(q * np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]]))
    pushes = rng.standard_normal((count, length, 2)) @ factor.T
    velocity = pushes[..., 1].cumsum(axis=1)
    moved = pushes[..., 0].copy()
    moved[:, 1:] += velocity[:, :-1]
    return np.asarray(moved.cumsum(axis=1) + np.sqrt(R) * noise(rng, (count, length), kind))


STEP, GRAVITY = 0.05, 9.81
"""A pendulum of 1 m, twenty samples per second."""
START, SPREAD = np.array([0.6, 0.0]), 0.05


def pendulums(rng: np.random.Generator, count: int, length: int, q: float, R: float) -> np.ndarray:
    """Sideways positions of pendulums that noise of density q accelerates, ``(count, length)``."""
    angle, rate = (START + SPREAD * rng.standard_normal((count, 2))).T
    seen = np.empty((count, length))
    for k in range(length):
        angle, rate = angle + STEP * rate, rate - STEP * GRAVITY * np.sin(angle)
        rate = rate + np.sqrt(q * STEP) * rng.standard_normal(count)
        seen[:, k] = np.sin(angle) + np.sqrt(R) * rng.standard_normal(count)
    return seen


def pseudo_true(filter: Literal["level", "track"], q: float, R: float, kind: Noise) -> np.ndarray:
    """The maximum of the white-noise likelihood in an infinite record: ``(ln q, ln R)``.

    Only spectra matter (Whittle 1953): of the first differences of a local level, q + R |D|^2, and
    of the second ones of a track, q (2 + cos w) / 3 + R |D|^4, with |D|^2 = 2 - 2 cos w. The
    minimum of the mean of ln s + s0 / s over all frequencies w is the pseudo-true spectrum s.
    """
    from scipy.optimize import minimize

    w = (np.arange(4000) + 0.5) * np.pi / 4000
    square = 2 - 2 * np.cos(w)
    moving = np.ones_like(w) if filter == "level" else (2 + np.cos(w)) / 3
    seen = square if filter == "level" else square**2
    colour = COLOUR if kind == "coloured" else 0.0
    shape = (1 - colour**2) / (1 + colour**2 - 2 * colour * np.cos(w))
    true = q * moving + R * shape * seen

    def distance(z: np.ndarray) -> float:
        s = np.exp(z[0]) * moving + np.exp(z[1]) * seen
        return float(np.mean(np.log(s) + true / s))

    options = {"xatol": 1e-9, "fatol": 1e-14, "maxiter": 4000}
    begin = np.log([q, R])
    return np.asarray(minimize(distance, begin, method="Nelder-Mead", options=options).x)


NILE = np.array(
    [
        [1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140],
        [995, 935, 1110, 994, 1020, 960, 1180, 799, 958, 1140],
        [1100, 1210, 1150, 1250, 1260, 1220, 1030, 1100, 774, 840],
        [874, 694, 940, 833, 701, 916, 692, 1020, 1050, 969],
        [831, 726, 456, 824, 702, 1120, 1100, 832, 764, 821],
        [768, 845, 864, 862, 698, 845, 744, 796, 1040, 759],
        [781, 865, 845, 944, 984, 897, 822, 1010, 771, 676],
        [649, 846, 812, 742, 801, 1040, 860, 874, 848, 890],
        [744, 749, 838, 1050, 918, 986, 797, 923, 975, 815],
        [1020, 906, 901, 1170, 912, 746, 919, 718, 714, 740],
    ],
    float,
).ravel()
"""Yearly flow of the Nile at Aswan, 1871 to 1970, 10^8 m^3 (Durbin and Koopman 2012, 2.2)."""
