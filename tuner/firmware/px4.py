"""PX4: a parameter file as QGroundControl loads it, for the EKF2.

Names, units and ends: PX4-Autopilot, src/modules/ekf2, module.yaml and params_*.yaml. Its
covariance.cpp adds (T sigma)^2 in a prediction of T = EKF2_PREDICT_US, so sigma = N / sqrt(T).
"""

from tuner.firmware.key import Key
from tuner.firmware.target import FileRequest, Target, Text, commented, head, how, keyed

_PREDICTION_S = 0.01
_REAL = 9  # MAVLink's MAV_PARAM_TYPE_REAL32

KEYS = (
    Key("EKF2_GYR_NOISE", "rad/s", "step", 1e-4, 0.1, "gyroscope_noise_density"),
    Key("EKF2_ACC_NOISE", "m/s^2", "step", 0.01, 1.0, "accelerometer_noise_density"),
    Key("EKF2_GYR_B_NOISE", "rad/s^2", "step", 0.0, 0.01, "gyroscope_random_walk"),
    Key("EKF2_ACC_B_NOISE", "m/s^3", "step", 0.0, 0.01, "accelerometer_random_walk"),
    Key("EKF2_BARO_NOISE", "m", "deviation", 0.01, 15.0),
    Key("EKF2_GPS_P_NOISE", "m", "deviation", 0.01, 10.0),
    Key("EKF2_RNG_NOISE", "m", "deviation", 0.01),
    Key("EKF2_GPS_V_NOISE", "m/s", "deviation", 0.01, 5.0),
    Key("EKF2_EAS_NOISE", "m/s", "deviation", 0.5, 5.0),
    Key("EKF2_HEAD_NOISE", "rad", "deviation", 0.01, 1.0),
    Key("EKF2_MAG_NOISE", "gauss", "deviation", 1e-3, 1.0),
    Key("EKF2_MAG_E_NOISE", "gauss/s", "step", 0.0, 0.1),
    Key("EKF2_MAG_B_NOISE", "gauss/s", "step", 0.0, 0.1),
    Key("EKF2_WIND_NSD", "m/s^2", "density", 0.0, 1.0),
)


def written(request: FileRequest) -> Text:
    """The file: a line for each parameter, with vehicle, component, name, value and type."""
    T = _PREDICTION_S if request.rate_hz is None else 1 / request.rate_hz
    found, notes = keyed(request, KEYS, T, "PX4")
    above = ["Onboard parameters for Vehicle 1", "", *head(request, "PX4", TARGET.filter, notes)]
    above += [f"At EKF2_PREDICT_US = {1e6 * T:.0f}.", *(line for s in found for line in how(s))]
    lines = commented([*above, "", "Vehicle-Id Component-Id Name Value Type"])
    lines += [f"1\t1\t{each.key.name}\t{each.value:.9g}\t{_REAL}" for each in found]
    return Text("\n".join([*lines, ""]), len(found), notes)


TARGET = Target("px4", "px4.params", "noises of PX4's EKF2", "PX4's EKF2", written)
