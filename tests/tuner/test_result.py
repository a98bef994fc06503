"""result.json: written, read back, and told from what is none."""

import json
import math
import re
from dataclasses import asdict, replace

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from tests.tuner.helpers import bowl, hollow, problem
from tuner.certificate.solution import Certificate, Solution, Starts, Status, TunedParameter
from tuner.data.source import Source
from tuner.run.comparison import Comparison, Verdict
from tuner.run.result import (
    ExportRecord,
    Result,
    SingleRecord,
    SolutionRecord,
    pretty,
    read_result,
)

SOLUTION = Solution(
    problem="gyro",
    solver="nelder-mead",
    status=Status.AT_BOUND,
    message="a bound",
    value=1 / 3,
    z=np.array([0.1, -2e-300]),
    parameters={
        "R": TunedParameter(np.array(1e-6), "(rad/s)^2", (1e-7, 1e-5)),
        "P0": TunedParameter(np.array([[1.0, 0.5], [0.5, 2.0]]), "", None),
        "v": TunedParameter(np.array([1.0, 2.0]), "", None),
    },
    derived={"q_over_r": 1027.47},
    evaluations=12,
    seconds=0.25,
    certificate=Certificate(
        {"ln R": -1e-9, "ln Q": 0.2},
        ("ln Q",),
        (0.0, 0.4),
        ("only Q/R is determined",),
        Starts(4, 3, 1.5),
        {"l-bfgs-b": 1.01},
    ),
)


def same(one, other):
    """Equal in every field, arrays included."""
    plain = [json.loads(SolutionRecord.of(s).model_dump_json()) for s in (one, other)]
    assert plain[0] == plain[1]
    assert one.z.tobytes() == other.z.tobytes()
    for name, parameter in one.parameters.items():
        assert parameter.value.shape == other.parameters[name].value.shape
        assert parameter.value.tobytes() == other.parameters[name].value.tobytes()
        assert parameter.interval == other.parameters[name].interval
    assert one.certificate == other.certificate
    assert (one.value, one.derived, one.status) == (other.value, other.derived, other.status)


def through_json(solution):
    text = SolutionRecord.of(solution).model_dump_json()
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    return SolutionRecord.model_validate_json(text).solution()


def test_solution_round_trip():
    same(through_json(SOLUTION), SOLUTION)


def test_infinite_numbers_are_null_and_come_back():
    infinite = replace(
        SOLUTION,
        value=math.inf,
        derived={"bandwidth_hz": math.inf},
        certificate=replace(
            SOLUTION.certificate,
            gradient={"ln R": math.inf},
            curvatures=(math.inf, 1.0),
            starts=Starts(4, 1, math.inf),
            methods={"tpe": math.inf},
        ),
    )
    plain = json.loads(SolutionRecord.of(infinite).model_dump_json())
    assert plain["value"] is plain["derived"]["bandwidth_hz"] is None
    assert plain["certificate"]["starts"]["worst"] is None
    same(through_json(infinite), infinite)


def test_failed_solutions_can_be_written_and_read():
    from tuner.solvers import Gradient

    failed = Gradient("l-bfgs-b", seed=0, starts=2)(problem(hollow))
    back = through_json(failed)
    assert back.status is Status.FAILED
    assert back.value == math.inf


def test_solved_problems_come_back_to_the_bit():
    from tuner.solvers import Gradient

    solution = Gradient("l-bfgs-b", seed=0, starts=2)(problem(bowl))
    same(through_json(solution), solution)


def row(**changed):
    fields = {
        "quantity": "gyro.q_over_r",
        "where": "Table 2",
        "paper": 1027.47,
        "ours": 1012.5,
        "unit": "1/s^2",
        "tolerance": 0.05,
        "verdict": Verdict.MATCH,
        "note": "",
    }
    return Comparison(**fields | changed)


def result(**changed):
    fields = {
        "schema": "tuner.result/1",
        "study": "kownacki2010",
        "seed": 3,
        "log": Source(name="log.csv", sha256="0f" * 32, samples=100, rate_hz=100.0),
        "settings": {"step": 0.2, "R": None, "solvers": ["tpe"]},
        "solutions": [SolutionRecord.of(SOLUTION)],
        "comparisons": [row()],
        "exports": [
            ExportRecord(problem="gyro", format="c", file="g.h", score=1.0, relative_change=0.0)
        ],
        "single_precision": [
            SingleRecord(
                problem="gyro",
                form="f",
                output="rate",
                largest=1.0,
                share=2.0,
                sample=3,
                rms=4.0,
                warning="w",
            )
        ],
        "tuned": [{"name": "gyro"}],
        "artifacts": ["study.toml"],
        "seconds": 1.5,
    }
    return Result(**fields | changed)


def test_result_round_trip(tmp_path):
    (tmp_path / "result.json").write_text(result().to_json())
    for path in (tmp_path, tmp_path / "result.json"):
        assert read_result(path).to_json() == result().to_json()
        assert read_result(path).solutions[0].status is Status.AT_BOUND
    assert result().to_json().endswith("}\n")


def test_first_entries_are_the_fixed_ones():
    plain = json.loads(result().to_json())
    assert list(plain)[:4] == ["schema", "study", "seed", "log"]
    assert plain["schema"] == "tuner.result/1"
    assert set(plain["log"]) == {"name", "sha256", "samples", "rate_hz"}
    fixed = {"problem", "solver", "status", "value", "parameters", "derived", "evaluations"}
    assert fixed | {"seconds", "certificate"} <= set(plain["solutions"][0])
    assert plain["solutions"][0]["status"] == "at bound"
    assert plain["solutions"][0]["parameters"]["R"] == {
        "value": 1e-6,
        "unit": "(rad/s)^2",
        "interval": [1e-7, 1e-5],
        "interval_kind": "",
        "robust": None,
        "deviation": None,
    }
    assert plain["comparisons"][0] == {**asdict(row()), "verdict": "match"}
    assert {"solutions", "comparisons", "artifacts"} <= set(plain)


def test_infinite_rows_scores_and_checks_can_be_read_back(tmp_path):
    written = result(
        comparisons=[row(ours=math.inf, verdict=Verdict.DIFFERS)],
        exports=[
            ExportRecord(
                problem="g", format="c", file="g.h", score=math.inf, relative_change=math.nan
            )
        ],
        single_precision=[
            SingleRecord(
                problem="g",
                form="f",
                output="",
                largest=math.inf,
                share=math.inf,
                sample=0,
                rms=math.inf,
                warning="",
            )
        ],
    )
    (tmp_path / "result.json").write_text(written.to_json())
    json.loads(written.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    found = read_result(tmp_path)
    assert found.comparisons[0] == row(ours=None, verdict=Verdict.DIFFERS)
    assert found.exports[0].score is None
    assert found.single_precision[0].largest is None


@pytest.mark.parametrize("verdict", Verdict)
def test_rows_come_back(verdict):
    one = row(verdict=verdict, paper=None, tolerance=None)
    kept = TypeAdapter(Comparison)
    assert kept.validate_json(kept.dump_json(one)) == one


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("", "the file: Invalid JSON"),
        ("{", "the file: Invalid JSON"),
        ("[]", "the file: Input should be an object"),
        ("{}", "schema: Field required"),
        ('{"schema": "tuner.result/2"}', "schema: Input should be 'tuner.result/1'"),
        ('{"schema": "other", "points": [1]}', "schema: Input should be 'tuner.result/1'"),
        ("\0\1\2", "the file: Invalid JSON"),
    ],
)
def test_foreign_files_are_refused_in_one_sentence(tmp_path, text, where):
    file = tmp_path / "result.json"
    file.write_text(text)
    pattern = f"^{re.escape(f'result.json is no result of a run: {where}')}"
    for path in (tmp_path, file):
        with pytest.raises(ValueError, match=pattern) as raised:
            read_result(path)
        assert "\n" not in str(raised.value)
        assert str(tmp_path) not in str(raised.value)


def test_unknown_entries_are_refused(tmp_path):
    plain = json.loads(result().to_json())
    (tmp_path / "result.json").write_text(json.dumps(plain | {"extra": 1}))
    with pytest.raises(ValueError, match=r"is no result of a run: extra: Extra inputs"):
        read_result(tmp_path)
    with pytest.raises(ValidationError):
        result(schema="tuner.result/2")


def test_tuned_values_without_a_solution_are_refused(tmp_path):
    plain = json.loads(result().to_json())
    changed = plain | {"tuned": [{"name": "gyro"}], "solutions": []}
    (tmp_path / "result.json").write_text(json.dumps(changed))
    with pytest.raises(ValueError, match=r"the file: tuned values, and no solution they come from"):
        read_result(tmp_path)


def test_no_result(tmp_path):
    for path in (tmp_path, tmp_path / "nowhere"):
        sentence = f"{path} holds no result.json; give the folder of a finished run"
        with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
            read_result(path)


def test_a_result_that_cannot_be_read(tmp_path):
    (tmp_path / "result.json").mkdir()
    with pytest.raises(ValueError, match="is a folder, not a file"):
        read_result(tmp_path)


def test_pretty():
    assert pretty({"ω": [1]}) == '{\n "ω": [\n  1\n ]\n}\n'.encode()
