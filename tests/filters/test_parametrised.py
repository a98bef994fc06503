"""Kalman filters of models that are put together by hand, as classes, against textbook loops."""

import jax.numpy as jnp
import numpy as np
import pytest

import tuner
from filters import (
    Channel,
    ExtendedKalman,
    ExtendedModel,
    LinearKalman,
    LinearModel,
    LocalLevel,
    Param,
    Timed,
    TimedSample,
    Transition,
    UnscentedKalman,
    assembled,
    channel_facts,
    parametrised,
    run,
)

NOISE = {
    "q": Param("m^2/s^3", "density of the acceleration", 0.1, 1e-6, 1e3),
    "R": Param("m^2", "variance of a position", 1.0, 1e-6, 1e3),
}
STATES = {"place": Channel("m", "place"), "speed": Channel("m/s", "speed")}


def moving(v, dt):
    """A cart that is pushed."""
    F = jnp.array([[1.0, 0.0], [0.0, 1.0]]) + dt * jnp.array([[0.0, 1.0], [0.0, 0.0]])
    G = jnp.stack([jnp.stack([dt**2 / 2]), jnp.stack([dt * jnp.ones(())])])
    Q = v["q"] * jnp.stack(
        [jnp.stack([dt**3 / 3, dt**2 / 2]), jnp.stack([dt**2 / 2, dt * jnp.ones(())])]
    )
    H = jnp.array([[1.0, 0.0]])
    return LinearModel(
        Transition(F, jnp.eye(2), Q, G), H, v["R"][None], 10.0 * jnp.eye(2), jnp.zeros(2)
    )


def cart(known=True):
    return parametrised(
        LinearKalman(),
        moving,
        params=NOISE,
        measured={"position": Channel("m", "measured position")},
        states=STATES,
        known={"push": Channel("m/s^2", "acceleration that is commanded")} if known else None,
        name="Cart",
    )


def loop(z, u, dt, q, R):
    """Predict and update in plain matrices; the input of the sample before moves it on."""
    x, P, last, found = np.zeros(2), 10.0 * np.eye(2), 0.0, []
    for zk, uk, step in zip(z, u, np.broadcast_to(dt, len(z)), strict=True):
        F = np.array([[1.0, step], [0.0, 1.0]])
        Q = q * np.array([[step**3 / 3, step**2 / 2], [step**2 / 2, step]])
        x = F @ x + np.array([step**2 / 2, step]) * last
        P = F @ P @ F.T + Q
        y = s = 0.0
        if not np.isnan(zk):
            s = P[0, 0] + R
            y = zk - x[0]
            K = P[:, 0] / s
            x, P = x + K * y, (np.eye(2) - np.outer(K, [1.0, 0.0])) @ P
        last = last if np.isnan(uk) else uk
        found.append([*x, y, s])
    return np.array(found)


@pytest.fixture(scope="module")
def record():
    draw = np.random.default_rng(3)
    z = np.cumsum(draw.standard_normal(80))
    u = 0.3 * draw.standard_normal(80)
    z[[4, 9]], u[[0, 7]] = np.nan, np.nan
    return z, u


def columns(out):
    return np.stack([out.place, out.speed, out.innovation[:, 0], out.variance[:, 0]], axis=1)


def test_with_a_known_input(record):
    z, u = record
    cls = cart()
    params = assembled(cls, {"q": 0.3, "R": 0.7})
    out = run(cls(dt=0.2), params, cls.inputs(jnp.asarray(z), jnp.asarray(u)))[1]
    # 1e-11 of numbers up to some 10: 80 steps of rounding.
    np.testing.assert_allclose(columns(out), loop(z, u, 0.2, 0.3, 0.7), atol=1e-11)


def test_with_varying_steps(record):
    z, u = record
    cls = cart()
    steps = np.where(np.arange(80) % 7 == 0, 0.5, 0.2)
    params = assembled(cls, {"q": 0.3, "R": 0.7})
    samples = TimedSample(jnp.asarray(steps), cls.inputs(jnp.asarray(z), jnp.asarray(u)))
    out = run(Timed(cls(dt=0.2)), params, samples)[1]
    np.testing.assert_allclose(columns(out), loop(z, u, steps, 0.3, 0.7), atol=1e-11)


def drive(p, x, u):
    """Two places and a heading, by speed and turn."""
    dt = p["dt"]
    return x + dt * jnp.stack([u[0] * jnp.cos(x[2]), u[0] * jnp.sin(x[2]), u[1]])


def spread(p, x, u):
    return p["dt"] * jnp.diag(jnp.stack([p["q"], p["q"], p["turn"]]))


def seen(p, x, u):
    return x[:2]


def robot(v, dt):
    start = jnp.zeros(3)
    R = jnp.stack([v["R"], v["R"]])
    return ExtendedModel({**v, "dt": dt}, R, start, jnp.diag(jnp.array([1.0, 1.0, 0.1])))


def robot_loop(z, u, dt, q, turn, R):
    x, P, last, found = np.zeros(3), np.diag([1.0, 1.0, 0.1]), np.zeros(2), []
    for zk, uk in zip(z, u, strict=True):
        v, w = last
        F = np.eye(3)
        F[0, 2], F[1, 2] = -dt * v * np.sin(x[2]), dt * v * np.cos(x[2])
        x = x + dt * np.array([v * np.cos(x[2]), v * np.sin(x[2]), w])
        P = F @ P @ F.T + dt * np.diag([q, q, turn])
        if not np.isnan(zk).any():
            H = np.eye(2, 3)
            S = H @ P @ H.T + R * np.eye(2)
            K = P @ H.T @ np.linalg.inv(S)
            x, P = x + K @ (zk - x[:2]), P - K @ H @ P
        last = uk
        found.append(x)
    return np.array(found)


def test_an_extended_filter_with_vectors():
    draw = np.random.default_rng(5)
    u = np.stack([1 + 0.1 * draw.standard_normal(60), 0.3 * draw.standard_normal(60)], axis=1)
    z = np.cumsum(0.1 * draw.standard_normal((60, 2)), axis=0)
    z[::3] = np.nan
    params = {
        "q": Param("m^2/s", "density of the place's noise", 0.1, 1e-6, 1e3),
        "turn": Param("rad^2/s", "density of the heading's noise", 0.1, 1e-6, 1e3),
        "R": Param("m^2", "variance of a position", 1.0, 1e-6, 1e3),
    }
    cls = parametrised(
        ExtendedKalman(drive, spread, seen),
        robot,
        params=params,
        measured={"gps": Channel("m", "position", ("x", "y"))},
        known={"speed": Channel("m/s", "wheel speed"), "turn_rate": Channel("rad/s", "yaw rate")},
        states={name: Channel(unit, name) for name, unit in (("x", "m"), ("y", "m"), ("h", "rad"))},
    )
    assert cls.__name__ == "Robot"
    assert channel_facts(cls, "outputs")["innovation"].axes == ("x", "y")
    values = assembled(cls, {"q": 0.05, "turn": 0.02, "R": 0.4})
    inputs = cls.inputs(jnp.asarray(z), jnp.asarray(u[:, 0]), jnp.asarray(u[:, 1]))
    out = run(cls(dt=0.1), values, inputs)[1]
    expected = robot_loop(z, u, 0.1, 0.05, 0.02, 0.4)
    # The textbook's update takes both coordinates at once: to rounding the same.
    np.testing.assert_allclose(np.stack([out.x, out.y, out.h], axis=1), expected, atol=1e-11)
    points = parametrised(
        UnscentedKalman(drive, spread, seen),
        robot,
        params=params,
        measured={"gps": Channel("m", "position", ("x", "y"))},
        known={"speed": Channel("m/s", "wheel speed"), "turn_rate": Channel("rad/s", "yaw rate")},
        states=cls.states,
    )
    sigma = run(points(dt=0.1), points.params(*values), inputs)[1]
    # Nearly linear over a step: sigma points and Jacobians differ by little.
    assert abs(sigma.x - out.x).max() < 0.2
    record = tuner.Record.of(
        {"gps": z, "speed": u[:, 0], "turn_rate": u[:, 1]}, rate_hz=10.0, units={"gps": "m"}
    )
    found = tuner.fit(cls, record, starts=1, hold_out=False, fix={"turn": 0.02, "q": 0.05})
    assert found.solution.parameters["R"].unit == "m^2"


def test_without_inputs_what_can_be_known_is_told(record):
    """It is the Kalman filter of a linear model, so that its noise is estimated before."""
    z, _ = record
    plain = cart(known=False)
    data = tuner.Record.of({"position": z}, rate_hz=5.0, units={"position": "m"})
    found = tuner.fit(plain, data, starts=2, hold_out=False)
    q, R = (float(found.solution.parameters[name].value) for name in ("q", "R"))
    expected = loop(z, np.zeros(80), 0.2, q, R)
    np.testing.assert_allclose(found.outputs.place, expected[:, 0], atol=1e-9)
    assert tuner.determined(found.posed.problem).rank == 2
    quantities = {one.name: one.value for one in found.posed.problem.quantities(found.solution)}
    np.testing.assert_allclose(
        quantities["Q_derived"], q * np.array([[0.2**3 / 3, 0.02], [0.02, 0.2]]), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"filter": LocalLevel(dt=1.0)}, "LocalLevel takes no samples of z and u"),
        ({"states": {"P": Channel("m", "x")}}, "the name P comes twice"),
        ({"measured": {}}, "there is nothing measured"),
        ({"known": {"position": Channel("m", "x")}}, "the name position comes twice"),
        ({"name": "no name"}, "'no name' is not a name of a class"),
    ],
)
def test_refusals(changed, words):
    given = {
        "params": NOISE,
        "measured": {"position": Channel("m", "measured position")},
        "states": STATES,
    }
    filter = changed.pop("filter", LinearKalman())
    with pytest.raises(ValueError, match=words):
        parametrised(filter, moving, **{**given, **changed})
    with pytest.raises(ValueError, match="make a class of it and your build with"):
        tuner.fit(LinearKalman(), tuner.Record.of({"z": [1.0, 2.0]}, rate_hz=1.0))
