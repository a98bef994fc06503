"""The mixing filter against the textbook loops of You and Lee, and what must not stop it."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    AngleSample,
    Complementary,
    ComplementaryGain,
    PiComplementary,
    PiGains,
    PiSample,
    VelocityNoise,
    accelerometer_angles,
    run,
)
from tests import oracles_you_lee as oracle

AIDS = {"gyro": "none", "eq10": "airspeed", "kf": "velocity"}
N = 300
"""Of a short record; longer ones are cut, for each length is a compilation."""
# Without the compiler's optimisation, which changes no formula and takes most of the time.
QUICK = {"xla_backend_optimization_level": 0}
compiled = jax.jit(run, static_argnums=0, compiler_options=QUICK)


def params(start, velocity="zero", p0=0.0, q_k=oracle.Q_K, threshold=oracle.THRESHOLD):
    x0 = start.velocity[0] * ([1, 1, 1] if velocity == "true" else [1, 0, 0])
    noise = VelocityNoise(q_k, oracle.R_K, threshold, x0, p0)
    angles0 = np.array([start.phi[0], start.theta[0]])
    made = PiGains(oracle.K1, oracle.K2, oracle.G, angles0, noise)
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, float), made)


def samples(sensors, rows=slice(None)):
    return PiSample(
        *(jnp.asarray(part[rows, 0]) for part in (sensors.acc, sensors.gyro, sensors.airspeed))
    )


def filtered(case, gains, inputs, dt=oracle.T):
    return jax.tree.map(np.asarray, compiled(PiComplementary(dt, AIDS[case]), gains, inputs)[1])


def printed(digits):
    """A number of so many digits, within half of its last one."""
    places = len(digits.partition(".")[2])
    return pytest.approx(float(digits), abs=0.5000001 * 10**-places)


# ------------------------------------------------------------------------------ the textbook


@pytest.mark.parametrize("case", oracle.CASES)
def test_every_digit_of_the_deterministic_run(case):
    true = oracle.truth("T1")
    angles = filtered(case, params(true), samples(oracle.deterministic("T1"))).angles
    error = np.degrees(angles - np.stack([true.phi, true.theta], axis=1)[1:])
    for t, digits in oracle.D1[case].items():
        assert list(error[oracle.row(t) - 1]) == [printed(each) for each in digits], t


@cache
def cut(name, seed=1):
    """The first seconds of a turn with errors, and where the textbook starts: its true row."""
    rng = np.random.default_rng(seed)
    rows = slice(25000, 25000 + N)
    exact = oracle.deterministic(name, 2e-4, 3e-3)
    short = oracle.Sensors(*(part[rows] + 0.0 for part in exact))
    short.gyro[...] += 1e-4 * rng.normal(size=short.gyro.shape)
    short.airspeed[...] += rng.normal(size=short.airspeed.shape)
    return short, oracle.Motion(*(part[rows] for part in oracle.truth(name)))


@pytest.mark.parametrize("name", ["T1", "T2"])
@pytest.mark.parametrize("velocity", oracle.STARTS)
@pytest.mark.parametrize("p0", [0.0, 50.0])
def test_the_turn_is_the_textbooks(name, velocity, p0, monkeypatch):
    sensors, start = cut(name)
    monkeypatch.setattr(oracle, "N", N)
    for case in oracle.CASES:
        expected = oracle.run(sensors, start, case, velocity=velocity, p0=p0, q_k=1e-4)
        found = filtered(case, params(start, velocity, p0, 1e-4), samples(sensors))
        true = np.stack([expected["phi"], expected["theta"]], axis=-1)[1:, 0]
        # angles of 0.5 rad, 300 samples of rounding
        np.testing.assert_allclose(found.angles, true, rtol=1e-12, atol=1e-14)
        if case == "kf":
            np.testing.assert_array_equal(found.running, expected["running"][1:, 0])
            assert 0 < found.running.sum() < N
            np.testing.assert_allclose(
                found.velocity, expected["velocity"][1:, 0], rtol=1e-12, atol=1e-9
            )


def test_airspeed_alone_is_velocity_without_sides():
    force, rate = jnp.array([1.0, -3.0, -30.0]), jnp.array([0.01, 0.02, 0.03])
    expected = oracle.accelerometer_angles(np.asarray(force), *np.asarray(rate), 500.0, 40.0, -9.0)
    velocity, gravity = jnp.array([500.0, 40.0, -9.0]), jnp.array(oracle.G)
    found = jax.jit(accelerometer_angles)(force, rate, velocity, gravity)
    np.testing.assert_allclose(found, expected, rtol=1e-14)


# ------------------------------------------------------------- samples that bring no attitude


def short(**changed):
    """A turn's first seconds in which samples 40 to 59 are changed."""
    inputs = samples(cut("T1")[0])
    spoilt = {name: np.array(getattr(inputs, name)).copy() for name in ("acc", "gyr", "airspeed")}
    for name, (at, value) in changed.items():
        spoilt[name][(slice(40, 60), *at)] = value
    return PiSample(*(jnp.asarray(spoilt[name]) for name in ("acc", "gyr", "airspeed")))


SPOILT = {
    "force forward": {"acc": ((0,), np.nan)},
    "force down": {"acc": ((2,), np.nan)},
    "all of the force": {"acc": ((), np.nan)},
    "airspeed": {"airspeed": ((), np.nan)},
    "one rate": {"gyr": ((2,), np.nan)},
    "more than gravity": {"acc": ((0,), 40.0)},
    "exactly gravity": {"acc": ((0,), oracle.G)},
    "more across than gravity": {"acc": ((1,), -80.0)},
    "everything": dict.fromkeys(("acc", "gyr", "airspeed"), ((), np.nan)),
}


def end(gains, inputs):
    found = run(PiComplementary(oracle.T, "velocity"), gains, inputs)[1]
    return found.angles[-1] @ jnp.array([1.0, 2.0]) + found.velocity[-1].sum()


slopes = jax.jit(jax.jacfwd(end), compiler_options=QUICK)


@pytest.mark.parametrize("spoil", SPOILT)
def test_no_nan_in_outputs_or_derivatives(spoil):
    gains, inputs = params(cut("T1")[1], p0=5.0), short(**SPOILT[spoil])
    found = [filtered(case, gains, inputs) for case in ("eq10", "kf")]
    for leaf in jax.tree.leaves((found, slopes(gains, inputs))):
        assert np.isfinite(leaf).all()


def test_a_sample_without_an_attitude_corrects_nothing():
    """It moves as the gyroscopes alone say, and by the integral as it stands."""
    gains = params(cut("T1")[1])
    for spoil, still in (("more than gravity", (0, 1)), ("more across than gravity", (0,))):
        inputs = short(**SPOILT[spoil])
        state = compiled(PiComplementary(oracle.T), gains, jax.tree.map(lambda x: x[:40], inputs))[
            0
        ]
        found = filtered("eq10", gains, inputs).angles
        rates = np.array(oracle.rates(*found[39], *np.asarray(inputs.gyr[40])))
        moved = found[39] + oracle.T * (rates + np.asarray(state.integral))
        for angle in (0, 1):
            same = found[40, angle] == pytest.approx(moved[angle], abs=1e-15)
            assert same == (angle in still)


def test_a_missing_rate_stays_as_it_was():
    gains, inputs = params(cut("T1")[1]), short(gyr=((), np.nan))
    held = np.array(inputs.gyr).copy()
    held[40:60] = held[39]
    expected = filtered("kf", gains, inputs._replace(gyr=jnp.asarray(held)))
    found = filtered("kf", gains, inputs)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_velocity_needs_its_noise():
    with pytest.raises(ValueError, match="'velocity' needs a VelocityNoise"):
        PiComplementary(0.01, "velocity").init(params(cut("T1")[1])._replace(velocity=None))


# ---------------------------------------------------------------------------------- first order


def test_first_order_is_a_blend():
    rng = np.random.default_rng(3)
    rate, angle = rng.normal(size=(2, N, 2))
    angle[7, 1] = rate[9, 0] = np.nan
    gain = ComplementaryGain(jnp.asarray(0.3), jnp.array([0.1, -0.2]))
    out = compiled(Complementary(0.1), gain, AngleSample(jnp.asarray(rate), jnp.asarray(angle)))[1]
    at, share = np.array([0.1, -0.2]), 0.3 / 0.4
    for k in range(N):
        ahead = at + 0.1 * np.where(np.isnan(rate[k]), 0.0, rate[k])
        at = np.where(np.isnan(angle[k]), ahead, share * ahead + (1 - share) * angle[k])
        np.testing.assert_allclose(out[k], at, rtol=1e-12)


def test_first_order_leaves_tau_times_the_bias():
    gain = ComplementaryGain(jnp.asarray(0.5), jnp.zeros(()))
    still = AngleSample(0.02 * jnp.ones(N), jnp.zeros(N))
    out = compiled(Complementary(0.1), gain, still)[1]
    assert float(out[-1]) == pytest.approx(0.5 * 0.02, rel=1e-12)


def test_a_sample_time_may_be_traced():
    zero, gain = jnp.zeros(()), ComplementaryGain(jnp.asarray(0.5), jnp.zeros(()))

    def moved(dt):
        return Complementary(dt).step(gain, zero, AngleSample(zero + 1, zero))[1]

    found = jax.vmap(moved)(jnp.array([0.1, 0.2]))
    np.testing.assert_allclose(found, [moved(0.1), moved(0.2)], rtol=1e-12)
