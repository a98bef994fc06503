"""ArduPilot: a parameter file as Mission Planner and MAVProxy load it, for the EKF3.

Names, units and ends: ArduPilot, libraries/AP_NavEKF3/AP_NavEKF3.cpp. Its covariance prediction
adds (T sigma)^2 in T = EKF_TARGET_DT, so sigma = N / sqrt(T).
"""

from tuner.firmware.key import Key
from tuner.firmware.target import FileRequest, Target, Text, commented, head, how, keyed

_PREDICTION_S = 0.012
_LEAST = "the least that is taken where the receiver reports its accuracy"

KEYS = (
    Key("EK3_GYRO_P_NSE", "rad/s", "step", 1e-4, 0.1, "gyroscope_noise_density"),
    Key("EK3_ACC_P_NSE", "m/s^2", "step", 0.01, 1.0, "accelerometer_noise_density"),
    Key("EK3_GBIAS_P_NSE", "rad/s^2", "step", 1e-5, 1e-3, "gyroscope_random_walk"),
    Key("EK3_ABIAS_P_NSE", "m/s^3", "step", 1e-5, 0.02, "accelerometer_random_walk"),
    Key("EK3_ALT_M_NSE", "m", "deviation", 0.01, 100.0),
    Key("EK3_POSNE_M_NSE", "m", "deviation", 0.1, 10.0),
    Key("EK3_RNG_M_NSE", "m", "deviation", 0.1, 10.0),
    Key("EK3_VELNE_M_NSE", "m/s", "deviation", 0.05, 5.0, note=_LEAST),
    Key("EK3_VELD_M_NSE", "m/s", "deviation", 0.05, 5.0, note=_LEAST),
    Key("EK3_EAS_M_NSE", "m/s", "deviation", 0.5, 5.0),
    Key("EK3_YAW_M_NSE", "rad", "deviation", 0.05, 1.0),
    Key("EK3_MAG_M_NSE", "gauss", "deviation", 0.01, 0.5),
    Key("EK3_MAGE_P_NSE", "gauss/s", "step", 1e-5, 0.01),
    Key("EK3_MAGB_P_NSE", "gauss/s", "step", 1e-5, 0.01),
    Key("EK3_WIND_P_NSE", "m/s^2", "step", 0.01, 2.0),
)


def written(request: FileRequest) -> Text:
    """The file: a line for each parameter, with name and value."""
    T = _PREDICTION_S if request.rate_hz is None else 1 / request.rate_hz
    found, notes = keyed(request, KEYS, T, "ArduPilot")
    lines = commented(head(request, "ArduPilot", TARGET.filter, notes))
    for each in found:
        lines += [*commented(how(each)), f"{each.key.name},{each.value:.9g}"]
    return Text("\n".join([*lines, ""]), len(found), notes)


TARGET = Target(
    "ardupilot", "ardupilot.param", "noises of ArduPilot's EKF3", "ArduPilot's EKF3", written
)
