"""Observers of linear models as problems, without data: the fastest, and the quietest."""

from tuner.design.fastest import fastest
from tuner.design.model import LinearDesign
from tuner.design.point import Observer, gain_of
from tuner.design.quietest import quietest, riccati

__all__ = ["LinearDesign", "Observer", "fastest", "gain_of", "quietest", "riccati"]
