"""A run's result: what is written to result.json, and read back from it."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from tuner.certificate.solution import Certificate, Solution, Starts, Status, TunedParameter
from tuner.data.source import Source
from tuner.files import whole
from tuner.run.comparison import Comparison
from tuner.run.finding import Finding
from tuner.run.fit_record import FitRecord, Recorded


class ParameterRecord(Recorded):
    """A tuned parameter; see :class:`tuner.certificate.solution.TunedParameter`.

    An end of an interval that is infinite is null.
    """

    value: float | list[float] | list[list[float]]
    unit: str
    interval: tuple[float | None, float | None] | None
    interval_kind: str = ""
    robust: tuple[float | None, float | None] | None = None
    deviation: list[list[float]] | None = None

    @classmethod
    def of(cls, parameter: TunedParameter) -> "ParameterRecord":
        """The record of a parameter."""
        return cls(
            value=parameter.value.tolist(),
            unit=parameter.unit,
            interval=parameter.interval,
            interval_kind=parameter.interval_kind,
            robust=parameter.robust,
            deviation=None if parameter.deviation is None else parameter.deviation.tolist(),
        )

    def parameter(self) -> TunedParameter:
        """The parameter that was recorded."""
        value = np.array(self.value)
        ends = _ends(self.interval), self.interval_kind, _ends(self.robust)
        deviation = None if self.deviation is None else np.array(self.deviation)
        return TunedParameter(value, self.unit, *ends, deviation)


def _ends(interval: tuple[float | None, float | None] | None) -> tuple[float, float] | None:
    """An interval with infinity for null."""
    if interval is None:
        return None
    low, high = interval
    return -np.inf if low is None else low, np.inf if high is None else high


class SolutionRecord(Recorded):
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
    gradient_by: str = ""

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
            parameters={name: ParameterRecord.of(p) for name, p in solution.parameters.items()},
            derived=dict(solution.derived),
            evaluations=solution.evaluations,
            seconds=solution.seconds,
            certificate=asdict(solution.certificate),
            gradient_by=solution.gradient_by,
        )

    def solution(self) -> Solution:
        """The solution that was recorded.

        Raises:
            ValueError: where the certificate is none.
        """
        try:
            return self._solution()
        except (KeyError, TypeError, AttributeError):
            raise ValueError(
                f"the certificate of {self.problem} by {self.solver} is not that of a run; run it "
                "again"
            ) from None

    def _solution(self) -> Solution:
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
            parameters={name: p.parameter() for name, p in self.parameters.items()},
            derived=_infinite(self.derived),
            evaluations=self.evaluations,
            seconds=self.seconds,
            certificate=Certificate(**{**fields, "starts": Starts(**fields["starts"])}),
            gradient_by=self.gradient_by,
        )


def _infinite(data: Any) -> Any:
    """The same with infinity for null, which is how JSON has infinite numbers."""
    if isinstance(data, dict):
        return {key: _infinite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_infinite(value) for value in data]
    return np.inf if data is None else data


class ExportRecord(Recorded):
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


class SingleRecord(Recorded):
    """A check in single precision; see :mod:`tuner.certificate.single_precision`."""

    problem: str
    form: str
    output: str
    largest: float | None
    share: float | None
    sample: int
    rms: float | None
    warning: str


class CodeRecord(Recorded):
    """A filter in C.

    Attributes:
        problem, precision: which filter, in which precision.
        file: the header, relative to the run's folder; "" where there is no code.
        forms: the forms that it has.
        operations: of the first form, a sample.
        code_bytes, stack_bytes: compiled for size on the machine that ran; null without a compiler.
        refused: why there is no code; "" where there is.
    """

    problem: str
    precision: str
    file: str
    forms: list[str]
    operations: int
    code_bytes: int | None = None
    stack_bytes: int | None = None
    refused: str = ""


class Result(Recorded):
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
    findings: list[Finding] = Field([], description="numbers that people take from the run")
    code: list[CodeRecord] = Field([], description="what is exported as C")
    identity: dict[str, str] = Field({}, description="digests of settings, data and code")
    not_drawn: list[str] = Field([], description="figures that could not be drawn, and why")

    @model_validator(mode="after")
    def _tuned_by_something(self) -> "Result":
        if self.tuned and not self.solutions:
            raise PydanticCustomError("no_solution", "tuned values, and no solution they come from")
        return self

    def to_json(self) -> str:
        """JSON text; infinite numbers become null."""
        return self.model_dump_json(by_alias=True, indent=1) + "\n"


LARGEST = 1 << 28
"""Bytes of a result.json."""


def read_result(path: Path) -> Result:
    """Read a run's result from its folder, or from result.json itself.

    Raises:
        ValueError: where there is none, or it is not one.
    """
    file = path / "result.json" if path.is_dir() else path
    try:
        return Result.model_validate_json(whole(file, LARGEST, "result of a run"))
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
