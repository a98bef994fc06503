"""What a fit tunes and by what it is judged, of a filter's facts, the data and the wishes."""

import numpy as np
import pytest

import tuner
from filters import Complementary, ConstantVelocity, Lanes, LocalLevel, Madgwick, Timed
from filters.declared import parameter_facts
from filters.pi_complementary import PiComplementary
from objectives import AttitudeRmse, ChannelRmse, InnovationLikelihood
from tests.tuner import fit_cases as cases
from tuner.catalogue import find, names
from tuner.problem.parameters import Bounded, Fixed, Positive
from tuner.run.fit import pose_on
from tuner.run.search_space import Wishes


def posed(cls, *records, **wishes):
    return pose_on(cls.__name__, cls, records, Wishes(**wishes))


def level(scale=1.0, **more):
    channels = {"z": scale * cases.level(samples=100)["z"]}
    return tuner.Record.of(channels, rate_hz=1.0, **more)


def free(case):
    return {n: p for n, p in case.problem.space.parameters if not isinstance(p, Fixed)}


def test_starts_and_ranges_scale_with_the_data():
    one, other = (dict(posed(LocalLevel, level(k)).problem.space.parameters) for k in (1.0, 1e-6))
    for name in ("q", "R"):
        for end in ("init", "low", "high"):
            ratio = getattr(other[name], end) / getattr(one[name], end)
            assert ratio == pytest.approx(1e-12, rel=1e-9)
    # Near the data's own noise: half the variance of its steps, to a factor of 3.
    assert 1 / 3 < one["R"].init < 3


def test_units_are_those_of_the_data():
    plain = free(posed(LocalLevel, level()))
    told = free(posed(LocalLevel, level(units={"z": "hPa"})))
    assert [p.unit for p in plain.values()] == ["unit^2/s", "unit^2"]
    assert [p.unit for p in told.values()] == ["Pa^2/s", "Pa^2"]


def test_kinds_of_parameters():
    facts = parameter_facts(find("tuner.filters", "alpha-beta"))
    space = dict(posed(find("tuner.filters", "alpha-beta"), level()).problem.space.parameters)
    assert {name: type(p) for name, p in space.items()} == dict.fromkeys(facts, Bounded)
    truth = {"angle": np.zeros(50)}
    record = tuner.Record.of(
        {"rate": np.zeros(50), "angle": np.ones(50)}, rate_hz=10.0, truth=truth
    )
    space = dict(posed(Complementary, record).problem.space.parameters)
    assert {name: type(p) for name, p in space.items()} == {"tau": Positive, "angle0": Fixed}


def test_what_belongs_to_a_channel_that_is_absent_idles():
    still = {"gyr": np.zeros((60, 3)), "acc": np.tile([0.0, 0.0, 9.81], (60, 1))}
    baro = np.random.default_rng(1).normal(size=60)
    record = tuner.Record.of(still | {"baro": baro}, rate_hz=10.0)
    found = free(posed(find("tuner.filters", "ins"), record))
    assert {name for name in found if name.startswith("R_")} == {"R_baro"}
    asked = posed(find("tuner.filters", "ins"), record, bound={"R_mag": (1e-3, 1.0)})
    assert "R_mag" in free(asked)


def test_exported_states_are_those_of_the_axes_given():
    walk = cases.level(samples=100)["z"]
    record = tuner.Record.of({"x": walk, "y": walk}, rate_hz=1.0)
    states = posed(ConstantVelocity, record).problem.what_is_exported().states
    assert states == ("position_x", "position_y", "velocity_x", "velocity_y")


def test_wishes_decide():
    case = posed(LocalLevel, level(), fix={"R": 2.0}, bound={"q": (0.1, 9.0)})
    space = dict(case.problem.space.parameters)
    assert space["R"].value == 2.0
    assert (space["q"].low, space["q"].high) == (0.1, 9.0)
    case = posed(LocalLevel, level(), bound={"q": (100.0, 400.0)})
    assert free(case)["q"].init == pytest.approx(200.0)  # the middle, where typical is outside
    case = posed(LocalLevel, level(), bound={"q": (0.0, 9.0)}, start={"q": 3.0})
    assert (type(free(case)["q"]), free(case)["q"].init) == (Bounded, 3.0)


def test_the_objective_follows_from_what_there_is():
    assert isinstance(posed(LocalLevel, level()).problem.objective, InnovationLikelihood)
    truth = {"level": cases.level(samples=100)["level"]}
    assert posed(LocalLevel, level(truth=truth)).problem.objective == ChannelRmse("level")
    data = cases.imu(seconds=8.0)
    gyr = np.stack([data[f"g{axis}"] for axis in "xyz"], axis=1)
    acc = np.stack([data[f"a{axis}"] for axis in "xyz"], axis=1)
    att = {"att": np.stack([data[f"q{i}"] for i in range(4)], axis=1)}
    six = tuner.Record.of({"gyr": gyr, "acc": acc}, rate_hz=50.0, truth=att)
    nine = tuner.Record.of({"gyr": gyr, "acc": acc, "mag": acc}, rate_hz=50.0, truth=att)
    case = posed(Madgwick, six)
    assert (case.objective, case.unit) == ("inclination", "deg")
    assert case.problem.objective == AttitudeRmse("inclination")
    case = posed(Madgwick, nine)
    assert (case.objective, case.problem.objective) == ("rmse", AttitudeRmse("total"))
    assert posed(Madgwick, nine, objective="heading").problem.objective == AttitudeRmse("heading")


def test_the_filter_is_of_the_datas_clock():
    assert posed(LocalLevel, level()).problem.filter == LocalLevel(1.0)
    t = np.cumsum(0.5 + np.random.default_rng(1).random(100))
    uneven = tuner.Record.of({"z": cases.level(samples=100)["z"]}, times=t)
    assert isinstance(posed(LocalLevel, uneven).problem.filter, Timed)
    both = posed(LocalLevel, level(), level())
    assert both.problem.filter == Lanes(LocalLevel(1.0), 2)
    both = posed(LocalLevel, uneven, level())
    assert isinstance(both.problem.filter, Lanes)
    assert isinstance(both.problem.filter.filter, Timed)


def test_axes_are_those_given():
    z = cases.level(samples=60)["z"]
    for axes in ("x", "xy", "xyz"):
        record = tuner.Record.of(dict.fromkeys(axes, z), rate_hz=1.0)
        assert posed(ConstantVelocity, record).problem.filter.axes == axes
    with pytest.raises(ValueError, match="name the first one x, the second y"):
        posed(ConstantVelocity, tuner.Record.of({"x": z, "z": z}, rate_hz=1.0))
    # A truth may have the axes that there are.
    pair = {"position": np.stack([z, z], axis=1)}
    record = tuner.Record.of({"x": z, "y": z}, rate_hz=1.0, truth=pair)
    assert posed(ConstantVelocity, record).problem.objective == ChannelRmse("position", parts=2)
    lone = tuner.Record.of({"x": z}, rate_hz=1.0, truth={"position": z})
    assert posed(ConstantVelocity, lone).problem.objective == ChannelRmse("position")


def test_what_is_given_all_or_none_is_left_out_unless_it_is_asked_for():
    draw = np.random.default_rng(1)
    three = draw.standard_normal((60, 3)) - np.array([0, 0, 9.81])
    channels = {"gyr": 0.1 * draw.standard_normal((60, 3)), "acc": three, "airspeed": np.ones(60)}
    record = tuner.Record.of(channels, rate_hz=10.0, truth={"angles": np.zeros((60, 2))})
    assert set(free(posed(PiComplementary, record))) == {"K1", "K2"}
    asked = posed(PiComplementary, record, options={"aid": "velocity"}, start={"Q_k": 0.1})
    assert set(free(asked)) == {"K1", "K2", "Q_k"}


def test_where_nothing_was_measured_nothing_counts():
    z = cases.level(samples=100)["z"]
    z[10:30] = np.nan
    truth = np.asarray(posed(LocalLevel, tuner.Record.of({"z": z}, rate_hz=1.0)).problem.data.truth)
    assert np.flatnonzero(np.isnan(truth[:, 0])).tolist() == list(range(10, 30))


@pytest.mark.parametrize("name", names("tuner.filters"))
def test_every_filter_tells_what_it_lacks(name):
    try:
        cls = find("tuner.filters", name)
    except ValueError:
        pytest.skip(f"{name} has no module yet")
    record = tuner.Record.of({"nothing": np.ones(10)}, rate_hz=1.0)
    with pytest.raises(ValueError, match="unknown channel 'nothing'") as caught:
        posed(cls, record)
    assert "\n" not in str(caught.value)
