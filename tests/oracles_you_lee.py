"""Textbook loops in plain NumPy for You and Lee's mixing filter, and the numbers they must give.

Nothing here uses the project. Equation numbers are the paper's. Units: ft, s, rad, unless a name
says otherwise; body axes are forward, right, down. Angles are (roll, pitch); every error is the
filter's angle minus the true one, not wrapped.

Interval k = 0 .. N - 1 runs from t_k = k T to t_k+1. Arrays of sensors have a row per interval,
histories of angles N + 1 rows, the first one at t = 0. The readings that give the numbers, where
the paper leaves a choice:

* The sensors of interval k give the motion at its middle, t_k + T/2, the airspeed too; the
  airspeed is u = V_b[0], not the speed. Their errors are those of sample k. The error of row
  k + 1 is taken at t_k+1.
* (1) and (2) by explicit Euler: rates, differences phi_a - phi_m and the integral that enter
  interval k are those at t_k, so the angles move before the integral does. The integral starts
  at 0 and holds K1 K2 int(phi_a - phi_m). The angles start at the true ones.
* theta_a of (10) and (14) is that of the same interval; r, q, p in them are the gyroscopes'.
* Velocity filter, an interval in which it runs: x = Phi x + (I T + A T^2/2) b with
  Phi = I + A T + A^2 T^2/2, b of (11) with phi_m, theta_m at t_k; P = Phi P Phi^T + Q_k I, Q_k as
  it is, not times T; then the update with the airspeed of the same interval; then (14) with the
  updated x, its u included. With b T alone, or Phi T b, the numbers at t = 275 and 300 change in
  the third digit.
* It runs while the length of the measured [p, q, r] is above the threshold. The largest
  |component| gives the same digits; |r|, |p| or |q| alone do not.
* While it is held, u is the airspeed, v, w and P stay, and (14) is used all the same: with v, w
  not 0 the level part differs from (10).
* x starts from the true u (never used: the first interval is held) and v, w = 0 or true, P from 0.
  R_k = 100 and Q_k = 2e-9 leave the filter a dead reckoning: P11 ends at 1e-5.
* A random walk b_k + sqrt(S T) n has its initial value in interval 0.
* The RMS over the whole time is the root of the mean of roll^2 + pitch^2 over 0 .. 300 s and runs.

Every digit of D1 comes out. It does not tell the length from the largest |component| in the
switch, nor whether the velocity is updated before or after its time update. The Monte Carlo
numbers come from unknown seeds and stand within 15 %. The worst run of 100 varies most: .66 ..
.99 deg of roll in four seeds.

The optima of the whole RMS are those of one sample: other samples of 100 runs give .404 +- .013
at tau = 50 s and .384 +- .012 at the free gains below. Their own free minimum is at K1 = .0241 +-
.0010, K2 = .0315 +- .0015, lower by .2 %: flat. Roll alone gives .350 and .337, the mean of the
two angles' squares .286 and .272.
"""

import math
from typing import NamedTuple

import numpy as np

T = 0.01  # s
LEVEL, TURN, RAMP = 250.0, 50.0, 5.0  # s; the ramps in and out are parts of the turn
N = round((LEVEL + TURN) / T)
V = 500.0  # ft/s
G = 32.17404  # ft/s^2
DEGREE = math.pi / 180
DEGREE_PER_HOUR = DEGREE / 3600
BANK = 28.5659947 * DEGREE  # turns 90 deg in the 50 s
TILT = 3 * DEGREE  # angle of attack of T1 in level flight; pitch and slip of T2 in the bank

GYR_BIAS = 50 * DEGREE_PER_HOUR  # 1 sigma at t = 0
ACC_BIAS = 140e-6 * G
GYR_DENSITY = (10 * DEGREE_PER_HOUR) ** 2 / 3600  # (rad/s)^2 / s
ACC_DENSITY = (35e-6 * G) ** 2 / 3600  # (ft/s^2)^2 / s
AIRSPEED_NOISE = 1.0  # ft/s, 1 sigma of a sample

K1, K2 = 0.08, 0.0125  # 1/s
THRESHOLD = 2.5e-3  # rad/s
Q_K = 2e-9  # (ft/s)^2
R_K = 100.0

TRAJECTORIES = ("T0", "T1", "T2")
CASES = ("gyro", "eq10", "kf")  # gyroscopes only; (1) with (10); (1) with (14) and the switch
STARTS = ("zero", "true")  # of v and w

# T1, `deterministic`: roll and pitch error in deg at t in s; kf from v = w = 0
D1 = {
    "gyro": {
        30: (".440110", ".415065"),
        250: ("3.76782", "3.35679"),
        275: ("5.42251", "-.478052"),
        300: ("3.96867", "-4.06060"),
    },
    "eq10": {
        30: (".354292", ".144460"),
        250: (".215287", ".0140159"),
        275: (".669490", ".396637"),
        300: ("-1.32856", ".669566"),
    },
    "kf": {
        30: (".354292", ".144460"),
        250: (".215287", ".0140159"),
        275: (".762957", ".0397428"),
        300: ("-.724998", ".327288"),
    },
}

# T1, 100 runs, in deg: `level_rms` of roll, pitch and `turn_maximum` of roll, pitch
MONTE_CARLO = {
    ("gyro", None): ((2.45, 2.11), (4.62, 4.68)),
    ("eq10", None): ((0.229, 0.0488), (1.849, 0.888)),
    ("kf", "zero"): ((0.229, 0.0488), (1.653, 0.595)),
    ("kf", "true"): (None, (0.376, 0.174)),
}
MONTE_CARLO_TOLERANCE = 0.15
BEST_TAU = (50.0, 0.390)  # s; `whole_rms` in deg, eq10 on T1
BEST_GAINS = ((0.0253, 0.0269), 0.3765)  # K1, K2
LEVEL_FLOOR = ".2155"  # deg, of roll on T1 for 50 deg/h: `level_floor`
WORST_LEVEL = (0.68, 0.35)  # deg, largest |error| of 100 runs in level flight, eq10 on T1


# -------------------------------------------------------------------------------- trajectories


class Motion(NamedTuple):
    """The truth at times t: angles (n,), the rest (n, 3) in body axes."""

    phi: np.ndarray
    theta: np.ndarray
    omega: np.ndarray
    force: np.ndarray
    velocity: np.ndarray


def bank(t):
    """mu and mu': raised cosines over 5 s into and out of the bank, 0 before 250 s."""
    s = np.asarray(t, float) - LEVEL
    into = s < TURN / 2
    ramp = np.clip(np.where(into, s, TURN - s), 0, RAMP)
    mu = BANK / 2 * (1 - np.cos(math.pi * ramp / RAMP))
    slope = BANK / 2 * math.pi / RAMP * np.sin(math.pi * ramp / RAMP)
    return mu, np.where(into, slope, -slope)


def heading_rate(mu):
    """chi' of a level turn at constant speed."""
    return G * np.tan(mu) / V


def coordinated(t, tilt):
    """T1, and T0 with tilt = 0: angle of attack alpha = tilt / cos mu, no sideslip."""
    mu, dmu = bank(t)
    c, s = np.cos(mu), np.sin(mu)
    alpha = tilt / c
    dalpha = tilt * s / c**2 * dmu
    dchi = heading_rate(mu)
    zero = np.zeros_like(mu)

    def turned(x, y, z):  # Ry(alpha)
        ca, sa = np.cos(alpha), np.sin(alpha)
        return np.stack([ca * x - sa * z, y, sa * x + ca * z], -1)

    down = turned(zero, s, c)  # [-sin theta, cos theta sin phi, cos theta cos phi]
    return Motion(
        np.arctan2(down[:, 1], down[:, 2]),
        -np.arcsin(down[:, 0]),
        turned(dmu, dchi * s, dchi * c) + np.stack([zero, dalpha, zero], -1),
        turned(zero, zero, -G / c),
        turned(V + zero, zero, zero),
    )


def slipping(t):
    """T2: phi = mu, theta = 3 deg s, psi = chi - 3 deg s with s = mu / mu_max."""
    mu, dmu = bank(t)
    slip, dslip = TILT / BANK * mu, TILT / BANK * dmu  # theta, and chi - psi
    dchi = heading_rate(mu)
    dpsi = dchi - dslip
    zero = np.zeros_like(mu)

    def turned(x, y, z):  # Rx(phi) Ry(theta), from axes turned by psi alone
        cp, sp, ct, st = np.cos(mu), np.sin(mu), np.cos(slip), np.sin(slip)
        below = st * x + ct * z
        return np.stack([ct * x - st * z, cp * y + sp * below, cp * below - sp * y], -1)

    omega = turned(zero, zero, dpsi) + np.stack([dmu, dslip * np.cos(mu), -dslip * np.sin(mu)], -1)
    along, across = np.cos(slip), np.sin(slip)  # the velocity is turned by chi - psi
    force = turned(-V * dchi * across, V * dchi * along, -G + zero)
    return Motion(mu, slip, omega, force, turned(V * along, V * across, zero))


def motion(name, t):
    """The truth of T0, T1 or T2 at times t."""
    t = np.atleast_1d(np.asarray(t, float))
    if name == "T2":
        return slipping(t)
    return coordinated(t, {"T0": 0.0, "T1": TILT}[name])


def truth(name):
    """The truth at t = 0, T .. 300 s: rows of the histories."""
    return motion(name, T * np.arange(N + 1))


# ------------------------------------------------------------------------------------- sensors


class Sensors(NamedTuple):
    """What is measured: gyro and acc (N, runs, 3), airspeed (N, runs)."""

    gyro: np.ndarray
    acc: np.ndarray
    airspeed: np.ndarray


def deterministic(name, gyro=GYR_BIAS, acc=ACC_BIAS):
    """D1: constant errors, the same on all three axes, airspeed exact. One run."""
    true = motion(name, T * (np.arange(N) + 0.5))
    return Sensors(
        true.omega[:, None] + gyro, true.force[:, None] + acc, true.velocity[:, None, 0].copy()
    )


def walk(rng, sigma, density):
    """A random walk on three axes, (N, 3), its initial value in row 0."""
    steps = rng.standard_normal((N, 3)) * math.sqrt(density * T)
    steps[0] *= sigma / math.sqrt(density * T)
    return np.cumsum(steps, axis=0)


def random(name, runs=100, seed=0):
    """Errors of table 1; run i is the same for every number of runs above i."""
    exact = deterministic(name, 0.0, 0.0)
    out = Sensors(*(np.repeat(v, runs, axis=1) for v in exact))
    for i in range(runs):
        rng = np.random.default_rng([seed, i])
        out.gyro[:, i] += walk(rng, GYR_BIAS, GYR_DENSITY)
        out.acc[:, i] += walk(rng, ACC_BIAS, ACC_DENSITY)
        out.airspeed[:, i] += AIRSPEED_NOISE * rng.standard_normal(N)
    return out


# ------------------------------------------------------------------------------------- filters


def gains(tau):
    """(15): K1, K2 of a double pole at -1/tau."""
    return 2 / tau, 1 / (2 * tau)


def rates(phi, theta, p, q, r):
    """The first two rows of (2): phi', theta'."""
    return (
        p + np.tan(theta) * (q * np.sin(phi) + r * np.cos(phi)),
        q * np.cos(phi) - r * np.sin(phi),
    )


def accelerometer_angles(acc, p, q, r, u, v=0.0, w=0.0):
    """phi_a, theta_a of (14) with q w for the printed q v; of (10) with v = w = 0."""
    fx, fy = acc[..., 0], acc[..., 1]
    theta = np.arcsin((fx + r * v - q * w) / G)
    return np.arcsin((-fy + r * u - p * w) / (G * np.cos(theta))), theta


def system(p, q, r):
    """A of (11), (..., 3, 3)."""
    o = np.zeros_like(p)
    return np.stack([o, r, -q, -r, o, p, q, -p, o], -1).reshape(*p.shape, 3, 3)


def gravity(phi, theta):
    """(5): gravity in body axes."""
    return G * np.stack(
        [-np.sin(theta), np.sin(phi) * np.cos(theta), np.cos(phi) * np.cos(theta)], -1
    )


def velocity_step(x, P, A, b, z, q_k=Q_K, r_k=R_K):
    """(11) and (12): time update with the input b, then measurement update with z = u."""
    eye = np.eye(3)
    Phi = eye + A * T + A @ A * T**2 / 2
    x = (Phi @ x[..., None] + (eye * T + A * T**2 / 2) @ b[..., None])[..., 0]
    P = Phi @ P @ np.swapaxes(Phi, -1, -2) + q_k * eye
    K = P[..., :, 0] / (P[..., 0, 0] + r_k)[..., None]
    x = x + K * (z - x[..., 0])[..., None]
    keep = eye - K[..., :, None] * np.array([1.0, 0.0, 0.0])
    return x, keep @ P @ np.swapaxes(keep, -1, -2) + r_k * K[..., :, None] * K[..., None, :]


def run(
    sensors,
    start,
    case,
    k1=K1,
    k2=K2,
    velocity="zero",
    p0=0.0,
    q_k=Q_K,
    r_k=R_K,
    threshold=THRESHOLD,
):
    """One case over all runs; start: the Motion whose first row the filter starts from.

    k1 and k2 are numbers or arrays that broadcast against (runs,): a leading axis is a scan. The
    arrays returned have a row per time and then that shape: phi, theta and, for kf, velocity
    (..., 3) and running, those of the interval before (row 0: the start).
    """
    if case not in CASES or velocity not in STARTS:
        raise ValueError(f"unknown: {case}, {velocity}")
    shape = np.broadcast_shapes(np.shape(k1), np.shape(k2), sensors.airspeed.shape[1:])
    phi, theta = np.full(shape, start.phi[0]), np.full(shape, start.theta[0])
    sum_phi, sum_theta = np.zeros(shape), np.zeros(shape)
    x0 = start.velocity[0] * ([1, 1, 1] if velocity == "true" else [1, 0, 0])
    x = np.broadcast_to(x0, (*shape, 3)).copy()
    P = np.broadcast_to(p0 * np.eye(3), (*shape, 3, 3)).copy()
    out = {"phi": np.empty((N + 1, *shape)), "theta": np.empty((N + 1, *shape))}
    if case == "kf":
        out |= {
            "velocity": np.empty((N + 1, *shape, 3)),
            "running": np.zeros((N + 1, *shape), bool),
        }
        out["velocity"][0] = x
    out["phi"][0], out["theta"][0] = phi, theta
    running = np.zeros(shape, bool)

    for k in range(N):
        acc, u = sensors.acc[k], sensors.airspeed[k]
        p, q, r = np.moveaxis(sensors.gyro[k], -1, 0)
        dphi, dtheta = rates(phi, theta, p, q, r)
        if case == "kf":
            running = np.broadcast_to(np.sqrt(p**2 + q**2 + r**2) > threshold, shape)
            held = np.concatenate([np.broadcast_to(u, shape)[..., None], x[..., 1:]], -1)
            if running.any():
                b = acc + gravity(phi, theta)
                moved, moved_P = velocity_step(x, P, system(p, q, r), b, u, q_k, r_k)
                x = np.where(running[..., None], moved, held)
                P = np.where(running[..., None, None], moved_P, P)
            else:
                x = held
            phi_a, theta_a = accelerometer_angles(acc, p, q, r, *np.moveaxis(x, -1, 0))
            out["velocity"][k + 1], out["running"][k + 1] = x, running
        elif case == "eq10":
            phi_a, theta_a = accelerometer_angles(acc, p, q, r, u)
        if case == "gyro":
            phi, theta = phi + T * dphi, theta + T * dtheta
        else:
            e_phi, e_theta = phi_a - phi, theta_a - theta
            phi = phi + T * (dphi + k1 * e_phi + sum_phi)
            theta = theta + T * (dtheta + k1 * e_theta + sum_theta)
            sum_phi = sum_phi + T * k1 * k2 * e_phi
            sum_theta = sum_theta + T * k1 * k2 * e_theta
        out["phi"][k + 1], out["theta"][k + 1] = phi, theta
    return out


# -------------------------------------------------------------------------------------- scores


def errors(estimate, true):
    """Roll and pitch error in deg, (N + 1, ...) each, of what `run` returned."""
    extra = (slice(None), *(None,) * (estimate["phi"].ndim - 1))
    return tuple((estimate[a] - getattr(true, a)[extra]) / DEGREE for a in ("phi", "theta"))


def row(t):
    """The row of time t."""
    return round(t / T)


def level_rms(error, since=50.0):
    """Over 50 .. 250 s and all runs."""
    return np.sqrt(np.mean(error[row(since) : row(LEVEL) + 1] ** 2, axis=(0, -1)))


def turn_maximum(error):
    """The mean over runs of the largest |error| in 250 .. 300 s."""
    return np.mean(np.max(np.abs(error[row(LEVEL) :]), axis=0), axis=-1)


def level_worst(error):
    """The largest |error| of any run in 0 .. 250 s."""
    return np.max(np.abs(error[: row(LEVEL) + 1]), axis=(0, -1))


def whole_rms(roll, pitch):
    """Over 0 .. 300 s and all runs, of roll and pitch together."""
    return np.sqrt(np.mean(roll**2 + pitch**2, axis=(0, -1)))


# -------------------------------------------------------------------------------------- theory


def time_constants(k1, k2):
    """What (15) makes of gains: tau of K1, of K2 and of K1 K2; then zeta and the two poles."""
    root = np.roots([1.0, k1, k1 * k2])
    return 2 / k1, 1 / (2 * k2), 1 / math.sqrt(k1 * k2), math.sqrt(k1 / k2) / 2, np.sort(root)


def level_floor(bias, speed):
    """Roll error in deg that (10) leaves in level flight for a bias of r, for all gains."""
    return math.asin(bias * speed / G) / DEGREE


def observability(omega, domega):
    """(13) of a system that varies: rows c, c A, c A A + d/dt(c A), c = [1, 0, 0]."""
    A, dA = system(*np.asarray(omega, float)), system(*np.asarray(domega, float))
    c = np.array([1.0, 0.0, 0.0])
    return np.stack([c, c @ A, c @ A @ A + c @ dA])


def observability_determinant(omega, domega):
    """Det V = p (q^2 + r^2) + q r' - r q'."""
    p, q, r = omega
    _, dq, dr = domega
    return p * (q**2 + r**2) + q * dr - r * dq
