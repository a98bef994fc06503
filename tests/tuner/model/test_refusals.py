"""Documents that are wrong or hostile: one sentence with lines and entries, and nothing happens."""

import contextlib
import time
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tuner.model.documents import SHORT
from tuner.model import model_filter, read_model, template
from tuner.model.expression import ExpressionError, parse


def changed(kind, *pairs):
    text = template(kind)
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def refused(text, folder):
    """The sentence with which a file is refused."""
    path = Path(folder) / "mine.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    begun = time.perf_counter()
    with pytest.raises(ValueError, match=r"mine\.toml|the model") as raised:
        read_model(path)
    assert time.perf_counter() - begun < 2.0
    assert "\n" not in str(raised.value)
    return str(raised.value)


def level(h):
    return changed("level", ('h = "level"', f"h = {h}"))


def test_all_errors_are_told_at_once_with_lines_and_near_names(tmp_path):
    told = refused(
        changed(
            "robot",
            ('"speed * cos(heading)"', '"speeed * cos(heading)"'),
            ('"sigma^2"', '"sigm^2"'),
            ("high = 10,", "hihg = 10,"),
        ),
        tmp_path,
    )
    assert told.startswith("4 errors in mine.toml: line 7, parameters.q_turn.hihg: unknown entry")
    assert "line 7, parameters.q_turn: has one end of its search; give both" in told
    assert "line 23, measurements.gps.R: unknown name 'sigm'; did you mean sigma?" in told
    assert "line 27, model.f.x: unknown name 'speeed'; did you mean speed" in told


def test_a_document_without_a_file_has_entries_and_no_lines():
    with pytest.raises(ValueError, match=r"^the model: model\.Q: unknown name 'Q'; ") as raised:
        model_filter(tomllib.loads(SHORT.replace('Q = "q"', 'Q = "Q"')))
    assert "line" not in str(raised.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"turn"\n', '"turn + x"\n', "line 29, model.f.heading: adds turn in 1/s and x in m"),
        ('"turn"\n', '"turn * x"\n', "is in m/s, and the rate of heading is in 1/s"),
        ("cos(heading)", "cos(x)", "takes cos of x in m"),
        ('unit = "m^2/s"', 'unit = "m^2"', "is in m^2, and the spectral density of w1 is in m^2/s"),
        ('R = "sigma^2"', 'R = "sigma"', "is in m, and the variance of x is in m^2"),
        ('h = ["x", "y"]', 'h = ["x", "heading"]', "entry 2: is in no unit, and the measurement"),
        (
            'x = { unit = "m" }',
            'x = { unit = "km" }',
            "computes in SI, to which a log is converted",
        ),
        ('x = { unit = "m" }', 'x = { unit = "metr" }', "unknown unit 'metr'; near ones are"),
    ],
)
def test_units_that_contradict_each_other(old, new, words, tmp_path):
    assert words in refused(changed("robot", (old, new)), tmp_path)


def test_a_discrete_model_has_a_variance_a_sample(tmp_path):
    text = changed("tracking", ("A = [[0, 1],", "F = [[1, 1],"), ("     [0, 0]]", "     [0, 1]]"))
    assert "model.Q: is in m^2/s^3, and the variance a sample of w1 is in m^2/s^2" in refused(
        text, tmp_path
    )


def test_what_has_no_unit_is_not_judged():
    assert model_filter(tomllib.loads(SHORT))


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        ("C = [0, 1]", "position shows in no measurement"),
        ("C = [0, 0]", "position and velocity show in no measurement"),
    ],
)
def test_states_that_are_not_observable_are_named(measured, words, tmp_path):
    text = changed("tracking", ("C = [1, 0]", measured), ('unit = "m", meaning', "meaning"))
    assert words in refused(text, tmp_path)


def test_states_that_cannot_be_told_apart_are_named_and_may_be_wanted(tmp_path):
    text = """
        states = ["level", "offset"]
        measurements = ["z"]
        parameters = ["q", "R"]
        model = { A = [[0, 0], [0, 0]], Q = "q", C = [1, 1], R = "R" }
    """
    told = refused(text, tmp_path)
    assert "level and offset cannot be told apart by what is measured" in told
    assert 'unobserved = ["level", "offset"]' in told
    assert model_filter(tomllib.loads('unobserved = ["level", "offset"]\n' + text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (level('"level + 9**9**9"'), "line 12, measurements.z.h: 9 ** 3.8742e+08 is not a finite"),
        (level('"' + "(" * 450 + "level" + ")" * 450 + '"'), "too many nested parentheses"),
        (level('"' + "-" * 900 + 'level"'), "more than 40 levels or 400 parts"),
        (level('"' + "level+" * 300 + 'level"'), "has 1805 characters; 1000 is the most"),
        (level('"level + ' + "9" * 900 + '"'), "contains a number beyond 1e308"),
        (level("\"__import__('os').system('id')\""), "calls what is not the name of a function"),
        (level('"(lambda: level)()"'), "calls what is not the name of a function"),
        (level('"level.__class__"'), "'level.__class__' is not allowed"),
        (level('"[level for level in z]"'), "is not allowed"),
        (level('"eval(level)"'), "'eval' is not a function here"),
        (level('"level * 1j"'), "not a real number"),
        (level('"level / 0"'), "divides by 0"),
        (level('"level * (-8)**(1/3)"'), "is not a finite number"),
        (level('"lev\\u0000el"'), "is not an expression"),
        (level('"sin(level, 2)"'), "sin takes 1 argument and has 2"),
        (level('"where(level, 1, 2)"'), "where compares two numbers first"),
        (template("level").replace("A = 0", "A = nan"), "is nan; give a finite number"),
        (template("level").replace("A = 0", "A = " + "9" * 400), "a huge number"),
        (template("level") + "x0 = " + "9" * 5000, "a number of thousands of digits"),
        (template("level").replace("A = 0", "A = 2020-01-01"), "give a number, or an expression"),
        (template("level") + "".join(f"k{i} = 1\n" for i in range(6000)), "more than 5000 entries"),
        ("".join(f"k{i} = 1\n" for i in range(10**6)), "larger than 100 kB"),
        (".".join("a" * 40_000) + " = 1", "far too deep"),
        ("a = " + "[" * 40_000, "far too deep"),
        ("a = " + "{b=" * 8000, "far too deep"),
        ('a = "' + "x" * 60_000 + '"', "more than 50000 characters"),
        ("a = [[[[[[[[1]]]]]]]]", "more than 6 deep"),
        ('name = "../../x"\n' + template("level"), "'../../x' is not a name for a model"),
        (b"\xff\xfe\x00", "is not text in UTF-8"),
        ("a = ", "is not TOML: Invalid value (at end of document)"),
        ("", "parameters: is missing"),
    ],
)  # fmt: skip
def test_hostile_files(text, words, tmp_path):
    assert words in refused(text, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize("name", ["/dev/zero", ".", "nothing.toml"])
def test_what_is_no_file(name):
    with pytest.raises(ValueError, match="give a model in TOML, tuner init writes one"):
        read_model(Path(name))


@pytest.mark.parametrize(
    ("kind", "old", "new", "words"),
    [
        ("tracking", "     [0, 0]]", "     [0, 0, 0]]", "line 17, model.A, entry 2: is a row of 3"),
        ("tracking", "A = [[0, 1],", "A = [", "model.A: has the length 1; give 2 rows of 2"),
        ("tracking", "C = [1, 0]", "", "model: does not say what it shows; give one of h"),
        ("tracking", 'R = "R"', "", "model: has no R, the variance of what is measured"),
        ("tracking", 'Q = "q"', "", "model: has no Q, the spectral density of the process noise"),
        ("tracking", 'Q = "q"', 'Q = "q"\nF = 1', "model: has A and F; give one of A"),
        ("tracking", 'R = "R"', "R = 0", "has the variance 0; every measurement has some noise"),
        ("tracking", 'R = "R"', 'R = "position"', "contains position, a state; it may"),
        ("tracking", "[states]", "[stats]", "unknown entry 'stats'; did you mean states?"),
        ("level", 'R = "R" }', 'R = "dt*R", C = 1 }', "has h and C; give one of h"),
        ("robot", 'time = "continuous"', "", "say time = 'continuous' or time = 'discrete'"),
        ("robot", 'f.heading = "turn"', "", "model.f: has no heading; give an entry for each"),
        ("robot", 'method = "extended"', 'method = "kalman"', "that of x is not; take extended"),
        ("robot", 'method = "extended"', 'method = "ekf"', "unknown method 'ekf'"),
        ("robot", "P0 = {", "# {", "has no P0, the variances of the start"),
        ("robot", "start = 0.1,", "start = -0.1,", "begins at -0.1, which is not between"),
        ("robot", "[states]\nx =", "[states]\nturn =", "'turn' is an input as well"),
        ("robot", "[states]\nx =", "[states]\nlambda =", "'lambda' is not a name"),
        ("robot", "[states]\nx =", "[states]\nsin =", "'sin' has a meaning of its own"),
        ("robot", "angle = true", "angle = 1", "states.heading.angle: is 1; give true or false"),
    ],
)  # fmt: skip
def test_what_does_not_fit(kind, old, new, words, tmp_path):
    assert words in refused(changed(kind, (old, new)), tmp_path)


def test_a_discrete_model_without_dt_takes_no_varying_times():
    import jax.numpy as jnp

    from filters import Timed, TimedSample, run

    walk = model_filter(tomllib.loads(SHORT.replace("A = 0", "F = 1")))
    inputs = TimedSample(jnp.array([1.0, 2.0]), walk.inputs(jnp.zeros(2)))
    with pytest.raises(ValueError, match="for steps of one length only"):
        run(Timed(walk(1.0)), walk.params(jnp.array(1.0), jnp.array(1.0)), inputs)


@given(st.text(alphabet="xy0123456789.+-*/^()<>=,[]{}'\"_ \\sincosexpwherelambda", max_size=60))
@settings(max_examples=300, deadline=None)
def test_any_text_is_an_expression_or_is_refused(text):
    with contextlib.suppress(ExpressionError):
        parse(text)


_VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8)),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(
    st.dictionaries(
        st.sampled_from(["parameters", "states", "inputs", "measurements", "model", "method"]),
        _VALUES,
    ),
    st.dictionaries(st.sampled_from(["A", "F", "f", "h", "G", "Q", "R", "B", "P0", "x0"]), _VALUES),
)
@settings(max_examples=150, deadline=None)
def test_any_document_is_a_model_or_is_refused(document, model):
    whole = {"parameters": ["q"], "states": ["x", "y"], "measurements": ["z"], "model": model}
    for given_ in (document, whole | document):
        with contextlib.suppress(ValueError):
            model_filter(given_)
