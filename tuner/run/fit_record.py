"""The worth of a fit, as in result.json."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ConfigDict

from tuner.diagnostics.finding import Verdict

if TYPE_CHECKING:
    from tuner.diagnostics import Diagnostics
    from tuner.run.judgement import Judged


class Recorded(BaseModel):
    """A part of result.json: no other names, and never changed."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


Part = TypeVar("Part", bound=Recorded)


class ImprovementRecord(Recorded):
    """See :class:`tuner.run.sample_terms.Improvement`."""

    share: float | None
    low: float | None
    high: float | None
    blocks: int


class OneHeldOutRecord(Recorded):
    """See :class:`tuner.run.held_out.OneHeldOut`."""

    recording: int
    start: float | None
    tuned: float | None
    best: float | None


class HeldOutRecord(Recorded):
    """See :class:`tuner.run.held_out.HeldOut`."""

    way: str
    what: str
    start: float | None
    tuned: float | None
    gain: ImprovementRecord | None
    nothing: str
    unfiltered: float | None
    over_unfiltered: ImprovementRecord | None
    best: float | None
    gap: float | None
    recordings: list[OneHeldOutRecord]


class VarianceScalingRecord(Recorded):
    """See :class:`tuner.run.variance_scaling.VarianceScaling`."""

    factor: float
    powers: dict[str, float]
    nis: tuple[float | None, float | None]
    nees: tuple[float | None, float | None] | None
    reason: str


class TradedRecord(Recorded):
    """See :class:`tuner.run.front.Traded`."""

    first: float
    second: float
    weight: float
    knee: bool
    status: str
    parameters: dict[str, Any]


class TradeRecord(Recorded):
    """See :class:`tuner.run.front.Trade`."""

    objective: str
    unit: str
    depth: float
    points: list[TradedRecord]


class FindingRecord(Recorded):
    """See :class:`tuner.diagnostics.Finding`."""

    test: str
    what: str
    statistic: float | None
    p: float | None
    verdict: Verdict
    sentence: str
    details: dict[str, float | None]


class DiagnosticsRecord(Recorded):
    """See :class:`tuner.diagnostics.Diagnostics`."""

    nis: float | None
    low: float | None
    high: float | None
    factor: float | None
    factor_low: float | None
    factor_high: float | None
    lag_one: float | None
    numbers: int
    findings: list[FindingRecord]

    @classmethod
    def of(cls, diagnostics: "Diagnostics") -> "DiagnosticsRecord":
        """The record of what innovations say."""
        return cls.model_validate(asdict(diagnostics))


class RejectedRecord(Recorded):
    """See :class:`tuner.run.gate.Rejected`."""

    rejected: int
    outside: int
    numbers: int
    weighed: bool


class ExcludedStretchesRecord(Recorded):
    """See :class:`tuner.run.excluded_stretches.ExcludedStretches`."""

    numbers: int
    of: int
    stretches: list[tuple[int, float, float]]
    recordings: int


class FitRecord(Recorded):
    """The worth of a fit; see :class:`tuner.run.judgement.Judged`.

    Attributes:
        filter: name of the filter's class.
        objective, unit, start, tuned: the objective before and after.
        held_out: the same on data that was not used.
        diagnostics: of the innovations, before and after; empty without any.
        rescaled: what became of all variances after a fit against a truth.
        trade: the front against a second objective.
        rejected: what a gate or heavy tails left out, or weighed little.
        left_out: stretches that contradict the rest of the record.
        lines: the five lines that a run ends with.
        in_doubt: free parameters that are not determined.
    """

    filter: str
    objective: str
    unit: str
    start: float | None
    tuned: float | None
    held_out: HeldOutRecord | None
    diagnostics: list[DiagnosticsRecord]
    rescaled: VarianceScalingRecord | None = None
    trade: TradeRecord | None = None
    rejected: RejectedRecord | None = None
    left_out: ExcludedStretchesRecord | None = None
    lines: list[str]
    in_doubt: list[str] = []

    @classmethod
    def of(
        cls, judged: "Judged", filter: str, lines: list[str], in_doubt: list[str]
    ) -> "FitRecord":
        """The record of a judgement."""
        return cls(
            filter=filter,
            objective=judged.objective,
            unit=judged.unit,
            start=judged.start,
            tuned=judged.tuned,
            held_out=_record(HeldOutRecord, judged.held_out),
            diagnostics=[DiagnosticsRecord.of(each) for each in judged.diagnostics or ()],
            rescaled=_record(VarianceScalingRecord, judged.rescaled),
            trade=_record(TradeRecord, judged.trade),
            rejected=_record(RejectedRecord, judged.rejected),
            left_out=_record(ExcludedStretchesRecord, judged.left_out),
            lines=lines,
            in_doubt=in_doubt,
        )


def _record(cls: type[Part], part: Any) -> Part | None:
    """The record of a dataclass; None where there is none."""
    return None if part is None else cls.model_validate(asdict(part))
