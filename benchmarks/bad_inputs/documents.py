"""TOML that is almost a study or a model."""

from collections.abc import Iterator
from typing import Any

import tomli_w

from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.logs import text
from benchmarks.bad_inputs.mutate import Random, bytes_of, document_of
from tuner.model.template import KINDS, template

STUDIES: tuple[dict[str, Any], ...] = (
    {
        "study": "kownacki2010", "seed": 3,
        "settings": {"R": 1e-3, "seconds": 0.05, "starts": 2, "solvers": ["nelder-mead"]},
        "log": {"files": ["good.csv"], "map": ["omega=gx"], "rate_hz": 100.0},
    },
    {
        "study": "design",
        "settings": {
            "A": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "C": [[0, 0, 1]], "G": [[1, 0], [0, 1], [0, 0]],
            "Q": [[1e-6, 0], [0, 0.04]], "R": [[3.0]], "sample_time": 1.0, "error": [1.0, 0, 0],
        },
    },
    {
        "study": "fit",
        "settings": {
            "filter": "local-level", "start": {"q": 1.0}, "bound": {"R": [0.1, 10.0]}, "starts": 2,
        },
        "log": {"files": ["good.csv"], "map": ["z=gx"], "time": "t"},
    },
)  # fmt: skip
NESTS = (
    'study = "design"\n[settings]\nA = ' + "[" * 2000 + "]" * 2000,
    'study = "design"\n' + "[" + ".".join("a" * 3000) + "]\nx = 1",
    ".".join("a" * 5000) + " = 1",
    "a = " + "{b = " * 900 + "1" + "}" * 900,
    "a = " + "9" * 6000,
    'a = """' + '"' * 5000,
    "a = '" + "[" * 5000 + "'",
)


def cases(random: Random) -> Iterator[Case]:
    """An endless series of study files and model files."""
    log = {"good.csv": text()}
    for nest in NESTS:
        yield Case("toml: nest", ["run", "x.toml"], {"x.toml": nest.encode(), **log})
        yield Case("model: nest", _model("x.toml"), {"x.toml": nest.encode(), **log})
    while True:
        chance = random.random()
        if chance < 0.05:  # these are solved, which takes seconds
            yield Case("toml: run", ["run", "x.toml"], {"x.toml": _bad(random, STUDIES[1]), **log})
        elif chance < 0.6:
            study = STUDIES[int(random.integers(len(STUDIES)))]
            files = {"x.toml": _bad(random, study), **log}
            yield Case("toml: study", ["run", "x.toml", "--dry-run"], files)
        else:
            kind = KINDS[int(random.integers(len(KINDS)))]
            data = _bad_text(random, template(kind))
            yield Case("toml: model", _model("x.toml"), {"x.toml": data, **log})


def _model(name: str) -> list[str]:
    return ["fit", "good.csv", "--model", name, "--map", "z=gx", "--rate", "100", "--dry-run"]


def _bad(random: Random, document: dict[str, Any]) -> bytes:
    """A changed document, as TOML where TOML can express it."""
    try:
        data = tomli_w.dumps(document_of(random, document)).encode()
    except (TypeError, ValueError, AttributeError):
        data = tomli_w.dumps(document).encode()
    return data if random.random() < 0.6 else bytes_of(random, data)


def _bad_text(random: Random, whole: str) -> bytes:
    """A text with lines missing, doubled or exchanged, or with changed bytes."""
    lines = whole.splitlines(keepends=True)
    at, other = (int(k) for k in random.integers(0, len(lines), 2))
    kind = int(random.integers(4))
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 2:
        lines[at] = lines[at].partition("=")[0] + "= " + str(random.choice(_VALUES)) + "\n"
    data = "".join(lines).encode()
    return bytes_of(random, data) if kind == 3 else data


_VALUES = (
    "nan", "-inf", "1e999", "[]", '"q*"', '"q**q**q**99999"', '"1/0"', "{}", "0x" + "f" * 500,
    '"' + "(" * 300 + '"', '"exp(exp(exp(exp(9))))"', '"x0"', "-1", "true",
)  # fmt: skip
