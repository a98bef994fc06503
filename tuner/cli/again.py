"""The plan of a run that was finished earlier, from its folder."""

from dataclasses import replace
from pathlib import Path

from tuner.cli.run import Request, from_toml, load_log
from tuner.cli.settings import parse_settings
from tuner.run.study import Plan, find_study

_BLANK = Request(
    study="",
    log=None,
    maps=(),
    rate=None,
    time=None,
    sets=(),
    out=None,
    seed=None,
    storage=None,
    jobs=1,
    resume=False,
    dry_run=False,
    force=False,
    json=False,
)


def plan_again(folder: Path, log: Path | None) -> Plan:
    """The same problems on the same data.

    Raises:
        ValueError: where the study.toml or the log is missing, or the log is another one.
    """
    request, base = from_toml(replace(_BLANK, study=str(folder / "study.toml"), log=log))
    study = find_study(request.study)
    settings = parse_settings(study.settings, (), base)
    plan = study.plan(settings, load_log(study, request), request.seed or 0, "")
    from tuner.run.result import read_result

    recorded = read_result(folder).log.sha256
    if plan.source.sha256 != recorded:
        raise ValueError(f"{plan.source.name} is not the data of this run: its SHA-256 differs")
    return plan
