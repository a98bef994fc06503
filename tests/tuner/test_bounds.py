"""What is read within bounds: files that are none, nests, links, and cells of CSV."""

import csv
import io
import json
import os
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tuner.recordings import refusal
from tests.tuner.test_cli_refusals import refused
from tuner.export import Provenance, Quantity, Tuned, dump, load
from tuner.export.cells import as_written, inert
from tuner.files import opened, whole
from tuner.run.figure import Chart, Line
from tuner.toml import parsed

LOG = "t,gx\n" + "".join(f"{0.01 * k:.2f},{k % 7}\n" for k in range(90))
UNIX = pytest.mark.skipif(os.name == "nt", reason="Windows has no such files")


@UNIX
@pytest.mark.parametrize(
    "words",
    [
        ["columns", "x"],
        ["run", "kownacki2010", "--log", "x", "--map", "omega=gx"],
        ["run", "x.toml"],
        ["fit", "log.csv", "--model", "x", "--map", "z=gx"],
        ["fit", "log.csv", "--filter", "x.py:C", "--map", "z=gx"],
        ["compare", "x"],
    ],
    ids=lambda words: words[0] + words[-1],
)
def test_what_is_no_file_is_not_waited_for(cli, here, words):
    (here / "log.csv").write_text(LOG)
    name = next(word for word in words if word.startswith("x")).partition(":")[0]
    os.mkfifo(here / name)
    refused(cli(*words), name)
    (here / name).unlink()
    (here / name).symlink_to("/dev/zero")
    refused(cli(*words), name)
    assert sorted(path.name for path in here.iterdir()) == sorted(["log.csv", name])


@UNIX
def test_kinds_of_what_is_no_file(tmp_path):
    with pytest.raises(ValueError, match="is a folder, not a file"):
        opened(tmp_path)
    (tmp_path / "x").write_bytes(b"12345")
    assert whole(tmp_path / "x", 5, "note") == b"12345"
    with pytest.raises(ValueError, match="has more than 4 bytes, which is no note"):
        whole(tmp_path / "x", 4, "note")


@UNIX
def test_links_that_lead_out(cli, here):
    (here / "log.csv").write_text(LOG)
    (here / "folder").mkdir()
    (here / "folder/gyro.csv").symlink_to("../log.csv")
    assert "link that leads out of the folder" in refusal(here / "folder", ["omega=gyro/gx"])
    (here / "study").mkdir()
    (here / "study/log.csv").symlink_to("../log.csv")
    recipe = 'study = "kownacki2010"\n[log]\nfiles = ["log.csv"]\nmap = ["omega=gx"]\n'
    (here / "study/study.toml").write_text(recipe)
    (here / "log.csv").rename(here / "other.csv")
    (here / "study/log.csv").unlink()
    (here / "study/log.csv").symlink_to("../other.csv")
    refused(cli("run", "study/study.toml"), "link that leads out of its folder")
    assert cli("columns", "study/log.csv")[0] == 0  # a person named it


def test_links_of_hdf5_to_other_files(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["gx"] = np.arange(9.0)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["t"] = np.arange(9.0)
        file["gx"] = h5py.ExternalLink("other.h5", "gx")
    assert "'gx' is a link to another file" in refusal(tmp_path / "log.h5", ["omega=gx"])


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 2000 + "]" * 2000,
        "a = " + "{b = " * 900 + "1" + "}" * 900,
        "[" + ".".join("a" * 900) + "]",
        ".".join("a" * 900) + " = 1",
        '"a".' * 900 + "b = 1",
        "a = " + "9" * 6000,
        "a = [",
    ],
)
def test_toml_without_bounds(text):
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        parsed(text)
    assert "\n" not in str(caught.value)


def test_brackets_in_texts_and_remarks_are_no_nest():
    many = "[" * 99
    for text in (f"a = '{many}'", f'a = "\\"{many}"', f'a = """\n{many}"""', f"a = 1  # {many}"):
        assert parsed(text) == tomllib.loads(text)


@given(st.text("[]{}.=\"'#\n a1,", max_size=60))
def test_any_text_is_read_as_toml_reads_it_or_refused(text):
    try:
        expected = tomllib.loads(text)
    except ValueError:
        with pytest.raises(ValueError):  # noqa: PT011
            parsed(text)
    else:
        assert parsed(text) == expected


def test_a_nest_in_a_setting(cli, here):
    nest = "P0=" + "[" * 3000 + "]" * 3000
    refused(cli("run", "kownacki2010", "--set", nest, "--dry-run"), "more than 32 deep")


def test_an_array_that_would_not_fit(cli, here):
    words = ["--set", "seconds=1e9", "--memory", "1GB", "--dry-run"]
    refused(cli("run", "kownacki2010", *words), "1e+13 samples would take")


FORMULAS = (
    "=1+1",
    "+cmd|' /C calc'!A0",
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "\r=1",
    "'=1",
    "\uff1d1",
    ";=1",
    "a;=1",
)


def evil(text):
    source = Provenance(f"a,{text}", "b", "c", "d", 0, f"x;{text}", "", (("y", f"1,{text}"),))
    R = Quantity("R", np.array([1.0, -2.0]), text, f"{text}, more")
    return Tuned("gyro", "Filter", (R,), "discrete", 0.01, ("a",), source)


@pytest.mark.parametrize("text", FORMULAS)
@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
def test_no_spreadsheet_executes_a_cell(text, delimiter):
    data = dump(evil(text), "csv")
    rows = csv.reader(io.StringIO(data.decode(), newline=""), delimiter=delimiter)
    for cell in (cell for row in rows for cell in row):
        assert cell[:1] not in tuple("=+@\t\r\uff1d"), cell
        assert cell[:1] != "-" or float(cell), cell
    assert load(data, "csv") == evil(text)


@given(st.text() | st.text("=-+';|\t\r\na1"))
def test_cells_come_back_as_they_were(text):
    assert as_written(inert(text)) == text


def test_tables_of_figures_and_comparisons():
    from tuner.run.drawing import table

    line = Line("=1+1", np.arange(2.0), np.array([-1.0, 2.0]))
    assert b"\n'=1+1,0,-1\n" in table(Chart("f", "title", "x", "y", (line,)))


def test_a_certificate_that_somebody_changed():
    from tests.tuner.test_result import SOLUTION
    from tuner.run.result import SolutionRecord

    record = SolutionRecord.of(SOLUTION)
    good = json.loads(record.model_dump_json())
    assert SolutionRecord.model_validate(good).solution().problem == record.problem
    for changed in ({}, {"starts": 5}, {**good["certificate"], "starts": 5}):
        bad = SolutionRecord.model_validate({**good, "certificate": changed})
        with pytest.raises(ValueError, match="the certificate of .* is not that of a run; run it"):
            bad.solution()
    assert replace(SOLUTION, problem="x").problem == "x"
