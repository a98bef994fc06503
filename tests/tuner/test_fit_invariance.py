"""What must not change a fit: units, files, clocks, missing samples, and how recordings come."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

import tuner
from filters import Madgwick
from filters.declared import channel_facts
from tests.tuner import fit_cases as cases

G = 9.80665
QUICK = ("--starts", 1, "--no-hold-out", "--jobs", 1)
ONCE = {"starts": 1, "hold_out": False}


def fitted(cli, *words):
    """The parameters and the report of a fit that converged."""
    code, out, err = cli("fit", *words, *QUICK, "--json", "--force", "--out", "out")
    assert code == 0, (out, err)
    result = json.loads(out)
    (solution,) = result["solutions"]
    return {name: p["value"] for name, p in solution["parameters"].items()}, result


def values(fit):
    return {
        name: float(p.value) for name, p in fit.solution.parameters.items() if p.value.ndim == 0
    }


def test_units_of_sensors_do_not_matter(cli, here):
    si = cases.imu(seconds=8.0)
    degrees = si | {f"g{axis}": np.degrees(si[f"g{axis}"]) for axis in "xyz"}
    other = degrees | {f"a{axis}": si[f"a{axis}"] / G for axis in "xyz"}
    cases.write(here / "si.csv", si)
    cases.write(here / "other.csv", other)
    words = ("--filter", "madgwick", "--truth", "att=q0,q1,q2,q3")
    maps = ("--map", "gyr=gx,gy,gz:rad/s", "--map", "acc=ax,ay,az:m/s^2")
    one, first = fitted(cli, "si.csv", *words, *maps)
    maps = ("--map", "gyr=gx,gy,gz:deg/s", "--map", "acc=ax,ay,az:g")
    two, second = fitted(cli, "other.csv", *words, *maps)
    assert two == pytest.approx(one, rel=1e-9)
    assert second["fit"]["tuned"] == pytest.approx(first["fit"]["tuned"], rel=1e-9)


def test_a_level_in_another_unit_is_scaled(cli, here):
    cases.write(here / "level.csv", cases.level())
    words = ("level.csv", "--filter", "local-level")
    volts, first = fitted(cli, *words, "--map", "z=z:V")
    milli, second = fitted(cli, *words, "--map", "z=z:mV")
    # The start and the box scale with the data, so that both searches take the same steps.
    assert milli["q"] == pytest.approx(1e-6 * volts["q"], rel=1e-9)
    assert milli["R"] == pytest.approx(1e-6 * volts["R"], rel=1e-9)
    assert second["fit"]["tuned"] == pytest.approx(1e-3 * first["fit"]["tuned"], rel=1e-9)
    # SI units stand beside both, for a log in millivolts becomes volts.
    units = {r["solutions"][0]["parameters"]["q"]["unit"] for r in (first, second)}
    assert units == {"V^2/s"}


@pytest.mark.parametrize("filter", ["local-level", "constant-velocity"])
def test_a_fifth_of_the_cells_empty(cli, here, filter):
    data = cases.track(seed=4) if filter == "constant-velocity" else cases.level()
    name = "x" if filter == "constant-velocity" else "z"
    empty = np.random.default_rng(2).random(len(data["t"])) < 0.2
    data[name] = np.where(empty, np.nan, data[name])
    cases.write(here / "gaps.csv", data)
    found, result = fitted(cli, "gaps.csv", "--filter", filter, "--map", f"{name}={name}")
    loop, dt = (
        (cases.velocity_loop, cases.TRACK_DT)
        if filter == "constant-velocity"
        else (cases.level_loop, 1.0)
    )
    best, value = cases.tuned_by_hand(lambda q, R: loop(data[name], q, R, dt), [0.5, 2.0])
    # Two searches for the same optimum: the objective is flat to 1e-6 within 1e-3 of it.
    assert [found["q"], found["R"]] == pytest.approx(best, rel=1e-3)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)


def test_uneven_steps_are_taken_as_they_are(cli, here):
    draw = np.random.default_rng(3)
    t = np.cumsum(0.2 + 1.6 * draw.random(300))
    walk = np.cumsum(np.sqrt(0.2 * np.diff(t, prepend=t[0])) * draw.standard_normal(300))
    z = walk + draw.standard_normal(300)
    cases.write(here / "uneven.csv", {"t": t, "z": z})
    found, result = fitted(cli, "uneven.csv", "--filter", "local-level", "--map", "z=z")
    steps = np.diff(t, prepend=t[0])
    best, value = cases.tuned_by_hand(lambda q, R: cases.level_loop(z, q, R, steps), [0.5, 2.0])
    assert [found["q"], found["R"]] == pytest.approx(best, rel=1e-3)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)


def test_two_files_with_clocks_of_their_own_are_the_merged_arrays(cli, here):
    fast, slow = 0.01 * np.arange(1500), 0.003 + 0.2 * np.arange(75)  # 100 Hz and 5 Hz
    draw = np.random.default_rng(1)
    acc = 0.5 * np.sin(fast) + 0.2 + 0.3 * draw.standard_normal(1500)
    baro = np.interp(slow, fast, 0.5 * (fast - np.sin(fast))) + 0.2 * draw.standard_normal(75)
    cases.write(here / "acc.csv", {"t": fast, "acc": acc})
    cases.write(here / "baro.csv", {"t": slow, "baro": baro})
    maps = ("--map", "acc=acc:m/s^2", "--map", "baro=baro:m", "--fix", "q_bias=1e-6")
    found, result = fitted(cli, "acc.csv", "baro.csv", "--filter", "vertical", *maps)
    times = {"acc": fast, "baro": slow}
    record = tuner.Record.of({"acc": acc, "baro": baro}, times=times, units={"acc": "m/s^2"})
    apart = tuner.fit("vertical", record, fix={"q_bias": 1e-6}, **ONCE)
    # And by hand on one clock: 3 ms are less than half a step, so a height goes to its nearest.
    merged = np.full(1500, np.nan)
    merged[::20] = baro
    record = tuner.Record.of({"acc": acc, "baro": merged}, rate_hz=100.0)
    whole = tuner.fit("vertical", record, fix={"q_bias": 1e-6}, **ONCE)
    for other in (apart, whole):
        assert found == pytest.approx(values(other), rel=1e-9)
        assert result["fit"]["tuned"] == pytest.approx(other.judged.tuned, rel=1e-9)


# Several recordings.


def lanes(lengths=(120, 80, 150)):
    return [cases.level(seed=20 + i, samples=n)["z"] for i, n in enumerate(lengths)]


def joined_by_hand(recordings):
    """One q and R for all: the numbers of all loops together."""

    def loop(q, R):
        return np.concatenate([cases.level_loop(z, q, R, 1.0) for z in recordings], axis=1)

    return cases.tuned_by_hand(loop, [0.5, 2.0])


def test_recordings_of_one_file_and_of_several(cli, here):
    recordings = lanes()
    rows = [(i, k, v) for i, z in enumerate(recordings) for k, v in enumerate(z)]
    trip, t, z = np.array(rows).T
    # Sorted by time, as a logger would write them side by side.
    order = np.argsort(t, kind="stable")
    cases.write(here / "all.csv", {"t": t[order], "trip": trip[order], "z": z[order]})
    for i, one in enumerate(recordings):
        cases.write(here / f"{i}.csv", {"t": np.arange(len(one)), "z": one})
    best, value = joined_by_hand(recordings)
    words = ("--filter", "local-level", "--map", "z=z")
    for files in (("all.csv", "--by", "trip"), ("0.csv", "1.csv", "2.csv")):
        found, result = fitted(cli, *files, *words)
        assert [found["q"], found["R"]] == pytest.approx(best, rel=1e-3)
        assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)
        assert result["fit"]["diagnostics"][1]["numbers"] == sum(map(len, recordings)) - 3
        logs = [Path(file) for file in files if file.endswith(".csv")]
        assert result["log"]["name"] == " + ".join(log.name for log in logs)
        assert result["log"]["samples"] == sum(map(len, recordings))
        if len(logs) == 1:  # the digest of the file, as a shell would work it out
            own = hashlib.sha256((here / logs[0]).read_bytes()).hexdigest()
            assert result["log"]["sha256"] == own


def test_recordings_of_unequal_clocks(cli, here):
    """One at 1 Hz, one at 2 Hz, one uneven: every sample brings its own step."""
    draw, recordings, steps = np.random.default_rng(9), [], []
    for i, dt in enumerate((np.full(150, 1.0), np.full(200, 0.5), 0.3 + draw.random(120))):
        walk = np.cumsum(np.sqrt(0.1 * dt) * draw.standard_normal(len(dt)))
        z = walk + 0.7 * draw.standard_normal(len(dt))
        t = np.cumsum(dt) - dt[0]
        cases.write(here / f"{i}.csv", {"t": t, "z": z})
        recordings.append(z)
        steps.append(np.diff(t, prepend=t[0]))

    def loop(q, R):
        each = [cases.level_loop(z, q, R, dt) for z, dt in zip(recordings, steps, strict=True)]
        return np.concatenate(each, axis=1)

    best, value = cases.tuned_by_hand(loop, [0.5, 2.0])
    words = ("--filter", "local-level", "--map", "z=z")
    found, result = fitted(cli, "0.csv", "1.csv", "2.csv", *words)
    assert [found["q"], found["R"]] == pytest.approx(best, rel=1e-3)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)


def test_order_of_recordings_and_of_columns_does_not_matter():
    recordings = [
        tuner.Record.of({"z": z}, rate_hz=1.0, name=f"{i}") for i, z in enumerate(lanes())
    ]
    there = tuner.fit("local-level", recordings, **ONCE)
    back = tuner.fit("local-level", recordings[::-1], **ONCE)
    assert values(back) == pytest.approx(values(there), rel=1e-6)
    # The unit and the scale are the measurement's, whichever channel comes first.
    z, sigma = 1e3 * lanes()[0], np.full(120, 1e3)
    first = tuner.Record.of({"sigma": sigma, "z": z}, rate_hz=1.0, units={"z": "m", "sigma": "m"})
    second = tuner.Record.of({"z": z, "sigma": sigma}, rate_hz=1.0, units={"z": "m", "sigma": "m"})
    one, two = (tuner.fit("local-level", record, **ONCE) for record in (first, second))
    assert values(one) == values(two)
    # R is a factor on sigma^2 then, and near 1 for the deviation that the level was made with.
    assert one.solution.parameters["R"].unit == ""
    assert values(one)["R"] == pytest.approx(1.0, rel=0.45)


def test_a_truth_at_another_rate_is_that_truth(here):
    data = cases.imu(seconds=8.0)
    truth = np.stack([data[f"q{i}"] for i in range(4)], axis=1)
    channels = {
        "gyr": np.stack([data[f"g{axis}"] for axis in "xyz"], axis=1),
        "acc": np.stack([data[f"a{axis}"] for axis in "xyz"], axis=1),
    }
    facts = {"inputs": channel_facts(Madgwick, "inputs")}
    sparse = np.full_like(truth, np.nan)
    sparse[::4] = truth[::4]
    one = tuner.Record.of(channels, times=data["t"], truth={"att": sparse}, **facts)
    other = tuner.Record.of(
        channels, times=data["t"], truth={"att": truth[::4]}, truth_times=data["t"][::4], **facts
    )
    found = [tuner.fit("madgwick", record, **ONCE) for record in (one, other)]
    assert values(found[0]) == pytest.approx(values(found[1]), rel=1e-9)
    # Minus a quaternion is the same attitude.
    turned = tuner.Record.of(channels, times=data["t"], truth={"att": -sparse}, **facts)
    third = tuner.fit("madgwick", turned, **ONCE)
    assert values(third) == pytest.approx(values(found[0]), rel=1e-9)
