"""Files of recordings: their columns, and when the samples were taken."""

from tuner.data.logs.error import LogError

__all__ = ["LogError"]
