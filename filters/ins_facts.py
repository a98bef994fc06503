"""Parameters, inputs, states and outputs of an INS filter, with their facts."""

from typing import Annotated, NamedTuple

from jax import Array

from filters.declared import Channel, Param, components
from filters.imu import WXYZ, XYZ

_LESS_GYR = "the gyroscopes are trusted longer, the attitude follows the aiding more slowly"
_LESS_ACC = "the accelerometers are trusted longer, the velocity follows the aiding more slowly"


class InsNoise(NamedTuple):
    """Parameters of the filter, single numbers throughout.

    Densities hold at any sample time; variances R are those of one sample. Deviations at the start
    and constants are not tuned unless a space says so.
    """

    q_gyr: Annotated[
        Array,
        Param(
            "rad^2/s",
            "density of the gyroscopes' white noise, with all that makes rates wrong at random",
            typical=1e-6,
            low=1e-12,
            high=1.0,
            smaller=_LESS_GYR,
            larger="the attitude follows the aiding faster, with its noise",
            sensor="gyroscope",
        ),
    ]
    q_acc: Annotated[
        Array,
        Param(
            "m^2/s^3",
            "density of the accelerometers' white noise, vibration included",
            typical=1e-2,
            low=1e-8,
            high=1e3,
            smaller=_LESS_ACC,
            larger="the velocity follows the aiding faster, with its noise",
            sensor="accelerometer",
        ),
    ]
    q_gyr_bias: Annotated[
        Array,
        Param(
            "rad^2/s^3",
            "density of the drift of the gyroscopes' bias",
            typical=1e-10,
            low=1e-16,
            high=1e-2,
            smaller="the bias settles",
            larger="the bias follows what looks like one",
            sensor="gyroscope bias",
        ),
    ]
    q_acc_bias: Annotated[
        Array,
        Param(
            "m^2/s^5",
            "density of the drift of the accelerometers' bias",
            typical=1e-6,
            low=1e-12,
            high=1e2,
            smaller="the bias settles",
            larger="the bias follows what looks like one",
            sensor="accelerometer bias",
        ),
    ]
    R_gps: Annotated[
        Array,
        Param(
            "m^2",
            "variance of a GPS position, each level axis",
            typical=4,
            low=1e-06,
            high=10000,
            smaller="the position follows it faster, with its noise",
            larger="the position leans more on the inertial sensors",
            channel="gps",
        ),
    ]
    R_gps_up: Annotated[
        Array,
        Param(
            "m^2",
            "variance of a GPS height",
            typical=9,
            low=1e-06,
            high=10000,
            smaller="the height follows it faster, with its noise",
            larger="the height leans more on the inertial sensors",
            channel="gps",
        ),
    ]
    R_gps_vel: Annotated[
        Array,
        Param(
            "m^2/s^2",
            "variance of a GPS velocity, each axis",
            typical=0.04,
            low=1e-08,
            high=10000,
            smaller="the velocity follows it faster, with its noise",
            larger="the velocity leans more on the inertial sensors",
            channel="gps_vel",
        ),
    ]
    R_baro: Annotated[
        Array,
        Param(
            "m^2",
            "variance of a barometric height",
            typical=0.25,
            low=1e-08,
            high=10000,
            smaller="the height follows it faster, with its noise",
            larger="the height leans more on the inertial sensors",
            channel="baro",
        ),
    ]
    R_speed: Annotated[
        Array,
        Param(
            "m^2/s^2",
            "variance of the speed along the sensor's x axis",
            typical=0.01,
            low=1e-08,
            high=10000,
            smaller="the velocity follows it faster, with its noise",
            larger="the velocity leans more on the inertial sensors",
            channel="speed",
        ),
    ]
    R_mag: Annotated[
        Array,
        Param(
            "rad^2",
            "variance of the direction of the field's level part",
            typical=0.01,
            low=1e-08,
            high=10,
            smaller="the heading follows it faster, with its noise",
            larger="the heading leans more on the inertial sensors",
            channel="mag",
        ),
    ]
    R_still: Annotated[
        Array,
        Param(
            "m^2/s^2",
            "variance of the velocity at rest, each axis",
            typical=0.0001,
            low=1e-10,
            high=1,
            smaller="the velocity follows it faster, with its noise",
            larger="the velocity leans more on the inertial sensors",
            channel="still",
        ),
    ]
    tilt0: Annotated[Array, Param("rad", "deviation of roll and pitch at the start", 0.05)]
    heading0: Annotated[Array, Param("rad", "deviation of the heading at the start", 0.2)]
    velocity0: Annotated[
        Array, Param("m/s", "deviation at the start of the velocity, which is taken for 0", 1.0)
    ]
    position0: Annotated[
        Array,
        Param(
            "m",
            "deviation at the start of the position, which is taken for 0; a first GPS position, "
            "or without GPS a first height, takes its place",
            10.0,
        ),
    ]
    gyr_bias0: Annotated[
        Array, Param("rad/s", "deviation at the start of the gyroscopes' bias", 0.01)
    ]
    acc_bias0: Annotated[
        Array, Param("m/s^2", "deviation at the start of the accelerometers' bias", 0.2)
    ]
    heading: Annotated[
        Array,
        Param("rad", "compass heading at the start, where no magnetometer says it", 0.0),
    ]
    declination: Annotated[
        Array, Param("rad", "by how much magnetic north is east of the frame's north", 0.0)
    ]
    gravity: Annotated[Array, Param("m/s^2", "gravity where it moves", 9.80665)]


class InsSample(NamedTuple):
    """One sample's inputs; stacked along time for :func:`filters.run`. NaN means missing.

    A missing part of a rate or a force keeps its last value. Aiding may be missing at any sample,
    or have no channel at all, which costs no time.
    """

    gyr: Annotated[Array, Channel("rad/s", "angular rate, mean since the last sample", XYZ)]
    acc: Annotated[Array, Channel("m/s^2", "specific force, mean since the last sample", XYZ)]
    gps: Annotated[Array | None, Channel("m", "position in the earth frame", XYZ)] = None
    gps_vel: Annotated[Array | None, Channel("m/s", "velocity in the earth frame", XYZ)] = None
    baro: Annotated[Array | None, Channel("m", "height over the frame's origin, up")] = None
    speed: Annotated[Array | None, Channel("m/s", "speed along the sensor's x axis")] = None
    mag: Annotated[
        Array | None, Channel("", "magnetic field in sensor axes, any unit, calibrated", XYZ)
    ] = None
    still: Annotated[
        Array | None, Channel("", "1 where the sensor is known to be at rest, else 0")
    ] = None


class InsOutputs(NamedTuple):
    """The outputs of the filter after a sample.

    Innovations stand in the order of :data:`filters.ins_aiding.AIDS`, ``(12,)``, each after the
    numbers before it were taken; innovation and variance are 0 where nothing was measured, and
    where a GPS position begins the position.
    """

    att: Annotated[Array, Channel("", "attitude, sensor to earth", WXYZ, "attitude")]
    velocity: Annotated[Array, Channel("m/s", "velocity in the earth frame", XYZ)]
    position: Annotated[Array, Channel("m", "position in the earth frame", XYZ)]
    gyr_bias: Annotated[Array, Channel("rad/s", "bias of the gyroscopes", XYZ)]
    acc_bias: Annotated[Array, Channel("m/s^2", "bias of the accelerometers", XYZ)]
    innovation: Annotated[Array, Channel("", "measured less predicted, (12,)", kind="detail")]
    variance: Annotated[Array, Channel("", "predicted variance of it, (12,)", kind="detail")]
    P: Annotated[Array, Channel("", "covariance of the errors, (15, 15)", kind="detail")]


STATES = (
    components("tilt", "rad", "error of the attitude, a rotation in the earth frame", XYZ)
    | components("gyr_bias", "rad/s", "error of the gyroscopes' bias", XYZ)
    | components("acc_bias", "m/s^2", "error of the accelerometers' bias", XYZ)
    | components("velocity", "m/s", "error of the velocity", XYZ)
    | components("position", "m", "error of the position", XYZ)
)
"""The errors, in their order."""
