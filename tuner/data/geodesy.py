"""Degrees of latitude and longitude as metres north and east, near one point of the WGS 84."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_RADIUS = 6378137.0
_ECCENTRICITY_SQUARED = 6.69437999014e-3
# The standard atmosphere up to 11 km (ISO 2533): 288.15 K at sea level, 6.5 K less per km.
_SEA_PA = 101325.0
_SCALE_M = 288.15 / 0.0065
_POWER = 8.31446261815324 * 0.0065 / (9.80665 * 0.0289644)


def radii(latitude: float) -> tuple[float, float]:
    """Radii of curvature along the meridian and across it, m, at a latitude in degrees.

    >>> [round(radius) for radius in radii(0.0)]
    [6335439, 6378137]
    """
    w = 1.0 - _ECCENTRICITY_SQUARED * np.sin(np.radians(latitude)) ** 2
    across = _RADIUS / np.sqrt(w)
    return float(across * (1.0 - _ECCENTRICITY_SQUARED) / w), float(across)


def north(latitude: Floats, first: float) -> Floats:
    """Metres north of the latitude ``first``, all in degrees."""
    return np.asarray(np.radians(latitude - first) * radii(first)[0])


def east(longitude: Floats, latitude: float, first: float) -> Floats:
    """Metres east of the longitude ``first`` along a latitude, all in degrees."""
    turn = np.remainder(longitude - first + 180.0, 360.0) - 180.0
    return np.asarray(np.radians(turn) * radii(latitude)[1] * np.cos(np.radians(latitude)))


def height(pressure: Floats) -> Floats:
    """Height above 101325 Pa in the standard atmosphere, m, of a pressure in Pa.

    >>> height(np.array([101325.0, 89874.6])).round(1).tolist()
    [0.0, 1000.0]
    """
    return np.asarray(_SCALE_M * (1.0 - (pressure / _SEA_PA) ** _POWER))
