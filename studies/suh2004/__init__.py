"""Suh, Park, Kang and Ro 2004: a two-step Kalman filter that distrusts a disturbed accelerometer.

Equation numbers are the paper's; docs/suh2004.md reports the findings.
"""

from studies.suh2004.bench import bench
from studies.suh2004.claims import CLAIMS
from studies.suh2004.figures import figures
from studies.suh2004.settings import Settings
from tuner.data.record import Record
from tuner.run.study import Plan, Study, Task
from tuner.solvers import Gradient, NelderMead


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """All three filters tuned on the same records by the same means, judged on others."""
    made = bench(settings, seed)
    posed = made.problems
    smooth = Gradient("l-bfgs-b", seed=seed, starts=settings.starts)
    simplex = NelderMead(seed=seed, starts=1, tolerance=1e-4)
    return Plan(
        source=made.source,
        tasks=(
            Task(posed["standard"], smooth),
            Task(posed["simple"], smooth),
            Task(posed["two_step"], smooth),
            Task(posed["two_step"], simplex),
        ),
        exports=("two_step",),
        case=made,
        claims=CLAIMS,
        figures=figures,
    )


STUDY = Study(
    name="suh2004",
    title="Roll and pitch under external acceleration: a two-step Kalman filter, tuned",
    paper="Y.-S. Suh, S.-K. Park, H.-J. Kang and Y.-S. Ro, Attitude Estimation Adaptively "
    "Compensating External Acceleration, received 2004",
    settings=Settings,
    plan=plan,
    takes="half a minute",
)
