import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.data.units import Unit, change, convert

PI = np.pi
# One of each, and what it is in SI: definitions of the BIPM brochure and of the SI conversion
# tables in NIST SP 811, written out here so that they share nothing with the table.
DEFINED = [
    ("deg", PI / 180, "rad"),
    ("rev", 2 * PI, "rad"),
    ("deg/s", PI / 180, "rad/s"),
    ("dps", PI / 180, "rad/s"),
    ("°/s", PI / 180, "rad/s"),
    ("degrees per second", PI / 180, "rad/s"),
    ("deg/h", PI / 180 / 3600, "rad/s"),
    ("°/h", PI / 180 / 3600, "rad/s"),
    ("rpm", 2 * PI / 60, "rad/s"),
    ("mdps", PI / 180e3, "rad/s"),
    ("rad s-1", 1.0, "rad/s"),
    ("m/s2", 1.0, "m/s^2"),
    ("m/s²", 1.0, "m/s^2"),
    ("m s⁻²", 1.0, "m/s^2"),
    ("m s-2", 1.0, "m/s^2"),
    ("ms-2", 1.0, "m/s^2"),
    ("m/s/s", 1.0, "m/s^2"),
    ("g", 9.80665, "m/s^2"),
    ("mg", 9.80665e-3, "m/s^2"),
    ("gal", 0.01, "m/s^2"),
    ("cm", 0.01, "m"),
    ("mm", 0.001, "m"),
    ("km", 1000.0, "m"),
    ("ft", 0.3048, "m"),
    ("km/h", 1 / 3.6, "m/s"),
    ("kn", 1852 / 3600, "m/s"),
    ("ft/s", 0.3048, "m/s"),
    ("mph", 0.44704, "m/s"),
    ("mT", 1e-3, "T"),
    ("uT", 1e-6, "T"),
    ("µT", 1e-6, "T"),
    ("nT", 1e-9, "T"),
    ("G", 1e-4, "T"),
    ("gauss", 1e-4, "T"),
    ("mgauss", 1e-7, "T"),
    ("hPa", 100.0, "Pa"),
    ("kPa", 1000.0, "Pa"),
    ("mbar", 100.0, "Pa"),
    ("bar", 1e5, "Pa"),
    ("psi", 6894.757293168, "Pa"),
    ("ms", 1e-3, "s"),
    ("us", 1e-6, "s"),
    ("ns", 1e-9, "s"),
    ("min", 60.0, "s"),
    ("h", 3600.0, "s"),
    ("mA", 1e-3, "A"),
    ("mV", 1e-3, "V"),
    ("%", 0.01, ""),
    ("", 1.0, ""),
    ("m^2/s^3", 1.0, "m^2/s^3"),
]


@pytest.mark.parametrize(("text", "factor", "si"), DEFINED)
def test_units_by_their_definitions(text, factor, si):
    unit = Unit.of(text)
    assert unit.si == si
    assert unit.factor == pytest.approx(factor, rel=4e-16)  # two roundings of a double


@pytest.mark.parametrize(
    ("value", "unit", "to", "expected"),
    [
        (20.0, "degC", "K", 293.15),
        (293.15, "K", "°C", 20.0),
        (32.0, "degF", "degC", 0.0),
        (212.0, "degF", "degC", 100.0),
        (36.0, "km/h", "m/s", 10.0),
        (1013.25, "hPa", "mbar", 1013.25),
    ],
)
def test_conversions(value, unit, to, expected):
    # Temperatures pass 273.15 on the way, whose last digit is 6e-14.
    assert convert(value, unit, to) == pytest.approx(expected, rel=1e-15, abs=2e-13)


@settings(max_examples=50)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=9))
def test_degrees_are_radians_to_the_last_digits(values):
    np.testing.assert_allclose(convert(values, "deg/s", "rad/s"), np.radians(values), rtol=1e-15)
    there_and_back = convert(convert(values, "kn", "ft/s"), "ft/s", "kn")
    np.testing.assert_allclose(there_and_back, values, rtol=1e-15)


def test_missing_samples_stay_missing():
    assert np.isnan(convert([np.nan, 1.0], "g", "m/s^2")).tolist() == [True, False]


@pytest.mark.parametrize(
    ("text", "near"), [("def/s", "deg/s"), ("m/s^2x", "m/s^2"), ("gaus", "gauss"), ("LSB", "rad/s")]
)
def test_unknown_units_name_the_near_ones(text, near):
    with pytest.raises(ValueError, match="unknown unit") as caught:
        Unit.of(text)
    assert near in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("unit", "to"), [("deg/s", "m/s^2"), ("Hz", "rad/s"), ("g", "m"), ("", "m")]
)
def test_other_dimensions_are_refused(unit, to):
    with pytest.raises(ValueError, match="is no"):
        convert(1.0, unit, to)
    with pytest.raises(ValueError, match="is needed"):
        change(unit, to)


def test_what_any_unit_becomes():
    assert change("uT", "unit") == (1e-6, 0.0, "T", "")
    assert change("degC", "unit") == (1.0, 0.0, "degC", "")
    assert change(None, "unit").note == "no unit given, left as it is"
    kept = change("counts", "unit/s")
    assert (kept.factor, kept.unit) == (1.0, "counts")
    assert "unknown unit 'counts'" in kept.note


def test_a_quaternion_needs_no_unit():
    assert change(None, "") == (1.0, 0.0, "", "")
