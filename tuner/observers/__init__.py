"""Observers of linear systems as problems, without data: by decay, variance or settling time."""

from tuner.observers.fastest_decay import fastest_decay
from tuner.observers.gains import Observer, gain_of
from tuner.observers.minimum_variance import least_variance, minimum_variance, riccati
from tuner.observers.settled import settled, settling_time

__all__ = [
    "Observer",
    "fastest_decay",
    "gain_of",
    "least_variance",
    "minimum_variance",
    "riccati",
    "settled",
    "settling_time",
]
