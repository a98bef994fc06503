"""Textbook loops in plain NumPy for Suh, Park, Kang and Ro 2004, and the numbers they must give.

Nothing here uses the project. Equation numbers are the paper's. The state is
x = [theta, phi, wx, wy, wz] in rad and rad/s, z1 = [ax, ay] in g, z2 = [gx, gy, gz] in rad/s;
sample k = 1 .. N is row k - 1 of every array, t = k T.

The readings that give the numbers, where the paper leaves a choice:

* x, P and r at k = 0 are 0, 0 and r_nom; every sample, the first one included, is a time update
  and then a measurement update. Histories hold the estimates after the update.
* W in Phi and in Q_k is frozen at the previous estimate, the one after its update.
* C_1 is evaluated once a sample, at the predicted x-, in all three filters: the two-step filter
  does not relinearise at x_g. Its accelerometer update starts from x_g and P_g, with the
  innovation z1 - f1(x_g).
* r is adjusted before the accelerometer update of the same sample uses it; e of (9) is the
  innovation of that update.
* The standard and the simple filter update with all five measurements at once, innovation
  z - f(x-).
* The simple filter has r1 = r2 = r_big in a sample with a detection and r_nom in one without:
  no memory, so (9) and (10) are not used.

With a constant R the two-step filter is the standard one to rounding if its innovation is
z1 - f1(x-) - C1 (x_g - x-), `prediction` = 'linearised'; with f1(x_g) the roll differs by 1.6e-5
rad on D2. The two-step rows below do not tell these two apart: both give every digit.

Negating ay, gx and gz negates phi and leaves r unchanged, exactly; without gz only if gz = 0.
"""

import math

import numpy as np

T = 0.05  # s
DEGREE = math.pi / 180
ACC_VARIANCE = (1.68e-5, 1.67e-5, 1.68e-5)  # g^2; the one of az is not printed
GYR_VARIANCE = (0.0032, 0.0040, 0.0031)  # in a unit that is not printed
CHIRPS = (1.0, 1.1, 1.2, 1.3, 1.4, 1.5)  # ax, ay, az, gx, gy, gz
BURSTS = ((0.1, 3.0), (0.2, 7.0), (0.3, 11.0), (0.4, 15.0), (0.5, 19.0))  # g, s

LAWS = ("standard", "simple", "two-step")
DEFAULTS = {
    "T": T,
    "q1": 1.0,
    "r_nom": 0.05,
    "r3": 1.0,
    "alpha1": 0.4,
    "alpha2": 10.0,
    "delta": 0.005,
    "r_big": 5.0,
    "jacobian": "full",  # C(2,1) = -sin phi sin theta, or 'printed': 0 as in (5)
    "innovation": "nonlinear",  # z - f(x), or 'linear': z - C x as in (8), (9) and (11)
    "prediction": "nonlinear",  # two-step: f1(x_g), or 'linearised': f1(x-) + C1 (x_g - x-)
    "residual": "absolute",  # |e|, or 'signed': e as in (9)
    "decay": "printed",  # alpha1 r + r_nom as in (10), or 'convex': alpha1 r + (1 - alpha1) r_nom
    "x0": (0.0, 0.0, 0.0, 0.0, 0.0),
}

# D2, variances of the gyroscopes in (deg/s)^2: law, settings; S_theta, S_phi, M_theta, M_phi
EXPERIMENT_2 = {
    "standard": ("standard", {}, (".00546177", "30.2810", ".175086", "18.9719")),
    "simple adaptive": ("simple", {}, (".0105680", "1.56722", ".264500", "4.39136")),
    "two-step": ("two-step", {}, (".00532724", ".361249", ".175089", "2.23850")),
    "two-step, signed (9)": (
        "two-step",
        {"residual": "signed"},
        (".00595977", "136.337", ".199412", "26.9347"),
    ),
}
SUM_AY = ".0238196081"  # of D2

# peak of phi in deg for the pulse of sign +, sign -: each has the sign of its pulse
PULSE = {
    "standard": ("15.9419", "-15.9419"),
    "simple adaptive": (".711504", "-.711504"),
    "two-step": (".889810", "-.889810"),
    "two-step, signed (9)": (".889810", "-16.2092"),
}
PULSE_R2 = {101: "3.03333", 110: "4.79460", 115: ".131577"}  # of the two-step filter, at k

# true angle in deg: the fixed point of theta cos theta = sin theta_true, C x as the innovation
LINEAR_FIXED_POINT = {20: "20.99", 30: "34.95"}
LINEAR_LIMIT = "34.13"  # deg, none above
FALSE_ALARMS = ".54"  # of (7), no motion, normal noise; the chirps of `noise` give more


# ----------------------------------------------------------------------------------- signals


def chirp(N, a):
    """sqrt(2) sin(a k^2), k = 1 .. N: mean square about 1, the same on every machine."""
    return np.array([math.sqrt(2) * math.sin(a * k * k) for k in range(1, N + 1)])


def deviations(unit="deg"):
    """Standard deviations of ax, ay, az in g and of gx, gy, gz in rad/s.

    The unit of the printed variances of the gyroscopes is 'deg': (deg/s)^2, or 'rad': (rad/s)^2.
    """
    scale = {"deg": DEGREE, "rad": 1.0}[unit]
    return [math.sqrt(v) for v in ACC_VARIANCE] + [scale * math.sqrt(v) for v in GYR_VARIANCE]


def noise(N, unit="deg"):
    """Deterministic: accelerations (N, 3) in g without gravity and rates (N, 3) in rad/s."""
    columns = [s * chirp(N, a) for s, a in zip(deviations(unit), CHIRPS, strict=True)]
    return np.array(columns[:3]).T, np.array(columns[3:]).T


def normal_noise(N, seed, unit="deg"):
    """The same shapes and deviations, independent normal numbers."""
    draws = np.random.default_rng(seed).standard_normal((N, 6)) * deviations(unit)
    return draws[:, :3], draws[:, 3:]


def still(N):
    """No noise, no motion, level: az = 1."""
    return np.array([[0.0, 0.0, 1.0]] * N), np.zeros((N, 3))


def bursts(N):
    """External acceleration of D2 along y in g: periods of 1 s, two of them in each burst."""
    out = np.zeros(N)
    for k in range(1, N + 1):
        t = 0.05 * k
        for i, (A, s) in enumerate(BURSTS):
            if s <= t < s + 2:
                out[k - 1] += A * (-1) ** i * math.sin(2 * math.pi * (t - s))
    return out


def experiment2(unit="deg", seed=None, N=480):
    """D2: a level sensor in five bursts, with the deterministic noise or with a seed's."""
    acc, gyr = noise(N, unit) if seed is None else normal_noise(N, seed, unit)
    acc = acc + np.array([0.0, 0.0, 1.0])
    acc[:, 1] += bursts(N)
    return acc, gyr


def pulse(sign, N=300):
    """No noise; ay = sign * .3 g for k = 101 .. 110."""
    acc, gyr = still(N)
    acc[100:110, 1] = sign * 0.3
    return acc, gyr


def static(theta, phi, N):
    """No noise, no motion at this attitude, in the paper's mixed polarity."""
    a = [math.sin(theta), math.sin(phi) * math.cos(theta), math.cos(phi) * math.cos(theta)]
    return np.array([a] * N), np.zeros((N, 3))


# ------------------------------------------------------------------------------------- model


def rates_matrix(phi, theta):
    """W: [theta', phi'] = W [wx, wy, wz]. The roll comes first here and in the next three."""
    return np.array(
        [
            [0.0, math.cos(phi), -math.sin(phi)],
            [1.0, math.sin(phi) * math.tan(theta), math.cos(phi) * math.tan(theta)],
        ]
    )


def system(phi, theta):
    """A of (3)."""
    A = np.zeros((5, 5))
    A[:2, 2:] = rates_matrix(phi, theta)
    return A


def transition(phi, theta, T):
    """Phi of (4), exact for a frozen A: A A = 0."""
    return np.eye(5) + T * system(phi, theta)


def process_noise(phi, theta, T, q1):
    """Q_k below (4), exact for a frozen A."""
    W = rates_matrix(phi, theta)
    Q = np.zeros((5, 5))
    Q[:2, :2] = T**3 / 3 * W @ W.T
    Q[:2, 2:] = T**2 / 2 * W
    Q[2:, :2] = T**2 / 2 * W.T
    Q[2:, 2:] = T * np.eye(3)
    return q1 * Q


def f1(x):
    """What the accelerometers along x and y give without external acceleration."""
    return np.array([math.sin(x[0]), math.sin(x[1]) * math.cos(x[0])])


def jacobian1(x, jacobian="full"):
    """C_1, the first two rows of C: the derivative of f1, or (5) as printed."""
    theta, phi = x[0], x[1]
    C1 = np.zeros((2, 5))
    C1[0, 0] = math.cos(theta)
    C1[1, 1] = math.cos(phi) * math.cos(theta)
    if jacobian == "full":
        C1[1, 0] = -math.sin(phi) * math.sin(theta)
    return C1


def is_external(a, delta):
    """(7)."""
    return abs(a[0] ** 2 + a[1] ** 2 + a[2] ** 2 - 1) > delta


def adjusted(r, e, external, settings):
    """(9) or (10) for one axis."""
    alpha1, r_nom = settings["alpha1"], settings["r_nom"]
    if external:
        size = abs(e) if settings["residual"] == "absolute" else e
        return max(alpha1 * r + settings["alpha2"] * size, r_nom)
    if settings["decay"] == "convex":
        return alpha1 * r + (1 - alpha1) * r_nom
    return alpha1 * r + r_nom


def update(x, P, innovation, C, R):
    """A measurement update with the covariance in Joseph's form."""
    K = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
    keep = np.eye(5) - K @ C
    return x + K @ innovation, keep @ P @ keep.T + K @ R @ K.T


# ----------------------------------------------------------------------------------- filters


def run(acc, gyr, law, **settings):
    """One filter over accelerations (N, 3) in g and rates (N, 3) in rad/s; settings: DEFAULTS.

    Arrays of length N: theta, phi, wx, wy, wz after the update, r1 and r2 as used in it, detected.
    """
    unknown = set(settings) - set(DEFAULTS)
    if unknown or law not in LAWS:
        raise ValueError(f"unknown: {sorted(unknown) or law}")
    s = DEFAULTS | settings
    C2 = np.hstack([np.zeros((3, 2)), np.eye(3)])
    R2 = s["r3"] * np.eye(3)
    x, P = np.array(s["x0"], float), np.zeros((5, 5))
    r = [s["r_nom"], s["r_nom"]]
    xs, rs, detected = [], [], []
    for a, g in zip(acc, gyr, strict=True):
        Phi = transition(x[1], x[0], s["T"])
        Q = process_noise(x[1], x[0], s["T"], s["q1"])
        x = Phi @ x
        P = Phi @ P @ Phi.T + Q
        C1 = jacobian1(x, s["jacobian"])
        external = is_external(a, s["delta"])
        if law == "two-step":
            predicted = x
            x, P = update(x, P, g - C2 @ x, C2, R2)
            if s["innovation"] == "linear":
                e = a[:2] - C1 @ x
            elif s["prediction"] == "linearised":
                e = a[:2] - f1(predicted) - C1 @ (x - predicted)
            else:
                e = a[:2] - f1(x)
            r = [adjusted(r[i], e[i], external, s) for i in range(2)]
            x, P = update(x, P, e, C1, np.diag(r))
        else:
            level = s["r_big"] if law == "simple" and external else s["r_nom"]
            r = [level, level]
            e = a[:2] - (C1 @ x if s["innovation"] == "linear" else f1(x))
            C = np.vstack([C1, C2])
            R = np.diag([*r, s["r3"], s["r3"], s["r3"]])
            x, P = update(x, P, np.concatenate([e, g - C2 @ x]), C, R)
        xs.append(x)
        rs.append(r)
        detected.append(external)
    xs, rs = np.array(xs), np.array(rs)
    out = dict(zip(("theta", "phi", "wx", "wy", "wz"), xs.T, strict=True))
    return out | {"r1": rs[:, 0], "r2": rs[:, 1], "detected": np.array(detected)}


def errors(theta, phi, true_theta=0.0, true_phi=0.0):
    """(12): S = mean square in deg^2 and M = largest magnitude in deg, each (theta, phi)."""
    e = [(np.asarray(theta) - true_theta) / DEGREE, (np.asarray(phi) - true_phi) / DEGREE]
    return tuple(float(np.mean(v**2)) for v in e), tuple(float(np.max(np.abs(v))) for v in e)


def linear_fixed_point(true):
    """Where z - C x holds the pitch: theta cos theta = sin true by bisection, nan if none."""
    low, high = 0.0, 0.8603335890193797  # the maximum of theta cos theta: theta tan theta = 1
    if math.sin(true) > high * math.cos(high):
        return math.nan
    for _ in range(60):
        mid = (low + high) / 2
        low, high = (low, mid) if mid * math.cos(mid) > math.sin(true) else (mid, high)
    return low


def false_alarm_rate(delta=DEFAULTS["delta"], variance=ACC_VARIANCE[2]):
    """P(|2 n + n^2| > delta) for az = 1 + n alone, n normal: ax and ay add 1e-5."""
    sigma = math.sqrt(variance)
    above = (math.sqrt(1 + delta) - 1) / sigma
    below = (1 - math.sqrt(1 - delta)) / sigma
    return (math.erfc(above / math.sqrt(2)) + math.erfc(below / math.sqrt(2))) / 2
