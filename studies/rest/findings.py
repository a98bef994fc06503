"""The noise numbers of a record at rest, in customary units."""

from collections.abc import Iterator

import numpy as np

from filters.declared import Sensor
from studies.rest import requirement as first_order
from studies.rest.curve import Limited
from studies.rest.problems import Rest
from tuner.data.sensor_units import SheetUnit, sheet_units
from tuner.run.finding import Finding
from tuner.run.study import Solutions, best

_DEGREES = 180 / np.pi
_HOUR = 3600.0
_KALIBR: dict[str, Sensor] = {"rad/s": "gyroscope", "m/s^2": "accelerometer"}
_DRIFT: dict[Sensor, Sensor] = {
    "gyroscope": "gyroscope bias",
    "accelerometer": "accelerometer bias",
}


def findings(rests: tuple[Rest, ...], solutions: Solutions) -> Iterator[Finding]:
    """Densities by both methods, R and Q, and the filter's properties, of every axis."""
    for rest in rests:
        yield from _noise(rest)
        yield from _sampled(rest)
        if rest.requirement is not None:
            K = float(best(rest.axis.name, solutions).parameters["K1"].value)
            yield from _filtered(rest, K)
        yield from _trade(rest)


def per_second(unit: str) -> str:
    """A unit over seconds.

    >>> per_second("deg/s"), per_second("mg"), per_second("m/s^2")
    ('deg/s^2', 'mg/s', 'm/s^3')
    """
    head, slash, tail = unit.rpartition("/s")
    if slash and tail == "":
        return f"{head}/s^2"
    if slash and tail[0] == "^" and tail[1:].isdigit():
        return f"{head}/s^{int(tail[1:]) + 1}"
    return f"{unit or '1'}/s"


def _noise(rest: Rest) -> Iterator[Finding]:
    axis, noise = rest.axis, rest.noise
    for scale, unit, N, K in _units(rest):
        for how, white, walk in _ways(rest):
            yield _of(axis.name, f"{N}.{how}", white.times(scale[0]), unit[0], _MEANS[how])
            yield _of(axis.name, f"{K}.{how}", walk.times(scale[1]), unit[1], _MEANS[how])
    note = f"0.664 of it is the curve's floor, at {noise.floor_s:.4g} s"
    own = axis.scale
    yield _of(axis.name, "B", noise.instability.times(own), axis.written, note)
    if axis.unit == "rad/s":
        hourly = noise.instability.times(_DEGREES * _HOUR)
        yield _of(axis.name, "bias_instability", hourly, "deg/h", "B")
    where = f"averaging times that were fitted, s: {noise.from_s:.4g} to {noise.to_s:.4g}"
    yield Finding(f"{axis.name}.white_from_s", noise.from_s, "s", where)


_MEANS = {"curve": "from the Allan curve", "likelihood": "of greatest likelihood"}


def _ways(rest: Rest) -> list[tuple[str, Limited, Limited]]:
    return [
        ("curve", rest.noise.white, rest.noise.walk),
        ("likelihood", rest.white, rest.walk),
    ]


def _units(rest: Rest) -> Iterator[tuple[tuple[float, float], tuple[str, str], str, str]]:
    """Factors from SI, units and names, of density and walk."""
    axis = rest.axis
    own = axis.written or "1"
    units = f"{own}/sqrt(Hz)", f"{per_second(axis.written)}/sqrt(Hz)"
    yield (axis.scale, axis.scale), units, "N", "K"
    if axis.unit not in _KALIBR:
        return
    sensor = _KALIBR[axis.unit]
    whites, walks = _named(sensor), _named(_DRIFT[sensor])
    for white, walk in zip(whites, walks, strict=True):
        yield (white.factor, walk.factor), (white.unit, walk.unit), white.name, walk.name


def _named(sensor: Sensor) -> list[SheetUnit]:
    """The customary forms of a sensor's noise; else the record's own unit."""
    return [form for form in sheet_units(sensor) if form.name]


def _sampled(rest: Rest) -> Iterator[Finding]:
    axis, at = rest.axis, f"a sample at {rest.rate_hz:g} Hz"
    square, unit = axis.scale**2, f"({axis.written})^2" if axis.written else ""
    N2, K2 = (Limited(*(value**2 for value in each)) for each in (rest.white, rest.walk))
    R, Q = N2.times(square * rest.rate_hz), K2.times(square / rest.rate_hz)
    yield _of(axis.name, "R", R, unit, f"measurement variance of {at}: N^2 rate")
    yield _of(axis.name, "Q", Q, unit, f"variance the bias gains in {at}: K^2 / rate")


def _filtered(rest: Rest, K: float) -> Iterator[Finding]:
    axis, dt, wanted = rest.axis, rest.dt, rest.requirement
    assert wanted is not None
    slower = (
        "" if wanted.gain >= K * (1 - 1e-9) else "; slower filters only lag behind the random walk"
    )
    yield Finding(f"{axis.name}.K1", K, "", f"gain of x = x + K1 (z - x): {wanted.words}{slower}")
    yield Finding(f"{axis.name}.settles_s", first_order.settling(K, dt), "s", "settling to 2 %")
    yield Finding(f"{axis.name}.bandwidth_hz", first_order.bandwidth(K, dt), "Hz", "to -3 dB")
    lag = float(first_order.latency(K, dt))
    yield Finding(f"{axis.name}.latency_s", lag, "s", "lag behind a steady change")
    noise = float(np.sqrt(first_order.error_variance(K, rest.R, rest.Q)))
    before = np.sqrt(rest.R) * axis.scale
    meaning = f"deviation of the output at rest, by N and K; {before:.4g} before"
    yield Finding(f"{axis.name}.output", noise * axis.scale, axis.written, meaning)
    if rest.rate_hz == axis.rate_hz:
        seen = output_on(axis.values, K) * axis.scale
        yield Finding(f"{axis.name}.output_seen", seen, axis.written, "the same on the record")


def output_on(values: np.ndarray, K: float) -> float:
    """Deviation of the filter's output over a record, by differences over its settling time.

    Half their mean square; slower changes, such as a random walk of the bias, hardly count.
    """
    from scipy.signal import lfilter

    output = lfilter([K], [1.0, K - 1.0], values)
    apart = int(first_order.settling(K, 1.0))
    settled = output[apart:]
    if len(settled) <= apart:
        return float(settled.std())
    return float(np.sqrt(np.mean((settled[apart:] - settled[:-apart]) ** 2) / 2))


def _trade(rest: Rest) -> Iterator[Finding]:
    """The latency beyond which a slower filter does not pay."""
    at = first_order.knee(rest.R, rest.Q, rest.dt)
    if np.isfinite(at):
        text = "from here on twice the latency lowers the noise by less than a tenth"
        least = float(np.sqrt(rest.R / rest.Q)) * rest.dt
        yield Finding(f"{rest.axis.name}.knee_s", at, "s", f"{text}; the least is at {least:.4g} s")
        return
    text = "no walk was seen, so a slower filter is always quieter, as far as the record says"
    yield Finding(f"{rest.axis.name}.knee_s", None, "s", text)


def _of(axis: str, name: str, number: Limited, unit: str, meaning: str) -> Finding:
    low = number.low if number.known else None
    text = meaning if number.known else f"{meaning}; not distinguished from 0"
    return Finding(f"{axis}.{name}", number.value, unit, text, low, number.high)
