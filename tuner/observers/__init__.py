"""Observers of linear models as problems, without data: the fastest, and the quietest."""

from tuner.observers.fastest_decay import fastest
from tuner.observers.gains import Observer, gain_of
from tuner.observers.minimum_variance import quietest, riccati
from tuner.observers.model import LinearDesign

__all__ = ["LinearDesign", "Observer", "fastest", "gain_of", "quietest", "riccati"]
