"""One case per way of using a filter; every filter has to pass every check of test_battery.py."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import (
    AccelerometerFilter,
    AlphaBeta,
    AlphaBetaGains,
    AlphaBetaGamma,
    AlphaBetaGammaGains,
    AngleSample,
    AnyFilter,
    AttitudeKalman,
    AttitudeNoise,
    Batched,
    BoundedMotionKalman,
    BoundedMotionNoise,
    Complementary,
    ComplementaryGain,
    ConstantAcceleration,
    ConstantAccelerationNoise,
    ConstantVelocity,
    ConstantVelocityNoise,
    ConventionalLoop,
    DeadReckoningKalman,
    DeadReckoningNoise,
    DeadReckoningSample,
    ErrorStateIns,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    FixedGainFilter,
    FixedGains,
    Flow,
    GainCovariance,
    GainedSample,
    GainTable,
    Gated,
    GpsAidedKalman,
    GpsAidedNoise,
    GpsAidedSample,
    GyroscopeFilter,
    ImuSample,
    InsNoise,
    InsSample,
    Joined,
    JoinedSample,
    KalmanCovariance,
    KownackiNoise,
    Lanes,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    LocalLevelNoise,
    LoopGains,
    LoopStep,
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    PiComplementary,
    PiGains,
    PiSample,
    PositionSample,
    RestRule,
    RiccatiCovariance,
    Sample,
    SteadyGain,
    SteadyGains,
    StoredGains,
    Student,
    TableCovariance,
    TiltKalman,
    TiltNoise,
    TiltSample,
    Timed,
    TimedSample,
    Transition,
    UnscentedKalman,
    VelocityNoise,
    Vertical,
    VerticalNoise,
    VerticalSample,
    loop_step,
    measured_entries,
    riccati_flow,
    shared,
    transitions,
)

N = 24


@dataclass(frozen=True, eq=False)
class Case:
    """A filter with parameters ``build(point)`` and a record.

    ``measured`` are the measurements, time first; ``inputs`` makes the filter's inputs of them.
    ``holes`` says that a NaN among them is a missing sample. It is False for a filter that takes no
    measurements: ``measured`` is then whatever it takes instead, and no check makes holes in it.
    """

    name: str
    filter: AnyFilter
    build: Callable[[Any], Any]
    point: np.ndarray
    measured: np.ndarray
    inputs: Callable[[Any], Any] = jnp.asarray
    holes: bool = True


def _noise(point):
    R, Q, p = jnp.exp(point)
    return KownackiNoise(R=R, Q=Q, P0=p * jnp.ones((2, 2)))


def _gains(point):
    return FixedGains(*jnp.exp(point))


_RNG = np.random.default_rng(20100907)
_ONE, _TWO = _RNG.normal(size=N), _RNG.normal(size=(N, 2))
_DT = _RNG.choice([0.1, 0.0, 0.25], N)
_A = jnp.array([[0.0, 1.0], [-2.0, -0.4]])
_PUSH = jnp.asarray(_RNG.normal(size=(N, 1)))


def _linear(point, full):
    q, r, p = jnp.exp(point)
    R = r * jnp.array([[1.0, 0.4], [0.4, 0.7]])
    return LinearModel(
        transition=Transition(
            F=jnp.array([[0.9, 0.1], [-0.2, 0.8]]),
            G=jnp.array([[0.5], [1.0]]),
            Q=q * jnp.eye(1),
            B=jnp.array([[0.0], [0.3]]),
        ),
        H=jnp.array([[1.0, 0.0], [0.3, 1.0]]),
        R=R if full else jnp.diag(R),
        P0=p * jnp.ones((2, 2)),
        x0=jnp.array([0.1, -0.2]),
    )


def _three_signals(point):
    return _linear(point, full=False)._replace(x0=jnp.array([[0.1, 0.0, 0.3], [-0.2, 0.0, 0.1]]))


@cache
def _steps():
    return transitions(_A, jnp.eye(2), 0.1 * jnp.eye(2), _DT)


def _varying(z):
    return Sample(jnp.asarray(z), transition=_steps())


def _full(point):
    return _linear(point, full=True)


def _table(point):
    return GainTable(_linear(point, full=False), K=jnp.exp(point[:2, None, None]) * _GAINS[:2])


@cache
def _hamiltonian():
    with jax.ensure_compile_time_eval():  # it is kept, and may be asked for while a trace goes on
        return riccati_flow(_A, jnp.array([[1.0, 0.3]]), jnp.eye(2), jnp.eye(1), jnp.array(0.1))


def _flow(point):
    """Both densities times s: in that unit P is s times as large."""
    s, p = jnp.exp(point)
    return Flow(_hamiltonian().at[:2, 2:].divide(s).at[2:, :2].multiply(s), p * jnp.ones((2, 2)))


@cache
def _loop_step():
    with jax.ensure_compile_time_eval():
        return loop_step(LoopGains(1.2, 0.8, 0.3), 0.1, k_gh=0.01)


def _loop(point):
    return LoopStep(_loop_step().F * point[0], _loop_step().B * point[1])


def _seen(point):
    """What a filter with given gains makes use of: how the model moves, is seen and starts."""
    model = _linear(point, full=False)
    move = model.transition._replace(F=model.transition.F * jnp.exp(point[0]) / 0.3)
    return model._replace(transition=move, H=model.H * point[1], x0=point[2] * model.x0)


def _steady(point):
    move = _linear(point, full=False).transition.F * jnp.exp(point[0]) / 0.3
    return SteadyGains(move, point[1] * jnp.eye(2), _GAINS[0], point[2] * jnp.eye(2))


def _gained(z):
    return GainedSample(jnp.asarray(z), _GAINS)


def swung(p, x, u):
    """A pendulum with friction over one Euler step; p is (omega^2, q)."""
    return jnp.stack([x[0] + 0.1 * x[1], x[1] - 0.1 * (p[0] * jnp.sin(x[0]) + 0.3 * x[1])])


def shaken(p, x, u):
    """More noise the further it is from rest, so that Q has a derivative by the state."""
    return p[1] * (1 + x[0] ** 2) * jnp.array([[1e-3, 1e-2], [1e-2, 0.2]], x.dtype)


def seen_from_the_side(p, x, u):
    return jnp.stack([jnp.sin(x[0]), x[1]])


def bearing_and_range(p, x, u):
    """From a mast that stands close by; the bearing goes beyond half a turn."""
    east, north = x[0] - 1.5, x[1] + 0.1
    return jnp.stack([jnp.arctan2(north, east), jnp.sqrt(east**2 + north**2)])


def _pendulum(point):
    omega, q, r = jnp.exp(point)
    return ExtendedModel(
        jnp.stack([omega, q]),
        R=r * jnp.array([0.1, 0.4]),
        x0=jnp.array([0.4, 0.1]),
        P0=jnp.diag(jnp.array([0.2, 0.1])),
    )


def _tilt(point):
    q1, r_nom, r3, alpha1, alpha2, r_big = jnp.exp(point)
    return TiltNoise(
        q1,
        r_nom,
        r3,
        alpha1,
        alpha2,
        jnp.asarray(0.05),
        r_big,
        jnp.ones(()),
        jnp.array([0.2, -0.3, 0.1, 0.2, -0.1]),
        jnp.asarray(0.1),
    )


def _gravity(point):
    gyroscope, bias, accelerometer, memory, gain, gravity = jnp.exp(point)
    return AttitudeNoise(
        gyroscope,
        bias,
        accelerometer,
        memory,
        gain,
        jnp.asarray(0.05),
        gravity,
        _TURNED,
        jnp.array([0.01, -0.02, 0.03]),
        jnp.asarray(0.2),
        jnp.asarray(0.1),
    )


def _mahony(point):
    return MahonyGains(*jnp.exp(point), _TURNED)


def _madgwick(point):
    return MadgwickGain(jnp.exp(point[0]), _TURNED)


def _mixing(point):
    K1, K2, gravity, Q_k, R_k, P0 = jnp.exp(point)
    x0 = jnp.array([30.0, 1.0, -2.0])
    noise = VelocityNoise(Q_k, R_k, jnp.asarray(0.8), x0, P0)
    return PiGains(K1, K2, gravity, jnp.array([0.1, -0.2]), noise)


def _aided(z):
    """Small forces forward and across, so that every arc sine exists; and an airspeed."""
    z = jnp.asarray(z) + jnp.array([0.0, 0.0, -1.0, 0.0])
    return PiSample(9.81 * z[:, :3], _RATES, 0.3 * (20.0 + z[:, 3]))


def _euler(point):
    Q, bias, angle = jnp.exp(point)
    zero, small = jnp.zeros(()), jnp.asarray(0.01)
    start = _TURNED, jnp.zeros(3), small, small
    return GpsAidedNoise(angle, angle, angle, Q, bias, zero, zero, zero, jnp.ones(7), *start)


def _dead_reckoning(point):
    small = jnp.asarray(0.01)
    x0 = jnp.array([0.1, -0.2, 0.3])
    return DeadReckoningNoise(*jnp.exp(point), small, small, x0, jnp.ones(()))


def _imu(z):
    """Of errors of a level accelerometer, so that a zero is not a force without direction."""
    return ImuSample(9.81 * (jnp.asarray(z) + jnp.array([0.0, 0.0, 1.0])), _RATES)


def _room(point):
    speed, place, accelerometer, turning, matrix0, lead = jnp.exp(point)
    small = jnp.asarray(1e-3)
    return BoundedMotionNoise(
        speed,
        place,
        accelerometer,
        small,
        turning,
        small,
        matrix0,
        jnp.asarray(0.1),
        jnp.asarray(0.2),
        lead,
        jnp.asarray(9.81),
        _TURNED,
    )


def _ins(point):
    """All noises larger than usual, for N samples to show them."""
    gyr, acc, gps, baro, mag, gravity = jnp.exp(point)
    start = {"tilt0": 0.1, "heading0": 0.3, "velocity0": 1.0, "position0": 1.0}
    start |= {"gyr_bias0": 0.1, "acc_bias0": 0.3, "heading": 0.4, "declination": 0.1}
    rest = {"R_gps_vel": 0.2, "R_speed": 0.1, "R_still": 0.1} | start
    return InsNoise(
        q_gyr=gyr,
        q_acc=acc,
        q_gyr_bias=0.1 * gyr,
        q_acc_bias=0.1 * acc,
        R_gps=gps,
        R_gps_up=2 * gps,
        R_baro=baro,
        R_mag=mag,
        gravity=gravity,
        **{name: jnp.asarray(value) for name, value in rest.items()},
    )


def _navigated(z):
    """Everything that aids, from columns of :data:`_NAVIGATED`."""
    z = jnp.asarray(z)
    force, rest = 9.81 * (z[:, :3] + jnp.array([0.0, 0.0, 1.0])), z[:, 3:]
    field = rest[:, 5:] + jnp.array([0.2, 1.0, -2.0])
    still = jnp.asarray(np.arange(N) % 11 == 5, z.dtype)
    force = jnp.where(jnp.isnan(force), jnp.array([0.1, 0.2, 9.8]), force)
    return InsSample(_RATES, force, rest[:, :3], None, rest[:, 3], rest[:, 4], field, still)


def _three_a_block(z):
    """Each sample thrice."""
    force = 9.81 * (jnp.asarray(z) + jnp.array([0.0, 0.0, 1.0]))
    return ImuSample(*(jnp.repeat(part[:, None], 3, axis=1) for part in (force, _RATES)))


def _compass(z):
    z = jnp.asarray(z) + jnp.array([0.0, 0.0, 1.0, 0.0, 0.8, -0.6])
    return ImuSample(9.81 * z[:, :3], _RATES, 48.0 * z[:, 3:])


_POINT = np.log([0.3, 2.0, 1.5])
_COUNTED = np.zeros(N)
_DEVIATIONS = jnp.asarray(np.random.default_rng(1960).uniform(0.5, 2.0, N))
_GAINS = jnp.asarray(0.3 * np.random.default_rng(1981).normal(size=(N, 2, 2)))

_TWO_RATES = 0.4 * np.random.default_rng(1970).normal(size=(N, 2))
_TWO_RATES[np.arange(N) % 3 != 1, 1] = np.nan  # the second sensor is three times as slow

# Bearings on both sides of half a turn, about which the state swings.
_BEARINGS = np.array([0.0, 1.5]) + 0.3 * np.random.default_rng(1993).normal(size=(N, 2))
_BEARINGS[:, 0] += np.pi * (1 - 2 * (np.arange(N) % 2))

# What is detected depends on the record, on delta and on gravity. No point moves delta, and these
# samples are further from it than a step of gravity reaches, so no difference crosses it. Half of
# the samples are disturbed. Where a residual is zero abs(e) has a kink: these seeds have none
# within a step's reach.
_SHAKING = np.random.default_rng(2004)
_RATES = jnp.asarray(0.5 * _SHAKING.normal(size=(N, 3)))
_FORCES = 0.3 * _SHAKING.normal(size=(N, 3)) * (np.arange(N) // 3 % 2)[:, None]
_FORCES += 0.01 * _SHAKING.normal(size=(N, 3))
_FIELDS = np.hstack([_FORCES, 0.2 * _SHAKING.normal(size=(N, 3))])
_AIDED = np.hstack([0.3 * _FORCES, _FORCES[:, :1]])
_SIX = np.hstack([_FORCES + np.array([0.0, 0.0, 1.0]), 0.5 * _SHAKING.normal(size=(N, 3))])
_NAVIGATED = np.hstack([_FORCES, 0.5 * np.random.default_rng(2017).normal(size=(N, 8))])
_TURNED = jnp.array([0.9, 0.3, -0.3, 0.1])
_TILTED = np.log([1.0, 0.05, 1.0, 0.4, 10.0, 5.0])
_TURNING = np.log([1e-3, 1e-4, 1e-2, 0.5, 2.0, 9.81])


def _level(point):
    return LocalLevelNoise(*jnp.exp(point))


def _level_sample(z):
    return LevelSample(jnp.asarray(z), _DEVIATIONS)


_LEVEL_PARTS = measured_entries(LocalLevel(0.1), _level(_POINT[:2]), _level_sample(_ONE))


CASES = [
    Case("accelerometer", AccelerometerFilter(0.1), _noise, _POINT, _ONE),
    Case("gyroscope", GyroscopeFilter(0.1), _noise, _POINT, _ONE),
    Case("gyroscope, two signals", GyroscopeFilter(0.1, (2,)), _noise, _POINT, _TWO),
    Case("fixed gains", FixedGainFilter(0.1), _gains, np.log([0.4, 0.7]), _ONE),
    Case(
        "linear, diagonal R, control, three signals",
        LinearKalman(),
        _three_signals,
        _POINT,
        _RNG.normal(size=(N, 2, 3)),
        lambda z: Sample(jnp.asarray(z), u=_PUSH),
    ),
    Case(
        "linear, full R, varying dt",
        LinearKalman(),
        _full,
        _POINT,
        _TWO,
        _varying,
    ),
    Case("covariance", KalmanCovariance(), _full, _POINT, _COUNTED, holes=False),
    Case("covariance, gains", GainCovariance(), _full, _POINT, np.asarray(_GAINS), holes=False),
    Case(
        "covariance, table of gains",
        TableCovariance(),
        _table,
        _POINT,
        _RNG.integers(2, size=N),
        holes=False,
    ),
    Case("covariance, continuous", RiccatiCovariance(), _flow, _POINT[:2], _COUNTED, holes=False),
    Case(
        "conventional loop",
        ConventionalLoop(),
        _loop,
        np.array([1.1, 0.9]),
        _RNG.normal(size=(N, 1)),  # a column, for what is put out is no estimate of it alone
        lambda z: jnp.asarray(z)[:, 0],
    ),
    Case("steady gain", SteadyGain(("a", "b")), _steady, _POINT, _TWO),
    Case("stored gains", StoredGains(), _seen, _POINT, _TWO, _gained),
    Case(
        "extended, two rates",
        ExtendedKalman(swung, shaken, seen_from_the_side),
        _pendulum,
        np.log([4.0, 0.3, 1.0]),
        _TWO_RATES,
        lambda z: ExtendedSample(jnp.asarray(z)),
    ),
    Case(
        "extended, iterated, a bearing",
        ExtendedKalman(swung, shaken, bearing_and_range, iterations=3, angles=(True, False)),
        _pendulum,
        np.log([4.0, 0.3, 1.0]),
        _BEARINGS,
        lambda z: ExtendedSample(jnp.asarray(z)),
    ),
    Case(
        "unscented, two rates",
        UnscentedKalman(swung, shaken, seen_from_the_side),
        _pendulum,
        np.log([4.0, 0.3, 1.0]),
        _TWO_RATES,
        lambda z: ExtendedSample(jnp.asarray(z)),
    ),
    Case(
        "unscented, a bearing",
        UnscentedKalman(swung, shaken, bearing_and_range, 0.5, angles=(True, False)),
        _pendulum,
        np.log([4.0, 0.3, 1.0]),
        _BEARINGS,
        lambda z: ExtendedSample(jnp.asarray(z)),
    ),
    # A gradient takes seconds to compile, so one law stands for all, and a gravity filter that
    # does not adapt is one with the gain 0. test_tilt.py and test_gravity.py see to the rest.
    Case(
        "tilt, two-step",
        TiltKalman(0.05),
        _tilt,
        _TILTED,
        _SIX,
        lambda z: TiltSample(jnp.asarray(z)[:, :3], jnp.asarray(z)[:, 3:]),
    ),
    # The filters below integrate the rates: a missing one is no missing measurement, so the holes
    # are in what corrects them.
    Case("gravity, adaptive", AttitudeKalman(0.05), _gravity, _TURNING, _FORCES, _imu),
    Case("Mahony, field", Mahony(0.05), _mahony, np.log([2.0, 0.5]), _FIELDS, _compass),
    Case("Madgwick, field", Madgwick(0.05), _madgwick, np.log([0.4]), _FIELDS, _compass),
    Case(
        "first order, two angles",
        Complementary(0.1),
        lambda point: ComplementaryGain(jnp.exp(point[0]), point[1:]),
        np.array([-1.0, 0.1, 0.2]),
        _TWO,
        lambda z: AngleSample(0.3 * _PUSH, jnp.asarray(z)),
    ),
    Case(
        "mixing, velocity",
        PiComplementary(0.05, "velocity"),
        _mixing,
        np.log([0.8, 0.3, 9.81, 0.2, 4.0, 2.0]),
        _AIDED,
        _aided,
    ),
    Case(
        "Euler angles",
        GpsAidedKalman(0.1),
        _euler,
        np.log([1e-3, 1e-5, 1e-2]),
        _FORCES,
        lambda z: GpsAidedSample(_RATES, jnp.asarray(z)),
    ),
    Case(
        "position by speed and attitude",
        DeadReckoningKalman(0.2),
        _dead_reckoning,
        _POINT,
        _FORCES,
        lambda z: DeadReckoningSample(2.0 + _PUSH[:, 0], _RATES, jnp.asarray(z)),
    ),
    Case(
        "room",
        BoundedMotionKalman(0.05, RestRule(seconds=0.3)),
        _room,
        np.log([0.3, 0.2, 0.05, 5e-3, 3e-3, 0.02]),
        _FORCES,
        _three_a_block,
    ),
    Case(
        "inertial navigation, all aiding",
        ErrorStateIns(0.05),
        _ins,
        np.log([1e-2, 0.1, 0.5, 0.3, 0.05, 9.81]),
        _NAVIGATED,
        _navigated,
    ),
    Case(
        "several records",
        Batched(GyroscopeFilter(0.1)),
        lambda point: shared(_noise(point), 2),
        _POINT,
        _TWO,
    ),
    Case("records, shared", Lanes(GyroscopeFilter(0.1), 2), _noise, _POINT, _TWO),
    Case(
        "varying sample times",
        Timed(GyroscopeFilter(0.1)),
        _noise,
        _POINT,
        _ONE,
        lambda z: TimedSample(jnp.asarray(_DT), jnp.asarray(z)),
    ),
    Case(
        "end to end",
        Joined(GyroscopeFilter(0.1)),
        _noise,
        _POINT,
        _ONE,
        lambda z: JoinedSample(jnp.arange(N) % 9 == 0, jnp.asarray(z)),
    ),
    Case("local level, deviations", LocalLevel(0.1), _level, _POINT[:2], _ONE, _level_sample),
    Case("a gate", Gated(LocalLevel(0.1), _LEVEL_PARTS), _level, _POINT[:2], _ONE, _level_sample),
    Case(
        "heavy tails",
        Student(LocalLevel(0.1), _LEVEL_PARTS),
        _level,
        _POINT[:2],
        _ONE,
        _level_sample,
    ),
    Case(
        "constant velocity, two axes",
        ConstantVelocity(0.3, "xy"),
        lambda point: ConstantVelocityNoise(*jnp.exp(point)),
        _POINT[:2],
        _TWO,
        lambda z: PositionSample(jnp.asarray(z)[:, 0], jnp.asarray(z)[:, 1], sigma=_DEVIATIONS),
    ),
    Case(
        "constant acceleration",
        ConstantAcceleration(0.4),
        lambda point: ConstantAccelerationNoise(*jnp.exp(point)),
        _POINT[:2],
        _ONE,
        lambda z: PositionSample(jnp.asarray(z)),
    ),
    Case(
        "alpha-beta",
        AlphaBeta(0.2),
        lambda point: AlphaBetaGains(*point),
        np.array([0.5, 0.2]),
        _ONE,
    ),
    Case(
        "alpha-beta-gamma",
        AlphaBetaGamma(0.2),
        lambda point: AlphaBetaGammaGains(*point),
        np.array([0.5, 0.2, 0.1]),
        _ONE,
    ),
    Case(
        "vertical",
        Vertical(0.2, "included"),
        lambda point: VerticalNoise(*jnp.exp(point), climb0=0.7),
        np.log([0.1, 0.01, 0.5]),
        _ONE,
        lambda z: VerticalSample(9.8 + _PUSH[:, 0], jnp.asarray(z)),
    ),
]
