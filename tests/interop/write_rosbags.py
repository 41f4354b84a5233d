"""Writes one data set as CSV and as bags of ROS 1 and ROS 2: `write_rosbags.py FOLDER`.

Each folder below it is a data package. The names of the bags' folders are the container and the compression. `mcap-lz4` is by
the package mcap, the others are by rosbags. `db3-humble` has the tables of a bag that Humble recorded, without definitions.
"""

import csv
import json
import math
import sqlite3
import sys
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

ROWS = 400
FIELDS = [
    ("time", "time", "s"),
    ("angular_velocity.z", "gyro_rate", "rad/s"),
    ("/table/twist.angular.z", "reference_rate", "rad/s"),
    ("orientation_covariance[4]", "auxiliary", "1"),
    ("header.stamp", "auxiliary", "s"),
    ("header.frame_id", "auxiliary", "1"),
    ("/joints/position[1]", "auxiliary", "rad"),
    ("/battery/data", "auxiliary", "1"),
]
START = 1_700_000_000_000_000_000
STEP = 10_000_000


def package(folder, path):
    folder.mkdir()
    fields = [
        {"name": name, "role": role, "unit": unit} | ({"type": "string"} if name.endswith("frame_id") else {})
        for name, role, unit in FIELDS
    ]
    dialect = {"dialect": {"group": "/imu"}} if not path.endswith("csv") else {}
    resource = {"name": "data", "path": path, "schema": {"fields": fields}} | dialect
    (folder / "datapackage.json").write_text(
        json.dumps({"name": "measured", "hil": {"kind": "series"}, "resources": [resource]})
    )
    return folder / path


def messages(store, is_ros_1):
    """Topic, time and message, in order of time, and the rows that they are."""
    types = store.types

    def header(time, frame):
        stamp = types["builtin_interfaces/msg/Time"](sec=time // 10**9, nanosec=time % 10**9)
        sequence = {"seq": 7} if is_ros_1 else {}
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **sequence)

    def vector(x=0.0, y=0.0, z=0.0):
        return types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)

    random = np.random.default_rng(1)
    for count in range(ROWS):
        time = START + count * STEP
        frame = "table" if count % 80 < 40 else "rest"
        rate = (0.3 if count % 160 < 80 else -0.3) + random.normal(0, 0.001)
        covariance = np.arange(9, dtype=np.float64) * count / 7
        zero = np.zeros(9)
        upright = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
        imu = types["sensor_msgs/msg/Imu"](
            header=header(time - 5_000, frame),
            orientation=upright,
            orientation_covariance=covariance,
            angular_velocity=vector(z=rate),
            angular_velocity_covariance=zero,
            linear_acceleration=vector(z=9.81),
            linear_acceleration_covariance=zero,
        )
        yield "/imu", time, imu
        twist = types["geometry_msgs/msg/Twist"](linear=vector(), angular=vector(z=rate / 1.01))
        yield "/table", time + 1_000_000, types["geometry_msgs/msg/TwistStamped"](header(time, ""), twist)
        joints = np.array([0.5, count * 0.25, -1.0][: count % 3 + 1])
        names = ["left", "the other", ""][: len(joints)]
        empty = np.array([], dtype=np.float64)
        joint_state = types["sensor_msgs/msg/JointState"]
        yield "/joints", time + 2_000_000, joint_state(header(time, "odd"), names, joints, empty, empty)
        battery = types["std_msgs/msg/Float32"](data=math.sin(count))
        yield "/battery", time + 3_000_000, battery
        # Nobody asks for it.
        image = types["sensor_msgs/msg/Image"](header(time, "eye"), 1, 3, "mono8", 0, 3, np.arange(3, dtype=np.uint8))
        yield "/image", time + 4_000_000, image


def rows(store):
    row = []
    for topic, time, message in messages(store, False):
        if topic == "/imu":
            stamp = message.header.stamp
            numbers = [message.angular_velocity.z, None, message.orientation_covariance[4]]
            row = [(time - START) / 1e9, *numbers, stamp.sec + stamp.nanosec / 1e9, message.header.frame_id]
        elif topic == "/table":
            row[2] = message.twist.angular.z
        elif topic == "/joints":
            row.append(message.position[1] if len(message.position) > 1 else "")
        elif topic == "/battery":
            yield [cell if isinstance(cell, str) else repr(float(cell)) for cell in [*row, np.float32(message.data)]]


def write(writer, store, is_ros_1):
    connections = {}
    for topic, time, message in messages(store, is_ros_1):
        name = message.__msgtype__
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, name, typestore=store)
        serialize = store.serialize_ros1 if is_ros_1 else store.serialize_cdr
        writer.write(connections[topic], time, serialize(message, name))


def write_lz4(path, store):
    with path.open("wb") as out:
        writer = McapWriter(out, chunk_size=20_000, compression=CompressionType.LZ4)
        writer.start("ros2")
        channels = {}
        for topic, time, message in messages(store, False):
            name = message.__msgtype__
            if topic not in channels:
                text, _ = store.generate_msgdef(name, ros_version=2)
                schema = writer.register_schema(name, "ros2msg", text.encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = bytes(store.serialize_cdr(message, name))
            writer.add_message(channels[topic], time, data, time)
        writer.finish()


top = Path(sys.argv[1])
ros1, ros2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)

with package(top / "csv", "data.csv").open("w", newline="") as out:
    writer = csv.writer(out)
    writer.writerow([name for name, _, _ in FIELDS])
    writer.writerows(rows(ros2))

for compression in ["none", "bz2", "lz4"]:
    writer = Writer1(package(top / f"bag-{compression}", "data.bag"))
    if compression != "none":
        writer.set_compression(Writer1.CompressionFormat[compression.upper()])
    with writer:
        write(writer, ros1, True)

for compression in ["none", "zstd"]:
    name = f"mcap-{compression}"
    target = package(top / name, "data.mcap")
    writer = Writer2(top / name / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
    if compression == "zstd":
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        write(writer, ros2, False)
    next((top / name / "bag").glob("*.mcap")).rename(target)

for compression in ["none", "zstd", "humble"]:
    name = f"db3-{compression}"
    target = package(top / name, "data.db3")
    writer = Writer2(top / name / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3)
    if compression == "zstd":
        writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with writer:
        write(writer, ros2, False)
    next((top / name / "bag").glob("*.db3")).rename(target)
    if compression == "humble":
        with sqlite3.connect(target) as bag:
            for table in ["schema", "metadata", "message_definitions"]:
                bag.execute(f"DROP TABLE {table}")
            bag.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
        bag.close()

write_lz4(package(top / "mcap-lz4", "data.mcap"), ros2)
