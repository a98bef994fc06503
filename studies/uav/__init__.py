"""UAV: an attitude filter aided by GPS positions, on real flights without any truth.

The filter is that of Chauhan, Patil, Sinha and Halder 2009; the flights' files stay where the user
has them. docs/uav.md reports the findings.
"""

from collections.abc import Iterator
from dataclasses import replace

from studies.uav import problems
from studies.uav.claims import CLAIMS
from studies.uav.figures import figures
from studies.uav.flights import flown
from studies.uav.held_out import claims_held_out
from studies.uav.joint import joint
from studies.uav.judging import Field
from studies.uav.problems import alone_name, fold_name
from studies.uav.settings import Settings
from studies.uav.six_axes import CLAIM as SIX_AXES
from tuner.data.record import Record
from tuner.problem.problem import Problem
from tuner.run.study import Plan, Study, Task
from tuner.solvers import Gradient

ENOUGH = 1e-4
"""Slope of ln deviation at which a search may end: a tenth of a factor e more changes nothing."""
STILL = 1e-6
"""The same for searches without second derivatives, where all slopes have to be small."""
STARTS = 8
"""Of each law's search: where a likelihood jumps, rounding decides where two would end."""
STARTS_THAT_JUDGE = 2
"""Of the other searches."""


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Both laws tuned on one flight by the same means, judged on the others."""
    field = _field(settings)
    tuned = field.tuned
    posed = [problems.problem(tuned, law, settings.angles) for law in problems.LAWS]
    solver = Gradient("l-bfgs-b", seed=seed, starts=STARTS, gradient=ENOUGH, iterations=40)
    # Problems that only judge need no interval; without one the slope itself has to be small.
    few = STARTS_THAT_JUDGE
    quick = replace(solver, starts=few, gradient=STILL, iterations=60, curvature=False)
    return Plan(
        source=field.source,
        tasks=(
            *(Task(problem, solver) for problem in posed),
            *(Task(problem, quick) for problem in _left_out(field)),
        ),
        exports=problems.LAWS,
        case=field,
        claims=(*CLAIMS, *claims_held_out(field), SIX_AXES),
        figures=figures,
    )


def _field(settings: Settings) -> Field:
    """The flights, with those that are left out in turn.

    Raises:
        ValueError: where leaving out is asked for and leaves nothing to tune on.
    """
    tuned, *judged = flown(settings)
    field = Field(tuned, tuple(judged), settings.angles)
    if settings.left_out == "never":
        return field
    possible = tuple(flight for flight in field.flights if field.others(flight))
    if settings.left_out == "always" and not possible:
        raise ValueError(
            f"left_out needs another flight without a glitch beside {tuned.name}, and none is "
            "judged on; name one, --set judged=NAME, or do without, --set left_out=never"
        )
    return replace(field, left_out=possible)


def _left_out(field: Field) -> Iterator[Problem]:
    """The constant law without each flight in turn, and on each alone: its own optimum."""
    folds = {flight.name: field.others(flight) for flight in field.left_out}
    longest = max((sum(len(one.t) for one in others) for others in folds.values()), default=0)
    for name, others in folds.items():
        yield joint(fold_name(name), others, "constant", field.measured, longest)
    for flight in field.left_out:
        if flight is not field.tuned:
            yield joint(alone_name(flight.name), [flight], "constant", field.measured)


STUDY = Study(
    name="uav",
    title="Attitude from gyroscopes and GPS positions, on real flights",
    paper="S. Chauhan, C. Patil, M. Sinha and A. Halder, Fuzzy state noise-driven Kalman filter "
    "for sensor fusion, Proc. IMechE Part G: J. Aerospace Engineering 223, 2009",
    settings=Settings,
    plan=plan,
    needs="the folder of the flights' zips: --set folder=PATH",
    takes="a quarter of an hour",
)
