"""Noise in the files of other filters and programs: kalibr, robot_localization, PX4, ArduPilot."""

from tuner.firmware.amount import Amount, amounts
from tuner.firmware.choice import Wish
from tuner.firmware.maps import read_maps
from tuner.firmware.target import FileRequest, Target, Text
from tuner.firmware.targets import TARGETS

__all__ = ["TARGETS", "Amount", "FileRequest", "Target", "Text", "Wish", "amounts", "read_maps"]
