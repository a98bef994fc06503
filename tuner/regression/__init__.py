"""Tanaka's possibilistic regression as a linear program, solved exactly, one window or many."""

from tuner.regression.many import Windows, tanaka_windows
from tuner.regression.one import Outcome, Regression, tanaka
from tuner.regression.program import tanaka_program
from tuner.regression.simplex import Vertex, tanaka_simplex

__all__ = [
    "Outcome",
    "Regression",
    "Vertex",
    "Windows",
    "tanaka",
    "tanaka_program",
    "tanaka_simplex",
    "tanaka_windows",
]
