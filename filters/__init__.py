"""Filters: what runs on the machine. Pure JAX, differentiable, on one time loop."""

from filters.backend import LoopOption, loop_option

loop_option()  # before anything below starts JAX's backend

from filters.alpha_beta import (  # noqa: E402
    AlphaBeta,
    AlphaBetaGains,
    AlphaBetaGamma,
    AlphaBetaGammaGains,
    AlphaBetaGammaOutputs,
    AlphaBetaOutputs,
)
from filters.attitude import (  # noqa: E402
    AttitudeKalman,
    AttitudeNoise,
    AttitudeOutputs,
    AttitudeState,
)
from filters.backwards import run_kept  # noqa: E402
from filters.batched import Batched, Lanes, shared  # noqa: E402
from filters.bounded_motion import (  # noqa: E402
    BoundedMotionKalman,
    BoundedMotionNoise,
    BoundedMotionOutputs,
    BoundedMotionState,
    blocks,
)
from filters.coloured import coloured, coloured_noise  # noqa: E402
from filters.complementary import (  # noqa: E402
    AngleSample,
    Complementary,
    ComplementaryGain,
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    MahonyState,
)
from filters.constant_velocity import (  # noqa: E402
    ConstantAcceleration,
    ConstantAccelerationNoise,
    ConstantAccelerationOutputs,
    ConstantVelocity,
    ConstantVelocityNoise,
    ConstantVelocityOutputs,
    PositionSample,
)
from filters.conventional_loop import (  # noqa: E402
    GRAVITY_GRADIENT,
    ConventionalLoop,
    LoopGains,
    LoopStep,
    loop_error,
    loop_step,
    vertical_channel,
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
from filters.dead_reckoning import (  # noqa: E402
    DeadReckoningKalman,
    DeadReckoningNoise,
    DeadReckoningSample,
    constructed_attitude,
)
from filters.declared import (  # noqa: E402
    Channel,
    Param,
    assembled,
    bare,
    channel_facts,
    components,
    inputs_of,
    optional,
    output,
    parameter_facts,
)
from filters.discretise import transitions, van_loan  # noqa: E402
from filters.extended import (  # noqa: E402
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    linearised,
)
from filters.fuzzy_line import line  # noqa: E402
from filters.fuzzy_regression import regression  # noqa: E402
from filters.gated import Gated  # noqa: E402
from filters.gps_aided import GpsAidedKalman, GpsAidedNoise, GpsAidedSample  # noqa: E402
from filters.imu import ImuSample, SixAxes  # noqa: E402
from filters.ins import ErrorStateIns, InsState  # noqa: E402
from filters.ins_facts import InsNoise, InsOutputs, InsSample  # noqa: E402
from filters.joined import Joined, JoinedSample, joined, packed  # noqa: E402
from filters.kalman import Estimate, Innovation, decorrelate, predict, update, update_large  # noqa: E402
from filters.kownacki import (  # noqa: E402
    AccelerometerFilter,
    FixedGainFilter,
    FixedGains,
    GyroscopeFilter,
    KownackiNoise,
    SteadyState,
    accelerometer_steady,
    gyroscope_steady,
)
from filters.linear import (  # noqa: E402
    GainedSample,
    LinearForm,
    LinearKalman,
    LinearModel,
    LinearOutputs,
    Measured,
    Sample,
    StoredGains,
    Transition,
)
from filters.local_level import (  # noqa: E402
    LevelSample,
    LocalLevel,
    LocalLevelNoise,
    LocalLevelOutputs,
)
from filters.measurement_mask import measured_entries  # noqa: E402
from filters.parametrised import parametrised  # noqa: E402
from filters.pi_complementary import (  # noqa: E402
    PiComplementary,
    PiGains,
    PiOutputs,
    PiSample,
    PiState,
    VelocityNoise,
    accelerometer_angles,
    euler_rates,
)
from filters.protocol import AnyFilter, Filter, run  # noqa: E402
from filters.residual_noise import ResidualNoise  # noqa: E402
from filters.settling import Settling, summed  # noqa: E402
from filters.steady_gain import SteadyGain, SteadyGains, SteadyGainState  # noqa: E402
from filters.strapdown import RestRule  # noqa: E402
from filters.student import Student  # noqa: E402
from filters.tilt_euler import (  # noqa: E402
    TiltKalman,
    TiltNoise,
    TiltOutputs,
    TiltSample,
    TiltState,
    tilt_disturbance,
    tilt_transition,
)
from filters.timed import Timed, TimedSample  # noqa: E402
from filters.unscented import UnscentedKalman  # noqa: E402
from filters.varying_noise import channel_noise, level_noise  # noqa: E402
from filters.vertical import (  # noqa: E402
    Vertical,
    VerticalNoise,
    VerticalOutputs,
    VerticalSample,
)

__all__ = [
    "GRAVITY_GRADIENT",
    "AccelerometerFilter",
    "AlphaBeta",
    "AlphaBetaGains",
    "AlphaBetaGamma",
    "AlphaBetaGammaGains",
    "AlphaBetaGammaOutputs",
    "AlphaBetaOutputs",
    "AngleSample",
    "AnyFilter",
    "AttitudeKalman",
    "AttitudeNoise",
    "AttitudeOutputs",
    "AttitudeState",
    "Batched",
    "BoundedMotionKalman",
    "BoundedMotionNoise",
    "BoundedMotionOutputs",
    "BoundedMotionState",
    "Channel",
    "Complementary",
    "ComplementaryGain",
    "ConstantAcceleration",
    "ConstantAccelerationNoise",
    "ConstantAccelerationOutputs",
    "ConstantVelocity",
    "ConstantVelocityNoise",
    "ConstantVelocityOutputs",
    "ConventionalLoop",
    "DeadReckoningKalman",
    "DeadReckoningNoise",
    "DeadReckoningSample",
    "ErrorStateIns",
    "Estimate",
    "ExtendedKalman",
    "ExtendedModel",
    "ExtendedSample",
    "Filter",
    "FixedGainFilter",
    "FixedGains",
    "Flow",
    "GainCovariance",
    "GainTable",
    "GainedSample",
    "Gated",
    "GpsAidedKalman",
    "GpsAidedNoise",
    "GpsAidedSample",
    "GyroscopeFilter",
    "ImuSample",
    "Innovation",
    "InsNoise",
    "InsOutputs",
    "InsSample",
    "InsState",
    "Joined",
    "JoinedSample",
    "KalmanCovariance",
    "KownackiNoise",
    "Lanes",
    "LevelSample",
    "LinearForm",
    "LinearKalman",
    "LinearModel",
    "LinearOutputs",
    "LocalLevel",
    "LocalLevelNoise",
    "LocalLevelOutputs",
    "LoopGains",
    "LoopOption",
    "LoopStep",
    "Madgwick",
    "MadgwickGain",
    "Mahony",
    "MahonyGains",
    "MahonyState",
    "Measured",
    "Param",
    "PiComplementary",
    "PiGains",
    "PiOutputs",
    "PiSample",
    "PiState",
    "PositionSample",
    "ResidualNoise",
    "RestRule",
    "RiccatiCovariance",
    "Sample",
    "Settling",
    "SixAxes",
    "SteadyGain",
    "SteadyGainState",
    "SteadyGains",
    "SteadyState",
    "StoredGains",
    "Student",
    "TableCovariance",
    "TiltKalman",
    "TiltNoise",
    "TiltOutputs",
    "TiltSample",
    "TiltState",
    "Timed",
    "TimedSample",
    "Transition",
    "Uncertainty",
    "UnscentedKalman",
    "VelocityNoise",
    "Vertical",
    "VerticalNoise",
    "VerticalOutputs",
    "VerticalSample",
    "accelerometer_angles",
    "accelerometer_steady",
    "assembled",
    "bare",
    "blocks",
    "channel_facts",
    "channel_noise",
    "coloured",
    "coloured_noise",
    "components",
    "constructed_attitude",
    "decorrelate",
    "euler_rates",
    "gyroscope_steady",
    "inputs_of",
    "joined",
    "level_noise",
    "line",
    "linearised",
    "loop_error",
    "loop_option",
    "loop_step",
    "measured_entries",
    "optional",
    "output",
    "packed",
    "parameter_facts",
    "parametrised",
    "predict",
    "regression",
    "riccati_flow",
    "run",
    "run_kept",
    "shared",
    "summed",
    "tilt_disturbance",
    "tilt_transition",
    "transitions",
    "update",
    "update_large",
    "van_loan",
    "vertical_channel",
]
