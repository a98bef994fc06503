"""Scripts for MATLAB: run by Octave where there is one, and the loop against one in NumPy."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from tests.tuner.export_cases import nasty, tuned
from tuner.export import ExportError, Quantity, dump, load
from tuner.problem.exported import derived_of
from tuner.run.filter_choice import choose_filter

F = np.array([[1.0, 0.1], [0.0, 1.0]])
C = np.array([[1.0, 0.0]])
K = np.array([0.3, 0.2])


def tracker(told="x' = F x", **changed):
    """A filter with its model, whose meaning tells that it is one."""
    named = {"F": F, "C": C, "K": K, "R": np.array(2.0)} | changed
    kept = {name: value for name, value in named.items() if value is not None}
    return tuned(*(Quantity(n, value, "", told * (n == "F")) for n, value in kept.items()))


def script(one):
    return dump(one, "matlab").decode("ascii")


def statements(text):
    """What is no comment and not empty."""
    return [line for line in text.splitlines() if line and not line.startswith("%")]


def octave(folder, text, *commands):
    """What Octave prints after the script."""
    if shutil.which("octave-cli") is None:
        pytest.skip("there is no octave-cli to run scripts")
    (folder / "written.m").write_text(text)
    program = "; ".join(["written", *commands])
    command = ["octave-cli", "-q", "--norc", "--eval", program]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def test_whatever_the_texts_every_line_is_a_statement_or_a_comment():
    text = script(nasty())
    name = r"[A-Za-z]\w*"
    number = r"-?\d[\d.]*(e[+-]\d+)?"
    right = rf"(struct\(\)|'\w+'|\{{.*\}}|{number}|\[{number}([,;] {number})*\])"
    for line in statements(text):
        assert re.fullmatch(rf"{name}(\.{name})? = {right};", line), line


def test_keywords_and_own_fields_are_renamed():
    named = [Quantity(name, np.array(1.0), "") for name in ("end", "while", "predict", "R")]
    one = tuned(*named, name="function")
    text = script(one)
    left = [line.partition(" = ")[0] for line in statements(text)]
    assert left[0] == "function_"
    assert left[4:] == [f"function_.{n}" for n in ("end_", "while_", "predict_", "R")]
    assert load(text.encode(), "matlab") == one


@pytest.mark.parametrize(
    "missing",
    [
        {"F": None},
        {"C": None},
        {"K": None},
        {"K": np.ones((2, 2))},
        {"K": np.ones(3)},
        {"told": "force of the wind"},
        {"told": "", **dict.fromkeys("FCK", np.ones(()))},
    ],
)
def test_without_the_whole_model_there_is_no_loop(missing):
    assert "update" not in script(tracker(**missing))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("tuned.R = 2.0", "tuned.R = system(1)", "could not convert string to float"),
        ("tuned.R = 2.0", "tuned.R = ", "it has a quantity without numbers"),
        ("tuned.K = [0.3; 0.2]", "tuned.K = [0.3]", "'K' is not of the shape (2,)"),
        ("% end of tuned", "", "it names no tuned filter, or is cut short"),
    ],
)
def test_scripts_that_are_wrong(old, new, reason):
    text = script(tuned(*tracker().quantities, name="tuned"))
    assert old in text
    with pytest.raises(ExportError, match=re.escape(reason)):
        load(text.replace(old, new).encode(), "matlab")


def test_octave_has_the_same_numbers(tmp_path):
    one = nasty()
    names = [quantity.name for quantity in one.quantities]
    shown = [f"printf('%.17g ', gyro.{name}.'); disp('')" for name in names]
    printed = octave(tmp_path, script(one), *shown)
    for quantity, line in zip(one.quantities, printed.splitlines(), strict=True):
        found = np.array([float(word) for word in line.split()])
        assert found.tobytes() == quantity.value.ravel().tobytes(), quantity.name


def test_octave_runs_the_steady_loop(tmp_path):
    z = np.random.default_rng(0).standard_normal(20)
    z[7:9] = np.nan
    x = np.zeros(2)
    for measured in z:
        x = F @ x
        if not np.isnan(measured):
            x = x + K * (measured - (C @ x)[0])
    loop = re.findall(r"^%     (.+)$", script(tracker()), re.MULTILINE)
    values = ", ".join("NaN" if np.isnan(v) else repr(float(v)) for v in z)
    program = "\n".join([f"z = [{values}];", *loop, "printf('%.17g ', x);"])
    (tmp_path / "loop.m").write_text(program)
    printed = octave(tmp_path, script(tracker()), "loop")
    np.testing.assert_allclose([float(word) for word in printed.split()], x, rtol=1e-13)


def test_a_design_of_a_discrete_model_has_its_loop():
    told = "gain on a sample: x+ = x + K (y - C x), L = A K"
    one = tuned(Quantity("A", F, ""), Quantity("C", C, ""), Quantity("K", K[:, None], "", told))
    assert "gyro.predict = @(x) gyro.A * x;" in script(one)


def test_linear_filters_export_their_model():
    """x' = F x over a sample of 0.1 s, for a position that moves on."""
    import jax.numpy as jnp

    cls = choose_filter("constant-velocity").cls
    params = cls.params(**{name: jnp.asarray(1.0) for name in cls.params._fields})
    found = {q.name: q.value for q in derived_of(cls(dt=0.1), params)}
    np.testing.assert_allclose(found["F"], F, rtol=1e-15)
    np.testing.assert_array_equal(found["C"], C)
    assert "gyro.update" in script(tuned(*derived_of(cls(dt=0.1), params)))


def test_a_known_input_and_other_states_have_no_model_beside_their_gain():
    """The channel of heights is moved by the acceleration, and its linear model turns a sign."""
    import jax.numpy as jnp

    cls = choose_filter("vertical").cls
    params = cls.params(**{name: jnp.asarray(1.0) for name in cls.params._fields})
    assert not {"F", "C"} & {q.name for q in derived_of(cls(dt=0.1), params)}
