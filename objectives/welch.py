"""Welch's power spectral density in JAX: differentiable, and equal to scipy.signal.welch."""

from dataclasses import dataclass
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

# Cosine sums; the coefficients are those of Harris, Proc. IEEE 66(1), 1978.
_WINDOWS = {
    "boxcar": (1.0,),
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.5, 0.08),
    "blackmanharris": (0.35875, 0.48829, 0.14128, 0.01168),
}


def window(name: str, length: int, *, symmetric: bool) -> np.ndarray:
    """A window of the given length; symmetric for filter design, periodic for spectra.

    Raises:
        ValueError: for an unknown name.

    >>> window("hann", 4, symmetric=False).round(3).tolist()
    [0.0, 0.5, 1.0, 0.5]
    """
    if name not in _WINDOWS:
        raise ValueError(f"unknown window {name!r}; there are {', '.join(sorted(_WINDOWS))}")
    period = max(length - 1, 1) if symmetric else length
    phase = 2 * np.pi * np.arange(length) / period
    terms: list[np.ndarray] = [
        (-1) ** i * a * np.cos(i * phase) for i, a in enumerate(_WINDOWS[name])
    ]
    return np.asarray(sum(terms)) if length > 1 else np.ones(1)


@dataclass(frozen=True)
class Welch:
    """Parameters of Welch's estimate: averaged periodograms of overlapping, windowed segments.

    Source: Welch, IEEE Trans. Audio Electroacoustics 15(2), 1967. Every option means what it
    means in ``scipy.signal.welch``, and the result is the same.

    Attributes:
        segment: samples in a segment.
        overlap: samples that neighbours share, below ``segment``.
        nfft: length of the transform, at least ``segment``; the rest is filled with zeros.
        window: boxcar, hann, hamming, blackman or blackmanharris.
        symmetric: the symmetric window (MATLAB's default) instead of the periodic one (scipy's).
        detrend: what is subtracted from each segment first: nothing, its mean or its line.
        scaling: density (unit^2/Hz) or spectrum (unit^2).
        average: mean or (bias-corrected) median over the segments.
    """

    segment: int
    overlap: int
    nfft: int
    window: str = "hamming"
    symmetric: bool = True
    detrend: Literal["none", "constant", "linear"] = "none"
    scaling: Literal["density", "spectrum"] = "density"
    average: Literal["mean", "median"] = "mean"

    def __post_init__(self) -> None:
        if not 0 <= self.overlap < self.segment <= self.nfft:
            raise ValueError(
                f"Welch needs 0 <= overlap < segment <= nfft, got overlap {self.overlap}, "
                f"segment {self.segment}, nfft {self.nfft}"
            )
        for field, allowed in _CHOICES.items():
            if getattr(self, field) not in allowed:
                raise ValueError(
                    f"Welch's {field} is one of {', '.join(allowed)}, got {getattr(self, field)!r}"
                )

    @classmethod
    def matlab(cls, samples: int) -> "Welch":
        """MATLAB's ``pwelch`` defaults: 7 or 8 half-overlapping segments, symmetric Hamming window.

        ``segment = floor(samples / 4.5)``, ``nfft`` the next power of two (256 at least).

        Raises:
            ValueError: where the record is too short for segments of at least 8 samples.

        >>> Welch.matlab(100_001)
        Welch(segment=22222, overlap=11111, nfft=32768, window='hamming', symmetric=True, \
detrend='none', scaling='density', average='mean')
        """
        segment = int(samples / 4.5)
        if segment < 8:
            raise ValueError(
                f"the record has {samples} samples, too few for 8 half-overlapping Welch segments "
                "of at least 8 samples; record at least 36"
            )
        return cls(segment, segment // 2, max(256, 1 << (segment - 1).bit_length()))

    def frequencies(self, dt: float) -> np.ndarray:
        """The one-sided frequencies in Hz, ``(nfft // 2 + 1,)``."""
        return np.fft.rfftfreq(self.nfft, dt)

    def psd(self, x: Array, dt: float) -> Array:
        """The one-sided spectrum of a record ``(N,)`` with sample time dt: ``(nfft // 2 + 1,)``.

        Raises:
            ValueError: where the record is shorter than one segment.
        """
        spectra = jnp.fft.rfft(self._windowed(x), self.nfft)
        power = spectra.real**2 + spectra.imag**2
        # A product with 1/n is the mean over the segments; XLA takes three times as long for a sum.
        mean = jnp.full(power.shape[0], 1 / power.shape[0]) @ power
        power = _median(power) if self.average == "median" else mean
        return power * self._one_sided() * self._scale(dt)

    def power_weights(self, samples: int) -> np.ndarray:
        """Weights w ``(N,)`` with ``sum(w * x**2) == psd(x, dt).sum() * df``, by Parseval.

        With them the integral of the spectrum is one pass over the record, without a transform.

        Raises:
            ValueError: where the identity does not hold: with a detrend, a median or scaling
                other than density.
        """
        if (self.detrend, self.average, self.scaling) != ("none", "mean", "density"):
            raise ValueError(
                "the integral of the spectrum is a weighted sum of squares only without detrend, "
                f"with the mean and as a density; got {self}"
            )
        taper = self._taper() ** 2
        starts = self._starts(samples)
        weights = np.zeros(samples)
        for start in starts:
            weights[start : start + self.segment] += taper
        weights /= taper.sum() * len(starts)
        return weights

    def _taper(self) -> np.ndarray:
        return window(self.window, self.segment, symmetric=self.symmetric)

    def _starts(self, samples: int) -> np.ndarray:
        if samples < self.segment:
            raise ValueError(
                f"the record has {samples} samples, fewer than one Welch segment of {self.segment}"
            )
        return np.arange(0, samples - self.segment + 1, self.segment - self.overlap)

    def _cut(self, x: Array) -> Array:
        starts = self._starts(x.shape[0])
        if len(starts) <= 32:  # plain slices fuse with what follows, a gather does not
            return jnp.stack([x[start : start + self.segment] for start in starts])
        cut = jax.vmap(lambda start: jax.lax.dynamic_slice(x, (start,), (self.segment,)))
        return cut(jnp.asarray(starts))

    def _windowed(self, x: Array) -> Array:
        segments = self._cut(x)
        if self.detrend != "none":
            segments = segments - segments.mean(axis=1, keepdims=True)
        if self.detrend == "linear":
            time = np.arange(self.segment) - (self.segment - 1) / 2
            slope = segments @ time / (time @ time or 1.0)  # a single sample has no slope
            segments = segments - slope[:, None] * time
        return segments * self._taper()

    def _one_sided(self) -> np.ndarray:
        double = np.full(self.nfft // 2 + 1, 2.0)
        double[0] = 1.0
        if self.nfft % 2 == 0:
            double[-1] = 1.0
        return double

    def _scale(self, dt: float) -> float:
        taper = self._taper()
        if self.scaling == "spectrum":
            return float(1 / taper.sum() ** 2)
        return float(dt / np.square(taper).sum())


_CHOICES = {
    "window": tuple(sorted(_WINDOWS)),
    "detrend": ("none", "constant", "linear"),
    "scaling": ("density", "spectrum"),
    "average": ("mean", "median"),
}


def _median(power: Array) -> Array:
    """The median over segments, divided by its bias for exponentially distributed power."""
    odd = np.arange(3, power.shape[0] + 1, 2)
    bias = 1 + np.sum(1 / odd - 1 / (odd - 1))
    return jnp.median(power, axis=0) / float(bias)
