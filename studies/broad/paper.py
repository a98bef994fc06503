"""Published errors of Madgwick's and Mahony's filters with a magnetometer.

Source: the files results_madgwick_average_rmse.json and results_mahony_average_rmse.json beside
their recordings (CC BY 4.0), at the gains with the lowest mean total error: beta = 0.12, and
Kp = 0.74 with Ki = 0.0012. Over all 39 trials they are the numbers of the paper.
"""

from collections.abc import Sequence

import numpy as np

from objectives.attitude import Part

PARTS: tuple[Part, ...] = ("total", "heading", "inclination")
"""The errors, in the order of the columns below."""
_ERRORS = {
    # Madgwick: total, heading, inclination; Mahony: the same
    "01_undisturbed_slow_rotation_A": (2.310, 2.174, 0.779, 3.422, 3.220, 1.158),
    "02_undisturbed_slow_rotation_B": (1.497, 1.264, 0.802, 2.966, 2.891, 0.664),
    "03_undisturbed_slow_rotation_C": (2.471, 2.287, 0.935, 2.928, 2.796, 0.870),
    "04_undisturbed_slow_rotation_with_breaks_A": (1.531, 1.367, 0.689, 5.366, 5.142, 1.535),
    "05_undisturbed_slow_rotation_with_breaks_B": (1.786, 1.633, 0.723, 4.009, 3.933, 0.778),
    "06_undisturbed_fast_rotation_A": (2.307, 1.768, 1.482, 4.289, 3.844, 1.903),
    "07_undisturbed_fast_rotation_B": (4.996, 4.327, 2.499, 5.233, 4.899, 1.841),
    "08_undisturbed_fast_rotation_with_breaks_A": (3.905, 3.527, 1.675, 6.852, 6.414, 2.412),
    "09_undisturbed_fast_rotation_with_breaks_B": (2.484, 1.647, 1.860, 4.520, 4.244, 1.556),
    "10_undisturbed_slow_translation_A": (3.569, 1.707, 3.134, 2.764, 1.496, 2.324),
    "11_undisturbed_slow_translation_B": (4.241, 2.608, 3.345, 5.628, 5.173, 2.217),
    "12_undisturbed_slow_translation_C": (3.340, 1.930, 2.726, 4.818, 4.587, 1.473),
    "13_undisturbed_slow_translation_with_breaks_A": (2.166, 1.134, 1.846, 7.456, 7.174, 2.035),
    "14_undisturbed_slow_translation_with_breaks_B": (3.095, 1.597, 2.652, 4.985, 4.717, 1.613),
    "15_undisturbed_fast_translation_A": (12.304, 11.409, 4.622, 9.200, 6.946, 6.036),
    "16_undisturbed_fast_translation_B": (4.825, 3.703, 3.094, 20.277, 17.672, 10.008),
    "17_undisturbed_fast_translation_with_breaks_A": (8.233, 6.810, 4.630, 7.114, 4.808, 5.244),
    "18_undisturbed_fast_translation_with_breaks_B": (4.461, 2.869, 3.417, 29.068, 24.746, 15.463),
    "19_undisturbed_slow_combined_240s": (2.244, 0.926, 2.044, 1.529, 0.967, 1.184),
    "20_undisturbed_slow_combined_360s": (2.347, 1.077, 2.086, 1.566, 0.921, 1.266),
    "21_undisturbed_fast_combined": (7.158, 5.544, 4.530, 12.444, 9.649, 7.868),
    "22_undisturbed_fast_combined_240s": (8.422, 7.774, 3.244, 7.082, 5.588, 4.353),
    "23_undisturbed_fast_combined_360s": (8.867, 8.188, 3.405, 6.164, 3.656, 4.964),
    "24_disturbed_tapping_A": (1.768, 1.243, 1.258, 2.146, 1.892, 1.013),
    "25_disturbed_tapping_B": (3.916, 2.758, 2.780, 6.040, 5.626, 2.199),
    "26_disturbed_phone_vibration_A": (2.904, 2.264, 1.818, 2.266, 1.889, 1.251),
    "27_disturbed_phone_vibration_B": (10.617, 10.501, 1.565, 8.690, 8.459, 1.991),
    "28_disturbed_stationary_magnet_A": (8.329, 7.461, 3.703, 6.330, 4.497, 4.456),
    "29_disturbed_stationary_magnet_B": (9.159, 8.404, 3.647, 8.558, 6.437, 5.642),
    "30_disturbed_stationary_magnet_C": (5.566, 1.807, 5.265, 10.934, 7.385, 8.070),
    "31_disturbed_stationary_magnet_D": (3.489, 2.353, 2.576, 6.332, 3.706, 5.135),
    "32_disturbed_attached_magnet_1cm": (15.762, 14.964, 4.971, 41.005, 39.850, 9.924),
    "33_disturbed_attached_magnet_2cm": (7.088, 5.117, 4.906, 10.962, 8.388, 7.067),
    "34_disturbed_attached_magnet_3cm": (5.374, 4.253, 3.285, 5.726, 4.391, 3.675),
    "35_disturbed_attached_magnet_4cm": (3.267, 1.144, 3.060, 3.711, 2.362, 2.862),
    "36_disturbed_attached_magnet_5cm": (3.130, 1.559, 2.714, 4.001, 2.591, 3.049),
    "37_disturbed_office_A": (6.816, 6.188, 2.858, 4.236, 3.334, 2.613),
    "38_disturbed_office_B": (4.521, 3.382, 3.002, 4.283, 3.261, 2.776),
    "39_disturbed_mixed": (3.125, 2.224, 2.195, 7.168, 6.127, 3.726),
}
NAMES = tuple(_ERRORS)
"""The benchmark's trials."""


def means(filter: str, trials: Sequence[str]) -> dict[Part, float]:
    """The published errors of a filter, "madgwick" or "mahony", averaged over trials, deg, by part.

    Raises:
        ValueError: for names of trials that the benchmark does not have.
    """
    unknown = sorted(set(trials) - set(NAMES))
    if unknown:
        raise ValueError(f"nothing is published of {', '.join(unknown)}: they are not of BROAD")
    rows = np.array([_ERRORS[trial] for trial in trials]).reshape(-1, 2, 3)
    found = rows[:, ("madgwick", "mahony").index(filter)].mean(axis=0)
    return dict(zip(PARTS, found.tolist(), strict=True))
