"""Checks of the settings: an attitude in flight, and a switch that can switch."""

import numpy as np

from filters import PiSample
from studies.you_lee.cases import Bench
from studies.you_lee.data import Flown
from studies.you_lee.flight import Trajectory
from studies.you_lee.paper import GRAVITY
from studies.you_lee.settings import Settings

MISSING = 0.1
"""Largest share of a run's samples without an attitude."""
FARTHEST = 0.2
"""Largest angle in a sample, rad, for the filter's sums to be accurate."""


def refuse(bench: Bench) -> None:
    """Refuse settings with meaningless results.

    Raises:
        ValueError: where the true flight turns too far in a sample, where it, or much of what the
            sensors show, has no accelerometer attitude, or where the velocity filter's switch
            never or always fires.
    """
    for name, flight in bench.flights.items():
        _turn(bench.settings, name, flight)
        _attitude(bench.settings, name, flight)
    missing, low, high = np.concatenate([_of(shown) for shown in bench.shown()], axis=1)
    _enough_attitudes(missing)
    _switch(bench.settings.threshold, low, high)


def _of(shown: PiSample) -> np.ndarray:
    """Share of samples without arc sine, least and largest rate of k runs, (3, k)."""
    size = np.linalg.norm(np.asarray(shown.gyr), axis=2)
    return np.stack([_missing(shown), size.min(axis=0), size.max(axis=0)])


def _turn(settings: Settings, name: Trajectory, flight: Flown) -> None:
    """Refuse turns too fast for (2), which is summed with the rates at mid-sample."""
    fastest = float(np.linalg.norm(np.asarray(flight.sensed.rate), axis=1).max())
    if fastest * settings.dt > FARTHEST:
        raise ValueError(
            f"{name} turns with up to {fastest:.3g} rad/s, {fastest * settings.dt:.3g} rad in a "
            f"sample, at {settings.speed:g} ft/s; give a higher speed or rate_hz, or a longer ramp"
        )


def _attitude(settings: Settings, name: Trajectory, flight: Flown) -> None:
    """Refuse flights on which (10) or (14) has no arc sine for exact sensors."""
    force, velocity = np.asarray(flight.sensed.force), np.asarray(flight.sensed.velocity)
    p, q, r = np.asarray(flight.sensed.rate).T
    for equation, share in (("(10)", 0.0), ("(14)", 1.0)):
        u, v, w = velocity[:, 0], share * velocity[:, 1], share * velocity[:, 2]
        along = (force[:, 0] + r * v - q * w) / GRAVITY
        level = np.sqrt(np.clip(1 - along**2, 1e-12, None))
        across = (r * u - p * w - force[:, 1]) / (GRAVITY * level)
        # Where pitch has no arc sine, roll is not defined.
        both = np.where(np.abs(along) < 1, np.maximum(np.abs(along), np.abs(across)), np.abs(along))
        if not both.max() < 1:
            t = settings.dt * (int(np.argmax(both >= 1)) + 0.5)
            raise ValueError(
                f"on {name} {equation} needs the arc sine of {both.max():.3g} from {t:.4g} s on; "
                "give a smaller bank, tilt or speed, or a longer ramp"
            )


def _missing(shown: PiSample) -> np.ndarray:
    """Share of the samples in which (10) has no arc sine, ``(k,)``."""
    force, rate = np.asarray(shown.acc), np.asarray(shown.gyr)
    along = force[..., 0] / GRAVITY
    level = np.sqrt(np.clip(1 - along**2, 1e-12, None))
    across = (rate[..., 2] * np.asarray(shown.airspeed) - force[..., 1]) / (GRAVITY * level)
    share = (np.maximum(np.abs(along), np.abs(across)) >= 1).mean(axis=0)
    return np.asarray(share)


def _enough_attitudes(missing: np.ndarray) -> None:
    """Refuse runs with too large a share of samples without arc sine, ``(k,)``."""
    if missing.max() > MISSING:
        raise ValueError(
            f"in {100 * missing.max():.3g} % of a run's samples (10) would take the arc sine of a "
            "number above 1; give smaller errors of the sensors"
        )


def _switch(threshold: float, low: np.ndarray, high: np.ndarray) -> None:
    """Refuse a threshold beyond the least or largest measured rate of a run."""
    shown = f"the gyroscopes show {low.min():.3g} to {high.max():.3g} rad/s on this flight"
    for wrong, word, way in (
        (high <= threshold, "never", "lower"),
        (low > threshold, "always", "higher"),
    ):
        if wrong.any():
            raise ValueError(
                f"a switch at {threshold:g} rad/s {word} fires in {wrong.sum()} of "
                f"{len(low)} runs: {shown}; give a {way} threshold"
            )
