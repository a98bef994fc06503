"""Models in text files against the same in Python: ``python -m benchmarks.model_files``.

A wheeled robot and a pendulum, each as a document and as Python functions for
``filters.ExtendedKalman``, over one record in one process, in turn. The median of the ratios is
judged, each call against its neighbour; the numbers must be equal to 1e-12.
"""

import sys
import tomllib
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.timing import Call, interleave
from filters import ExtendedKalman, ExtendedModel, ExtendedSample, run
from objectives import Data, InnovationLikelihood, score_and_gradient
from tuner.model import model_filter

MOST = 1.1
"""Largest ratio to the time of the same in Python."""
EQUAL = 1e-12
SAMPLES, ROUNDS = 20_000, 40

ROBOT = """
parameters = ["q_speed", "q_turn", "R"]
inputs = ["speed", "turn"]
states = ["x", "y", "heading"]
[measurements]
gps = { axes = ["x", "y"], h = ["x", "y"], R = "R" }
[model]
time = "discrete"
f.x = "x + dt * speed * cos(heading)"
f.y = "y + dt * speed * sin(heading)"
f.heading = "heading + dt * turn"
G = [["cos(heading)", 0], ["sin(heading)", 0], [0, 1]]
Q = ["q_speed * dt", "q_turn * dt"]
P0 = [25, 25, 10]
"""

PENDULUM = """
parameters = ["omega", "q", "R"]
states = ["angle", "rate"]
[measurements]
across = { h = "sin(angle)", R = "R" }
[model]
time = "continuous"
f = ["rate", "-omega^2 * sin(angle) - 0.3 * rate"]
G = [0, 1]
Q = "q"
x0 = [0.4, 0.1]
P0 = [0.2, 0.1]
"""
DT = 0.05


def robot_move(p: Any, x: Any, u: Any) -> Any:
    way = DT * u[0]
    return jnp.stack([x[0] + way * jnp.cos(x[2]), x[1] + way * jnp.sin(x[2]), x[2] + DT * u[1]])


def robot_noise(p: Any, x: Any, u: Any) -> Any:
    c, s = jnp.cos(x[2]), jnp.sin(x[2])
    q, w = DT * p[0], DT * p[1]
    none = jnp.zeros_like(q)
    return jnp.stack(
        [
            jnp.stack([c * c * q, c * s * q, none]),
            jnp.stack([c * s * q, s * s * q, none]),
            jnp.stack([none, none, w]),
        ]
    )


def robot_seen(p: Any, x: Any, u: Any) -> Any:
    return x[:2]


def pendulum_rate(p: Any, x: Any) -> Any:
    return jnp.stack([x[1], -(p[0] ** 2) * jnp.sin(x[0]) - 0.3 * x[1]])


def pendulum_half(p: Any, x: Any) -> Any:
    h = DT / 2
    a = pendulum_rate(p, x)
    b = pendulum_rate(p, x + h / 2 * a)
    c = pendulum_rate(p, x + h / 2 * b)
    d = pendulum_rate(p, x + h * c)
    return x + h / 6 * (a + 2 * b + 2 * c + d)


def pendulum_move(p: Any, x: Any, u: Any) -> Any:
    return pendulum_half(p, pendulum_half(p, x))


def pendulum_noise(p: Any, x: Any, u: Any) -> Any:
    middle = pendulum_half(p, x)
    first, second = (jax.jacfwd(pendulum_half, 1)(p, at) for at in (x, middle))
    S = jnp.zeros((2, 2), x.dtype).at[1, 1].set(p[1])
    F = second @ first
    return DT / 6 * (F @ S @ F.T + 4 * second @ S @ second.T + S)


def pendulum_seen(p: Any, x: Any, u: Any) -> Any:
    return jnp.sin(x[:1])


def robot_build(at: Any) -> ExtendedModel:
    q, w, R = jnp.exp(at)
    P0 = jnp.diag(jnp.array([25.0, 25.0, 10.0]))
    return ExtendedModel(jnp.stack([q, w]), jnp.stack([R, R]), jnp.zeros(3), P0)


def pendulum_build(at: Any) -> ExtendedModel:
    omega, q, R = jnp.exp(at)
    start = jnp.array([0.4, 0.1]), jnp.diag(jnp.array([0.2, 0.1]))
    return ExtendedModel(jnp.stack([omega, q]), R[None], *start)


class Pair(NamedTuple):
    """A document's filter and the same in Python: filter, its parameters of a point, inputs."""

    document: tuple[Any, Any, Any]
    python: tuple[Any, Any, Any]
    point: np.ndarray


def robot() -> Pair:
    rng = np.random.default_rng(1)
    u = rng.normal(size=(SAMPLES, 2))
    fixes = np.cumsum(0.1 * rng.normal(size=(SAMPLES, 2)), axis=0)
    fixes[np.arange(SAMPLES) % 4 != 1] = np.nan
    before = np.vstack([np.zeros((1, 2)), u[:-1]])
    cls = model_filter(tomllib.loads(ROBOT))
    by_hand = ExtendedKalman(robot_move, robot_noise, robot_seen)
    return Pair(
        (cls(DT), lambda at: cls.params(*jnp.exp(at)), cls.inputs(u[:, 0], u[:, 1], fixes)),
        (by_hand, robot_build, ExtendedSample(fixes, before)),
        np.log([0.2, 0.05, 0.7]),
    )


def pendulum() -> Pair:
    rng = np.random.default_rng(2)
    seen = np.sin(0.3 * np.sin(0.1 * np.arange(SAMPLES))) + 0.1 * rng.normal(size=SAMPLES)
    cls = model_filter(tomllib.loads(PENDULUM))
    by_hand = ExtendedKalman(pendulum_move, pendulum_noise, pendulum_seen)
    return Pair(
        (cls(DT), lambda at: cls.params(*jnp.exp(at)), cls.inputs(seen)),
        (by_hand, pendulum_build, ExtendedSample(seen[:, None])),
        np.log([3.0, 0.3, 0.1]),
    )


def passing(filter: Any, build: Any, inputs: Any, point: np.ndarray) -> Call:
    """The innovations and their variances over the whole record."""

    @jax.jit
    def ran(at: Any, given: Any) -> Any:
        outputs = run(filter, build(at), given)[1]
        return outputs.innovation, outputs.variance

    given = jax.tree.map(jnp.asarray, inputs)
    return lambda: ran(jnp.asarray(point), given)


def gradient(filter: Any, build: Any, inputs: Any, point: np.ndarray) -> Call:
    """The likelihood and its gradient."""
    data = Data(jax.tree.map(jnp.asarray, inputs), jnp.zeros((SAMPLES, 1)))
    judge = InnovationLikelihood()
    ran = jax.jit(lambda at, given: score_and_gradient(filter, judge, build, at, given))
    return lambda: ran(jnp.asarray(point), data)


def apart(one: Any, other: Any) -> float:
    """The largest relative difference."""
    pairs = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return max(
        float(np.abs(np.asarray(a) - np.asarray(b)).max() / max(np.abs(np.asarray(b)).max(), 1.0))
        for a, b in pairs
    )


def main() -> int:
    """Measure, say what was found, and return 1 where a document is dearer than it may be."""
    wrong = False
    for name, pair in (("robot", robot()), ("pendulum", pendulum())):
        for what, made in (("pass", passing), ("gradient", gradient)):
            calls = {
                "document": made(*pair.document, pair.point),
                "python": made(*pair.python, pair.point),
            }
            far = apart(calls["document"](), calls["python"]())
            times = interleave(calls, ROUNDS)
            ratio = times.ratio("document", "python")
            print(
                f"{name + ', ' + what:20} {1e3 * times.best('document'):8.2f} ms, in Python "
                f"{1e3 * times.best('python'):8.2f} ms, ratio {ratio.median:.3f} (of the "
                f"shortest {ratio.best:.3f}), apart {far:.1e}"
            )
            wrong |= ratio.median > MOST or not far <= EQUAL
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
