"""Noise as variance, density and deviation, in data sheets' units and as they are written."""

import numpy as np
import pytest

from filters import (
    AttitudeKalman,
    BoundedMotionKalman,
    ConstantVelocity,
    ErrorStateIns,
    GyroscopeFilter,
    LocalLevel,
    Vertical,
)
from filters.declared import parameter_facts
from tuner.data.sensor_units import sheet_units
from tuner.data.unit_text import powers_of, raised, written
from tuner.data.units import Unit
from tuner.run.noise_parameters import noise_parameters
from tuner.run.noise_table import noise_findings


def told(cls, values, dt, units=None):
    units = units or {name: fact.unit for name, fact in parameter_facts(cls).items()}
    return {f.name: (f.value, f.unit) for f in noise_findings(cls(dt), values, units)}


def close(value):
    return pytest.approx(value, rel=1e-12)


def test_a_gyroscopes_density_as_data_sheets_tell_it():
    """0.01 deg/s/sqrt(Hz), as of many MEMS gyroscopes: 0.6 deg/sqrt(h)."""
    density = np.radians(0.01) ** 2
    found = told(ErrorStateIns, {"q_gyr": density}, 0.01)
    assert found["q_gyr.density"] == (density, "rad^2/s")
    assert found["q_gyr.variance"] == (close(density * 0.01), "rad^2")
    assert found["q_gyr.deviation"] == (close(np.radians(0.01) * 0.1), "rad")
    assert found["q_gyr.gyroscope_noise_density"] == (close(np.radians(0.01)), "rad/s/sqrt(Hz)")
    assert found["q_gyr.deg/s/sqrt(Hz)"] == (close(0.01), "deg/s/sqrt(Hz)")
    assert found["q_gyr.ARW"] == (close(0.6), "deg/sqrt(h)")


def test_an_accelerometers_density_as_data_sheets_tell_it():
    """100 ug/sqrt(Hz)."""
    found = told(Vertical, {"q_acc": (100e-6 * 9.80665) ** 2, "q_bias": 1e-10}, 0.02)
    assert found["q_acc.ug/sqrt(Hz)"] == (close(100.0), "ug/sqrt(Hz)")
    assert found["q_acc.VRW"] == (close(60 * 100e-6 * 9.80665), "m/s/sqrt(h)")
    assert found["q_bias.accelerometer_random_walk"] == (close(1e-5), "m/s^3/sqrt(Hz)")


def test_roots_of_densities_are_known_by_the_half():
    found = told(BoundedMotionKalman, {"gyroscope": 2e-4, "bias": 1e-5}, 0.01)
    assert found["gyroscope.density"] == (close(4e-8), "rad^2/s")
    assert found["gyroscope.gyroscope_noise_density"] == (close(2e-4), "rad/s/sqrt(Hz)")
    assert found["bias.RRW"] == (close(np.degrees(1e-5) * 3600 * 60), "deg/h/sqrt(h)")


def test_a_measurements_variance_is_a_density_times_the_rate():
    found = told(LocalLevel, {"q": 0.5, "R": 8.0}, 0.25, {"q": "(rad/s)^2/s", "R": "(rad/s)^2"})
    assert found["R.density"] == (2.0, "rad^2/s^2/Hz")
    assert found["R.deviation"] == (close(8**0.5), "rad/s")
    assert found["q.variance"] == (0.125, "rad^2/s^2")


def test_what_belongs_to_a_sample_has_no_density():
    found = told(GyroscopeFilter, {"R": 1.0, "Q": 4.0}, 0.01)
    assert "Q.density" not in found
    assert found["Q.deviation"][0] == 2.0


def test_times_gains_starts_and_what_cannot_be_read_are_no_noise():
    facts = parameter_facts(AttitudeKalman)
    values = {name: fact.typical for name, fact in facts.items()}
    units = {name: fact.unit for name, fact in facts.items()}
    assert [n.name for n in noise_parameters(AttitudeKalman(0.1), values, units)] == [
        "gyroscope",
        "bias",
    ]
    assert told(ConstantVelocity, {"q": 1.0}, 1.0, {"q": "as it is, unit"}) == {}
    assert told(ConstantVelocity, {"q": 0.0}, 1.0) == {}


def test_a_noise_without_a_unit_is_known_by_what_it_does():
    found = told(LocalLevel, {"q": 0.5, "R": 8.0}, 0.25, {"q": "", "R": ""})
    assert found["q.variance"] == (0.125, "")
    assert found["q.density"] == (0.5, "")
    assert found["R.variance"] == (8.0, "")
    assert found["R.density"] == (2.0, "")


@pytest.mark.parametrize(
    "sensor", ["gyroscope", "gyroscope bias", "accelerometer", "accelerometer bias"]
)
def test_factors_are_those_of_the_units(sensor):
    """As :mod:`tuner.data.units` knows them: a root of Hz is a power of s, one of h of 3600 s."""

    def si(unit):
        head, _, root = unit.partition("/sqrt(")
        return Unit.of(head).factor * {"Hz)": 1.0, "h)": 1 / 60}[root]

    first, *others = sheet_units(sensor)
    assert first.factor == 1
    for other in others:
        assert other.factor * si(other.unit) == close(si(first.unit))
    assert sheet_units("") == ()


@pytest.mark.parametrize(
    "text", ["", "m", "1/s", "unit^2/s^3", "rad^2 s", "m/s^0.5", "m^2/s^2/Hz", "rad/s^1.5"]
)
def test_units_are_written_as_they_were_read(text):
    assert written(powers_of(text)) == text
    assert written(raised(raised(powers_of(text), 2.0), 0.5)) == text


@pytest.mark.parametrize("text", ["1, 1/s", "unit^2 .. unit^2/s^4", "(m/s", "m^x"])
def test_other_texts_are_no_unit(text):
    assert powers_of(text) is None
