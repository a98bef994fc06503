"""The tilt filters of Suh et al. 2004 against the textbook loops and their numbers."""

import inspect
import itertools
import math
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given

from filters import TiltKalman, TiltNoise, TiltSample, run, tilt_disturbance, tilt_transition
from filters.tilt_euler import TO_PAPER
from objectives import angle_errors
from tests import oracles_suh2004 as suh
from tests.oracles import surprise, surprises
from tests.strategies import seeds
from tuner.data.simulation import GRAVITY, Swing, simulate

N = 600
"""Of every record: shorter ones are padded, for each length is a compilation."""

LAWS = ("standard", "simple", "two-step")
STATIC = {
    "jacobian": ("full", "printed"),
    "innovation": ("nonlinear", "linearised", "linear"),
    "residual": ("absolute", "signed"),
    "fading": ("printed", "convex"),
}
VARIANTS = [
    (law, dict(zip(STATIC, choice, strict=True)))
    for law in LAWS
    for choice in itertools.product(*STATIC.values())
]


def noise(**settings):
    chosen = suh.DEFAULTS | settings
    names = ("q1", "r_nom", "r3", "alpha1", "alpha2", "delta", "r_big")
    values = (jnp.asarray(chosen[name], float) for name in names)
    in_g, x0 = jnp.ones(()), jnp.asarray(chosen["x0"], float)
    return TiltNoise(*values, in_g, x0, jnp.zeros(()))


def sampled(acc, gyr):
    pad = N - len(acc)
    parts = (np.concatenate([part, np.repeat(part[-1:], pad, axis=0)]) for part in (acc, gyr))
    acc, gyr = parts
    return TiltSample(jnp.asarray(acc), jnp.asarray(gyr * TO_PAPER))


# Without the compiler's optimisation, which changes no formula and takes most of the time.
compiled = jax.jit(run, static_argnums=0, compiler_options={"xla_backend_optimization_level": 0})


finished = {}


@cache
def looped(filter):
    """The compiled run; filters that are traced to the same operations share one."""
    traced = compiled.trace(filter, noise(), sampled(*suh.still(N)))
    text = str(traced.jaxpr)
    if text not in finished:
        finished[text] = traced.lower().compile()
    return finished[text]


def follow(filter, acc, gyr, **settings):
    """What a filter makes of a record, in the oracle's words."""
    out = looped(filter)(noise(**settings), sampled(acc, gyr))[1]
    columns = [*out.angles.T, *out.rates.T, *out.r.T, out.detected]
    names = ("theta", "phi", "wx", "wy", "wz", "r1", "r2", "detected")
    return {name: np.asarray(c)[: len(acc)] for name, c in zip(names, columns, strict=True)}


def test_innovations_are_as_surprising_as_the_joint_one():
    """Rates and accelerations of one sample, all linearised at the prediction."""
    filter = TiltKalman(suh.T, "standard", innovation="linearised")
    params, (acc, gyr) = noise()._replace(P0=jnp.asarray(0.1)), suh.still(N)
    _, out = compiled(filter, params, sampled(acc, gyr))
    x, F = np.array(suh.DEFAULTS["x0"], float), np.asarray(tilt_transition(params.x0, suh.T))
    Q = np.asarray(tilt_disturbance(params.x0, params.q1, suh.T))
    x, P = F @ x, F @ (0.1 * np.eye(5)) @ F.T + Q
    (s, c), (sp, cp) = (np.sin(x[:2]), np.cos(x[:2])), (np.sin(x[1]), np.cos(x[1]))
    C = np.zeros((5, 5))
    C[:3, 2:] = np.eye(3)
    C[3:, :2] = [[c[0], 0.0], [-sp * s[0], cp * c[0]]]
    e = np.concatenate([gyr[0] - x[2:], acc[0, :2] - [s[0], sp * c[0]]])
    variances = [params.r3] * 3 + [params.r_nom] * 2
    expected = surprise(e, C @ P @ C.T + np.diag(np.array(variances)))
    found = surprises(np.asarray(out.innovation), np.asarray(out.variance))
    assert found[0] == pytest.approx(expected, rel=1e-12)


def test_what_is_not_measured_surprises_nobody():
    acc, gyr = (np.array(part) for part in suh.still(N))
    acc[3, 0], gyr[5, 1] = np.nan, np.nan
    _, out = compiled(TiltKalman(suh.T), noise(), sampled(acc, gyr))
    nothing = [tuple(place) for place in np.argwhere(np.asarray(out.variance) == 0)]
    assert nothing == [(3, 3), (5, 1)]
    assert not np.asarray(out.innovation)[[3, 5], [3, 1]].any()


def same(found, expected, tolerance=1e-12):
    """Angles, rates and variances, of order 1: tens of samples' rounding that does not grow."""
    assert found.keys() == expected.keys()
    for name in found:
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=tolerance)


def agrees(value, text):
    """To every digit of a printed number: half a unit of its last one."""
    digits = len(text.partition(".")[2])
    return abs(value - float(text)) <= 0.501 * 10**-digits


# ------------------------------------------------------------------------- the paper's numbers


@pytest.mark.parametrize("row", suh.EXPERIMENT_2)
def test_second_experiment(row):
    law, settings, expected = suh.EXPERIMENT_2[row]
    found = follow(TiltKalman(suh.T, law, **settings), *suh.experiment2())
    angles = jnp.stack([found["theta"], found["phi"]], axis=1)
    S, M = angle_errors(angles, jnp.zeros_like(angles))
    for value, text in zip([*S, *M], expected, strict=True):
        assert agrees(float(value), text), (float(value), text)


@pytest.mark.parametrize("row", suh.PULSE)
def test_pulse(row):
    law, settings, _ = suh.EXPERIMENT_2[row]
    filter = TiltKalman(suh.T, law, **settings)
    for sign, text in zip((1, -1), suh.PULSE[row], strict=True):
        phi = np.degrees(follow(filter, *suh.pulse(sign))["phi"])
        assert agrees(phi[np.abs(phi).argmax()], text)


def test_variance_in_the_pulse():
    r2 = follow(TiltKalman(suh.T), *suh.pulse(1))["r2"]
    for k, text in suh.PULSE_R2.items():
        assert agrees(r2[k - 1], text)


def test_defaults_are_the_corrected_two_step_filter():
    assert TiltKalman(0.05) == TiltKalman(
        0.05, "two-step", "full", "nonlinear", "absolute", "printed"
    )


# ------------------------------------------------------------------------- against the oracle


@cache
def mixed():
    """60 samples of turning up to 40 deg, with noise, and disturbed from time to time."""
    rng = np.random.default_rng(2004)
    t = suh.T * np.arange(60)
    theta, phi = np.radians(40) * np.sin(1.1 * t), np.radians(40) * np.sin(0.8 * t + 1)
    acc = np.stack(
        [np.sin(theta), np.sin(phi) * np.cos(theta), np.cos(phi) * np.cos(theta)], axis=1
    )
    acc += 0.004 * rng.normal(size=(60, 3))
    acc += 0.4 * rng.normal(size=(60, 3)) * (np.arange(60) // 6 % 3 == 1)[:, None]
    dtheta, dphi = np.gradient(theta, suh.T), np.gradient(phi, suh.T)
    gyr = np.stack([dphi, dtheta * np.cos(phi), -dtheta * np.sin(phi)], axis=1)  # no yaw
    return acc, gyr + 0.1 * rng.normal(size=(60, 3))


MIXED = {"q1": 0.7, "r_nom": 0.03, "r3": 0.6, "alpha1": 0.5, "alpha2": 4.0, "delta": 0.05}
MIXED |= {"r_big": 3.0, "x0": (0.3, 0.4, -0.1, 0.2, 0.1)}


@pytest.mark.parametrize(
    ("law", "variant"), VARIANTS, ids=lambda v: v if isinstance(v, str) else " ".join(v.values())
)
def test_every_variant_is_the_textbooks(law, variant):
    acc, gyr = mixed()
    asked = {"jacobian": variant["jacobian"], "residual": variant["residual"]}
    asked["decay"] = variant["fading"]
    if variant["innovation"] == "linearised":
        asked["prediction"] = "linearised"
    else:
        asked["innovation"] = variant["innovation"]
    expected = suh.run(acc, gyr, law, **MIXED, **asked)
    found = follow(TiltKalman(suh.T, law, **variant), acc, gyr, **MIXED)
    same(found, expected)
    assert 10 < found["detected"].sum() < 40
    assert np.degrees(np.abs(found["phi"]).max()) > 25  # or no sine differs from its slope


def test_the_variants_differ():
    """Each choice of the two-step filter changes its angles, or agreement would mean nothing."""
    plain = follow(TiltKalman(suh.T), *mixed(), **MIXED)["phi"]
    for name, choices in STATIC.items():
        for choice in choices[1:]:
            other = follow(TiltKalman(suh.T, **{name: choice}), *mixed(), **MIXED)["phi"]
            assert np.abs(other - plain).max() > 1e-5, (name, choice)


@pytest.mark.parametrize("name", ["q1", "r3", "alpha1", "alpha2", "delta", "r_big"])
def test_every_parameter_has_the_meaning_that_the_oracle_gives_it(name):
    """One at a time away from the others' point, so that no two can stand for one another."""
    law = "simple" if name == "r_big" else "two-step"
    settings = MIXED | {name: (8.0 if name == "delta" else 1.7) * MIXED[name]}
    expected = suh.run(*mixed(), law, **settings)
    same(follow(TiltKalman(suh.T, law), *mixed(), **settings), expected)
    before = suh.run(*mixed(), law, **MIXED)
    assert np.abs(expected["phi"] - before["phi"]).max() > 1e-4


# ---------------------------------------------------------------------------------- properties


def test_linearised_two_step_at_a_constant_variance_is_the_standard_filter():
    """alpha1 = 1 with convex fading, and alpha2 = 0: r stays at r_nom."""
    constant = MIXED | {"alpha1": 1.0, "alpha2": 0.0}
    two = TiltKalman(suh.T, innovation="linearised", fading="convex")
    found = follow(two, *mixed(), **constant)
    same(found, follow(TiltKalman(suh.T, "standard"), *mixed(), **constant))
    # with f at the gyroscopes' estimate it is another filter
    again = follow(TiltKalman(suh.T, fading="convex"), *mixed(), **constant)
    assert np.abs(again["phi"] - found["phi"]).max() > 1e-6


def test_standard_is_simple_with_one_variance():
    one = MIXED | {"r_big": MIXED["r_nom"]}
    found = follow(TiltKalman(suh.T, "simple"), *mixed(), **one)
    same(found, follow(TiltKalman(suh.T, "standard"), *mixed(), **one), 1e-14)


@pytest.mark.parametrize("law", LAWS)
def test_the_scale_of_the_noises_is_free(law):
    names = ("q1", "r_nom", "r3", "alpha2", "r_big")
    scaled = MIXED | {name: 37.0 * MIXED[name] for name in names}
    found = follow(TiltKalman(suh.T, law), *mixed(), **MIXED)
    other = follow(TiltKalman(suh.T, law), *mixed(), **scaled)
    same({**other, "r1": other["r1"] / 37, "r2": other["r2"] / 37}, found)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("theta", "phi"), [(0, 0), (20, -35), (-45, 10), (60, 60), (-60, 45)])
def test_static_attitude_is_found(law, theta, phi):
    found = follow(TiltKalman(suh.T, law), *suh.static(np.radians(theta), np.radians(phi), N))
    assert np.degrees(found["theta"][-1]) == pytest.approx(theta, abs=1e-6)
    assert np.degrees(found["phi"][-1]) == pytest.approx(phi, abs=1e-6)


def test_linear_innovation_rests_beside_the_truth():
    """As printed: 1 deg wrong at 20 deg, and without rest above 34 deg."""
    filter = TiltKalman(suh.T, "standard", innovation="linear")
    for degrees, text in suh.LINEAR_FIXED_POINT.items():
        theta = follow(filter, *suh.static(np.radians(degrees), 0.0, N))["theta"]
        assert agrees(math.degrees(theta[-1]), text)


@pytest.mark.parametrize("law", LAWS)
def test_mirrored_axis_negates_the_roll(law):
    """ay, gx and gz; rounding is symmetric too, but for the order of the sums."""
    mirrored = MIXED | {"x0": (0.3, -0.4, 0.1, 0.2, -0.1)}
    acc, gyr = mixed()
    found = follow(TiltKalman(suh.T, law), acc, gyr, **MIXED)
    other = follow(
        TiltKalman(suh.T, law), acc * [1.0, -1.0, 1.0], gyr * [-1.0, 1.0, -1.0], **mirrored
    )
    signs = {"phi": -1, "wx": -1, "wz": -1}
    same({name: signs.get(name, 1) * column for name, column in other.items()}, found)
    if law == "two-step":  # with gz as it is, it is another motion
        other = follow(
            TiltKalman(suh.T, law), acc * [1.0, -1.0, 1.0], gyr * [-1.0, 1.0, 1.0], **mirrored
        )
        assert np.abs(other["phi"] + found["phi"]).max() > 1e-4


def test_missing_samples_are_left_out():
    """Accelerometers alone, gyroscopes alone, and one axis; nothing is detected meanwhile."""
    acc, gyr = (part.copy() for part in mixed())
    acc[8:10], gyr[20:22], acc[31, 2] = np.nan, np.nan, np.nan
    found = follow(TiltKalman(suh.T), acc, gyr, **MIXED)
    assert all(np.isfinite(column).all() for column in found.values())
    assert mixed()[0].shape == (60, 3)
    whole = follow(TiltKalman(suh.T), *mixed(), **MIXED)
    assert whole["detected"][8:10].all()
    assert not found["detected"][[8, 9, 31]].any()
    for name, column in found.items():
        np.testing.assert_array_equal(column[:8], whole[name][:8])
    # r fades towards its rest as without a disturbance
    expected = MIXED["alpha1"] * found["r2"][7] + MIXED["r_nom"]
    assert found["r2"][8] == pytest.approx(expected, rel=1e-14)


def test_follows_a_simulated_motion():
    """The paper's polarity is that of axes forward, left, up; its rates are about right and down.

    Euler steps of 50 ms and no noise: within a degree over 30 s.
    """
    motion = simulate(seconds=30.0, dt=suh.T, seed=4, swing=Swing((0.4, 0.3, 0.5), fastest=0.2))
    rates = motion.rate * [1.0, -1.0, -1.0]
    found = follow(TiltKalman(suh.T), motion.force / GRAVITY, rates, r3=1e-3)
    error = np.degrees(np.stack([found["phi"], found["theta"]], axis=1) - motion.angles[:, :2])
    assert np.abs(error).max() < 1.0
    assert np.degrees(np.abs(motion.angles[:, :2])).max() > 25
    # with the rates of the sensor's own axes it does not follow
    wrong = follow(TiltKalman(suh.T), motion.force / GRAVITY, motion.rate, r3=1e-3)
    assert np.abs(wrong["theta"] - motion.angles[:, 1]).max() > np.radians(2)


# ------------------------------------------------------------------------------------ matrices


transition, disturbance = jax.jit(tilt_transition), jax.jit(tilt_disturbance)


def van_loan(A, Q, dt):
    """exp(A dt) and the covariance of its noise, by SciPy's matrix exponential."""
    n = len(A)
    block = scipy.linalg.expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * dt)
    Phi = block[n:, n:].T
    return Phi, Phi @ block[:n, n:]


@given(rng=seeds())
def test_matrices_are_exact_for_a_frozen_attitude(rng):
    """And for the oracle's, whose W is written by hand."""
    theta, phi = np.radians(60) * rng.uniform(-1, 1, 2)
    q1, dt = np.exp(rng.normal()), 10 ** rng.uniform(-3, 0)
    A = suh.system(phi, theta)
    Phi, Q = van_loan(A, q1 * np.diag([0.0, 0.0, 1.0, 1.0, 1.0]), dt)
    x = np.concatenate([[theta, phi], rng.normal(size=3)])  # whatever the rates
    np.testing.assert_allclose(transition(x, dt), Phi, rtol=0, atol=1e-12)
    np.testing.assert_allclose(disturbance(x, q1, dt), Q, rtol=0, atol=1e-12 * np.abs(Q).max())


def test_no_setting_is_left_out():
    """The battery of variants has every field of the class."""
    fields = set(inspect.signature(TiltKalman).parameters)
    assert fields == {"dt", "law", *STATIC}
