"""Gains for a linear model of the user's own: no paper, no data, a study.toml with matrices.

The same methods as for :mod:`studies.ha1981`: with a bound the fastest observer that keeps it, by
a search and by a matrix inequality; without one that of minimum variance, by the Riccati
equation, by a search and by a matrix inequality that proves it. With a settling time that of least
variance among those that settle in time. docs/design.md shows how.
"""

from studies.design.at_rate import at_rate
from studies.design.claims import claims_of
from studies.design.figures import figures
from studies.design.findings import findings
from studies.design.problems import pose
from studies.design.settings import Settings
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.run.study import Plan, Study


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Search and proof for one observer."""
    posed = pose(settings, seed)
    full, error = posed.designed.full, posed.designed.error
    numbers = (full.A, full.C, full.W, full.V, error, full.states, full.dt)
    rate_hz = 0.0 if full.dt is None else 1 / full.dt
    return Plan(
        source=Source.model("none: the model alone", numbers, rate_hz),
        tasks=posed.tasks,
        exports=(posed.problem.name,),
        case=posed,
        claims=claims_of(posed.problem.name),
        figures=figures,
        findings=findings,
    )


STUDY = Study(
    name="design",
    title="Gains for a linear model of your own, without data: least variance, or fastest decay",
    paper="none: a study.toml with A, C, Q, R",
    settings=Settings,
    plan=plan,
    needs="a study.toml with A, C, Q, R and error",
    takes="ten seconds",
    at_rate=at_rate,
)
