"""The spectra of a measurement and of its estimate."""

import re

import numpy as np
import pytest

from tuner.run.spectrum_figure import spectra


def test_a_filter_of_first_order_passes_up_to_its_corner():
    """White noise through exponential smoothing: its power gain is half at a known frequency."""
    rate, gain = 100.0, 0.1
    noise = np.random.default_rng(0).standard_normal(60_000)
    smooth = np.zeros(len(noise))
    for k in range(1, len(noise)):
        smooth[k] = smooth[k - 1] + gain * (noise[k] - smooth[k - 1])
    (shown,) = spectra("z", "m", rate, measured=noise, tuned=smooth)
    # gain^2 / (1 - 2 (1-gain) cos w + (1-gain)^2) = 1/2
    pole = 1 - gain
    corner = np.arccos((1 + pole**2 - 2 * gain**2) / (2 * pole)) * rate / (2 * np.pi)
    found = float(re.search(r"up to ([\d.]+) Hz", shown.figure.title)[1])
    assert found == pytest.approx(corner, rel=0.15)
    before, after = shown.figure.lines
    assert np.mean(before.y) == pytest.approx(2 / rate, rel=0.05)  # of variance 1, one-sided
    assert shown.figure.y_label == "density of z, m^2/Hz"
    assert after.y[-1] < 0.01 * before.y[-1]


def test_nothing_of_few_of_missing_or_of_constant_samples():
    noise = np.random.default_rng(0).standard_normal(400)
    gap = np.where(np.arange(400) == 7, np.nan, noise)
    for measured in (noise[:200], gap, np.ones(400)):
        assert not [*spectra("z", "", 1.0, measured=measured, tuned=measured)]
    (same,) = spectra("z", "", 1.0, measured=noise, tuned=noise)
    assert same.figure.title == "The filter follows all that is measured"
