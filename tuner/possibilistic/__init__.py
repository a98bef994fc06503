"""Tanaka's possibilistic regression as a linear program, solved exactly, one window or many."""

from tuner.possibilistic.many import Windows, tanaka_windows
from tuner.possibilistic.one import Outcome, Regression, tanaka
from tuner.possibilistic.program import tanaka_program
from tuner.possibilistic.simplex import Vertex, tanaka_simplex

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
