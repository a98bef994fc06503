"""The Allan curve, and noise against latency."""

from collections.abc import Iterator

import numpy as np

from studies.rest import requirement as first_order
from studies.rest.problems import Rest
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions, best

POINTS = 200


def figures(rests: tuple[Rest, ...], solutions: Solutions) -> Iterator[Figure]:
    """Both figures of every axis."""
    for rest in rests:
        yield _allan(rest)
        K = None
        if rest.requirement is not None:
            K = float(best(rest.axis.name, solutions).parameters["K1"].value)
        yield _latency(rest, K)


def _allan(rest: Rest) -> Chart:
    axis, noise = rest.axis, rest.noise
    curve, scale = noise.curve, axis.scale
    upper, lowest = scale * curve.highs, float(curve.taus[np.argmin(curve.deviations)])
    fitted = np.geomspace(noise.from_s, noise.to_s, POINTS)
    likely = np.sqrt(rest.white.value**2 / fitted + rest.walk.value**2 * fitted / 3)
    return Chart(
        name=f"allan_{axis.name}",
        title=f"Overlapping Allan deviation of {axis.name}: lowest at {lowest:.3g} s",
        x_label="averaging time, s",
        y_label=f"Allan deviation, {axis.written or '1'}",
        lines=(
            Line("95 % limits", curve.taus, scale * curve.lows, drawn="band", upper=upper),
            Line("record", curve.taus, scale * curve.deviations, drawn="points"),
            Line("fitted to the curve", fitted, scale * noise.model(fitted)),
            Line("walk and white noise by likelihood", fitted, scale * likely),
        ),
        log="xy",
    )


def _latency(rest: Rest, K: float | None) -> Chart:
    """Noise of the output over its latency."""
    axis, dt, scale = rest.axis, rest.dt, rest.axis.scale
    best_at = dt * float(np.sqrt(rest.R / rest.Q)) if rest.Q > 0 else 0.0
    longest = max(10 * best_at, 100 * dt) if best_at else axis.seconds / 3
    if K is not None:
        longest = max(longest, 3 * float(first_order.latency(K, dt)))
    delays = np.geomspace(0.3 * dt, longest, POINTS)

    def noise(delay: np.ndarray) -> np.ndarray:
        gain = dt / (delay + dt)
        variance = np.asarray(first_order.error_variance(gain, rest.R, rest.Q))
        return np.asarray(scale * np.sqrt(variance))

    lines = [Line("noise of the output", delays, noise(delays))]
    at, unit = first_order.knee(rest.R, rest.Q, dt), axis.written or "1"
    words = f"{noise(delays[:1])[0]:.2g} {unit} at a lag of {delays[0]:.2g} s"
    words += f", {noise(delays[-1:])[0]:.2g} at {delays[-1]:.2g} s"
    if np.isfinite(at):
        there = np.array([at])
        least = float(noise(delays).min())
        words = f"{noise(there)[0]:.2g} {unit} at the knee, {at:.2g} s; never below {least:.2g}"
        lines.append(Line(f"knee, {at:.3g} s", there, noise(there)))
    if K is not None and rest.requirement is not None:
        there = np.atleast_1d(first_order.latency(K, dt))
        lines.append(Line(rest.requirement.words, there, noise(there)))
    return Chart(
        name=f"latency_{axis.name}",
        title=f"Noise of {axis.name} after x = x + K1 (z - x): {words}",
        x_label="lag behind a steady change, s",
        y_label=f"deviation of the output at rest, {unit}",
        lines=tuple(lines),
        log="xy",
    )
