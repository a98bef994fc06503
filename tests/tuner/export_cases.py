"""Tuned filters to export: one of every sort of number and text, and hypothesis's."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tuner.export import Provenance, Quantity, Tuned

NASTY = (
    "",
    " ",
    "\0",
    "*/ #error out /*",
    "/*/",
    "??/",
    "????/\n#error trigraph",
    "\\",
    "line\r\nbreak\rand\u2028and\x85",
    "\"quoted\", 'twice'",
    "# a: comment",
    "{{ 7 * 7 }} {% raw %}",
    "${HOME} %s {0}",
    "__import__('os')",
    "(°/s)²",
    "\N{ROCKET}\ufeff\u202e",
    "nan",
    "-1",
    '"""',
    "'''",
)
EDGES = (0.0, -0.0, 5e-324, -5e-324, 1e308, -1.7976931348623157e308, 0.1, 1 / 3, 2.0**53, 1e-45)


def provenance(**changed):
    fields = {
        "study": "demo",
        "problem": "step",
        "solver": "grid",
        "status": "optimal",
        "seed": 7,
        "log_name": "flight.csv",
        "log_sha256": "0f" * 32,
        "versions": (("filter-tuner", "0.1.0"), ("jax", "0.10.2")),
    }
    return Provenance(**fields | changed)


def tuned(*quantities, **changed):
    fields = {
        "name": "gyro",
        "filter": "GyroscopeFilter",
        "quantities": quantities or (Quantity("R", np.array(1.9148e-10), "(rad/s)^2"),),
        "convention": "discrete",
        "dt": 1e-4,
        "states": ("omega", "epsilon"),
        "provenance": provenance(),
    }
    return Tuned(**fields | changed)


def nasty():
    """Every nasty text in every place for text, every edge in every shape."""
    edges = [Quantity(f"e{i}", np.array(x), NASTY[i], NASTY[-i]) for i, x in enumerate(EDGES)]
    return tuned(
        *edges,
        Quantity("row", np.array([EDGES]), "*/"),
        Quantity("column", np.array(EDGES)[:, None], "/*"),
        Quantity("vector", np.array(EDGES), "", "/*/"),
        Quantity("one", np.array([1.0]), ""),
        Quantity("one_by_one", np.array([[-1.0]]), ""),
        Quantity("P0", np.array([[1.0, -2.5], [3.25, 1e-30]]), "(rad/s)^2"),
        filter="\n".join(NASTY),
        provenance=provenance(
            study=NASTY[3],
            problem=NASTY[6],
            seed=-(2**63) + 1,
            log_name="".join(NASTY),
            versions=tuple((text, text) for text in NASTY),
        ),
    )


def gyroscope(**changed):
    """The gyroscope filter of the paper, with its fixed gains."""
    return tuned(
        Quantity("R", np.array(1.9148e-10), "(rad/s)^2", "Variance of the measurement noise."),
        Quantity("Q", np.array(1.9674e-7), "(rad/s^2)^2", "Variance of the process noise."),
        Quantity("P0", np.array([[0.5, 0.25], [0.25, 2.0]]), "", "Covariance of the start."),
        Quantity("K1", np.array(0.0032984), ""),
        Quantity("K2", np.array(0.0032), "1/s"),
        **changed,
    )


def texts():
    return st.sampled_from(NASTY) | st.text(st.characters(exclude_categories=["Cs"]), max_size=20)


def names(longest=25):
    return st.from_regex(rf"[A-Za-z](_?[A-Za-z0-9]){{0,{longest // 2}}}", fullmatch=True)


@st.composite
def quantities(draw):
    shape = draw(st.sampled_from([(), (1,), (3,), (1, 1), (1, 3), (3, 1), (2, 3)]))
    numbers = st.floats(allow_nan=False, allow_infinity=False) | st.sampled_from(EDGES)
    name = draw(names().filter(_allowed))
    return Quantity(name, draw(arrays(np.float64, shape, elements=numbers)), draw(texts()), "")


@st.composite
def tuned_filters(draw):
    numbers = st.lists(quantities(), min_size=1, max_size=4, unique_by=lambda q: q.name.lower())
    pairs = st.lists(st.tuples(texts(), texts()), max_size=3, unique_by=lambda pair: pair[0])
    convention = draw(st.sampled_from(["discrete", "continuous"]))
    return tuned(
        *draw(numbers),
        name=draw(names(31)),
        filter=draw(texts()),
        convention=convention,
        # A continuous model has no sample time.
        dt=draw(st.floats(0, 1e308, exclude_min=convention == "discrete")),
        states=tuple(draw(st.lists(names(), max_size=3, unique_by=str.lower))),
        provenance=provenance(
            study=draw(texts()),
            log_name=draw(texts()),
            seed=draw(st.integers(1 - 2**63, 2**63 - 1)),
            versions=tuple(draw(pairs)),
        ),
    )


def _allowed(name):
    try:
        Quantity(name, np.array(0.0), "")
    except ValueError:
        return False
    return True
