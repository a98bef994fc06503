"""A simulated flight that an INS filter's own steps describe exactly, and recordings of it."""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from filters import InsSample

G = 9.80665
FIELD = np.array([0.0, 20.0, -43.0])
"""uT in earth axes: north, and down by 65 deg."""
UP = np.array([0.0, 0.0, 1.0])


class Flight(NamedTuple):
    """A known motion in enu; rate and force lead to each sample from the one before."""

    dt: float
    attitude: Rotation
    velocity: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray


@cache
def flight(N=600, dt=0.05):
    """Turns and pushes of several frequencies, from rest."""
    t = dt * np.arange(N)[:, None]
    rate = np.array([0.3, 0.25, 0.2]) * np.sin(t * [0.7, 0.9, 0.3] + [0.0, 1.0, 2.0])
    push = np.array([1.5, 1.0, 0.7]) * np.sin(t * [0.5, 0.8, 0.6] + [0.5, 0.0, 1.0])
    attitude = [Rotation.from_euler("XYZ", [0.1, 0.05, 0.7])]
    force = [attitude[0].inv().apply(G * UP)]
    v, p = [np.zeros(3)], [np.zeros(3)]
    for k in range(1, N):
        half = Rotation.from_rotvec(rate[k] * dt / 2)
        middle = attitude[-1] * half
        force.append(middle.inv().apply(push[k] + G * UP))
        attitude.append(middle * half)
        v.append(v[-1] + push[k] * dt)
        p.append(p[-1] + (v[-1] + v[-2]) / 2 * dt)
    whole = Rotation.concatenate(attitude)
    return Flight(dt, whole, np.array(v), np.array(p), rate, np.array(force))


class Truth(NamedTuple):
    """What a noisy recording of the flight hides."""

    attitude: Rotation
    velocity: np.ndarray
    position: np.ndarray
    gyr_bias: np.ndarray
    acc_bias: np.ndarray
    heading: float


def recorded(rng, noise, every=(10, 10, 5, 4, 5)):
    """All channels, as noisy as the filter believes, and the start as uncertain.

    Args:
        rng: numpy's generator.
        noise: the filter's parameters by name.
        every: samples from one to the next of gps, gps_vel, baro, speed and mag.
    """
    f, n = flight(), noise
    N, dt = len(f.rate), f.dt
    white = rng.normal

    def walk(q, start):
        steps = white(size=(N, 3)) * np.sqrt(q * dt)
        steps[0] = start * white(size=3)
        return np.cumsum(steps, axis=0)

    gyr_bias = walk(n["q_gyr_bias"], n["gyr_bias0"])
    acc_bias = walk(n["q_acc_bias"], n["acc_bias0"])
    v0, p0 = n["velocity0"] * white(size=3), 100 * white(size=3)
    velocity, position = f.velocity + v0, f.position + p0 + v0 * dt * np.arange(N)[:, None]
    # A bias walks from one sample to the next: it is the one before that spoils a sample.
    gyr = f.rate + np.vstack([gyr_bias[:1], gyr_bias[:-1]])
    gyr += white(size=(N, 3)) * np.sqrt(n["q_gyr"] / dt)
    acc = f.force + np.vstack([acc_bias[:1], acc_bias[:-1]])
    acc += white(size=(N, 3)) * np.sqrt(n["q_acc"] / dt)
    acc[0], heading = _begun(f.attitude[0], white(size=3), n)
    gps = position + white(size=(N, 3)) * np.sqrt([n["R_gps"], n["R_gps"], n["R_gps_up"]])
    vel = velocity + white(size=(N, 3)) * np.sqrt(n["R_gps_vel"])
    baro = position[:, 2] + white(size=N) * np.sqrt(n["R_baro"])
    speed = f.attitude.inv().apply(velocity)[:, 0] + white(size=N) * np.sqrt(n["R_speed"])
    twist = Rotation.from_rotvec(np.outer(white(size=N) * np.sqrt(n["R_mag"]), UP))
    mag = f.attitude.inv().apply(twist.apply(FIELD))
    aiding = zip((gps, vel, baro, speed, mag), every, strict=True)
    thinned = [_now_and_then(values, k) for values, k in aiding]
    truth = Truth(f.attitude, velocity, position, gyr_bias, acc_bias, heading)
    return InsSample(gyr, acc, *thinned, np.zeros(N)), truth


def _begun(attitude, white, n):
    """A first force that makes the filter begin as wrong as it believes, and such a heading."""
    error = Rotation.from_rotvec(white * [n["tilt0"], n["tilt0"], n["heading0"]])
    begun = error.inv() * attitude
    force = begun.inv().apply(G * UP)
    shortest, _ = Rotation.align_vectors(UP, force)
    turn = (begun * shortest.inv()).as_rotvec()
    return force, np.pi / 2 - turn[2]


def _now_and_then(values, every, first=1):
    thinned = np.full_like(values, np.nan)
    thinned[first::every] = values[first::every]
    return thinned
