"""Filters: what runs on the machine. Pure JAX, differentiable, on one time loop."""

from filters.backend import LoopOption, loop_option

loop_option()  # before anything below starts JAX's backend

from filters.discretise import transitions, van_loan  # noqa: E402
from filters.inertial import (  # noqa: E402
    AccelerometerFilter,
    FixedGainFilter,
    Gains,
    GyroscopeFilter,
    Noise,
    SteadyState,
    accelerometer_steady,
    gyroscope_steady,
)
from filters.kalman import Estimate, Innovation, decorrelate, predict, update  # noqa: E402
from filters.linear import (  # noqa: E402
    LinearKalman,
    LinearModel,
    LinearOutputs,
    Sample,
    Transition,
)
from filters.protocol import AnyFilter, Filter, run  # noqa: E402

__all__ = [
    "AccelerometerFilter",
    "AnyFilter",
    "Estimate",
    "Filter",
    "FixedGainFilter",
    "Gains",
    "GyroscopeFilter",
    "Innovation",
    "LinearKalman",
    "LinearModel",
    "LinearOutputs",
    "LoopOption",
    "Noise",
    "Sample",
    "SteadyState",
    "Transition",
    "accelerometer_steady",
    "decorrelate",
    "gyroscope_steady",
    "loop_option",
    "predict",
    "run",
    "transitions",
    "update",
    "van_loan",
]
