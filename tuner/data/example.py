"""Example logs, simulated, so that the right result of a fit is known."""

from collections.abc import Callable, Mapping

import numpy as np

from tuner.names import unknown

Columns = Mapping[str, tuple[str, np.ndarray]]
"""The text of a number (a format, such as ``"%.2f"``) and the numbers, by column; NaN is empty."""


def example(kind: str) -> str:
    """A simulated log as comma-separated text, the same at every call.

    A comment on its first line says what it is and with which noise it was made.

    Args:
        kind: one of :data:`KINDS`.

    Raises:
        ValueError: for any other, with the near ones.

    >>> print(*example("vario").splitlines()[1:4], sep="\\n")
    t_ms,acc_up,height
    0,1.450,212.45
    20,2.206,
    """
    if kind not in KINDS:
        raise unknown("example", kind, KINDS)
    title, columns = KINDS[kind](np.random.default_rng(1))
    cells = [_cells(form, numbers) for form, numbers in columns.values()]
    rows = (",".join(row) for row in zip(*cells, strict=True))
    return "\n".join([f"# {title}", ",".join(columns), *rows]) + "\n"


def _cells(form: str, numbers: np.ndarray) -> list[str]:
    return ["" if np.isnan(number) else form % number for number in numbers]


def _vario(draw: np.random.Generator) -> tuple[str, Columns]:
    """Two minutes up and down: an accelerometer at 50 Hz, a barometer at 10 Hz."""
    dt, count = 0.02, 6000
    t = dt * np.arange(count)
    turns = ((2.4, 38.0), (1.3, 13.0), (0.4, 4.7))  # m/s, s
    acc = sum(2 * np.pi * v / T * np.cos(2 * np.pi * t / T) for v, T in turns)
    height = 212 + np.cumsum(np.cumsum(acc)) * dt**2
    offset = 0.15 + np.cumsum(np.sqrt(1e-4 * dt) * draw.standard_normal(count))
    measured = acc + offset + 0.3 * draw.standard_normal(count)
    baro = height + 0.5 * draw.standard_normal(count)
    baro[np.arange(count) % 5 != 0] = np.nan
    return (
        "vertical flight, simulated: acc_up +- 0.3 m/s^2 (q_acc 0.0018), "
        "height +- 0.5 m (R_baro 0.25)",
        {
            "t_ms": ("%d", 20 * np.arange(count)),
            "acc_up": ("%.3f", measured),
            "height": ("%.2f", baro),
        },
    )


def _rest(draw: np.random.Generator) -> tuple[str, Columns]:
    """A gyroscope that lies still for five minutes at 100 Hz."""
    count = 30_000
    walk = np.cumsum(2e-4 * draw.standard_normal(count))
    rate = 0.35 + walk + 0.12 * draw.standard_normal(count)
    return "gyroscope at rest, 100 Hz, simulated: gyro_x +- 0.12 deg/s (0.012 deg/s/sqrt(Hz))", {
        "gyro_x": ("%.4f", rate)
    }


def _level(draw: np.random.Generator) -> tuple[str, Columns]:
    """A pressure that wanders, beside a reference instrument."""
    count = 2000
    truth = 101_325 + np.cumsum(0.4 * draw.standard_normal(count))
    pressure = truth + 3.0 * draw.standard_normal(count)
    return "pressure, simulated: Q 0.16 Pa^2 a sample (q 1.6 Pa^2/s), R 9 Pa^2", {
        "millis": ("%d", 100 * np.arange(count)),
        "pressure": ("%.2f", pressure),
        "reference": ("%.2f", truth),
    }


def _tracks(draw: np.random.Generator) -> tuple[str, Columns]:
    """Ten walks with a position every second, distinguished by a number."""
    walks, count = 10, 200
    q, accuracy = 0.2, draw.choice([3.0, 4.0, 6.0], (walks, count))
    root = np.linalg.cholesky(q * np.array([[1 / 3, 1 / 2], [1 / 2, 1]]))
    state, metres = np.zeros((2, 2, walks)), np.empty((2, walks, count))
    for k in range(count):
        state[0] += state[1]
        state += np.einsum("ij,jaw->iaw", root, draw.standard_normal(state.shape))
        metres[:, :, k] = state[0]
    metres += accuracy * draw.standard_normal(metres.shape)
    degrees = 1 / 111_320
    return "ten tracks, simulated: q 0.2 m^2/s^3, accuracy is the deviation of each position", {
        "track": ("%d", np.repeat(np.arange(walks), count)),
        "t": ("%d", np.tile(np.arange(count), walks)),
        "lat": ("%.7f", 48.1 + degrees * metres[0].ravel()),
        "lon": ("%.7f", 11.5 + degrees / np.cos(np.radians(48.1)) * metres[1].ravel()),
        "accuracy": ("%.1f", accuracy.ravel()),
    }


KINDS: Mapping[str, Callable[[np.random.Generator], tuple[str, Columns]]] = {
    "level": _level,
    "rest": _rest,
    "tracks": _tracks,
    "vario": _vario,
}
"""The example logs by name."""
