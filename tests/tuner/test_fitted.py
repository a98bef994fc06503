"""A fit from Python: its table, its picture, its folder and its exports."""

import json
import re
from dataclasses import replace
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

import tuner
from filters import LocalLevel
from tests.tuner import fit_cases as cases
from tests.tuner.helpers import snapshot
from tuner.certificate.solution import Status, TunedParameter
from tuner.cli.tables import show_result
from tuner.export import FORMATS, is_text, load
from tuner.run.recipe import HOW, read_recipe
from tuner.run.result import read_result


def record(z, **more):
    return tuner.Record.of({"z": z}, rate_hz=1.0, units={"z": "m"}, **more)


@pytest.fixture(scope="module")
def fit():
    level = cases.level(samples=200)
    return tuner.fit("local-level", record(level["z"]), starts=2)


def numbers(solution):
    return {name: float(p.value) for name, p in solution.parameters.items()}


# As a table.


def test_a_solution_is_a_table(fit):
    lines = repr(fit.solution).splitlines()
    assert str(fit.solution) == repr(fit.solution)
    assert lines[0].startswith("local_level by l-bfgs-b: converged, the gradient vanishes here")
    assert lines[1].endswith("; 2 of 2 starts agree")
    head, q, R, Q, K = lines[2:]
    assert head.split() == ["parameter", "value", "interval", "unit"]
    assert q.split()[0] == "q"
    assert q.endswith("m^2/s")
    assert "(95 %)" in R
    assert (Q.split()[2], K.split()[2]) == ("follows", "follows")
    starts = {line.index(line.split()[1], len(line.split()[0])) for line in (head, q, R)}
    assert len(starts) == 1  # aligned


def test_what_is_held_or_open_is_told():
    level = cases.level(samples=200)
    solution = tuner.fit(
        "local-level", record(level["z"]), fix={"R": 1.0}, starts=1, hold_out=False
    ).solution
    rows = {line.split()[0]: line for line in repr(solution).splitlines()[3:]}
    assert rows["R"].split() == ["R", "1", "held", "m^2"]
    open_ = replace(solution.parameters["q"], interval=None)
    matrix = TunedParameter(np.eye(2), "<m>", None)
    doubtful = replace(
        solution,
        status=Status.STALLED,
        parameters={**solution.parameters, "q": open_, "P": matrix},
        certificate=replace(solution.certificate, flat_directions=("only q/R is determined",)),
    )
    told = repr(doubtful)
    assert "not determined" in told
    assert "stalled, the method stopped by its own tolerance" in told
    assert "only q/R is determined" in told
    assert "[[1., 0.], [0., 1.]]" in told
    html = doubtful._repr_html_()
    assert "&lt;m&gt;" in html
    assert "<m>" not in html
    assert html.count("<tr>") == 6


def test_a_fit_shows_table_and_lines(fit):
    shown = repr(fit).splitlines()
    assert shown[0] == repr(fit.solution).splitlines()[0]
    assert [line.split()[0] for line in shown[-4:]] == ["how", "trust", "open", "next"]
    assert "fit.export" in shown[-1]
    html = fit._repr_html_()
    assert html.count("<li>") == 4
    assert html.startswith(fit.solution._repr_html_())


def test_a_record_shows_itself_in_a_notebook():
    odd = tuner.Record.of({"z<b>": np.arange(5.0)}, rate_hz=2.0, name="<i>log</i>")
    html = odd._repr_html_()
    assert "&lt;i&gt;log&lt;/i&gt;" in html
    assert "z&lt;b&gt;" in html
    assert "<i>" not in html
    assert html.count("<b>") == 1
    assert "channel" in html


def test_one_sided_intervals_are_no_markup(here, fit, capsys):
    fit.save("out")
    result = read_result(here / "out")
    lines = ["use       q = 1e-06 [below 0.0002] (95 %) m^2/s"]
    told = result.model_copy(update={"fit": result.fit.model_copy(update={"lines": lines})})
    show_result(told, here / "out")
    assert lines[0] in capsys.readouterr().out


# As a picture.


def test_its_picture(fit):
    picture = fit.plot()
    measured, innovations, held = picture.axes
    labels = [text.get_text() for text in measured.get_legend().get_texts()]
    assert labels == ["expected range of 95 % of measurements", "measured", "level"]
    assert "measurement, m" in measured.get_ylabel()
    assert "deviation" in innovations.get_ylabel()
    assert [tick.get_text() for tick in held.get_yticklabels()] == [
        "before",
        "tuned",
        "no filter",
        "best there",
    ]
    bars = [bar.get_width() for bar in held.patches]
    found = fit.judged.held_out
    assert bars == [found.start, found.tuned, found.unfiltered, found.best]
    # What is drawn is what was measured, and what the filter returned.
    points, line = measured.lines
    z = fit.posed.timeline.channels["z"]
    np.testing.assert_allclose(points.get_ydata(), z[1:], atol=1e-12)
    np.testing.assert_array_equal(line.get_ydata(), fit.outputs.level)


def test_the_picture_of_a_fit_against_a_truth():
    level = cases.level(samples=120)
    held = record(level["z"], truth={"level": level["level"]})
    found = tuner.fit("local-level", held, starts=1, hold_out=False)
    titles = [axes.get_title("left") for axes in found.plot().axes]
    assert len(titles) == 3
    assert re.search(r"[\d.]+\sm rms from the truth, [\d.]+\sbefore", titles[1])


def test_the_picture_of_a_filter_without_innovations():
    imu = cases.imu(seconds=3.0, bursts=False)
    stacked = {
        name: np.stack([imu[part] for part in parts], axis=1)
        for name, parts in {
            "gyr": ("gx", "gy", "gz"),
            "acc": ("ax", "ay", "az"),
            "att": ("q0", "q1", "q2", "q3"),
        }.items()
    }
    truth = {"att": stacked.pop("att")}
    both = tuner.Record.of(stacked, rate_hz=50.0, truth=truth)
    found = tuner.fit("madgwick", [both, both], starts=1, held_out="recording")
    titles = [" ".join(axes.get_title("left").split()) for axes in found.plot().axes]
    assert len(titles) == 2
    assert "first recording" in titles[0]
    assert titles[1].startswith("Tuned on the rest, ")
    assert titles[1].endswith(" error than before on 1 recording")


# As a folder.


def test_its_folder_is_that_of_the_command_line(cli, here, fit):
    columns = cases.level(samples=200)
    cases.write(here / "level.csv", {"t": columns["t"], "z": columns["z"]})
    words = ("--filter", "local-level", "--map", "z=z:m", "--starts", 2, "--out", "told")
    assert cli("fit", "level.csv", *words)[0] == 0
    assert fit.save(here / "saved") == here / "saved"
    files = {name for name, data in snapshot(here / "told").items() if data is not None}
    ours = {name for name, data in snapshot(here / "saved").items() if data is not None}
    assert ours - files == {"recording.npz"}
    assert not files - ours
    assert [p.name for p in here.iterdir() if p.name.startswith(".")] == []
    both = [read_result(here / name) for name in ("told", "saved")]
    told, saved = (numbers(each.solutions[0].solution()) for each in both)
    assert saved == told
    assert both[0].settings == both[1].settings
    assert both[0].fit.lines[:-1] == both[1].fit.lines[:-1]
    for name in ("exports/local_level.csv", "exports/local_level.npz", "outputs.npz"):
        if not name.startswith("exports"):  # exports tell the log's name
            assert (here / "told" / name).read_bytes() == (here / "saved" / name).read_bytes()
    # It runs again, to the same numbers, and is checked and exported as any other.
    code, _, err = cli("run", "saved/study.toml", "--out", "again")
    assert code == 0, err
    assert numbers(read_result(here / "again").solutions[0].solution()) == saved
    assert cli("check", "saved", "--log", "level.csv")[0] == 0
    assert cli("export", "saved", "--to", "c", "-o", "-")[0] == 0


def test_nothing_is_overwritten_unasked(here, fit, monkeypatch):
    Path("full").mkdir()
    (Path("full") / "mine.txt").write_text("mine")
    before = snapshot(here)
    with pytest.raises(ValueError, match=r"full already exists; .* give force=True"):
        fit.save("full")
    with pytest.raises(ValueError, match="already exists"):
        fit.save("full/mine.txt", force=True)
    assert snapshot(here) == before
    # A folder that cannot be finished leaves nothing.
    with monkeypatch.context() as patch:
        patch.setattr("tuner.run.save.FORMATS", ("json", "nonsense"))
        with pytest.raises(ValueError, match="nonsense"):
            fit.save("never")
    assert snapshot(here) == before
    Path("empty").mkdir()
    fit.save("empty")
    assert (here / "empty" / "result.json").exists()
    fit.save("full", force=True)
    assert (here / "full" / "mine.txt").read_text() == "mine"
    assert (here / "full" / "result.json").exists()


def test_recordings_with_clocks_of_their_own_run_again(cli, here):
    draw = np.random.default_rng(2)
    slow, fast = np.arange(40) * 0.5, np.sort(draw.uniform(0, 19.5, 200))
    climb = tuner.Record.of(
        {"acc": 0.1 * draw.standard_normal(200), "baro": draw.standard_normal(40)},
        times={"acc": fast, "baro": slow},
    )
    found = tuner.fit("vertical", climb, starts=1, hold_out=False)
    found.save("climb")
    assert json.loads((here / "climb" / "result.json").read_text())["study"] == "fit"
    code, _, err = cli("run", "climb/study.toml", "--out", "again")
    assert code in (0, 1), err
    assert numbers(read_result(here / "again").solutions[0].solution()) == pytest.approx(
        numbers(found.solution), rel=1e-12
    )
    levels = [record(cases.level(seed=seed, samples=80)["z"]) for seed in (1, 2)]
    both = tuner.fit("local-level", levels, starts=1, hold_out=False)
    both.save("two")
    code, _, err = cli("run", "two/study.toml", "--out", "two again")
    assert code in (0, 1), err
    assert numbers(read_result(here / "two again").solutions[0].solution()) == numbers(
        both.solution
    )


def test_recordings_of_files_are_named_and_not_copied(cli, here):
    columns = cases.level(samples=120)
    cases.write(here / "level.csv", {"t": columns["t"], "z": columns["z"]})
    told = tuner.read_record("level.csv", ["z=z:m"], from_s=5.0, time="t")
    found = tuner.fit("local-level", told, starts=1, hold_out=False)
    found.save("out")
    assert not (here / "out" / "recording.npz").exists()
    log = read_recipe(here / "out" / "study.toml").log
    assert (log.files, log.map, log.from_s, log.time) == (["level.csv"], ["z=z:m"], 5.0, "t")
    assert cli("run", "out/study.toml", "--out", "again")[0] in (0, 1)
    again = read_result(here / "again").solutions[0].solution()
    assert numbers(again) == numbers(found.solution)
    # What was changed since it was read is no longer what the file holds.
    doubled = replace(told.channels["z"], values=2 * told.channels["z"].values)
    other = replace(told, channels={"z": doubled})
    tuner.fit("local-level", other, starts=1, hold_out=False).save("changed")
    assert (here / "changed" / "recording.npz").exists()


def test_a_recipe_has_all_that_says_how_a_log_is_read(here):
    """Whatever a reading takes, a study.toml keeps, or a run would not be the same again."""
    cases.write(here / "level.csv", cases.level(samples=20))
    given = set(signature(tuner.read_records).parameters) - {"paths", "inputs", "outputs"}
    names = {"map" if name == "mappings" else name for name in given}
    assert names == set(HOW)
    (record_,) = tuner.read_records("level.csv", ["z=z"])
    assert set(record_.read_as) == names


def test_a_class_of_the_catalogue_goes_by_its_name(here):
    z = cases.level(samples=80)["z"]
    found = tuner.fit(LocalLevel, record(z), starts=1, hold_out=False)
    assert found.posed.problem.name == "local_level"
    found.save("out")
    assert 'filter = "local-level"' in (here / "out" / "study.toml").read_text()


def test_a_class_of_a_module_goes_by_its_file(here):
    from tests.tuner.test_fit_python import Smooth

    level = cases.level(samples=80)
    held = record(level["z"], truth={"level": level["level"]})
    tuner.fit(Smooth, held, starts=1, hold_out=False).save("out")
    recipe = (here / "out" / "study.toml").read_text()
    assert 'filter = "test_fit_python.py:Smooth"' in recipe
    assert "filter_sha256" in recipe


def test_settings_that_no_file_can_hold(here, fit):
    odd = {**fit.made.settings, "options": {"law": object()}}
    spoilt = replace(fit, made=replace(fit.made, settings=odd))
    with pytest.raises(ValueError, match="the settings of this fit cannot be written"):
        spoilt.save("out")
    assert not (here / "out").exists()


# As an export.


@pytest.mark.parametrize("form", FORMATS)
def test_its_exports(here, fit, form):
    data = fit.export(form)
    assert isinstance(data, str if is_text(form) else bytes)
    found = load(data.encode() if isinstance(data, str) else data, form)
    assert {q.name: float(q.value) for q in found.quantities}["R"] == numbers(fit.solution)["R"]
    assert fit.export(form, "file") == Path("file")
    assert load(Path("file").read_bytes(), form) == found
    with pytest.raises(ValueError, match="exists"):
        fit.export(form, "file")
    assert fit.export(form, "file", force=True) == Path("file")


def test_what_did_not_converge_is_exported_when_asked(fit):
    doubtful = replace(fit, solution=replace(fit.solution, status=Status.AT_BOUND))
    with pytest.raises(ValueError, match="'at bound', not converged; force=True exports it"):
        doubtful.export("json")
    assert json.loads(doubtful.export("json", force=True))
    with pytest.raises(ValueError, match="there is no format 'jsn'; there are json"):
        fit.export("jsn")
