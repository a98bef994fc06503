"""A small sample of the generator of bad input; ``python -m benchmarks.bad_inputs`` tries 5000."""

from itertools import islice

import numpy as np
import pytest

from benchmarks.bad_inputs import documents, hostile, lines, logs
from benchmarks.bad_inputs.judge import REFUSED, Ended, _seen
from benchmarks.bad_inputs.mutate import bytes_of, document_of
from tuner.cli import invoke

KINDS = {"logs": logs.cases, "lines": lines.cases, "documents": documents.cases}
COUNT = 8


def not_files(random):
    """What is no file, without the bombs before."""
    return (case for case in hostile.cases(random) if case.kind.startswith("no file"))


@pytest.mark.parametrize("kind", [*KINDS, "no files"])
def test_a_sample(kind, tmp_path, monkeypatch, capfd):
    made = KINDS.get(kind, not_files)
    monkeypatch.setattr(hostile, "files", lambda: iter(()))
    for number, case in enumerate(islice(made(np.random.default_rng(5)), COUNT)):
        folder = tmp_path / str(number)
        folder.mkdir()
        monkeypatch.chdir(folder)
        case.lay(folder)
        before = _seen(folder)
        capfd.readouterr()
        code = invoke(list(case.words))
        out, err = capfd.readouterr()
        left = tuple(name for name, at in _seen(folder).items() if at != before.get(name))
        assert Ended(code, out, err, 0.0, 0, left).faults == [], (case.words, err)


def test_what_is_wrong_is_found():
    good = Ended(REFUSED, "", "tuner: no\n", 0.1, 1 << 20, ())
    assert good.faults == []
    bad = Ended(-11, "\x1b[2J", "Traceback (most recent call last):\n", 21.0, 2 << 30, ("x",))
    assert bad.faults == ["traceback", "signal 11", "hang", "peak", "control characters"]
    assert Ended(REFUSED, "", "", 0.1, 0, ("x",)).faults == ["files left", "no sentence"]


def test_the_same_seed_makes_the_same_cases():
    first, second = (
        [c.files for c in islice(logs.cases(np.random.default_rng(3)), 5)] for _ in range(2)
    )
    assert first == second
    rng = np.random.default_rng(0)
    assert any(bytes_of(rng, b"0123456789") != b"0123456789" for _ in range(5))
    document = {"a": [1, {"b": 2}]}
    assert any(document_of(rng, document) != document for _ in range(5))
    assert document == {"a": [1, {"b": 2}]}
