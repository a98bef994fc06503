"""The one generic study: any filter that declares its facts, on a user's own recordings."""

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from filters.declared import Channel, channel_facts
from tuner.catalogue import find
from tuner.data.record import Record
from tuner.run.fit import Request, asked_for, plan_fit, pose_on
from tuner.run.front import in_order, posed_against
from tuner.run.parting import HeldOutBy
from tuner.run.searched import Wishes
from tuner.run.settings import StudySettings
from tuner.run.study import Plan, Study


class FitSettings(StudySettings):
    """What ``tuner fit`` can be told; ``tuner list filters NAME`` says what a filter knows."""

    filter: str = Field(description="name of the filter")
    start: dict[str, float] = Field({}, description="where the search begins, by parameter")
    fix: dict[str, float] = Field({}, description="parameters that are held, and at what")
    bound: dict[str, tuple[float, float]] = Field({}, description="ends of the search")
    options: dict[str, Any] = Field({}, description="fields of the filter's class")
    objective: str | None = Field(None, description="unset: the error, or without truth likelihood")
    solver: str = Field("l-bfgs-b", description="of tuner list solvers")
    starts: int = Field(4, ge=1, description="starts of each search")
    hold_out: bool = Field(True, description="whether a part of the data judges the rest")
    held_out: HeldOutBy | None = Field(None, description="which part; unset: by what there is")

    against: str | None = Field(None, description="a second objective: the front of both")

    @property
    def wishes(self) -> Wishes:
        """What the user decides of the problem."""
        objective, _ = in_order(self.objective, self.against)
        return Wishes(self.start, self.fix, self.bound, self.options, objective)


def channels(settings: FitSettings) -> Mapping[str, Channel]:
    """What ``--map`` may name: the filter's inputs."""
    return channel_facts(find("tuner.filters", settings.filter), "inputs")


def truths(settings: FitSettings) -> Mapping[str, Channel]:
    """What ``--truth`` may name: the filter's outputs that can be compared."""
    outputs = channel_facts(find("tuner.filters", settings.filter), "outputs")
    return {name: fact for name, fact in outputs.items() if fact.kind != "detail"}


def plan(settings: FitSettings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """The filter tuned on all recordings, and on a part of them to be judged on the rest."""
    if not records:
        raise ValueError("a fit needs a recording; give it as in tuner fit LOG --filter NAME")
    cls = find("tuner.filters", settings.filter)
    posed = pose_on(settings.filter, cls, records, settings.wishes)
    held_out = asked_for(settings.hold_out, settings.held_out)
    request = Request(settings.solver, settings.starts, seed, storage, held_out)
    _, against = in_order(settings.objective, settings.against)
    if against is None:
        return plan_fit(posed, request)
    other = posed_against(settings.filter, cls, posed, settings.wishes, against)
    return plan_fit(posed, request, other)


STUDY = Study(
    name="fit",
    title="Any filter, tuned on a recording of your own: tuner fit LOG --filter NAME",
    paper="none: your own recording",
    settings=FitSettings,
    plan=plan,
    channels=channels,
    truths=truths,
)
