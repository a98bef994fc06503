"""The one generic study: any filter that declares its facts, on a user's own recordings."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import fields
from typing import Any

from pydantic import Field, field_serializer, field_validator, model_validator

from filters.declared import Channel, channel_facts, parameter_facts
from tuner.catalogue import names
from tuner.data.record import Record
from tuner.export.tuned import Tuned
from tuner.names import unknown
from tuner.problem.facts import check_facts
from tuner.run.at_rate import AtRate, filter_at_rate
from tuner.run.filter_choice import FilterChoice, choose_filter
from tuner.run.fit import Request, asked_for, plan_fit, pose_on
from tuner.run.front import in_order, posed_against
from tuner.run.gate import NAMES
from tuner.run.own_file import own_file
from tuner.run.search_space import Wishes
from tuner.run.settings import StudySettings
from tuner.run.split import HeldOutBy
from tuner.run.study import Plan, Study
from tuner.solvers import SOLVERS

INFINITE = float("inf")


class FitSettings(StudySettings):
    """The settings of ``tuner fit``; ``tuner list filters NAME`` lists a filter's facts."""

    filter: str | None = Field(None, description="name of a filter, or FILE.py:CLASS")
    filter_sha256: str | None = Field(None, description="checksum of that file")
    model: dict[str, Any] | None = Field(
        None, description="contents of a model file, in place of a filter"
    )
    start: dict[str, float] = Field({}, description="initial values of the search, by parameter")
    fix: dict[str, float] = Field({}, description="values of the parameters that are not tuned")
    bound: dict[str, tuple[float, float]] = Field(
        {}, description="ranges of the search, by parameter"
    )
    options: dict[str, Any] = Field(
        {},
        description="fields of the filter's class, and gate, patience, student, noise, stretches",
    )
    objective: str | None = Field(
        None,
        description="objective; if unset the error against the truth, without truth the likelihood",
    )
    solver: str = Field("l-bfgs-b", description="name of a solver, see tuner list solvers")
    starts: int = Field(4, ge=1, description="number of starts of each search")
    hold_out: bool = Field(True, description="whether a part of the data is held out for judging")
    held_out: HeldOutBy | None = Field(
        None,
        description="part that is held out; if unset recordings (three or more), otherwise time",
    )

    against: str | None = Field(None, description="second objective, for the front of both")

    @model_validator(mode="after")
    def _one_of_them(self) -> "FitSettings":
        if (self.filter is None) == (self.model is None):
            which = "there is none" if self.model is None else "there are both"
            raise ValueError(
                "a fit takes a filter (--filter NAME or FILE.py:CLASS) or a model (--model "
                f"FILE.toml), and {which}; give one of them"
            )
        if self.filter is not None and self.filter.endswith(".toml"):
            raise ValueError(f"{self.filter} is a model and no filter; give --model {self.filter}")
        return self

    @field_validator("model", mode="before")
    @classmethod
    def _infinite(cls, model: Any) -> Any:
        """Results are JSON, which has no infinite numbers: there they are words."""
        return _replaced(model, {"inf": INFINITE, "-inf": -INFINITE})

    @field_serializer("model")
    def _in_words(self, model: dict[str, Any] | None) -> dict[str, Any] | None:
        found: dict[str, Any] | None = _replaced(model, {INFINITE: "inf", -INFINITE: "-inf"})
        return found

    @field_serializer("filter")
    def _without_folder(self, filter: str | None) -> str | None:
        """Results and recipes are passed on, and hold no path of a machine."""
        file = None if filter is None else own_file(filter)
        return filter if file is None else file.reference

    @property
    def choice(self) -> FilterChoice:
        """The filter that is tuned."""
        if self.model is not None:
            return choose_filter(self.model)
        return choose_filter(self.filter or "", self.filter_sha256)

    @property
    def wishes(self) -> Wishes:
        """The user's choices for the problem."""
        objective, _ = in_order(self.objective, self.against)
        return Wishes(self.start, self.fix, self.bound, self.options, objective)


def _replaced(value: Any, words: Mapping[Any, Any]) -> Any:
    """A document with some of its values in other words."""
    if isinstance(value, dict):
        return {key: _replaced(each, words) for key, each in value.items()}
    if isinstance(value, list):
        return [_replaced(each, words) for each in value]
    return words.get(value, value) if isinstance(value, str | float) else value


def channels(settings: FitSettings) -> Mapping[str, Channel]:
    """The names for ``--map``: the filter's inputs."""
    return channel_facts(settings.choice.cls, "inputs")


def truths(settings: FitSettings) -> Mapping[str, Channel]:
    """The names for ``--truth``: the filter's outputs that can be compared."""
    return _compared(settings.choice.cls)


def _compared(cls: type[Any]) -> dict[str, Channel]:
    outputs = channel_facts(cls, "outputs")
    return {name: fact for name, fact in outputs.items() if fact.kind != "detail"}


def faults(settings: FitSettings, maps: Iterable[str], truths: Iterable[str]) -> Iterator[str]:
    """The names in a fit's recipe that nothing has, with the near ones."""
    solvers, objectives = SOLVERS, names("tuner.objectives")
    if settings.solver not in solvers:
        yield str(unknown("solver", settings.solver, solvers))
    for objective in (settings.objective, settings.against):
        if objective is not None and objective not in objectives:
            yield str(unknown("objective", objective, objectives))
    try:
        choice = settings.choice
        check_facts(choice.cls)
    except ValueError as error:
        yield str(error)
        return
    named = {part: list(getattr(settings, part)) for part in ("start", "fix", "bound")}
    for part, given in named.items():
        yield from _strangers(part, "parameter", given, parameter_facts(choice.cls))
    options = {each.name for each in fields(choice.cls)} - {"dt"} | {*NAMES}
    yield from _strangers("options", f"option of {choice.name}", settings.options, options)
    yield from _strangers("log.map", "channel", _mapped(maps), channels(settings))
    yield from _strangers("log.truth", "output", _mapped(truths), _compared(choice.cls))


def _strangers(
    where: str, kind: str, given: Iterable[str], known: Collection[str]
) -> Iterator[str]:
    return (f"{where}: {unknown(kind, name, known)}" for name in given if name not in known)


def _mapped(mappings: Iterable[str]) -> list[str]:
    """The names before the "=" of mappings."""
    return [name.strip() for text in mappings for name in str(text).partition("=")[0].split(",")]


def plan(settings: FitSettings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """The filter tuned on all recordings, and on a part of them to be judged on the rest."""
    if not records:
        raise ValueError("a fit needs a recording; give it as in tuner fit LOG --filter NAME")
    name, cls = settings.choice.name, settings.choice.cls
    posed = pose_on(name, cls, records, settings.wishes)
    held_out = asked_for(settings.hold_out, settings.held_out)
    request = Request(settings.solver, settings.starts, seed, storage, held_out)
    _, against = in_order(settings.objective, settings.against)
    if against is None:
        return plan_fit(posed, request)
    other = posed_against(name, cls, posed, settings.wishes, against)
    return plan_fit(posed, request, other)


def at_rate(
    settings: FitSettings, tuned: Tuned, rate_hz: float, densities: Collection[str]
) -> AtRate:
    """The filter that a fit tuned, at another rate."""
    return filter_at_rate(settings.choice, settings.options, tuned, rate_hz, densities)


STUDY = Study(
    name="fit",
    title="Any filter, tuned on a recording of your own: tuner fit LOG --filter NAME",
    paper="none: your own recording",
    settings=FitSettings,
    plan=plan,
    needs="recordings of your own: tuner fit LOG --filter NAME",
    channels=channels,
    truths=truths,
    at_rate=at_rate,
    faults=faults,
)
