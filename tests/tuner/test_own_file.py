"""A filter's class from a Python file: tuned, run again, checked, and never run unasked."""

import json
import shlex
import shutil
import sys
from dataclasses import fields

import pytest

import filters
import tuner
from tests.tuner import fit_cases as cases
from tests.tuner.helpers import snapshot
from tuner.run.own_file import own_file

SOURCE = '''"""A level that returns to zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters import Channel, Param

LEVEL = Channel("unit", "level")
print("loaded")


class Noise(NamedTuple):
    tau: Annotated[Array, Param("s", "time constant", 10.0, 1e-1, 1e4)]
    sigma: Annotated[Array, Param("unit", "deviation of the level", 1.0, 1e-3, 1e3)]
    R: Annotated[Array, Param("unit^2", "variance of a measurement", 1.0, 1e-6, 1e6)]


class Outputs(NamedTuple):
    level: Annotated[Array, LEVEL]
    innovation: Annotated[Array, Channel("unit", "measured less predicted", kind="detail")]
    variance: Annotated[Array, Channel("unit^2", "of the innovation", kind="detail")]


class State(NamedTuple):
    x: Array
    P: Array


@dataclass(frozen=True)
class Robot:
    """Kalman filter of a Gauss-Markov process."""

    dt: float
    params, outputs = Noise, Outputs
    inputs, states = {"z": Channel("unit", "measured level")}, {"level": LEVEL}

    def init(self, params: Noise) -> State:
        return State(jnp.zeros_like(params.sigma), params.sigma**2)

    def step(self, params: Noise, state: State, inputs: Array) -> tuple[State, Outputs]:
        a = jnp.exp(-self.dt / params.tau)
        x, P = a * state.x, a**2 * state.P + params.sigma**2 * (1 - a**2)
        missing, s = jnp.isnan(inputs), P + params.R
        y = jnp.where(missing, 0.0, inputs - x)
        K = jnp.where(missing, 0.0, P / s)
        outputs = Outputs(x + K * y, y[None], jnp.where(missing, 0.0, s)[None])
        return State(outputs.level, (1 - K) * P), outputs


def helper(x):
    return x
'''
QUICK = ("--starts", 1, "--no-hold-out", "--jobs", 1)


@pytest.fixture
def log(here):
    return cases.write(here / "level.csv", cases.level(samples=200))


@pytest.fixture
def robot(here):
    """In a folder of its own, under the name of one of our packages, beside another of them."""
    folder = here / "mine"
    folder.mkdir()
    (folder / "tuner.py").write_text("raise SystemExit('the wrong module')\n")
    (folder / "filters.py").write_text(SOURCE)
    return folder / "filters.py"


def values(folder):
    result = json.loads((folder / "result.json").read_text())
    return {n: p["value"] for n, p in result["solutions"][0]["parameters"].items()}


def test_a_class_of_a_file_is_tuned_and_run_again(cli, here, log, robot):
    path, modules = list(sys.path), set(sys.modules)
    told = f"{robot}:Robot"
    words = ("fit", log, "--filter", told, "--map", "z=z:m", *QUICK)
    code, out, err = cli(*words, "--out", "one", "--json")
    assert code == 0, err
    assert "loaded" in err  # stdout is the result alone
    assert json.loads(out)["fit"]["filter"] == "Robot"
    assert sys.path == path
    new = [name for name in set(sys.modules) - modules if name.startswith("filters_")]
    assert len(new) == 1
    assert sys.modules["filters"] is filters
    assert not list(robot.parent.glob("__pycache__"))
    # The recipe names it without a folder, and its checksum.
    recipe = (here / "one" / "study.toml").read_text()
    assert 'filter = "filters.py:Robot"' in recipe
    assert f'filter_sha256 = "{own_file(told).sha256}"' in recipe
    assert str(here) not in recipe + (here / "one" / "result.json").read_text()
    before = snapshot(here)
    code, out, err = cli("run", "one/study.toml", "--dry-run")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "no input file runs code" in err
    assert "tuner run one/study.toml --filter filters.py:Robot" in err
    assert snapshot(here) == before
    code, _, err = cli("run", "one/study.toml", "--filter", told, "--out", "two", "--jobs", 1)
    assert code == 0, err
    assert values(here / "two") == values(here / "one")
    assert (here / "two" / "study.toml").read_text() == recipe
    # The same from Python, by the same class.
    record = tuner.read_record(log, ["z=z:m"])
    found = tuner.fit(told, record, starts=1, hold_out=False)
    assert {n: float(p.value) for n, p in found.solution.parameters.items()} == values(here / "one")
    assert type(found.posed.problem.filter) is own_file(told).load()


def test_a_run_of_a_file_is_checked_where_the_file_is_named(cli, here, log, robot):
    told = f"{robot}:Robot"
    assert cli("fit", log, "--filter", told, "--map", "z=z:m", *QUICK, "--out", "one")[0] == 0
    code, _, err = cli("check", "one", "--log", log)
    assert code == 2
    assert "tuner check one --filter filters.py:Robot" in err
    code, out, err = cli("check", "one", "--filter", told, "--log", log, "--json")
    assert code == 0, err
    assert json.loads(out)["filter"] == "Robot"
    code, _, err = cli("check", "one", "--filter", "local-level", "--log", log)
    assert (code, "leave out --filter" in err) == (2, True)
    robot.write_text(SOURCE + "\n# changed\n")
    code, _, err = cli("check", "one", "--filter", told, "--log", log)
    assert code == 0
    assert "filters.py has changed since: its SHA-256 is another one" in err
    code, _, err = cli("run", "one/study.toml", "--filter", told, "--out", "two", "--jobs", 1)
    assert code == 0
    assert "filters.py has changed since" in err
    code, out, err = cli("export", "one", "--to", "json", "-o", "-")
    assert code == 0, err  # numbers alone, no code
    direct = ("--set", "tau=1", "--set", "sigma=1", "--set", "R=1", "--map", "z=z")
    code, out, err = cli("check", "--filter", told, *direct, "--log", log, "--json")
    assert code == 0, err


def test_an_interrupted_run_goes_on_with_its_file(cli, here, log, robot, monkeypatch):
    from tuner.solvers.gradient import Gradient

    def interrupt(*_):
        raise KeyboardInterrupt

    told = f"{robot}:Robot"
    with monkeypatch.context() as patch:
        patch.setattr(Gradient, "__call__", interrupt)
        code, _, err = cli("fit", log, "--filter", told, "--map", "z=z", *QUICK, "--out", "one")
    assert code == 130
    words = shlex.split(err.splitlines()[-1].removeprefix("tuner "))
    assert words[-3:] == ["--filter", told, "--resume"]
    shutil.copy(robot, here / "kept.py")
    robot.write_text(SOURCE + "\n# changed\n")
    code, _, err = cli(*words)
    assert (code, "has other settings" in err) == (2, True)
    shutil.move(here / "kept.py", robot)
    assert cli(*words)[0] == 0


def test_its_facts_are_listed(cli, robot):
    code, out, err = cli("list", "filters", f"{robot}:Robot")
    assert code == 0, err
    assert "Robot: Kalman filter of a Gauss-Markov process. (filters.py:Robot)" in out
    assert "time constant" in out


REFUSED = {
    "no file": ("", "nowhere.py:Robot", "nowhere.py cannot be read: No such file"),
    "near class": (SOURCE, "own.py:Robt", "unknown class of own.py 'Robt'; did you mean Robot?"),
    "no class told": (SOURCE, "own.py", "name the filter's class in it, such as own.py:Robot"),
    "a function": (SOURCE, "own.py:helper", "helper of own.py is no class but function"),
    "another class": (SOURCE, "own.py:Noise", "Noise declares no inputs"),
    "syntax": ("x = 1\ny = (\n", "own.py:Robot", "own.py cannot be loaded: line 2: SyntaxError"),
    "raises": (
        "def f():\n    return 1 / 0\n\n\nf()\n",
        "own.py:Robot",
        "own.py cannot be loaded: line 2: ZeroDivisionError: division by zero; mend that line",
    ),
    "exits": (
        "import sys\nsys.exit(3)\n",
        "own.py:Robot",
        'line 2: SystemExit: 3; put what ends the program below if __name__ == "__main__"',
    ),
    "missing module": (
        "import a_module_that_nobody_has\n",
        "own.py:Robot",
        "line 1: ModuleNotFoundError: No module named 'a_module_that_nobody_has'; a filter's file "
        "is self-contained",
    ),
    "relative": (
        "from .helpers import f\n",
        "own.py:Robot",
        "line 1: ImportError: attempted relative import",
    ),
    "no text": (b"\xff\xfe\x00\x01", "own.py:Robot", "own.py cannot be loaded"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_loaded_is_told_in_a_sentence(cli, here, log, case):
    text, told, sentence = REFUSED[case]
    (here / "helpers.py").write_text("f = 1\n")
    (here / "own.py").write_bytes(text if isinstance(text, bytes) else text.encode())
    before, modules = snapshot(here), set(sys.modules)
    code, out, err = cli("fit", log, "--filter", told, "--map", "z=z", "--out", "out")
    assert (code, out) == (2, "")
    (line,) = [each for each in err.splitlines() if each != "loaded"]
    assert sentence in line, line
    assert snapshot(here) == before
    if "cannot be loaded" in sentence:
        assert not [name for name in set(sys.modules) - modules if name.startswith("own_")]


def test_a_recipe_runs_no_code_whatever_it_holds(cli, here, log):
    (here / "evil.py").write_text("open('harm', 'w')\n")
    head = "study = 'fit'\n[log]\nfiles = ['level.csv']\nmap = ['z=z']\n[settings]\n"
    for entry in ("'evil.py:Robot'", "'./evil.py:Robot'", "'evil.py'", f"'{here}/evil.py:A'"):
        (here / "my.toml").write_text(f"{head}filter = {entry}\n")
        code, _, err = cli("run", "my.toml")
        assert (code, "no input file runs code" in err) == (2, True)
    assert not (here / "harm").exists()


def test_a_changed_file_is_another_module(here):
    file = here / "own.py"
    file.write_text(SOURCE)
    first = own_file(f"{file}:Robot").load()
    assert own_file(f"{file}:Robot").load() is first
    assert [each.name for each in fields(first)] == ["dt"]
    file.write_text(SOURCE.replace("returns to zero", "goes back to zero"))
    assert own_file(f"{file}:Robot").load() is not first
    with pytest.raises(ValueError, match="own.py has changed: its SHA-256 differs"):
        own_file(f"{file}:Robot").load("0" * 64)


# Models in text files.


POSITION = """
title = "A position that is pushed, of which nothing is known at the start"
[parameters]
q = { start = 0.1, unit = "m^2/s^3" }
R = { start = 1.0, unit = "m^2" }
[states]
place = { unit = "m" }
speed = { unit = "m/s" }
[measurements]
z = { unit = "m" }
[model]
A = [[0, 1], [0, 0]]
G = [0, 1]
Q = "q"
C = [1, 0]
R = "R"
P0 = [inf, 1.0]
"""


def test_a_model_is_kept_in_the_recipe(cli, here, log):
    (here / "own.toml").write_text(POSITION)
    words = ("fit", log, "--model", "own.toml", "--map", "z=z:m", *QUICK, "--out", "one")
    code, _, err = cli(*words)
    assert code in (0, 1), err
    (here / "own.toml").rename(here / "gone.toml")
    recipe = (here / "one" / "study.toml").read_text()
    assert "[settings.model.parameters.q]" in recipe
    assert "inf" in recipe  # as TOML has it
    code, _, err = cli("run", "one/study.toml", "--out", "two", "--jobs", 1)
    assert code in (0, 1), err
    assert values(here / "two") == values(here / "one")
    code, _, err = cli("check", "one", "--log", log)
    assert code == 0, err
    own = ("--set", "q=1", "--set", "R=1", "--map", "z=z:m")
    assert cli("check", "--model", "gone.toml", *own, "--log", log)[0] == 0
    code, out, err = cli("list", "filters", "gone.toml")
    assert code == 0, err
    assert "(gone.toml)" in out
    assert cli("export", "one", "--to", "json", "-o", "-", "--force")[0] == 0
    found = tuner.fit(
        here / "gone.toml", tuner.read_record(log, ["z=z:m"]), starts=1, hold_out=False
    )
    assert {n: float(p.value) for n, p in found.solution.parameters.items()} == values(here / "one")
    found.save("saved")
    assert cli("run", "saved/study.toml", "--out", "three", "--jobs", 1)[0] in (0, 1)
    assert values(here / "three") == values(here / "one")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "and there is none; give one of them"),
        (("--filter", "local-level", "--model", "leaky.toml"), "and there are both"),
        (("--filter", "leaky.toml"), "leaky.toml is a model and no filter; give --model leaky"),
    ],
)
def test_one_filter_is_named(cli, here, log, words, sentence):
    (here / "leaky.toml").write_text(POSITION)
    code, out, err = cli("fit", log, "--map", "z=z", *words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert sentence in err
