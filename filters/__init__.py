"""Filters: what runs on the machine. Pure JAX, differentiable, on one time loop."""

from filters.backend import LoopOption, loop_option

loop_option()  # before anything below starts JAX's backend

from filters.complementary import (  # noqa: E402
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    MahonyState,
)
from filters.covariance import (  # noqa: E402
    Flow,
    GainCovariance,
    GainTable,
    KalmanCovariance,
    RiccatiCovariance,
    TableCovariance,
    Uncertainty,
    riccati_flow,
)
from filters.discretise import transitions, van_loan  # noqa: E402
from filters.extended import (  # noqa: E402
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    linearised,
)
from filters.gravity import (  # noqa: E402
    GravityKalman,
    GravityNoise,
    GravityOutputs,
    GravityState,
    ImuSample,
)
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
    GainedSample,
    LinearKalman,
    LinearModel,
    LinearOutputs,
    Sample,
    StoredGains,
    Transition,
)
from filters.protocol import AnyFilter, Filter, run  # noqa: E402
from filters.room import RestRule, RoomKalman, RoomNoise, RoomOutputs, RoomState, blocks  # noqa: E402
from filters.several import Several, shared  # noqa: E402
from filters.tilt import (  # noqa: E402
    TiltKalman,
    TiltNoise,
    TiltOutputs,
    TiltSample,
    TiltState,
    tilt_disturbance,
    tilt_transition,
)
from filters.vertical import (  # noqa: E402
    GRAVITY_GRADIENT,
    ConventionalLoop,
    LoopGains,
    LoopStep,
    Plant,
    loop_error,
    loop_step,
    vertical_channel,
)

__all__ = [
    "GRAVITY_GRADIENT",
    "AccelerometerFilter",
    "AnyFilter",
    "ConventionalLoop",
    "Estimate",
    "ExtendedKalman",
    "ExtendedModel",
    "ExtendedSample",
    "Filter",
    "FixedGainFilter",
    "Flow",
    "GainCovariance",
    "GainTable",
    "GainedSample",
    "Gains",
    "GravityKalman",
    "GravityNoise",
    "GravityOutputs",
    "GravityState",
    "GyroscopeFilter",
    "ImuSample",
    "Innovation",
    "KalmanCovariance",
    "LinearKalman",
    "LinearModel",
    "LinearOutputs",
    "LoopGains",
    "LoopOption",
    "LoopStep",
    "Madgwick",
    "MadgwickGain",
    "Mahony",
    "MahonyGains",
    "MahonyState",
    "Noise",
    "Plant",
    "RestRule",
    "RiccatiCovariance",
    "RoomKalman",
    "RoomNoise",
    "RoomOutputs",
    "RoomState",
    "Sample",
    "Several",
    "SteadyState",
    "StoredGains",
    "TableCovariance",
    "TiltKalman",
    "TiltNoise",
    "TiltOutputs",
    "TiltSample",
    "TiltState",
    "Transition",
    "Uncertainty",
    "accelerometer_steady",
    "blocks",
    "decorrelate",
    "gyroscope_steady",
    "linearised",
    "loop_error",
    "loop_option",
    "loop_step",
    "predict",
    "riccati_flow",
    "run",
    "shared",
    "tilt_disturbance",
    "tilt_transition",
    "transitions",
    "update",
    "van_loan",
    "vertical_channel",
]
