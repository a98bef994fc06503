"""Textbook loops in plain NumPy for Chauhan, Patil, Sinha and Halder 2009, and their numbers.

Nothing here uses the project. Equation numbers are the paper's. The state is x = [q, b]: a
quaternion, scalar first, from body to NED, and the gyro's bias in rad/s; z = [phi, theta, psi]
in rad. Sample k = 1 .. N is row k - 1 of every array, t = k T.

The readings that give the numbers, where the notes and the paper leave a choice:

* Every sample is a time update, and every fourth one, k = 4, 8, .., is a measurement update
  after it (6.1). The eight samples of `example` hold two measurements: with one at each k the
  numbers are (.99643, .03226, ..) and tr P = .0105.
* P is projected after (9), the normalisation of an update, and not after (4), that of a time
  update. `projection` = 'both' gives q2 = .0067747 and tr P = .0200968 in place of .00641114 and
  .0201371, 'time' .0066965 and .0201612, 'none' tr P = .0303430.
* A, in both blocks, is at the estimate before the time update, and so is the rate w - b.
* T Q is added after (I + T A) P (I + T A)'.
* J = diag((I - u u') / |q|, I3) with u = q / |q| and |q| before the normalisation.
* The residual of the state is K nu: before the normalisation.
* The window of the slopes starts at t = 0 s and its samples are Dt apart. At t = Dt, 2 Dt, ..
  the slope is another one when c0 = 0 binds, in about one window of eight of white noise.
* Q is changed after the update that gives the residual: it acts from the next time update on.

REPRODUCE_X and REPRODUCE_TRACE come out in every digit, but q2 is .00641114 and the notes have
.00641111. No reading tried gives that without losing digits elsewhere.

P is positive semidefinite of rank 6, P (q, 0) = 0, after an update; in the time updates that
follow T Q fills the rank up again.
"""

import math

import numpy as np

from tests.oracles_tanaka import strip

DEGREE = math.pi / 180
T = 0.25  # s
DT = 1.0  # s, between updates
TICKS = 4
WINDOW = 6
FLOOR = 1e-12
GRAVITY = 9.81  # m/s^2

LAWS = ("constant", "fuzzy", "random")
DEFAULTS = {
    "T": T,
    "ticks": TICKS,  # a measurement at every so many samples
    "R": 0.01 * np.eye(3),
    "P0": 0.01 * np.eye(7),
    "Q": np.diag([1e-4] * 4 + [1e-6] * 3),  # all of law 'constant', the start of the others
    "x0": (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    "window": WINDOW,
    "h": 0.0,
    "floor": FLOOR,
    "slope": "centre",  # |p1|, or 'edge': |p1| + c1
    "scale": None,  # law 'random': lambda sqrt(3) rms(p1), (7)
    "draws": None,  # law 'random': u in [0, 1), (updates, 7)
    "kinematics": "half",  # q' = 1/2 Omega q, or 'printed': (3) without the 1/2, here and in A
    "propagation": "psd",  # (I + T A) P (I + T A)' + T Q, or 'printed': (6)
    "covariance": "joseph",  # or 'printed': (10)
    "projection": "update",  # after (9); 'time': after (4); 'both'; 'none'
    "euler": "homogeneous",  # asin(s / |q|^2), or 'unit': asin(s), whose C q is not 0
}

# x(8) and tr P of `example`, law 'constant' and the other defaults
REPRODUCE_X = (
    ".997019",
    ".0236189",
    ".00641114",  # the notes: .00641111
    ".0731739",
    "-.0030787",
    ".0562794",
    "-.0250149",
)
REPRODUCE_TRACE = ".0201371"

PRINTED_TURN = "79.9"  # deg, what (3) makes of 10 deg/s for 4 s


# ------------------------------------------------------------------------------- quaternions


def omega(w):
    """(17)."""
    a, b, c = w
    return np.array([[0, -a, -b, -c], [a, 0, c, -b], [b, -c, 0, a], [c, b, -a, 0.0]])


def xi(q):
    """Omega(w) q = Xi(q) w."""
    q0, q1, q2, q3 = q
    return np.array([[-q1, -q2, -q3], [q0, -q3, q2], [q3, q0, -q1], [-q2, q1, q0]])


def quaternion(phi, theta, psi):
    """From body to NED, of the Euler angles."""
    (cp, ct, cs), (sp, st, ss) = (
        [f(angle / 2) for angle in (phi, theta, psi)] for f in (math.cos, math.sin)
    )
    return np.array(
        [
            cp * ct * cs + sp * st * ss,
            sp * ct * cs - cp * st * ss,
            cp * st * cs + sp * ct * ss,
            cp * ct * ss - sp * st * cs,
        ]
    )


def euler(q, form="homogeneous"):
    """Phi, theta, psi of a quaternion, of any length if homogeneous."""
    q0, q1, q2, q3 = q
    s = 2 * (q0 * q2 - q1 * q3) / (q @ q if form == "homogeneous" else 1.0)
    return np.array(
        [
            math.atan2(2 * (q0 * q1 + q2 * q3), q0**2 - q1**2 - q2**2 + q3**2),
            math.asin(min(1.0, max(-1.0, s))),
            math.atan2(2 * (q0 * q3 + q1 * q2), q0**2 + q1**2 - q2**2 - q3**2),
        ]
    )


def euler_jacobian(q, form="homogeneous"):
    """C without its zero columns: of the homogeneous form, dEuler/dq (I - q q') where |q| = 1."""
    q0, q1, q2, q3 = q

    def of_atan2(y, x, dy, dx):
        return (x * np.array(dy) - y * np.array(dx)) / (x * x + y * y)

    s, ds = 2 * (q0 * q2 - q1 * q3), 2 * np.array([q2, -q3, q0, -q1])
    if form == "homogeneous":
        s, ds = s / (q @ q), ds / (q @ q) - 2 * s * np.asarray(q) / (q @ q) ** 2
    return np.array(
        [
            of_atan2(
                2 * (q0 * q1 + q2 * q3),
                q0**2 - q1**2 - q2**2 + q3**2,
                [2 * q1, 2 * q0, 2 * q3, 2 * q2],
                [2 * q0, -2 * q1, -2 * q2, 2 * q3],
            ),
            ds / math.sqrt(1 - s * s),
            of_atan2(
                2 * (q0 * q3 + q1 * q2),
                q0**2 + q1**2 - q2**2 - q3**2,
                [2 * q3, 2 * q2, 2 * q1, 2 * q0],
                [2 * q0, 2 * q1, -2 * q2, -2 * q3],
            ),
        ]
    )


def wrapped(angle):
    """In [-pi, pi]."""
    return math.remainder(angle, 2 * math.pi)


def normalised(x, P, project):
    """(4) and (9), with P <- J P J' where asked for."""
    length = np.linalg.norm(x[:4])
    u = x[:4] / length
    if project:
        J = np.eye(7)
        J[:4, :4] = (np.eye(4) - np.outer(u, u)) / length
        P = J @ P @ J.T
    return np.concatenate([u, x[4:]]), P


# ----------------------------------------------------------------------------------- attitude


def predict(x, P, w, Q, s):
    """(3) to (6); s: settings as DEFAULTS."""
    factor = 0.5 if s["kinematics"] == "half" else 1.0
    q, turn = x[:4], omega(w - x[4:])
    A = np.zeros((7, 7))
    A[:4, :4] = factor * turn
    A[:4, 4:] = -factor * xi(q)
    if s["propagation"] == "psd":
        F = np.eye(7) + s["T"] * A
        P = F @ P @ F.T + s["T"] * Q
    else:
        P = P + s["T"] * (A @ P + P @ A.T + Q)
    x = np.concatenate([q + s["T"] * factor * turn @ q, x[4:]])
    return normalised(x, P, s["projection"] in ("time", "both"))


def update(x, P, z, s):
    """(7) to (10), and the residual K nu of the state."""
    C = np.zeros((3, 7))
    C[:, :4] = euler_jacobian(x[:4], s["euler"])
    nu = z - euler(x[:4], s["euler"])
    nu[0], nu[2] = wrapped(nu[0]), wrapped(nu[2])
    K = P @ C.T @ np.linalg.inv(C @ P @ C.T + s["R"])
    keep = np.eye(7) - K @ C
    joseph = s["covariance"] == "joseph"
    P = keep @ P @ keep.T + K @ s["R"] @ K.T if joseph else keep @ P
    residual = K @ nu
    return *normalised(x + residual, P, s["projection"] in ("update", "both")), residual


def slopes(residuals, window=WINDOW, h=0.0, dt=DT):
    """p1 and c1 of each component over the largest even count of residuals, None below 2."""
    count = min(window, len(residuals) - len(residuals) % 2)
    if count < 2:
        return None
    t = [j * dt for j in range(count)]
    lines = [strip(t, x, h, number=float) for x in np.array(residuals[-count:]).T]
    return np.array([sum(v.p1) / 2 for v in lines]), np.array([sum(v.c1) / 2 for v in lines])


def run(rates, z, law="constant", **settings):
    """One filter over rates (N, 3) and z (N, 3), of which every `ticks`-th row is read.

    Arrays of N samples: x and P at their end, the diagonal of Q as used in the time update; of
    the updates: residual K nu and, of law 'fuzzy', p1 and c1 as found after it (nan after the
    first).
    """
    unknown = set(settings) - set(DEFAULTS)
    if unknown or law not in LAWS:
        raise ValueError(f"unknown: {sorted(unknown) or law}")
    s = DEFAULTS | settings
    x, P, Q = np.array(s["x0"], float), np.array(s["P0"], float), np.array(s["Q"], float)
    dt = s["T"] * s["ticks"]
    out = {name: [] for name in ("x", "P", "Q", "residual", "p1", "c1")}
    for k, w in enumerate(rates, start=1):
        out["Q"].append(np.diag(Q))
        x, P = predict(x, P, w, Q, s)
        if k % s["ticks"] == 0:
            x, P, residual = update(x, P, z[k - 1], s)
            out["residual"].append(residual)
            size = None
            if law == "fuzzy":
                line = slopes(out["residual"], s["window"], s["h"], dt)
                p1, c1 = (np.full(7, np.nan),) * 2 if line is None else line
                out["p1"].append(p1)
                out["c1"].append(c1)
                if line is not None:
                    size = np.abs(p1) + (c1 if s["slope"] == "edge" else 0.0)
            if law == "random":
                size = s["scale"] * s["draws"][len(out["residual"]) - 1]
            if size is not None:
                Q = np.diag(np.maximum(size**2 * dt, s["floor"]))
        out["x"].append(x)
        out["P"].append(P)
    return {name: np.array(values) for name, values in out.items()}


def random_scale(p1, factor):
    """Lambda sqrt(3) rms(p1), a component each, over all updates of a run with fuzzy Q.

    u is uniform in [0, 1), so E (sqrt(3) u)^2 = 1: at lambda = 1 both laws have one mean of Q.
    """
    return factor * np.sqrt(3 * np.nanmean(np.square(p1), axis=0))


def example(N=8):
    """Rates and measurements of REPRODUCE, k = 1 .. N."""
    k = np.arange(1, N + 1)
    rates = np.array([0.1 * np.sin(k), 0.2 * np.cos(k), 0.05 * k / 8]).T
    return rates, np.array([0.05 * k / 8, 0.1 * np.sin(0.5 * k), 0.02 * k]).T


# ----------------------------------------------------------------------------------- position


def position_predict(x, P, V, attitude, Qu, T):
    """(12) and (13); Qu is the covariance of u = (V, phi, theta, psi)."""
    (_, ct, cp), (_, st, sp) = ([f(v) for v in attitude] for f in (math.cos, math.sin))
    G = np.array(
        [
            [ct * cp, 0, -V * st * cp, -V * ct * sp],
            [ct * sp, 0, -V * st * sp, V * ct * cp],
            [-st, 0, -V * ct, 0],
        ]
    )
    return x + T * V * G[:, 0], P + T * G @ Qu @ G.T


def position_update(x, P, z, R):
    """(14) to (16)."""
    K = P @ np.linalg.inv(P + R)
    return x + K @ (z - x), (np.eye(3) - K) @ P


# -------------------------------------------------------------------- constructed measurement


def constructed_attitude(positions, a, g=GRAVITY, dt=1.0, held=None, least_speed=0.0):
    """Phi, theta, psi, dt before the last of three positions in NED that are dt apart.

    a: the accelerometers, -g along z at rest, averaged over the same 2 dt. At rest psi is not
    defined: `held` is used, or ValueError raised without it. So it is where |ax| > |(rx, rz)|.
    """
    p1, p2, p3 = np.asarray(positions, float)
    v1, v2 = (p2 - p1) / dt, (p3 - p2) / dt
    v, acceleration = (v1 + v2) / 2, (v2 - v1) / dt
    if math.hypot(v[0], v[1]) > least_speed:
        psi = math.atan2(v[1], v[0])
    elif held is not None:
        psi = held
    else:
        raise ValueError("at rest the track angle is undefined")
    c, s = math.cos(psi), math.sin(psi)
    rx, ry, rz = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ (acceleration - [0, 0, g])
    ax, ay, az = a
    theta = math.asin(ax / math.hypot(rx, rz)) - math.atan2(rx, -rz)
    s = rx * math.sin(theta) + rz * math.cos(theta)
    return math.atan2(ay * s - az * ry, ay * ry + az * s), theta, psi
