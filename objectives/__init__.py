"""Objectives: the quality of a filter's run, or of a design, as one differentiable number."""

from objectives.angle_rmse import AngleRmse
from objectives.attitude import (
    AngleErrors,
    AttitudeError,
    AttitudeRmse,
    angle_errors,
    attitude_error,
    masked,
)
from objectives.complementary import ComplementaryLoop, SensorNoise, Transfer
from objectives.kinds import Additive, Kind, is_additive, kind_of
from objectives.likelihood import InnovationLikelihood
from objectives.linear_systems.checks import covariance
from objectives.linear_systems.lyapunov import lyapunov, stein
from objectives.linear_systems.model import LinearSystem
from objectives.linear_systems.modes import (
    Mode,
    Reduction,
    require_detectable,
    undriven_modes,
    unseen_modes,
    without_undriven,
    without_unseen,
)
from objectives.linear_systems.placement import Factors, place
from objectives.linear_systems.response import (
    decay_rate,
    ise,
    settling_time,
    spectral_radius,
    steady_variance,
)
from objectives.linear_systems.riccati import bucy_gain, care, dare, steady_gain, updated
from objectives.linear_systems.steady import SteadyKalman, steady_kalman
from objectives.linear_systems.subspaces import Subspace, unobservable
from objectives.linear_systems.tracker import tracker_gains
from objectives.linear_systems.variance_ratio import VarianceRatio
from objectives.records import Records
from objectives.rmse import ChannelRmse
from objectives.robust import HeavyTails, PartlyWrong
from objectives.score import (
    Data,
    Fold,
    Folded,
    Objective,
    Way,
    contributions,
    is_fold,
    judged,
    kept_bytes,
    score,
    score_and_gradient,
    scores_and_gradients,
    sum_and_gradient,
    weighed,
)
from objectives.step_response import (
    Crossing,
    Reading,
    StepCost,
    StepResponse,
    StepSum,
    StepTruth,
)
from objectives.welch import Welch, window

__all__ = [
    "Additive",
    "AngleErrors",
    "AngleRmse",
    "AttitudeError",
    "AttitudeRmse",
    "ChannelRmse",
    "ComplementaryLoop",
    "Crossing",
    "Data",
    "Factors",
    "Fold",
    "Folded",
    "HeavyTails",
    "InnovationLikelihood",
    "Kind",
    "LinearSystem",
    "Mode",
    "Objective",
    "PartlyWrong",
    "Reading",
    "Records",
    "Reduction",
    "SensorNoise",
    "SteadyKalman",
    "StepCost",
    "StepResponse",
    "StepSum",
    "StepTruth",
    "Subspace",
    "Transfer",
    "VarianceRatio",
    "Way",
    "Welch",
    "angle_errors",
    "attitude_error",
    "bucy_gain",
    "care",
    "contributions",
    "covariance",
    "dare",
    "decay_rate",
    "is_additive",
    "is_fold",
    "ise",
    "judged",
    "kept_bytes",
    "kind_of",
    "lyapunov",
    "masked",
    "place",
    "require_detectable",
    "score",
    "score_and_gradient",
    "scores_and_gradients",
    "settling_time",
    "spectral_radius",
    "steady_gain",
    "steady_kalman",
    "steady_variance",
    "stein",
    "sum_and_gradient",
    "tracker_gains",
    "undriven_modes",
    "unobservable",
    "unseen_modes",
    "updated",
    "weighed",
    "window",
    "without_undriven",
    "without_unseen",
]
