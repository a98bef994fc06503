"""Filters of six axes, without GPS, on the same flights, with parameters for a room."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from filters import (
    AnyFilter,
    BoundedMotionKalman,
    ImuSample,
    Mahony,
    SixAxes,
    assembled,
    parameter_facts,
    run,
)
from studies.uav.flights import Flight, Whole
from studies.uav.judging import Field
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Claim, Solutions

FLIP = np.array([1.0, -1.0, -1.0])
"""From axes forward, right, down to forward, left, up."""
REFERENCE = "root mean square against the autopilot's vertical where it moves, no truth"


class Use(NamedTuple):
    """A filter with its parameters.

    Attributes:
        label: its name in words.
        filter: the filter for a sample time, s.
        values: parameters that are not typical, by name.
    """

    label: str
    filter: AnyFilter
    values: dict[str, float]


def root_density(values: np.ndarray, dt: float) -> float:
    """Root of the density of a motion regarded as white noise, unit s^1/2.

    Of a signal with deviation s and correlation time T it is s sqrt(2 T): twice the integral of the
    autocovariance up to its first zero, of which the root is taken, root mean square of the axes.

    Args:
        values: about zero, ``(N, d)``; NaN is bridged.
        dt: sample time, s.
    """
    n = len(values)
    known = ~np.isnan(values).any(axis=1)
    at = np.flatnonzero(known)
    if len(at) < 2:
        raise ValueError(f"a motion's density takes 2 samples or more, not {len(at)}; give more")
    densities = []
    for column in values.T:
        whole = np.interp(np.arange(n), at, column[at])
        power = np.abs(np.fft.rfft(whole, 2 * n)) ** 2
        covariance = np.fft.irfft(power)[:n] / n
        end = int(np.argmax(covariance <= 0)) or n
        densities.append(2 * dt * (covariance[:end].sum() - covariance[0] / 2))
    return float(np.sqrt(np.mean(densities)))


def motion_noises(flight: Flight) -> dict[str, float]:
    """The bounded-motion filter's two noises from a flight's motion over ground, by its GPS."""
    ground = flight.position[:: flight.every, :2]
    dt = flight.every * flight.dt
    speed = np.gradient(ground, dt, axis=0)
    return {"speed": root_density(speed, dt), "place": root_density(ground, dt)}


def uses(flight: Flight) -> dict[str, Use]:
    """The filters compared with the autopilot; one with two noises by the motion of a flight."""
    bounded, found = BoundedMotionKalman(flight.dt), motion_noises(flight)
    values = ", ".join(f"{name} {value:.3g}" for name, value in found.items())
    return {
        "mahony": Use("Mahony, published gains", Mahony(flight.dt), {}),
        "bounded_room": Use("bounded motion, a room's noises", bounded, {}),
        "bounded_flown": Use(f"bounded motion, {values} by {flight.name}'s GPS", bounded, found),
    }


def inclination(use: Use, whole: Whole) -> np.ndarray:
    """Angle between the verticals of a filter and of the autopilot, deg, ``(N,)``."""
    values: dict[str, Any] = {
        name: fact.typical for name, fact in parameter_facts(use.filter).items()
    }
    params = jax.tree.map(jnp.asarray, assembled(use.filter, values | use.values))
    kind = ImuSample if isinstance(use.filter, Mahony) else SixAxes
    samples = kind(jnp.asarray(whole.force * FLIP), jnp.asarray(whole.rate * FLIP))
    out = _runs(use.filter, params, samples)[1]
    q = np.asarray(getattr(out, "att", out))
    up = Rotation.from_quat(q, scalar_first=True).inv().apply([0.0, 0.0, 1.0])
    pilot = Rotation.from_euler("ZYX", whole.reference[:, ::-1])  # type: ignore[index]
    theirs = -pilot.inv().apply([0.0, 0.0, 1.0]) * FLIP
    across = np.linalg.norm(np.cross(up, theirs), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, (up * theirs).sum(axis=1))))


_runs = jax.jit(run, static_argnums=0, compiler_options={"xla_backend_optimization_level": 1})


def rows(field: Field, solutions: Solutions) -> Iterator[Comparison]:
    """Each filter on each flight; the noises by motion are the tuned flight's."""
    known = uses(field.tuned)
    for flight in field.flights:
        whole = flight.whole
        if whole.reference is None or not whole.moves.any():
            for name, use in known.items():
                note = f"{use.label}; the autopilot's attitude is missing, or it never moves"
                quantity = f"uav.six_axes_deg.{name}.{flight.name}"
                yield undecided(quantity, "without GPS", unit="deg", note=note)
            continue
        moves = whole.moves
        found = {name: inclination(use, whole)[moves] for name, use in known.items()}
        errors = {name: float(np.sqrt((e**2).mean())) for name, e in found.items()}
        for name, error in errors.items():
            quantity = f"uav.six_axes_deg.{name}.{flight.name}"
            note = f"{known[name].label}; {REFERENCE}"
            if name == "mahony":
                where = "without GPS, within 5 deg of the autopilot's vertical"
                yield claim(quantity, where, error <= 5.0, ours=error, unit="deg", note=note)
                continue
            where = "without GPS, nearer to the autopilot's vertical than Mahony's filter"
            nearer = error < errors["mahony"]
            yield claim(quantity, where, nearer, ours=error, unit="deg", note=note)


CLAIM = Claim("uav.six_axes_deg.*", rows)
