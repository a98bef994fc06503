"""Tune filters by optimisation: problems, solvers, certificates, logs, exports and studies.

Public names are imported from here; what they need is loaded when they are first used.
"""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

_HOMES = {
    "filters": (
        "AccelerometerFilter",
        "ConventionalLoop",
        "GpsAidedKalman",
        "GpsAidedNoise",
        "GpsAidedSample",
        "ExtendedKalman",
        "ExtendedModel",
        "ExtendedSample",
        "FixedGainFilter",
        "GainCovariance",
        "Gains",
        "AttitudeKalman",
        "AttitudeNoise",
        "GyroscopeFilter",
        "ImuSample",
        "KalmanCovariance",
        "LinearKalman",
        "LinearModel",
        "Madgwick",
        "MadgwickGain",
        "Mahony",
        "MahonyGains",
        "PiComplementary",
        "PiGains",
        "PiSample",
        "Noise",
        "ResidualNoise",
        "Sample",
        "StoredGains",
        "TiltKalman",
        "TiltNoise",
        "TiltSample",
        "DeadReckoningKalman",
        "DeadReckoningNoise",
        "DeadReckoningSample",
        "Transition",
        "accelerometer_steady",
        "gyroscope_steady",
        "transitions",
        "van_loan",
        "vertical_channel",
    ),
    "objectives": (
        "AttitudeRmse",
        "ComplementaryLoop",
        "Crossing",
        "Data",
        "Factors",
        "Reading",
        "StepResponse",
        "Welch",
        "care",
        "dare",
        "decay_rate",
        "ise",
        "lyapunov",
        "place",
        "settling_time",
        "steady_kalman",
        "steady_variance",
        "stein",
    ),
    "tuner.run.comparison": ("Comparison", "Verdict"),
    "tuner.problem.constraint": ("Constraint",),
    "tuner.convex": ("ConvexProgram", "linear_program"),
    "tuner.observers": ("LinearDesign", "fastest", "quietest"),
    "tuner.export": ("Provenance", "Quantity", "Tuned"),
    "tuner.data.logs": ("Log", "LogError", "parse_mapping", "read_log"),
    "tuner.observers.lmi": ("fastest_observer", "h2_observer"),
    "tuner.regression": ("tanaka", "tanaka_program", "tanaka_simplex", "tanaka_windows"),
    "tuner.problem.problem": ("Problem",),
    "tuner.data.simulation": ("Bursts", "Sensor", "Swing", "measure", "simulate"),
    "tuner.certificate.single_precision": ("single_precision",),
    "tuner.certificate.solution": ("Certificate", "Solution", "Status"),
    "tuner.solvers": (
        "Alternating",
        "Convex",
        "Gradient",
        "Ipopt",
        "Known",
        "NelderMead",
        "Sampler",
        "fminsearch",
    ),
    "tuner.problem.parameters": ("Bounded", "Covariance", "Fixed", "Limited", "Positive"),
    "tuner.problem.space": ("Space",),
    "tuner.data.noise_split": ("split_noise",),
    "tuner.data.source": ("Source",),
    "tuner.run.study": ("Claim", "Plan", "Study", "Task", "find_study"),
    "tuner.problem.surface": ("grid", "values", "values_and_gradients"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME)  # noqa: PLE0605  # the names are those of the table above


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'tuner' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]


def _check_siblings() -> None:
    """Refuse to start beside another package called filters, objectives or studies."""
    root = Path(__file__).resolve().parents[1]
    for name in ("filters", "objectives", "studies"):
        spec = find_spec(name)
        found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
        if found != root / name / "__init__.py":
            raise ImportError(
                f"tuner needs its own package {name!r} in {root / name}, but Python finds "
                f"{found or 'none'}; rename yours, or start Python with -P so that the current "
                "folder does not come first"
            )


_check_siblings()
