"""Tests of a filter's innovations: size, whiteness, outliers, and their causes."""

from tuner.diagnostics.diagnose import Diagnostics, Remedies, diagnose
from tuner.diagnostics.finding import Finding
from tuner.diagnostics.innovations import Innovations

__all__ = ["Diagnostics", "Finding", "Innovations", "Remedies", "diagnose"]
