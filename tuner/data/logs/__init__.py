"""Sensor logs: a file and a mapping in, named channels and a word on what was found out.

Example:
    >>> parse_mapping("omega=gyr_degs[0]*gyr_lsb:deg/s", ["omega"]).source
    'gyr_degs[0]*gyr_lsb'
"""

from tuner.data.logs.error import LogError
from tuner.data.logs.findings import ChannelFindings, Findings
from tuner.data.logs.log import Log, read_log
from tuner.data.logs.mapping import Mapping, parse_mapping
from tuner.data.logs.report import describe, to_dict

__all__ = [
    "ChannelFindings",
    "Findings",
    "Log",
    "LogError",
    "Mapping",
    "describe",
    "parse_mapping",
    "read_log",
    "to_dict",
]
