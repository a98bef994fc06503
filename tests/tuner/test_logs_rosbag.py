import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.logs.formats import open_table
from tuner.data.reading import read_record

pytest.importorskip("rosbags")
START, STEP, LATE = 1_700_000_000_123_456_789, 5_000_000, 1_500_000
SAMPLES = 60


def messages(store, ros1, stamped):
    """An IMU's messages with the time at which each was received."""
    kinds = store.types
    zeros, vector = np.zeros(9), kinds["geometry_msgs/msg/Vector3"]
    for k in range(SAMPLES):
        stamp = divmod(START + k * STEP if stamped else 0, 10**9)
        head = [k] * ros1 + [kinds["builtin_interfaces/msg/Time"](*stamp), "imu"]
        yield (
            START + k * STEP + LATE,
            kinds["sensor_msgs/msg/Imu"](
                kinds["std_msgs/msg/Header"](*head),
                kinds["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
                np.arange(9.0),
                vector(0.1 * k, 0.2, 0.3),
                zeros,
                vector(0.0, 0.0, 9.81),
                zeros,
            ),
        )


def write(path, kind, stamped=True):
    """A bag with an IMU at 200 Hz, and a number at 20 Hz without a header."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    ros1 = kind.startswith("bag")
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    if ros1:
        writer = rosbag1.Writer(path / "log.bag")
        if kind == "bag-lz4":
            writer.set_compression(rosbag1.Writer.CompressionFormat.LZ4)
    else:
        plugin = rosbag2.StoragePlugin.MCAP if "mcap" in kind else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path / "log", version=9, storage_plugin=plugin)
        if kind == "mcap-zstd":
            zstd = rosbag2.CompressionFormat.ZSTD
            writer.set_compression(rosbag2.CompressionMode.STORAGE, zstd)
    written = store.serialize_ros1 if ros1 else store.serialize_cdr
    number = store.types["std_msgs/msg/Float64"]
    with writer:
        imu = writer.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        height = writer.add_connection("/height", "std_msgs/msg/Float64", typestore=store)
        for k, (time, message) in enumerate(messages(store, ros1, stamped)):
            writer.write(imu, time, written(message, "sensor_msgs/msg/Imu"))
            if k % 10 == 0:
                writer.write(height, time, written(number(float(k)), "std_msgs/msg/Float64"))
    if ros1:
        return path / "log.bag"
    return next(file for file in (path / "log").iterdir() if file.suffix != ".yaml")


@pytest.mark.parametrize("kind", ["bag", "bag-lz4", "db3", "mcap", "mcap-zstd"])
def test_bags_of_all_kinds(tmp_path, kind):
    path = write(tmp_path, kind)
    record = read_record(path, ["omega=/imu/data.angular_velocity.x", "z=/height.data:m"])
    omega, z = record.channels["omega"], record.channels["z"]
    np.testing.assert_allclose(omega.values, 0.1 * np.arange(SAMPLES))
    np.testing.assert_array_equal(z.values, 10.0 * np.arange(6))
    assert omega.unit == "rad/s"
    assert (omega.rate_hz, z.rate_hz) == pytest.approx((200.0, 20.0), rel=1e-12)
    assert omega.clock.source == "column '/imu/data.header.stamp'"
    assert z.times[0] - omega.times[0] == pytest.approx(LATE * 1e-9)
    assert any("--time receive_time takes the recorder's" in note for note in record.notes)


def test_the_recorders_time_and_arrays(tmp_path):
    path = write(tmp_path, "mcap")
    maps = ["P=/imu/data.orientation_covariance[8]"]
    record = read_record(path, maps, time="receive_time:ns")
    assert record.channels["P"].clock.source == "column '/imu/data.receive_time'"
    np.testing.assert_array_equal(record.channels["P"].values, 8.0)


def test_a_folder_is_a_bag_too(tmp_path):
    folder = write(tmp_path, "db3").parent
    table = open_table(folder)
    assert table.format == "ROS 2 bag"
    record = read_record(folder, ["z=/height.data:m"])
    assert (record.sources[0].name, len(record.sources[0].sha256)) == ("log", 64)


def test_stamps_that_nobody_set(tmp_path):
    record = read_record(write(tmp_path, "bag", stamped=False), ["a=/imu/data.angular_velocity.y"])
    assert record.channels["a"].clock.source == "column '/imu/data.receive_time'"
    assert any("its header stamps do not rise" in note for note in record.notes)


def test_other_systems_and_packed_files(tmp_path):
    path = tmp_path / "log.mcap"
    header = b"\x04\0\0\0ros1\0\0\0\0"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + len(header).to_bytes(8, "little") + header)
    assert "profile 'ros1'" in refusal(path, ["x=y"])
    path.write_bytes(b"\x28\xb5\x2f\xfd" + bytes(60))
    assert "compressed by zstd" in refusal(path, ["x=y"])


@pytest.mark.parametrize("name", ["a-b", 'x"+str(1)+"', "", "a\nint32 b", "9", "é"])
def test_names_of_types_are_names(name):
    from tuner.data.logs.error import LogError
    from tuner.data.logs.rosbag_types import check_names

    check_names(["sensor_msgs/msg/Imu", "x", "a_1"])
    with pytest.raises(LogError, match="which is none"):
        check_names([name])
