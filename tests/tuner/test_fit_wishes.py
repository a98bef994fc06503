"""What a user decides of a fit, and what comes out of one: files, words, the same again."""

import json
import re
import shutil

import numpy as np
import pytest

from tests.tuner import fit_cases as cases
from tests.tuner.helpers import snapshot
from tuner.cli import invoke
from tuner.report.write import page_again, read_kept
from tuner.run.result import read_result

WORDS = ("--filter", "local-level", "--map", "z=z:m")
QUICK = ("--starts", 1, "--no-hold-out", "--jobs", 1)


@pytest.fixture(scope="module")
def finished(tmp_path_factory, cache):
    """A fit with all that a fit has: several starts, a part held out, its wishes."""
    folder = tmp_path_factory.mktemp("finished")
    log = cases.write(folder / "level.csv", cases.level())
    wishes = ("--start", "q=0.5", "--bound", "R=0.01..100", "--seed", "3", "--starts", "2")
    words = [str(word) for word in ("fit", log, *WORDS, *wishes, "--out", folder / "out")]
    assert invoke(words) == 0
    return folder


@pytest.fixture
def run(finished, here):
    shutil.copytree(finished / "out", here / "out")
    shutil.copy(finished / "level.csv", here)
    return here / "out"


def fitted(cli, *words):
    code, out, err = cli("fit", *words, "--json")
    assert code in (0, 1), err
    assert next(iter(json.loads(out))) == "schema"
    return json.loads(out)


def number(result, name):
    return result["solutions"][0]["parameters"][name]["value"]


@pytest.fixture
def log(here):
    return cases.write(here / "level.csv", cases.level())


# Wishes.


def test_what_is_fixed_is_held_and_the_rest_tuned(cli, here, log):
    result = fitted(cli, log, *WORDS, *QUICK, "--fix", "R=2")
    assert number(result, "R") == 2.0
    assert list(result["solutions"][0]["certificate"]["gradient"]) == ["ln q"]
    z = cases.level()["z"]
    found, _ = cases.tuned_by_hand(lambda q: cases.level_loop(z, q, 2.0, 1.0), [0.5])
    assert number(result, "q") == pytest.approx(found[0], rel=1e-3)
    # The report names what was tuned, and the number that was held stands in the exports.
    assert "R =" not in result["fit"]["lines"][0]
    assert {q["name"] for q in result["tuned"][0]["quantities"]} >= {"q", "R", "K"}


def test_a_start_is_where_it_begins_and_what_is_meant_by_before(cli, here, log):
    result = fitted(cli, log, *WORDS, *QUICK, "--start", "q=4", "--start", "R=25")
    y, s = cases.level_loop(cases.level()["z"], 4.0, 25.0, 1.0)
    assert result["fit"]["start"] == pytest.approx(cases.deviation(y, s), rel=1e-9)
    before = result["fit"]["diagnostics"][0]
    assert before["nis"] == pytest.approx(np.mean(y**2 / s), rel=1e-9)
    # Far from the data's own scale a start widens the search to itself.
    far = fitted(cli, log, *WORDS, *QUICK, "--start", "q=1e13", "--out", "far")
    # Nothing of the data is seen beside it: y^2/s is 0, so the deviation is sqrt(s/e).
    assert far["fit"]["start"] == pytest.approx(np.sqrt(1e13 / np.e), rel=1e-3)


def test_a_bound_ends_the_search(cli, here, log):
    result = fitted(cli, log, *WORDS, *QUICK, "--bound", "q=1..9")
    assert number(result, "q") == pytest.approx(1.0, rel=1e-6)
    assert result["solutions"][0]["status"] == "at bound"
    _, _, trust, still, then = result["fit"]["lines"]
    assert trust.startswith("trust     at bound")
    assert "q lies at its bound" in still
    assert then == "next      search again with a wider --bound, or --fix, for q"
    assert result["exports"] == []
    assert cli("fit", log, *WORDS, *QUICK, "--bound", "q=1..9")[0] == 1


@pytest.mark.parametrize("bound", ["0.6..0.9", "0..0.2", "-1..2"])
def test_a_bound_that_leaves_out_the_typical_value(cli, here, bound):
    """0.5 is typical of alpha, which the search then begins in the middle."""
    cases.write(here / "track.csv", cases.track())
    words = ("track.csv", "--filter", "alpha-beta", "--map", "z=x", *QUICK)
    result = fitted(cli, *words, "--bound", f"alpha={bound}")
    low, high = map(float, bound.split(".."))
    assert low <= number(result, "alpha") <= high


def test_a_bound_tunes_what_has_no_range(cli, here):
    data = cases.imu(seconds=8.0)
    cases.write(here / "imu.csv", data)
    words = ("--map", "rate=rate:rad/s", "--map", "angle=angle:rad", "--truth", "angle=roll:rad")
    words = ("imu.csv", "--filter", "complementary", *words, *QUICK)
    result = fitted(cli, *words, "--bound", "angle0=-1..1", "--start", "tau=0.3")
    assert set(result["solutions"][0]["certificate"]["gradient"]) == {"ln tau", "logit angle0"}
    assert abs(number(result, "angle0")) < 0.2


def test_options_of_a_filter(cli, here):
    data = cases.climb(samples=300)
    data["acc"] = data["acc"] + 9.80665
    cases.write(here / "climb.csv", data)
    maps = ("--map", "acc=acc:m/s^2", "--map", "baro=baro:m", "--fix", "q_bias=1e-6")
    words = ("climb.csv", "--filter", "vertical", *maps, *QUICK)
    included = fitted(cli, *words, "--set", "gravity=included")
    cases.write(here / "climb.csv", data | {"acc": data["acc"] - 9.80665})
    removed = fitted(cli, *words)
    # Taken off by the filter or before: rounding of 9.8 beside 0.5.
    assert included["fit"]["tuned"] == pytest.approx(removed["fit"]["tuned"], rel=1e-9)


@pytest.mark.parametrize("solver", ["nelder-mead", "cma-es", "trust-constr"])
def test_solvers_agree(cli, here, log, solver):
    result = fitted(cli, log, *WORDS, *QUICK, "--solver", solver)
    (solution,) = result["solutions"]
    assert solution["solver"] == solver
    best, value = cases.tuned_by_hand(
        lambda q, R: cases.level_loop(cases.level()["z"], q, R, 1.0), [0.5, 2.0]
    )
    # 150 draws in a box of many decades come near, and no nearer; which of them is chance.
    value_near, near = (3e-3, 0.3) if solver == "cma-es" else (1e-4, 0.05)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=value_near)
    # A value flat to 1e-4 leaves some per cent of a parameter open.
    assert [number(result, "q"), number(result, "R")] == pytest.approx(best, rel=near)
    assert (solution["status"] == "converged") == (solver != "cma-es")


def test_objectives_by_name(cli, here, log):
    words = (log, *WORDS, *QUICK, "--json")
    likely = fitted(cli, *words, "--objective", "likelihood")
    plain = fitted(cli, *words)
    assert likely["solutions"][0]["value"] == plain["solutions"][0]["value"]
    predicted = fitted(cli, *words, "--objective", "prediction", "--fix", "R=1")
    z, q = cases.level()["z"], number(predicted, "q")
    y, _ = cases.level_loop(z, q, 1.0, 1.0)
    assert predicted["fit"]["tuned"] == pytest.approx(np.sqrt(np.mean(y**2)), rel=1e-9)
    truth = fitted(cli, *words, "--truth", "level=level:m", "--fix", "R=1")
    assert truth["fit"]["objective"] == "rmse"
    assert truth["fit"]["tuned"] < 1.0  # better than the measurements


def test_a_seed_gives_the_same_again(cli, here, log):
    words = (log, *WORDS, "--starts", 3, "--no-hold-out")
    one, two = (fitted(cli, *words, "--seed", 4) for _ in range(2))
    assert one["solutions"][0] | {"seconds": 0} == two["solutions"][0] | {"seconds": 0}
    assert fitted(cli, *words, "--seed", 5)["seed"] == 5


def test_dry_run_says_what_would_be_done_and_what_is_strange(cli, here, log):
    words = ("fit", log, *WORDS, "--fix", "R=1", "--dry-run")
    code, out, err = cli(*words)
    assert code == 0
    assert "would solve local_level over ln q by l-bfgs-b" in out
    assert "level.csv: 400 samples at 1 Hz" in err
    assert set(snapshot(here)) == {"level.csv"}
    draw, data = np.random.default_rng(1), cases.imu(seconds=8.0)
    # It falls for a while, the calmest there is, and is shaken otherwise.
    late = data["t"] > 1.0
    data |= {f"a{n}": np.where(late, data[f"a{n}"] + draw.normal(size=len(late)), 0) for n in "xyz"}
    cases.write(here / "imu.csv", data)
    words = ("fit", "imu.csv", "--filter", "attitude", "--map", "gyr=gx,gy,gz:rad/s")
    code, _, err = cli(*words, "--map", "acc=ax,ay,az:m/s^2", "--dry-run")
    assert code == 0
    assert "acc reads 0 m/s^2 where it is calmest" in err


# What comes out.


def test_the_five_lines(run):
    lines = read_result(run).fit.lines
    assert [line[:10].strip() for line in lines] == ["use", "how good", "trust", "open", "next"]
    use, good, trust, still, then = lines
    assert re.match(r"use       q = \S+ \[\S+, \S+\] \(95 %\) m\^2/s, R = \S+ \[\S+, \S+\] ", use)
    assert re.search(
        r"predicted within \S+ m, \S+ m before; on the last 119 samples, .* better", good
    )
    assert trust.startswith("trust     converged; 2 of 2 starts agree; before: NIS ")
    assert "expected: consistent)" in trust
    assert still == "open      nothing: all is determined"
    assert then == "next      tuner export RUN --to c -o local_level.h"


def test_json_holds_the_fit_section(run):
    result = json.loads((run / "result.json").read_text())
    assert (result["schema"], result["study"]) == ("tuner.result/1", "fit")
    fit = result["fit"]
    assert set(fit) == {
        *("filter", "objective", "unit", "start", "tuned", "held_out", "diagnostics", "lines"),
        *("rescaled", "trade", "rejected", "left_out", "in_doubt"),
    }
    assert (fit["filter"], fit["objective"], fit["unit"]) == ("LocalLevel", "likelihood", "m")
    assert set(fit["held_out"]) == {
        *("way", "what", "start", "tuned", "gain", "nothing", "unfiltered", "over_unfiltered"),
        *("best", "gap", "recordings"),
    }
    assert set(fit["held_out"]["gain"]) == {"share", "low", "high", "blocks"}
    assert len(fit["diagnostics"]) == 2
    assert [s["problem"] for s in result["solutions"]] == [
        *("local_level", "local_level_part", "local_level_alone"),
    ]
    assert set(result["artifacts"]) == {n for n, data in snapshot(run).items() if data is not None}


def test_its_report_shows_the_signal(run):
    kept = read_kept(run)
    names = ["signal_0", "spectrum_z", "innovations", "nis", "whiteness", "spread", "objective"]
    assert [picture.name for picture in kept.pictures] == names
    band, measured, before, tuned = kept.pictures[0].lines
    assert [line.label for line in (measured, before, tuned)] == ["measured", "before", "tuned"]
    assert all(low < high for low, high in zip(band.y, band.upper, strict=True))
    assert page_again(run) == (run / "report.html").read_bytes()
    surface = kept.pictures[-1]  # as low as it gets where it was tuned
    (spot,) = surface.lines
    i = np.argmin(np.abs(np.log(np.array(surface.x) / spot.x[0])))
    j = np.argmin(np.abs(np.log(np.array(surface.y) / spot.y[0])))
    assert surface.z[i][j] == np.min(surface.z) < 0.1


def test_its_recipe_runs_again(cli, here, run):
    code, out, err = cli("run", "out/study.toml", "--out", "again", "--json")
    assert code == 0, err
    first, again = json.loads((run / "result.json").read_text()), json.loads(out)
    for one, other in zip(first["solutions"], again["solutions"], strict=True):
        assert one | {"seconds": 0} == other | {"seconds": 0}
    for key in ("log", "settings", "seed", "fit", "exports", "tuned", "artifacts"):
        assert first[key] == again[key], key
    for name in ("study.toml", "outputs.npz", "exports/local_level.h"):
        assert (run / name).read_bytes() == (here / "again" / name).read_bytes()
    # Beside the recipe as well, but not another file of that name.
    (here / "level.csv").rename(run / "level.csv")
    assert cli("run", "out/study.toml", "--out", "third", "--dry-run")[0] == 0
    cases.write(run / "level.csv", cases.level(seed=6))
    code, _, err = cli("run", "out/study.toml", "--out", "third")
    assert code == 2
    assert "level.csv is not the log of study.toml: its SHA-256 differs" in err
    assert not (here / "third").exists()
    assert (
        cli("run", "out/study.toml", "--log", "out/level.csv", "--out", "third", "--dry-run")[0]
        == 0
    )
    (run / "level.csv").unlink()
    assert "level.csv of out/study.toml is not here" in cli("run", "out/study.toml")[2]


def test_no_file_knows_where_it_was_made(finished):
    for file in (finished / "out").rglob("*"):
        assert file.is_dir() or str(finished).encode() not in file.read_bytes(), file


def test_an_interrupted_fit_goes_on(cli, here, log, monkeypatch):
    from tuner.solvers.gradient import Gradient

    whole, solved = Gradient.__call__, []

    def interrupted(solver, problem):
        if problem.name.endswith(("_part", "_alone")):
            raise KeyboardInterrupt
        solved.append(problem.name)
        return whole(solver, problem)

    words = ("fit", log, *WORDS, "--starts", 1, "--jobs", 1, "--out", "out")
    with monkeypatch.context() as patch:
        patch.setattr(Gradient, "__call__", interrupted)
        code, _, err = cli(*words)
    assert (code, solved) == (130, ["local_level"])
    last = err.splitlines()[-1]
    assert last.startswith("tuner run out/study.toml --out out --log")
    assert last.endswith("--resume")
    assert cli(*words, "--resume")[0] == 0
    resumed = read_result(here / "out")
    assert cli(*words[:-1], "whole")[0] == 0
    assert resumed.fit == read_result(here / "whole").fit


def test_people_get_the_five_lines_last(cli, here, run):
    code, out, _ = cli("run", "out/study.toml", "--out", "again")
    assert code == 0
    assert [line[:10].strip() for line in out.splitlines()[-5:]] == [
        *("use", "how good", "trust", "open", "next"),
    ]
    command = out.splitlines()[-1].removeprefix("next      tuner ").split()
    assert cli(*command)[0] == 0
    assert (here / "local_level.h").is_file()


def test_pictures_say_what_they_show(run):
    table = (run / "figures" / "local_level_innovations.csv").read_text().splitlines()
    assert table[0] == "label,x,y"
    labels = {line.split(",")[0] for line in table[1:]}
    assert labels == {"innovation", "95 % expected"}
    rows = np.array([line.split(",")[1:] for line in table if line.startswith("innov")], float)
    inside = np.mean(np.abs(rows[:, 1]) < 2)
    assert 0.92 < inside < 0.98  # 399 numbers of 95.4 %: a deviation of 1 %
    assert (run / "figures" / "local_level_innovations.png").read_bytes()[:4] == b"\x89PNG"


def test_what_is_held_out_is_chosen(cli, here, log):
    code, _, err = cli("fit", log, *WORDS, "--starts", 1, "--set", "held_out=none", "--out", "none")
    assert code == 0, err
    assert read_result(here / "none").fit.held_out is None
    code, _, err = cli("fit", log, *WORDS, "--set", "held_out=leave-one-out", "--out", "two")
    assert (code, "takes several recordings, and there is one alone" in err) == (2, True)
    code, _, err = cli("fit", log, *WORDS, "--set", "held_out=half", "--out", "three")
    assert code == 2
    assert "held_out" in err
    assert "leave-one-out" in err
    assert err.count("\n") == 1
