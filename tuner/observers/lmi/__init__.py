"""Observers designed by convex optimisation: least variance, and fastest within a variance.

The model is x' = A x + w, y = C x + v with white noise of spectral densities W and V, the observer
x^' = A x^ + L (y - C x^), its error e' = (A - L C) e + w - L v. In discrete time x+ = A x + w, W
and V are covariances per sample, and the observer is the predictor x^+ = A x^ + L (y - C x^).

With Y the inverse of a bound on the error's covariance and Z = Y L, both designs are linear matrix
inequalities (Boyd, El Ghaoui, Feron, Balakrishnan: Linear Matrix Inequalities in System and
Control Theory, 1994, chapters 6 and 7; Scherer, Gahinet, Chilali, IEEE TAC 42, 1997).

All is solved in units that the model itself suggests, so that no result depends on the user's.
"""

from tuner.observers.lmi.fastest import FastestObserver, fastest_observer
from tuner.observers.lmi.least import H2Observer, h2_observer
from tuner.observers.lmi.model import Model, observer_model
from tuner.observers.lmi.task import Attempt, FastestTask, LeastTask

__all__ = [
    "Attempt",
    "FastestObserver",
    "FastestTask",
    "H2Observer",
    "LeastTask",
    "Model",
    "fastest_observer",
    "h2_observer",
    "observer_model",
]
