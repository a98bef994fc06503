"""BROAD: inclination of a moving inertial sensor, on real recordings with optical truth.

The benchmark is that of Laidig, Caruso, Cereatti and Seel, Data 6(7):72, 2021; its files stay where
the user has them. docs/broad.md reports the findings.
"""

from studies.broad.claims import claims_of
from studies.broad.figures import figures
from studies.broad.problems import case_of, tasks
from studies.broad.settings import Settings
from tuner.data.record import Record
from tuner.run.study import Plan, Study


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Every filter tuned on all trials, the room filter also with each trial left out in turn."""
    case = case_of(settings)
    return Plan(
        source=case.contest.source,
        tasks=tasks(case, seed),
        exports=("room",),
        case=case,
        claims=claims_of(case),
        figures=figures,
    )


STUDY = Study(
    name="broad",
    title="Inclination of a moving inertial sensor, on the BROAD recordings",
    paper="D. Laidig, M. Caruso, A. Cereatti and T. Seel, BROAD - A Benchmark for Robust Inertial "
    "Orientation Estimation, Data 6(7):72, 2021",
    settings=Settings,
    plan=plan,
    needs="the folder of the benchmark's .mat files: --set folder=PATH",
    takes="ten minutes for twelve trials",
)
