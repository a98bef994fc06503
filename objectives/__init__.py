"""Objectives: how good a filter's run is, as one differentiable number."""

from objectives.score import (
    Data,
    Fold,
    Folded,
    Objective,
    is_fold,
    kept_bytes,
    score,
    score_and_gradient,
    scores_and_gradients,
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
    "Crossing",
    "Data",
    "Fold",
    "Folded",
    "Objective",
    "Reading",
    "StepCost",
    "StepResponse",
    "StepSum",
    "StepTruth",
    "Welch",
    "is_fold",
    "kept_bytes",
    "score",
    "score_and_gradient",
    "scores_and_gradients",
    "window",
]
