"""A guess of R and Q from a record at rest: its fast part is taken as measurement noise."""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from tuner.names import unknown

_Method: TypeAlias = Literal["ideal", "butterworth"]


class NoiseSplit(NamedTuple):
    """Variances of a record's fast and slow parts, in its unit squared."""

    R: float
    Q: float


def split_noise(
    record: np.ndarray,
    rate_hz: float,
    cutoff_hz: float = 1.0,
    method: _Method = "ideal",
) -> NoiseSplit:
    """Split a motionless record ``(N,)`` at a frequency; the parts' variances stand for R and Q.

    This is the procedure behind Kownacki's Table 1, which names the frequency (1 Hz) but not the
    filters. The ideal split counts each spectral line on one side, so R + Q is the record's
    variance; the other one runs second-order Butterworth filters forwards and back.

    Raises:
        ValueError: where the cutoff is not between the record's lowest frequency and half its rate,
            and for an unknown method.

    >>> t = np.arange(1000) / 100
    >>> slow, fast = np.sin(2 * np.pi * 0.5 * t), 2 * np.sin(2 * np.pi * 20 * t)
    >>> [round(part, 6) for part in split_noise(slow + fast, rate_hz=100)]
    [2.0, 0.5]
    """
    if method not in get_args(_Method):
        raise unknown("split", method, get_args(_Method))
    n = len(record)
    if not rate_hz / n < cutoff_hz < rate_hz / 2:
        raise ValueError(
            f"a record of {n} samples at {rate_hz:g} Hz cannot be split at {cutoff_hz:g} Hz; "
            f"choose a cutoff between {rate_hz / n:.3g} and {rate_hz / 2:g} Hz"
        )
    centred = record - record.mean()
    if method == "butterworth":
        from scipy.signal import butter, sosfiltfilt

        fast, slow = (
            sosfiltfilt(butter(2, cutoff_hz, kind, fs=rate_hz, output="sos"), centred)
            for kind in ("highpass", "lowpass")
        )
        return NoiseSplit(float(np.var(fast)), float(np.var(slow)))
    power = np.abs(np.fft.rfft(centred)) ** 2 / n**2
    power[1 : (n + 1) // 2] *= 2  # every line but the mean and the highest stands for two
    slow_lines = np.fft.rfftfreq(n, 1 / rate_hz) < cutoff_hz
    return NoiseSplit(float(power[~slow_lines].sum()), float(power[slow_lines].sum()))
