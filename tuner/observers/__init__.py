"""Observers of linear systems as problems, without data: fastest decay, and minimum variance."""

from tuner.observers.fastest_decay import fastest_decay
from tuner.observers.gains import Observer, gain_of
from tuner.observers.minimum_variance import least_variance, minimum_variance, riccati

__all__ = [
    "Observer",
    "fastest_decay",
    "gain_of",
    "least_variance",
    "minimum_variance",
    "riccati",
]
