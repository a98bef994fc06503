"""UAV: an attitude filter aided by GPS positions, on real flights without any truth.

The filter is that of Chauhan, Patil, Sinha and Halder 2009; the flights' files stay where the user
has them. docs/uav.md tells what was found.
"""

from studies.uav import problems
from studies.uav.claims import CLAIMS
from studies.uav.figures import figures
from studies.uav.flights import flown
from studies.uav.judging import Field
from studies.uav.settings import Settings
from tuner.data.record import Record
from tuner.run.study import Plan, Study, Task
from tuner.solvers import Gradient

ENOUGH = 1e-4
"""Slope of ln deviation at which a search may end: a tenth of a factor e more changes nothing."""
STARTS = 2
"""Of each search: with the fuzzy law the likelihood has kinks, where one search may end."""


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Both laws tuned on one flight by the same means, judged on the others."""
    tuned, *judged = flown(settings)
    field = Field(tuned, tuple(judged), settings.angles)
    posed = [problems.problem(tuned, law, settings.angles) for law in problems.LAWS]
    solver = Gradient("l-bfgs-b", seed=seed, starts=STARTS, gradient=ENOUGH, iterations=40)
    return Plan(
        source=field.source,
        tasks=tuple(Task(problem, solver) for problem in posed),
        exports=problems.LAWS,
        case=field,
        claims=CLAIMS,
        figures=figures,
    )


STUDY = Study(
    name="uav",
    title="Attitude from gyroscopes and GPS positions, on real flights",
    paper="S. Chauhan, C. Patil, M. Sinha and A. Halder, Fuzzy state noise-driven Kalman filter "
    "for sensor fusion, Proc. IMechE Part G: J. Aerospace Engineering 223, 2009",
    settings=Settings,
    plan=plan,
)
