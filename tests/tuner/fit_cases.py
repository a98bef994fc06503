"""Recordings with a known truth for the tests of fits, and textbook loops to hold fits against."""

import numpy as np
from scipy.optimize import minimize

from tuner.data.simulation import Bursts, Sensor, Swing, measure, simulate

LEVEL_Q, LEVEL_R = 0.09, 1.0
TRACK_Q, TRACK_R, TRACK_DT = 0.5, 4.0, 0.5


def write(path, columns):
    """A CSV file; a cell is empty where there is no number."""
    rows = zip(*(np.asarray(values, float) for values in columns.values()), strict=True)
    cells = ((("" if np.isnan(v) else repr(float(v))) for v in row) for row in rows)
    path.write_text("\n".join([",".join(columns), *map(",".join, cells)]) + "\n")
    return path


def level(seed=5, samples=400):
    """A random walk at 1 Hz, measured: t, z, level."""
    draw = np.random.default_rng(seed)
    walk = np.cumsum(np.sqrt(LEVEL_Q) * draw.standard_normal(samples))
    z = walk + np.sqrt(LEVEL_R) * draw.standard_normal(samples)
    return {"t": np.arange(float(samples)), "z": z, "level": walk}


def track(seed=6, samples=300, dt=TRACK_DT):
    """Two axes of white-noise acceleration: t, x, y."""
    draw = np.random.default_rng(seed)
    root = np.linalg.cholesky(TRACK_Q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]))
    position, speed, found = np.zeros(2), np.zeros(2), []
    for _ in range(samples):
        noise = root @ draw.standard_normal((2, 2))
        position, speed = position + dt * speed + noise[0], speed + noise[1]
        found.append(position)
    z = np.array(found) + np.sqrt(TRACK_R) * draw.standard_normal((samples, 2))
    return {"t": dt * np.arange(samples), "x": z[:, 0], "y": z[:, 1]}


def jerks(seed=8, samples=400, dt=TRACK_DT):
    """A position whose acceleration wanders, measured: t, x."""
    draw = np.random.default_rng(seed)
    acceleration = np.cumsum(0.2 * draw.standard_normal(samples))
    position = np.cumsum(np.cumsum(acceleration) * dt) * dt
    return {"t": dt * np.arange(samples), "x": position + 2.0 * draw.standard_normal(samples)}


def climb(seed=7, samples=1000, dt=0.05):
    """An accelerometer with an offset, and a barometer of a fifth of its rate: t, acc, baro."""
    draw = np.random.default_rng(seed)
    acc = 0.5 * np.sin(0.4 * dt * np.arange(samples))
    height = np.cumsum(np.cumsum(acc) * dt) * dt
    baro = height + 0.3 * draw.standard_normal(samples)
    baro[np.arange(samples) % 5 != 0] = np.nan
    return {
        "t": dt * np.arange(samples),
        "acc": acc + 0.3 + 0.5 * draw.standard_normal(samples),
        "baro": baro,
    }


GYRO_NOISE, ACC_NOISE, ANGLE_NOISE, PLACE_NOISE = 0.02, 0.1, 0.05, 1.0


def imu(seed=3, seconds=12.0, dt=0.02, bursts=True):
    """An inertial unit that swings, axes forward, left, up, with what else its filters take.

    With ``bursts`` it is pushed, and its gyroscopes have a bias.
    """
    pushed = Bursts(3, 2.0) if bursts else None
    bias = (0.02, -0.01, 0.015) if bursts else (0.0, 0.0, 0.0)
    motion = simulate(
        seconds=seconds, dt=dt, seed=seed, swing=Swing((0.2, 0.2, 0.3)), bursts=pushed
    )
    sensed = measure(
        motion,
        gyroscope=Sensor(noise=GYRO_NOISE, bias=bias),
        accelerometer=Sensor(noise=ACC_NOISE),
        seed=seed + 1,
    )
    draw = np.random.default_rng(seed + 2)
    N, angles = len(motion.q), np.asarray(motion.angles)
    phi, theta, psi = angles.T
    ahead = np.stack(
        [np.cos(theta) * np.cos(psi), np.cos(theta) * np.sin(psi), -np.sin(theta)], axis=1
    )
    place = 5.0 * dt * np.cumsum(np.concatenate([np.zeros((1, 3)), ahead[:-1]]), axis=0)
    fixes = place + PLACE_NOISE * draw.standard_normal((N, 3))
    fixes[np.arange(N) % 5 != 0] = np.nan
    told = angles + ANGLE_NOISE * draw.standard_normal((N, 3))
    told[np.arange(N) % 3 != 0] = np.nan
    still = 0.5 * draw.standard_normal((N, 3))
    still[np.arange(N) % 5 != 0] = np.nan
    columns = {"t": dt * np.arange(N)}
    columns |= dict(zip(("gx", "gy", "gz"), np.asarray(sensed.gyr).T, strict=True))
    columns |= dict(zip(("ax", "ay", "az"), np.asarray(sensed.acc).T, strict=True))
    columns |= dict(zip(("q0", "q1", "q2", "q3"), np.asarray(motion.q).T, strict=True))
    columns |= dict(zip(("roll", "pitch", "yaw"), angles.T, strict=True))
    columns |= dict(zip(("mroll", "mpitch", "myaw"), told.T, strict=True))
    columns |= dict(zip(("north", "east", "down"), fixes.T, strict=True))
    columns |= dict(zip(("sx", "sy", "sz"), still.T, strict=True))
    columns["rate"] = np.gradient(phi, dt) + 0.02 + 0.02 * draw.standard_normal(N)
    columns["angle"] = phi + ANGLE_NOISE * draw.standard_normal(N)
    columns["speed"] = np.full(N, 5.0)
    return columns


# Textbook loops.


def nats(innovations, variances):
    """Minus the mean logarithm of the density of numbers."""
    y, s = np.asarray(innovations), np.asarray(variances)
    return float(np.mean(y**2 / s + np.log(s) + np.log(2 * np.pi)) / 2)


def deviation(innovations, variances):
    """The same as a deviation in the numbers' unit."""
    return float(np.exp(nats(innovations, variances)) / np.sqrt(2 * np.pi * np.e))


def level_loop(z, q, R, dt):
    """Innovations and variances of a random walk that begins with its first measurement."""
    steps = np.broadcast_to(dt, len(z))
    x = p = None
    found = []
    for zk, step in zip(z, steps, strict=True):
        if x is not None:
            p = p + q * step
        if np.isnan(zk):
            continue
        if x is None:
            x, p = zk, R
            continue
        s = p + R
        found.append((zk - x, s))
        x, p = x + p / s * (zk - x), p * R / s
    return np.array(found).T


def velocity_loop(z, q, R, dt):
    """The same of a constant velocity; two measurements are its start, whatever lies between."""
    steps = np.broadcast_to(dt, len(z))
    found, x, P, first, passed = [], None, None, None, 0.0
    for zk, step in zip(z, steps, strict=True):
        if x is not None:
            F = np.array([[1.0, step], [0.0, 1.0]])
            Q = q * np.array([[step**3 / 3, step**2 / 2], [step**2 / 2, step]])
            x, P = F @ x, F @ P @ F.T + Q
        passed += step
        if np.isnan(zk):
            continue
        if first is None:
            first, passed = zk, 0.0
            continue
        if x is None:
            # The velocity over the gap errs by both measurements' noise and the white noise within.
            x = np.array([zk, (zk - first) / passed])
            P = np.array([[R, R / passed], [R / passed, 2 * R / passed**2 + q * passed / 3]])
            continue
        s = P[0, 0] + R
        found.append((zk - x[0], s))
        K = P[:, 0] / s
        x, P = x + K * (zk - x[0]), P - np.outer(K, P[0])
    return np.array(found).T


def tuned_by_hand(loop, start):
    """Parameters, positive, with the likeliest innovations by Nelder-Mead, and their deviation."""
    found = minimize(
        lambda logs: nats(*loop(*np.exp(logs))),
        np.log(start),
        method="Nelder-Mead",
        options={"xatol": 1e-8, "fatol": 1e-13, "maxiter": 2000},
    )
    return np.exp(found.x), deviation(*loop(*np.exp(found.x)))


def gains_loop(z, gains, dt):
    """Innovations of a filter with constant gains: position, and its derivatives over 1, dt, ..."""
    order = len(gains)
    F = np.array(
        [
            [dt ** (j - i) / np.prod(np.arange(1.0, j - i + 1)) if j >= i else 0.0]
            for i in range(order)
            for j in range(order)
        ]
    ).reshape(order, order)
    x, found = np.zeros(order), []
    x[0] = z[0]
    for zk in z[1:]:
        x = F @ x
        found.append(zk - x[0])
        x = x + gains * found[-1]
    return np.array(found)


def mixed_angle(rate, angle, tau, dt):
    """A first-order complementary filter from 0."""
    estimate, found = 0.0, []
    for w, measured in zip(rate, angle, strict=True):
        a = tau / (tau + dt)
        estimate = a * (estimate + w * dt) + (1 - a) * measured
        found.append(estimate)
    return np.array(found)


def product(a, b):
    """Of quaternions, w first."""
    (p, u), (q, v) = (a[0], a[1:]), (b[0], b[1:])
    return np.concatenate([[p * q - u @ v], p * v + q * u + np.cross(u, v)])


def down_to_sensor(q):
    """Earth's up in the sensor's axes."""
    w, x, y, z = q
    return np.array([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])


def levelled(acc):
    """The attitude without heading in which gravity is measured, turned the short way."""
    a = acc / np.linalg.norm(acc)
    q = np.array([1 + a[2], a[1], -a[0], 0.0])
    return q / np.linalg.norm(q)


def madgwick_loop(gyr, acc, beta, dt):
    """Madgwick's filter as published for six axes."""
    q, found = levelled(acc[0]), []
    units = acc / np.linalg.norm(acc, axis=1)[:, None]
    for w, a in zip(gyr, units, strict=True):
        q0, q1, q2, q3 = q
        f = np.array(
            [
                2 * (q1 * q3 - q0 * q2) - a[0],
                2 * (q0 * q1 + q2 * q3) - a[1],
                2 * (0.5 - q1 * q1 - q2 * q2) - a[2],
            ]
        )
        J = np.array(
            [
                [-2 * q2, 2 * q3, -2 * q0, 2 * q1],
                [2 * q1, 2 * q0, 2 * q3, 2 * q2],
                [0, -4 * q1, -4 * q2, 0],
            ]
        )
        slope = J.T @ f
        slope = slope / max(np.linalg.norm(slope), 1e-15)
        q = q + dt * (0.5 * product(q, np.concatenate([[0.0], w])) - beta * slope)
        q = q / np.linalg.norm(q)
        found.append(q)
    return np.array(found)


def inclination_rms(estimate, truth):
    """Root mean square of the angle between both verticals, deg, over the truth that there is."""
    angles = [
        np.arccos(np.clip(down_to_sensor(a) @ down_to_sensor(b), -1.0, 1.0))
        for a, b in zip(estimate, truth, strict=True)
        if not np.isnan(b).any()
    ]
    return float(np.degrees(np.sqrt(np.mean(np.square(angles)))))
