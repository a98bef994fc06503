"""All targets."""

from tuner.firmware import ardupilot, kalibr, px4, robot_localization

TARGETS = {
    target.name: target
    for target in (kalibr.TARGET, robot_localization.TARGET, px4.TARGET, ardupilot.TARGET)
}
