"""Observers designed by convex optimisation: least variance, and fastest within a variance.

System and observer are those of :mod:`objectives.linear_systems.model`; the error moves as
e' = (A - L C) e + w - L v.

With Y the inverse of a bound on the error's covariance and Z = Y L, both designs are linear matrix
inequalities (Boyd, El Ghaoui, Feron, Balakrishnan: Linear Matrix Inequalities in System and
Control Theory, 1994, chapters 6 and 7; Scherer, Gahinet, Chilali, IEEE TAC 42, 1997).

All is solved in units that follow from the system, so that no result depends on the user's.
"""

from tuner.observers.lmi.fastest_decay import FastestObserver, fastest_observer
from tuner.observers.lmi.minimum_variance import H2Observer, h2_observer
from tuner.observers.lmi.task import Attempt, FastestDecayTask, MinimumVarianceTask

__all__ = [
    "Attempt",
    "FastestDecayTask",
    "FastestObserver",
    "H2Observer",
    "MinimumVarianceTask",
    "fastest_observer",
    "h2_observer",
]
