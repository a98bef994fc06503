"""Results and pictures that nobody computed, for the tests of reports."""

import numpy as np

from tuner.certificate.solution import Status
from tuner.data.source import Source
from tuner.report.report_json import SCHEMA, Kept, KeptRecord, kept_pictures
from tuner.run.comparison import claim, number, undecided
from tuner.run.figure import Chart, Line, Map
from tuner.run.fit_record import DiagnosticsRecord, FitRecord, HeldOutRecord, ImprovementRecord
from tuner.run.report_figure import ReportFigure
from tuner.run.result import ExportRecord, ParameterRecord, Result, SolutionRecord

HOSTILE = "</script><script>alert(1)</script>\"'><img src=x onerror=alert(2)>&{{7*7}}"


def solution(name="level", *, status=Status.CONVERGED, flat=(), agreeing=4):
    return SolutionRecord(
        problem=name,
        solver="l-bfgs-b",
        status=status,
        message="",
        value=2.5,
        z=[0.0, 1.0],
        parameters={
            "q": ParameterRecord(
                value=0.146, unit="Pa^2/s", interval=(0.07, 0.3), interval_kind="95 %, sandwich"
            ),
            "R": ParameterRecord(value=6.34, unit="Pa^2", interval=(0.0, 7.0)),
            "P0": ParameterRecord(value=[[1.0]], unit="", interval=None),
        },
        derived={"K": 0.042},
        evaluations=79,
        seconds=1.25,
        certificate={
            "gradient": {"ln q": 0.0, "ln R": 0.0},
            "active_bounds": [],
            "curvatures": [7.0, 700.0],
            "flat_directions": list(flat),
            "starts": {"count": 4, "agreeing": agreeing, "worst": 0.0},
            "methods": {},
        },
    )


def gain(low, high):
    return ImprovementRecord(share=(low + high) / 2, low=low, high=high, blocks=20)


def held_out(gained=(0.13, 0.19), over=None):
    return HeldOutRecord(
        way="time",
        what="the last 449 samples",
        start=3.1,
        tuned=2.6,
        gain=None if gained is None else gain(*gained),
        nothing="the constant mean",
        unfiltered=5.7,
        over_unfiltered=None if over is None else gain(*over),
        best=2.59,
        gap=0.004,
        recordings=[],
    )


def diagnostics(nis=1.0, failed=()):
    tests = ("whiteness", "size")
    return DiagnosticsRecord.model_validate(
        {
            "nis": nis,
            "low": 0.93,
            "high": 1.07,
            "factor": nis,
            "factor_low": 0.9,
            "factor_high": 1.1,
            "lag_one": 0.04,
            "numbers": 1499,
            "findings": [
                {
                    "test": test,
                    "what": f"what {test} is",
                    "statistic": 1.0,
                    "p": 0.5,
                    "verdict": "failed" if test in failed else "passed",
                    "sentence": f"{test} is wrong" if test in failed else "",
                    "details": {},
                }
                for test in tests
            ],
        }
    )


def fit(**changed):
    fields = {
        "filter": "LocalLevel",
        "objective": "likelihood",
        "unit": "Pa",
        "start": 3.15,
        "tuned": 2.57,
        "held_out": held_out(),
        "diagnostics": [diagnostics(0.8), diagnostics()],
        "lines": [f"{word:10}words" for word in ("use", "how good", "trust", "open", "next")],
    }
    return FitRecord(**fields | changed)


def result(**changed):
    quantities = [
        {"name": "q", "value": 0.146, "unit": "Pa^2/s", "meaning": "of a random walk, m^2"},
        {"name": "K", "value": 0.042, "unit": "", "meaning": "steady gain"},
    ]
    fields = {
        "schema": "tuner.result/1",
        "study": "fit",
        "seed": 0,
        "log": Source("log.csv", "0f" * 32, 1500, 12.5),
        "settings": {},
        "solutions": [solution()],
        "comparisons": [],
        "exports": [
            ExportRecord(
                problem="level", format="c", file="exports/level.h", score=2.5, relative_change=0.0
            )
        ],
        "single_precision": [],
        "tuned": [
            {"name": "level", "quantities": quantities, "versions": {"filter-tuner": "0.1.0"}}
        ],
        "artifacts": [],
        "seconds": 1.5,
        "fit": fit(),
    }
    return Result(**fields | changed)


def study(*, all_met=False):
    rows = [
        number("gain", "Table 2", 2.0, 2.01, tolerance=0.05, unit="deg"),
        claim("order", "section 5", True, ours=0.23, note="S 30.3 deg^2"),
    ]
    if not all_met:
        rows += [
            number("ratio", "Table 3", 2.0, 7.2, tolerance=0.05),
            undecided("R", "Table 1", paper=1.0, note="the scale is free"),
        ]
    return result(study="some2004", fit=None, comparisons=rows)


def pictures(label="tuned"):
    t = np.arange(3000.0)
    wave = np.sin(t / 100)
    lines = (
        Line("95 % expected", t, wave - 1, drawn="band", upper=wave + 1),
        Line("measured", t, np.where(t % 7 == 0, np.nan, wave), drawn="points"),
        Line(label, t, wave),
        Line("", t[[0, -1]], np.ones(2), drawn="limit"),
    )
    chart = Chart("signal_0", f"What {label} is", "time, s", "level, Pa^2", lines)
    powers = np.geomspace(1e-3, 1e3, 12)
    sizes = Chart("sizes", "Sizes", "f, Hz", "S", (Line("S", powers, powers**2),), log="xy")
    numbers = Line("run", np.array([1.0, 7.0, 30.0]), np.ones(3))
    counted = Chart("runs", "Runs", "run", "error", (numbers,), numbered=True)
    x = np.geomspace(0.01, 1.0, 12)
    z = np.log(x[:, None] / 0.1) ** 2 + np.log(x[None, :] / 0.1) ** 2
    spot = Line("tuned", np.array([0.1]), np.array([0.1]))
    surface = Map("surface", "One place", "q", "R", "nats", x, x, z, (spot,), "xy")
    return kept_pictures(
        [
            ReportFigure("signal", chart, "A note."),
            ReportFigure("figures", sizes),
            ReportFigure("figures", counted),
            ReportFigure("certificate", surface, "", (0.0, 1.0, 3.0, 9.0), (3.0, "95 % region")),
        ]
    )


def kept(label="tuned", **changed):
    fields = {
        "schema": SCHEMA,
        "title": "A study",
        "paper": "A. Author, 2004",
        "notes": ["z steps by 0.1"],
        "records": [
            KeptRecord(
                about=["log.csv: 1500 samples at 12.5 Hz"],
                rows=[["channel", "column", "unit", "Hz"], ["z", label, "Pa", "12.5"]],
            )
        ],
        "recordings": 1,
        "pictures": pictures(label),
    }
    return Kept(**fields | changed)
