"""Chauhan, Patil, Sinha and Halder 2009: a process noise that follows the filter's own residuals.

Equation numbers are the paper's; docs/chauhan2009.md reports the findings.
"""

from studies.chauhan2009.claims import CLAIMS
from studies.chauhan2009.figures import figures
from studies.chauhan2009.settings import Settings
from studies.chauhan2009.sweep import Sweep
from tuner.data.record import Record
from tuner.run.study import Plan, Study, Task
from tuner.solvers import NelderMead


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Every law tuned on the same steps by the same means, judged on others; and the sweep."""
    sweep = Sweep(settings, seed)
    # The fuzzy law takes the largest of many lines, so its cost has kinks.
    simplex = NelderMead(seed=seed, starts=settings.starts, tolerance=1e-3)
    return Plan(
        source=sweep.tuned_on.source,
        tasks=tuple(Task(problem, simplex) for problem in sweep.posed.values()),
        exports=("constant", f"fuzzy_{settings.windows[-1]}"),
        case=sweep,
        claims=CLAIMS,
        figures=figures,
    )


STUDY = Study(
    name="chauhan2009",
    title="Attitude from gyroscopes and GPS with a fuzzy process noise, against tuned constants",
    paper="S. Chauhan, C. Patil, M. Sinha and A. Halder, Fuzzy state noise-driven Kalman filter "
    "for sensor fusion, Proc. IMechE Part G: J. Aerospace Engineering 223, 2009",
    settings=Settings,
    plan=plan,
    takes="a minute",
)
