"""A run's result: what is written to result.json, and read back from it."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tuner.certificate.solution import Certificate, Solution, Starts, Status, TunedParameter
from tuner.data.source import Source
from tuner.run.comparison import Comparison

if TYPE_CHECKING:
    from tuner.run.judged import Judged


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class ParameterRecord(_Record):
    """A tuned parameter; see :class:`tuner.certificate.solution.TunedParameter`."""

    value: float | list[float] | list[list[float]]
    unit: str
    interval: tuple[float, float] | None


class SolutionRecord(_Record):
    """A solution; see :class:`tuner.certificate.solution.Solution`. Infinite numbers are null."""

    problem: str
    solver: str
    status: Status
    message: str
    value: float | None
    z: list[float]
    parameters: dict[str, ParameterRecord]
    derived: dict[str, float | None]
    evaluations: int
    seconds: float
    certificate: dict[str, Any]

    @classmethod
    def of(cls, solution: Solution) -> "SolutionRecord":
        """The record of a solution."""
        return cls(
            problem=solution.problem,
            solver=solution.solver,
            status=solution.status,
            message=solution.message,
            value=solution.value,
            z=solution.z.tolist(),
            parameters={
                name: ParameterRecord(value=p.value.tolist(), unit=p.unit, interval=p.interval)
                for name, p in solution.parameters.items()
            },
            derived=dict(solution.derived),
            evaluations=solution.evaluations,
            seconds=solution.seconds,
            certificate=asdict(solution.certificate),
        )

    def solution(self) -> Solution:
        """The solution that was recorded."""
        fields = _infinite(self.certificate)
        for name in ("active_bounds", "curvatures", "flat_directions"):
            fields[name] = tuple(fields[name])
        fields["lower_bound"] = self.certificate.get("lower_bound")  # null: nothing is proved
        return Solution(
            problem=self.problem,
            solver=self.solver,
            status=self.status,
            message=self.message,
            value=_infinite(self.value),
            z=np.array(self.z),
            parameters={
                name: TunedParameter(np.array(p.value), p.unit, p.interval)
                for name, p in self.parameters.items()
            },
            derived=_infinite(self.derived),
            evaluations=self.evaluations,
            seconds=self.seconds,
            certificate=Certificate(**{**fields, "starts": Starts(**fields["starts"])}),
        )


def _infinite(data: Any) -> Any:
    """The same with infinity for null, which is how JSON has infinite numbers."""
    if isinstance(data, dict):
        return {key: _infinite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_infinite(value) for value in data]
    return np.inf if data is None else data


class ExportRecord(_Record):
    """An exported file, read back.

    Attributes:
        problem, format, file: what was written where, relative to the run's folder.
        score: the objective with the parameters that were read back.
        relative_change: its distance from the solution's value, over that value.
    """

    problem: str
    format: str
    file: str
    score: float | None
    relative_change: float | None


class SingleRecord(_Record):
    """A check in single precision; see :mod:`tuner.certificate.single_precision`."""

    problem: str
    form: str
    output: str
    largest: float | None
    share: float | None
    sample: int
    rms: float | None
    warning: str


class GainRecord(_Record):
    """See :class:`tuner.run.amounts.Gain`."""

    share: float | None
    low: float | None
    high: float | None
    blocks: int


class OneHeldOutRecord(_Record):
    """See :class:`tuner.run.held_out.OneHeldOut`."""

    recording: int
    start: float | None
    tuned: float | None
    best: float | None


class HeldOutRecord(_Record):
    """See :class:`tuner.run.held_out.HeldOut`."""

    way: str
    what: str
    start: float | None
    tuned: float | None
    gain: GainRecord | None
    nothing: str
    unfiltered: float | None
    over_unfiltered: GainRecord | None
    best: float | None
    gap: float | None
    recordings: list[OneHeldOutRecord]


class RescaledRecord(_Record):
    """See :class:`tuner.run.rescaled.Rescaled`."""

    factor: float
    powers: dict[str, float]
    nis: tuple[float | None, float | None]
    nees: tuple[float | None, float | None] | None
    reason: str


class ConsistencyRecord(_Record):
    """See :class:`tuner.run.judged.Consistency`."""

    nis: float | None
    low: float
    high: float
    lag_one: float | None
    numbers: int


class FitRecord(_Record):
    """What a fit is worth; see :class:`tuner.run.judged.Judged`.

    Attributes:
        filter: name of the filter's class.
        objective, unit, start, tuned: the objective before and after.
        held_out: the same on data that was not used.
        consistency: of the innovations, before and after; empty without a variance.
        rescaled: what became of all variances after a fit against a truth.
        lines: the five lines that a run ends with.
    """

    filter: str
    objective: str
    unit: str
    start: float | None
    tuned: float | None
    held_out: HeldOutRecord | None
    consistency: list[ConsistencyRecord]
    rescaled: RescaledRecord | None = None
    lines: list[str]

    @classmethod
    def of(cls, judged: "Judged", filter: str, lines: list[str]) -> "FitRecord":
        """The record of a judgement."""
        held = judged.held_out
        return cls(
            filter=filter,
            objective=judged.objective,
            unit=judged.unit,
            start=judged.start,
            tuned=judged.tuned,
            held_out=None if held is None else HeldOutRecord.model_validate(asdict(held)),
            consistency=[ConsistencyRecord(**asdict(each)) for each in judged.consistency or ()],
            rescaled=(
                RescaledRecord.model_validate(asdict(judged.rescaled)) if judged.rescaled else None
            ),
            lines=lines,
        )


class Result(_Record):
    """Everything a run found; ``result.json``."""

    schema_: Literal["tuner.result/1"] = Field(alias="schema")
    study: str
    seed: int
    log: Source
    settings: dict[str, Any]
    solutions: list[SolutionRecord]
    comparisons: list[Comparison]
    exports: list[ExportRecord]
    single_precision: list[SingleRecord]
    tuned: list[dict[str, Any]] = Field(description="what is exported, as JSON exports have it")
    artifacts: list[str]
    seconds: float
    fit: FitRecord | None = Field(None, description="of a fit: what it is worth")

    def to_json(self) -> str:
        """JSON text; infinite numbers become null."""
        return self.model_dump_json(by_alias=True, indent=1) + "\n"


def read_result(path: Path) -> Result:
    """Read a run's result from its folder, or from result.json itself.

    Raises:
        ValueError: where there is none, or it is not one.
    """
    file = path / "result.json" if path.is_dir() else path
    try:
        return Result.model_validate_json(file.read_bytes())
    except FileNotFoundError:
        raise ValueError(
            f"{path} holds no result.json; give the folder of a finished run"
        ) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise ValueError(f"{file.name} is no result of a run: {where}: {first['msg']}") from None
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None


def pretty(data: Any) -> bytes:
    """JSON with line breaks, as bytes."""
    return (json.dumps(data, indent=1, ensure_ascii=False) + "\n").encode()
