"""Runs to write firmware's files of, without a search; and readers that share no code with us."""

import json
from pathlib import Path

import numpy as np

from tests.tuner.export_cases import provenance
from tuner.export import Quantity, Tuned, dump
from tuner.run.finding import Finding
from tuner.run.result import Result

N, K = "noise_density", "random_walk"


def filter_of(name, quantities, states=(), dt=0.02, status="converged", **source):
    """A tuned filter of quantities by name: value, unit and perhaps meaning."""
    found = tuple(Quantity(n, np.array(v), *words) for n, (v, *words) in quantities.items())
    source = provenance(**{"study": "fit", "solver": "search", "status": status} | source)
    return Tuned(name, "Any", found, "discrete", dt, tuple(states), source)


def axis(name, unit, white, walk, below=None):
    """An axis of a record at rest, and what is found of it."""
    sensor = "gyroscope" if unit == "rad/s" else "accelerometer"
    told = {
        N: (white, f"{unit}/sqrt(Hz)", "N"),
        K: (walk, f"{unit}/s/sqrt(Hz)", "K"),
        "q": (1e-9, f"({unit})^2/s", "growth of the variance"),
        "R": (1e-6, f"({unit})^2", "variance of a mean"),
    }
    one = filter_of(name, told, dt=1.0, study="rest")
    low = None if below is not None else 0.5 * walk
    findings = [
        Finding(f"{name}.{sensor}_{N}.curve", 2 * white, told[N][1], "", white, 3 * white),
        Finding(f"{name}.{sensor}_{N}.likelihood", white, told[N][1], "", white, 2 * white),
        Finding(f"{name}.{sensor}_{K}.likelihood", walk, told[K][1], "", low, below or 2 * walk),
        Finding(f"{name}.R", 1.0, f"({unit})^2", ""),
    ]
    return one, findings


def vertical(q_acc=4e-4, q_bias=9e-10, R=0.25, **changed):
    """A fit whose parameters say whose noise they are, but for the barometer's."""
    quantities = {
        "q_acc": (q_acc, "m^2/s^3", "density of the acceleration"),
        "q_bias": (q_bias, "m^2/s^5", "growth of the offset's variance"),
        "R_baro": (R, "m^2", "variance of the barometer's height"),
        "climb0": (1.0, "m/s", "deviation of the start"),
        "bias0": (1.0, "m/s^2", "deviation of the offset at the start"),
    }
    findings = [
        Finding("q_acc.accelerometer_noise_density", q_acc**0.5, "m/s^2/sqrt(Hz)", ""),
        Finding("q_acc.VRW", 60 * q_acc**0.5, "m/s/sqrt(h)", ""),
        Finding("q_bias.accelerometer_random_walk", q_bias**0.5, "m/s^3/sqrt(Hz)", ""),
    ]
    states = ("height", "climb", "bias")
    return filter_of("vertical", quantities, states, **changed), findings


def save_run(folder, *runs, intervals=None, settings=None, rate_hz=50.0, derived=("Q",)):
    """Write result.json of tuned filters and their findings; intervals as of one solution each.

    Numbers are parameters but for those that are said to be derived, and matrices.
    """
    tuned = [one for one, _ in runs]
    solutions = [_solution(one, intervals or {}, derived) for one in tuned]
    document = {
        "schema": "tuner.result/1",
        "study": tuned[0].provenance.study,
        "seed": 0,
        "log": {"name": "log.csv", "sha256": "", "samples": 100, "rate_hz": rate_hz},
        "settings": settings or {},
        "solutions": solutions,
        "tuned": [json.loads(dump(one, "json")) for one in tuned],
        "findings": [vars(finding) for _, findings in runs for finding in findings],
        "seconds": 0.0,
        **{key: [] for key in ("comparisons", "exports", "single_precision", "artifacts")},
    }
    folder = Path(folder)
    folder.mkdir()
    result = Result.model_validate(document)
    (folder / "result.json").write_text(result.to_json())
    return folder


def _solution(tuned, intervals, derived):
    searched = {
        q.name: {
            "value": q.value.tolist(),
            "unit": q.unit,
            "interval": intervals.get(q.name, (q.value / 2, q.value * 2)),
        }
        for q in tuned.quantities
        if q.value.ndim == 0 and not q.name.endswith("0") and q.name not in derived
    }
    for q in tuned.quantities:
        if q.name.endswith("0"):
            searched[q.name] = {"value": q.value.tolist(), "unit": q.unit, "interval": None}
    names = {"problem": tuned.name, "solver": tuned.provenance.solver, "status": "converged"}
    numbers = {"value": 0.0, "z": [], "evaluations": 1, "seconds": 0.0}
    return {**names, **numbers, "message": "", "parameters": searched} | {
        "derived": {},
        "certificate": {},
    }


def read_px4(text):
    """As a ground station does: five fields between tabs, # begins a comment."""
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert all(len(row) == 5 and row[:2] == ["1", "1"] and row[4] == "9" for row in rows), rows
    found = {row[2]: float(row[3]) for row in rows}
    assert len(found) == len(rows)
    return found


def read_ardupilot(text):
    """As a ground station does: a name and a value, between commas or blanks."""
    lines = [line.strip() for line in text.splitlines()]
    rows = [line.replace(",", " ").split() for line in lines if line and line[0] != "#"]
    assert all(len(row) == 2 and len(row[0]) <= 16 for row in rows), rows
    found = {name: float(value) for name, value in rows}
    assert len(found) == len(rows)
    return found
