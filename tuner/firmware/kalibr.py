"""kalibr: the noise of an inertial sensor, ``imu.yaml``.

Keys: kalibr, IMU noise model; densities of continuous time, as they are found at rest.
"""

from tuner.firmware.key import Key
from tuner.firmware.target import (
    FileRequest,
    Target,
    Text,
    commented,
    head,
    how,
    keyed,
    yaml_number,
)

KEYS = tuple(
    Key(name, unit, "density", export=name)
    for name, unit in {
        "accelerometer_noise_density": "m/s^2",
        "accelerometer_random_walk": "m/s^3",
        "gyroscope_noise_density": "rad/s",
        "gyroscope_random_walk": "rad/s^2",
    }.items()
)


def written(request: FileRequest) -> Text:
    """The file; missing numbers are comments, for kalibr needs all of them."""
    found, notes = keyed(request, KEYS, 1.0, "kalibr")
    there = {each.key.name for each in found}
    missing = [key.name for key in KEYS if key.name not in there]
    rate = request.rate_hz or request.log_rate_hz
    if missing:
        notes += (f"kalibr needs {', '.join(missing)} too: fill it in",)
    if not rate:
        notes += ("the rate of the record is not known: give --rate HZ, or fill update_rate in",)
    lines = commented(head(request, "kalibr", "", notes))
    for each in found:
        lines += [*commented(how(each)), f"{each.key.name}: {yaml_number(each.value)}"]
    lines += [f"#{name}:" for name in missing]
    lines += [f"update_rate: {yaml_number(rate)}" if rate else "#update_rate:"]
    lines += ["# The topic that the sensor is on:", "#rostopic: /imu0"]
    return Text("\n".join([*lines, ""]), len(found), notes)


TARGET = Target(
    "kalibr", "imu.yaml", "noise densities of an IMU, for Kalibr and others", "", written
)
