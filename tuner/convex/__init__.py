"""Convex programs, built once and solved for many parameter values, with checked answers."""

from tuner.convex.answer import Answer, Report
from tuner.convex.bound import MARGIN
from tuner.convex.clarabel import TOLERANCES, building
from tuner.convex.linear import linear_program
from tuner.convex.program import ConvexProgram, solve
from tuner.convex.reading import ADMISSIBLE

__all__ = [
    "ADMISSIBLE",
    "MARGIN",
    "TOLERANCES",
    "Answer",
    "ConvexProgram",
    "Report",
    "building",
    "linear_program",
    "solve",
]
