"""Textbook loops in plain NumPy for Ha, Kim and Choi 1981, and the numbers they have to give.

Nothing here uses the project. Equation numbers are the paper's. The conventional loop lives in
error coordinates [eps, e, dV, dh_r], eps = A_Bhat - A_B and e = dh - dh_r, the Kalman filter in
[A_B, dV, dh]. Gains of the loop are (K1, K2', K3), K2' = K2 - K_gh. Units: ft and s.
"""

from itertools import pairwise
from typing import NamedTuple

import mpmath
import numpy as np

K_GH = 3.07e-6  # 1/s^2
Q_A = 0.04  # (ft/s^2)^2 s, a power spectral density
Q_B = 3.24  # ft^2
VAR_AB = 4.0  # (ft/s^2)^2, the bias at t = 0
VAR_HR = 100.0  # ft^2, the altitude at t = 0
BOUND = 4e-4  # (ft/s^2)^2, the worked case: eta = BOUND / Q_A = .01 1/s

LOOP_P0 = np.diag([VAR_AB, 0.0, 0.0, VAR_HR])  # P33 = P34 = P44 of (10): e(0) = 0
KALMAN_P0 = np.diag([VAR_AB, 0.0, VAR_HR])


class Design(NamedTuple):
    """A row of the table of designs as printed: gains, ISE and settling times in units of eta."""

    shape: tuple[float, float, float]  # s^3 + k1 s^2 + k2 s + k3 before it is scaled to the bound
    gains: tuple[str, str, str]  # K1/eta, K2'/eta^2, K3/eta^3
    ise: str  # of the unit step's error, times eta
    settling_5: str  # last time outside 1 +- .05, times eta
    settling_2: str


DESIGNS = {
    "triple pole": Design(
        (3.0, 3.0, 1.0), ("16", "85.3333", "151.704"), ".386719", "1.18046", "1.40936"
    ),
    "ISE form": Design((1.0, 2.0, 1.0), ("2", "8", "8"), ".75", "4.36557", "6.76116"),
    "Bessel": Design((6.0, 15.0, 15.0), ("10", "41.6667", "69.4444"), ".444", "1.11759", "1.23165"),
}

# eta = .01: (10) at t, including the floor that the bound leaves out
LOOP_VARIANCE = {
    10: "3.86483",
    50: "1.00756",
    100: ".0397877",
    200: "4.10213e-4",
    300: "4.00002e-4",
}
FLOOR = "9.4249e-10"  # K_gh^2 sigma_hr^2
SETTLING_2_WORKED = "140.9"  # s

# Ts: A, B, K2inf, K3inf (K_gh -> 0)
STEADY = {
    0.5: (".514125", ".0715862", ".0682930", ".244442"),
    1.0: (".740093", ".171281", ".0877796", ".375874"),
    5.0: ("2.13564", "1.40320", ".113031", ".793028"),
}

# Ts: P11(+) at t, first update at t = 0; "Ts = 0" is the Riccati equation with R_c = q_b
P11 = {
    1.0: {10: ".00644271", 50: "8.65278e-4", 200: "2.03845e-4"},
    5.0: {10: ".00746902", 50: "8.79241e-4", 200: "2.04610e-4"},
}
P11_RICCATI = {10: ".00702787", 100: "4.17679e-4"}

# Ts: first sample with P11(+) <= BOUND; the Riccati equation crosses it at
KALMAN_REACHES = {0.5: "103.5", 1.0: "104.0", 2.0: "106.0", 5.0: "105.0"}
RICCATI_REACHES = "104.233"
# level / BOUND: last time of the triple pole's variance above it
LOOP_REACHES = {1.01: "210.54", 1.02: "202.76", 1.05: "192.38"}

# Ts = 5: shares of P11(+) that q_a, q_b and VAR_AB cause = normalised sensitivities by (19)
SENSITIVITY = {
    10: (".677786", ".317894", ".00186726"),
    50: (".968747", ".0310336", "2.19810e-4"),
    100: (".985111", ".0147845", "1.04719e-4"),
    105: (".985852", ".0140489", "9.95087e-5"),
    200: (".992727", ".00722187", "5.11525e-5"),
    500: (".997130", ".00284934", "2.01819e-5"),
}
# gains of Ts = 5 used at Ts = 2.5, P11(+) at t over that of the filter designed for 2.5
REPLAY_BY_INDEX = {50: "200.698", 100: "204.952", 200: "207.229"}
REPLAY_BY_TIME_HELD = {50: "2.55637", 100: "1.68365", 200: "1.32376"}  # each gain used twice

# triple poles only, chosen to minimise the variance at t = 105: variance * t / q_a
ONE_STAGE, TWO_STAGES = "1.949", "1.241"
ONE_STAGE_ETA = 0.017469
TWO_STAGE_ETAS, TWO_STAGE_SWITCH = (0.101098, 0.0103333), 15.6157


# ---------------------------------------------------------------------------- linear algebra


def expm(M):
    """exp(M) by Taylor's series on M / 2^n and n squarings."""
    n = max(0, int(np.ceil(np.log2(max(np.abs(M).sum(axis=0).max(), 1e-300)))) + 2)
    term = total = np.eye(len(M))
    for k in range(1, 20):
        term = term @ M / (k * 2.0**n)
        total = total + term
    for _ in range(n):
        total = total @ total
    return total


def van_loan(F, W, t):
    """Transition matrix of x' = F x + w over t and the covariance w (PSD W) adds meanwhile."""
    n = len(F)
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(F).sum(axis=0).max() * t, 1e-300)))) + 2)
    h = t / 2.0**halvings
    E = expm(np.block([[-F, W], [np.zeros((n, n)), F.T]]) * h)
    Phi = E[n:, n:].T
    Q = Phi @ E[:n, n:]
    for _ in range(halvings):  # over 2h: the first half's noise is carried through the second
        Q = Phi @ Q @ Phi.T + Q
        Phi = Phi @ Phi
    return Phi, Q


# ------------------------------------------------------------------------- conventional loop


def triple_pole_gains(eta):
    """The paper's design: three poles at -16 eta / 3."""
    return 16 * eta, 256 * eta**2 / 3, 4096 * eta**3 / 27


def gain_variance(gains, q_a=1.0):
    """The right-hand term of (5), the one that is bounded."""
    K1, K2, K3 = gains
    return q_a * K1 * K3 / (2 * (K1 * K2 - K3))


def is_stable(gains):
    """Routh and Hurwitz: (6)."""
    K1, K2, K3 = gains
    return min(gains) > 0 and K1 * K2 > K3


def scaled_to_bound(shape, eta):
    """The gains s k1, s^2 k2, s^3 k3 whose gain_variance is eta q_a: it is proportional to s."""
    s = eta / gain_variance(shape)
    return tuple(s ** (i + 1) * k for i, k in enumerate(shape))


def error_matrix(gains, k_gh=K_GH):
    """[eps, e, dV, dh_r]' = F [eps, e, dV, dh_r], and W_a drives dV."""
    K1, K2, K3 = gains
    return np.array([[0, K3, 0, 0], [0, -K1, 1, 0], [-1, -K2, 0, k_gh], [0, 0, 0, 0.0]])


def staged_variance(stages, times, q_a=Q_A, k_gh=K_GH, P0=LOOP_P0):
    """E eps^2 at increasing times; stages are (start, gains), the first from t = 0."""
    W = np.diag([0.0, 0.0, q_a, 0.0])
    starts = [s for s, _ in stages] + [np.inf]
    now, P, out = 0.0, np.array(P0, float), []
    for t in times:
        for (_, gains), end in zip(stages, starts[1:], strict=True):
            until = min(t, end)
            if until > now:
                Phi, Q = van_loan(error_matrix(gains, k_gh), W, until - now)
                P = Phi @ P @ Phi.T + Q
                now = until
        out.append(P[0, 0])
    return np.array(out)


def conventional_variance(
    gains, times, q_a=Q_A, k_gh=K_GH, sigma_hr2=VAR_HR, sigma_ab2=VAR_AB, P0=None
):
    """E eps^2 at increasing times of a loop with constant gains: (10) in error coordinates."""
    P0 = np.diag([sigma_ab2, 0.0, 0.0, sigma_hr2]) if P0 is None else P0
    return staged_variance([(0.0, gains)], times, q_a, k_gh, P0)


def variance_by_eq10(gains, t, steps=4000, q_a=Q_A, k_gh=K_GH):
    """(10) as it stands for [A_B, dV, dh, dh_r, A_Bhat], by Runge and Kutta; C is corrected."""
    K1, K2, K3 = gains[0], gains[1] + k_gh, gains[2]
    C, D = np.zeros((5, 5)), np.diag([0.0, q_a, 0.0, 0.0, 0.0])
    C[1], C[2], C[4] = [1, 0, k_gh - K2, K2, -1], [0, 1, -K1, K1, 0], [0, 0, K3, -K3, 0]
    P = np.diag([VAR_AB, 0.0, VAR_HR, VAR_HR, 0.0])
    P[2, 3] = P[3, 2] = VAR_HR
    h = t / steps

    def slope(P):
        return C @ P + P @ C.T + D

    for _ in range(steps):
        a = slope(P)
        b = slope(P + h / 2 * a)
        c = slope(P + h / 2 * b)
        P = P + h / 6 * (a + 2 * b + 2 * c + slope(P + h * c))
    return P[0, 0] + P[4, 4] - 2 * P[0, 4]


def last_time_above(level, gains, end, step=0.5, **model):
    """Last t <= end at which the loop's variance is above the level, by a grid and bisection."""
    times = np.arange(0.0, end + step / 2, step)
    above = np.nonzero(conventional_variance(gains, times, **model) > level)[0]
    if len(above) == 0:
        return 0.0
    if above[-1] == len(times) - 1:
        return np.inf
    low, high = times[above[-1]], times[above[-1] + 1]
    for _ in range(50):
        mid = (low + high) / 2
        outside = conventional_variance(gains, [mid], **model)[0] > level
        low, high = (mid, high) if outside else (low, mid)
    return low


# ----------------------------------------------------------------------------- step response


def step_error(gains, times):
    """1 - y(t) of K3 / (s^3 + K1 s^2 + K2' s + K3) for a unit step, at equidistant times from 0."""
    K1, K2, K3 = gains
    E = expm(np.array([[0, 1, 0], [0, 0, 1], [-K3, -K2, -K1]]) * (times[1] - times[0]))
    x, out = np.array([0.0, 0.0, 1.0]), []
    for _ in times:
        out.append(K2 * x[0] + K1 * x[1] + x[2])
        x = E @ x
    return np.array(out)


def triple_pole_step_error(pole, times):
    """The same in closed form for (s + pole)^3."""
    x = pole * np.asarray(times)
    return np.exp(-x) * (1 + x + x**2 / 2)


def settling_time(gains, tolerance, end, samples=20001):
    """Last time <= end with |1 - y| > tolerance: inverse interpolation by a cubic."""
    times = np.linspace(0.0, end, samples)
    error = np.abs(step_error(gains, times)) - tolerance
    last = np.nonzero(error > 0)[0][-1]
    if last == samples - 1:
        return np.inf
    lead = min(max(last - 1, 0), samples - 4)  # four samples around the crossing: t as a cubic
    t, f = times[lead : lead + 4], error[lead : lead + 4]
    return sum(
        t[i] * np.prod([-f[j] / (f[i] - f[j]) for j in range(4) if j != i]) for i in range(4)
    )


def ise(gains):
    """Integral of the squared step error: Parseval's integral by residues."""
    K1, K2, K3 = gains
    return K2 / (2 * K3) + K1**2 / (2 * (K1 * K2 - K3))


def ise_by_quadrature(gains, end, samples=20001):
    """The same by Simpson's rule; samples is odd."""
    times = np.linspace(0.0, end, samples)
    f = step_error(gains, times) ** 2
    return (times[1] / 3) * (f[0] + 4 * f[1:-1:2].sum() + 2 * f[2:-2:2].sum() + f[-1])


def least_ise_in_box(largest):
    """Least ISE with gain_variance <= 1 and all gains <= largest (>= 8): 1/4 + sqrt(2 / largest).

    At the bound K2' = K3 / K1 + K3 / 2, which leaves ISE = 1/4 + 1/(2 K1) + K1 / K3.
    """
    K1 = np.sqrt(largest / 2)
    return 0.25 + np.sqrt(2 / largest), (K1, largest / K1 + largest / 2, largest)


# ------------------------------------------------------------------------------ Kalman filter


def kalman_F(k_gh=K_GH):
    """F of (11)."""
    return np.array([[0, 0, 0], [1, 0, k_gh], [0, 1, 0.0]])


def discrete(Ts, q_a=Q_A, k_gh=K_GH):
    """Phi and Q over Ts by Van Loan's exponential."""
    return van_loan(kalman_F(k_gh), np.diag([0.0, q_a, 0.0]), Ts)


def discrete_closed(Ts, q_a=Q_A, k_gh=K_GH):
    """Phi and Q over Ts in closed form, in 40 digits because Q33 cancels."""
    with mpmath.workdps(40):
        T, k = mpmath.mpf(Ts), mpmath.mpf(k_gh)
        w = mpmath.sqrt(k)
        s, c, s2 = mpmath.sinh(w * T), mpmath.cosh(w * T), mpmath.sinh(2 * w * T) / (4 * w)
        Phi = [[1, 0, 0], [s / w, c, w * s], [(c - 1) / k, s / w, c]]
        cross = q_a * s**2 / (2 * k)
        Q = [[0, 0, 0], [0, q_a * (T / 2 + s2), cross], [0, cross, q_a / k * (s2 - T / 2)]]
        return np.array(Phi, float), np.array(Q, float)


def printed_Q(Ts, q_a=Q_A, k_gh=K_GH):
    """Q as printed; det Q = (q_a cosh sinh)^2 (1 - 1/Ts^2) / k_gh is negative for Ts < 1."""
    w = np.sqrt(k_gh)
    s, c, cross = np.sinh(w * Ts), np.cosh(w * Ts), np.sinh(2 * w * Ts) / (2 * Ts * w)
    return q_a * np.array([[0, 0, 0], [0, c**2, cross], [0, cross, s**2 / k_gh]])


class History(NamedTuple):
    """Covariances P(+) and gains P(+) H' / q_b of the samples k = 0, 1, ..., at t = k Ts."""

    P: np.ndarray
    K: np.ndarray


def kalman_history(Ts, steps, q_a=Q_A, q_b=Q_B, k_gh=K_GH, P0=KALMAN_P0, first=0):
    """(14) to (16) for k = 0 .. steps; the first measurement is at sample `first`."""
    Phi, Q = discrete(Ts, q_a, k_gh)
    P, Ps, Ks = np.array(P0, float), [], []
    for k in range(steps + 1):
        if k > 0:
            P = Phi @ P @ Phi.T + Q
        if k >= first:
            P = P - np.outer(P[:, 2], P[2]) / (P[2, 2] + q_b)
        P = (P + P.T) / 2
        Ps.append(P)
        Ks.append(P[:, 2] / q_b if k >= first else np.zeros(3))
    return History(np.array(Ps), np.array(Ks))


def riccati_history(times, q_a=Q_A, r_c=Q_B, k_gh=K_GH, P0=KALMAN_P0, step=0.5):
    """P of P' = F P + P F' + Q - P H' H P / r_c at increasing times, exact: Y = P X is linear."""
    F = kalman_F(k_gh)
    M = np.block([[-F.T, np.diag([0, 0, 1 / r_c])], [np.diag([0, q_a, 0]), F]])
    now, P, out = 0.0, np.array(P0, float), []
    for t in times:
        parts = int(np.ceil((t - now) / step))
        if parts > 0:
            E = expm(M * ((t - now) / parts))
            for _ in range(parts):
                X, Y = E[:3, :3] + E[:3, 3:] @ P, E[3:, :3] + E[3:, 3:] @ P
                P = np.linalg.solve(X.T, Y.T).T
                P = (P + P.T) / 2
        now = t
        out.append(P)
    return np.array(out)


def sensitivity_history(gains, Ts, q_a=Q_A, q_b=Q_B, k_gh=K_GH, P0=KALMAN_P0):
    """P(+) of a filter that uses the given gains on this truth: (19), update before prediction."""
    Phi, Q = discrete(Ts, q_a, k_gh)
    P, out = np.array(P0, float), []
    for k, gain in enumerate(gains):
        if k > 0:
            P = Phi @ P @ Phi.T + Q
        keep = np.eye(3) - np.outer(gain, [0, 0, 1])
        P = keep @ P @ keep.T + q_b * np.outer(gain, gain)
        out.append(P)
    return np.array(out)


def sensitivity_shares(Ts, steps):
    """d ln P11(+) / d ln of q_a, q_b, VAR_AB, VAR_HR with the nominal gains; rows sum to 1.

    (19) is linear in these four, so a share is the derivative and every difference quotient.
    """
    K = kalman_history(Ts, steps).K
    none = np.zeros((3, 3))
    alone = [
        {"q_b": 0.0, "P0": none},
        {"q_a": 0.0, "P0": none},
        {"q_a": 0.0, "q_b": 0.0, "P0": np.diag([VAR_AB, 0.0, 0.0])},
        {"q_a": 0.0, "q_b": 0.0, "P0": np.diag([0.0, 0.0, VAR_HR])},
    ]
    parts = np.array([sensitivity_history(K, Ts, **truth)[:, 0, 0] for truth in alone]).T
    return parts / sensitivity_history(K, Ts)[:, :1, 0]


def steady_closed(Ts, q_a=Q_A, q_b=Q_B):
    """A, B, K2inf and K3inf of the paper, exact for K_gh -> 0."""
    A = q_a * (Ts**2 + np.sqrt(Ts**4 / 3 + 16 * q_b * Ts / q_a)) / 2
    B = np.sqrt(A**2 - 4 * q_a * q_b * Ts)
    K3 = 1 - 2 * q_a * q_b * Ts / (A * B + B**2 + 2 * q_a * q_b * Ts)
    return A, B, (A - B) / (2 * q_b), K3


def steady_iterated(Ts, q_a=Q_A, q_b=Q_B, k_gh=0.0, steps=5000):
    """K2inf and K3inf by iterating (15) and (16) on [dV, dh]: the bias is not driven."""
    F, W = np.array([[0, k_gh], [1, 0.0]]), np.diag([q_a, 0.0])
    Phi, Q = van_loan(F, W, Ts)
    P = np.diag([0.0, VAR_HR])
    for _ in range(steps):
        P = Phi @ P @ Phi.T + Q
        P = P - np.outer(P[:, 1], P[1]) / (P[1, 1] + q_b)
    return P[:, 1] / q_b


# ------------------------------------------------------------------------------- stored gains


def segment_means(gains, edges):
    """Gains held at their mean over samples edges[i] .. edges[i + 1] - 1."""
    out = np.empty_like(gains)
    for a, b in pairwise(edges):
        out[a:b] = np.mean(gains[a:b], axis=0)
    return out


def time_integral(values, Ts):
    """Trapezoidal rule over the samples."""
    return Ts * (values[:-1] + values[1:]).sum() / 2
