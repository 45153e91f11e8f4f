#!/usr/bin/env python3
"""Writes the bags of fixtures/field: one known motion with known noise, in three formats of robots.

    pip install numpy mcap mcap-ros2-support rosbags pyulog
    python3 scripts/field_bags.py fixtures/field

- ros1/:  a bag of ROS 1, chunks in bz2: odometry, a rudder in degrees, a propeller in rpm; and a short bag of LZ4 chunks
- ros2/:  a bag of ROS 2 in SQLite, in two parts: pose, twist, a rudder, and a propeller in a message of its own; and a short
          bag without definitions, whose messages are compressed
- px4/:   a ULog: odometry of PX4, a rudder, a propeller in two instances

Motion and noise are those of field_logs.py. Bags are written by rosbags, the ULog by pyulog, so that reading them is
checked against other implementations.
"""

import shutil
import sqlite3
import struct
import sys
import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np
from field_logs import (
    ANGLE_RAD,
    POSITION_M,
    RATE_RAD_S,
    SECONDS,
    SPEED_M_S,
    heading,
    motion,
    nanoseconds,
    place,
    quaternion,
    revolutions,
    rudder,
)
from pyulog import ULog
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import CompressionFormat, CompressionMode
from rosbags.rosbag2 import Writer as Bag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# Times between messages [s].
ODOMETRY_S, RUDDER_S, PROPELLER_S = 0.2, 0.25, 0.5


def sampled(t, random):
    """North, east [m], heading [rad], surge, sway [m/s] and yaw rate [rad/s] with noise."""
    u, v, r = motion(t)
    north, east = place(t) + POSITION_M * random.standard_normal(2)
    psi = heading(t) + ANGLE_RAD * random.standard_normal()
    du, dv = SPEED_M_S * random.standard_normal(2)
    return north, east, psi, u + du, v + dv, r + RATE_RAD_S * random.standard_normal()


def times(step, first=0.0):
    return np.arange(first, SECONDS, step)


class Messages:
    """Messages of ROS from a store of types, in the axes of ROS: east, north, up; forward, port, up."""

    def __init__(self, store):
        self.store, self.types = store, store.types

    def header(self, t):
        stamp = self.types["builtin_interfaces/msg/Time"](*divmod(nanoseconds(t), 10**9))
        own = self.types["std_msgs/msg/Header"]
        return own(0, stamp, "odom") if "seq" in own.__dataclass_fields__ else own(stamp, "odom")

    def vector(self, x, y, z):
        return self.types["geometry_msgs/msg/Vector3"](float(x), float(y), float(z))

    def pose(self, sample):
        north, east, psi = sample[:3]
        w, x, y, z = quaternion(np.pi / 2 - psi, 0.0)
        point = self.types["geometry_msgs/msg/Point"](float(east), float(north), 0.0)
        turn = self.types["geometry_msgs/msg/Quaternion"](float(x), float(y), float(z), float(w))
        return self.types["geometry_msgs/msg/Pose"](point, turn)

    def twist(self, sample):
        u, v, r = sample[3:]
        return self.types["geometry_msgs/msg/Twist"](self.vector(u, -v, 0.0), self.vector(0.0, 0.0, -r))

    def odometry(self, t, sample):
        zeros = np.zeros(36)
        pose = self.types["geometry_msgs/msg/PoseWithCovariance"](self.pose(sample), zeros)
        twist = self.types["geometry_msgs/msg/TwistWithCovariance"](self.twist(sample), zeros)
        return self.types["nav_msgs/msg/Odometry"](self.header(t), "base_link", pose, twist)

    def pose_stamped(self, t, sample):
        return self.types["geometry_msgs/msg/PoseStamped"](self.header(t), self.pose(sample))

    def twist_stamped(self, t, sample):
        return self.types["geometry_msgs/msg/TwistStamped"](self.header(t), self.twist(sample))

    def number(self, value, bits=64):
        return self.types[f"std_msgs/msg/Float{bits}"](float(value))


def ros1(folder, random):
    folder.mkdir(parents=True, exist_ok=True)
    store = get_typestore(Stores.ROS1_NOETIC)
    own = Messages(store)
    topics = {
        "/odometry": ("nav_msgs/msg/Odometry", times(ODOMETRY_S)),
        "/rudder_deg": ("std_msgs/msg/Float64", times(RUDDER_S)),
        "/propeller_rpm": ("std_msgs/msg/Float64", times(PROPELLER_S)),
        "/diagnostics": ("std_msgs/msg/String", times(10.0)),
    }

    def message(topic, t):
        match topic:
            case "/odometry":
                return own.odometry(t, sampled(t, random))
            case "/rudder_deg":
                return own.number(np.degrees(rudder(t)))
            case "/propeller_rpm":
                return own.number(60 * revolutions(t))
            case _:
                return store.types["std_msgs/msg/String"]("all is well")

    for name, compression, seconds in [("mission.bag", "BZ2", SECONDS), ("short-lz4.bag", "LZ4", 10.0)]:
        (folder / name).unlink(missing_ok=True)
        bag = Bag1(folder / name)
        bag.set_compression(getattr(Bag1.CompressionFormat, compression))
        with bag:
            known = {
                topic: bag.add_connection(topic, kind, typestore=store, callerid=f"/node{topic}")
                for topic, (kind, _) in topics.items()
            }
            events = sorted((float(t), topic) for topic, (_, own) in topics.items() for t in own)
            for t, topic in events:
                if t < seconds:
                    data = store.serialize_ros1(message(topic, t), topics[topic][0])
                    bag.write(known[topic], nanoseconds(t), bytes(data))


SHAFT = "std_msgs/Header header\nfloat32[2] rps\n"


def bag2(folder, topics, message, version, store, compression=None):
    """Writes a bag, and returns its only file."""
    shutil.rmtree(folder, ignore_errors=True)
    bag = Bag2(folder, version=version)
    if compression is not None:
        bag.set_compression(compression, CompressionFormat.ZSTD)
    with bag:
        known = {
            topic: bag.add_connection(topic, kind, typestore=store) for topic, (kind, _) in topics.items()
        }
        for t, topic in sorted((float(t), topic) for topic, (_, own) in topics.items() for t in own):
            data = store.serialize_cdr(message(topic, t), topics[topic][0])
            bag.write(known[topic], nanoseconds(t), bytes(data))
    return next(folder.glob("*.db3*"))


def ros2(folder, random):
    folder.mkdir(parents=True, exist_ok=True)
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(SHAFT, "boat_msgs/msg/Shaft"))
    own = Messages(store)

    def message(topic, t):
        match topic:
            case "/pose":
                return own.pose_stamped(t, sampled(t, random))
            case "/twist":
                return own.twist_stamped(t, sampled(t, random))
            case "/rudder":
                return own.number(rudder(t))
            case _:
                shaft = store.types["boat_msgs/msg/Shaft"]
                return shaft(own.header(t), np.array([revolutions(t), 0.0], dtype=np.float32))

    kinds = {
        "/pose": ("geometry_msgs/msg/PoseStamped", ODOMETRY_S),
        "/twist": ("geometry_msgs/msg/TwistStamped", ODOMETRY_S),
        "/rudder": ("std_msgs/msg/Float64", RUDDER_S),
        "/propeller": ("boat_msgs/msg/Shaft", PROPELLER_S),
    }
    with tempfile.TemporaryDirectory() as beside:
        for part, (first, last) in enumerate([(0.0, 60.0), (60.0, SECONDS)]):
            within = {
                topic: (kind, [t for t in times(step) if first <= t < last]) for topic, (kind, step) in kinds.items()
            }
            made = bag2(Path(beside) / "mission", within, message, 9, store)
            shutil.copyfile(made, folder / f"mission_{part}.db3")
        names = "".join(f"  - mission_{part}.db3\n" for part in range(2))
        (folder / "metadata.yaml").write_text(
            "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: sqlite3\n  relative_file_paths:\n" + names
        )
        # Ten seconds, without definitions as in the first releases of ROS 2.
        few = {topic: (kind, [t for t in times(step) if t < 10.0]) for topic, (kind, step) in kinds.items()}
        made = bag2(Path(beside) / "short", few, message, 8, store, CompressionMode.MESSAGE)
        with closing(sqlite3.connect(made)) as database:
            database.execute("DROP TABLE message_definitions")
            database.execute("VACUUM")
        shutil.copyfile(made, folder / "short-bare.db3")


FORMATS = [
    "vehicle_odometry:uint64_t timestamp;uint64_t timestamp_sample;float[3] position;float[4] q;float[3] velocity;"
    "float[3] angular_velocity;uint8_t pose_frame;uint8_t velocity_frame;uint8_t[6] _padding0;",
    "rudder:uint64_t timestamp;float angle_rad;uint8_t[4] _padding0;",
    "propeller:uint64_t timestamp;float speed_rpm;bool is_on;uint8_t[3] _padding0;",
]
# The topics in the order of their numbers, with the number of the instance.
SUBSCRIBED = [("vehicle_odometry", 0), ("rudder", 0), ("propeller", 0), ("propeller", 1)]
# Frames of PX4: north, east, down, for positions and velocities.
NED = 1


def px4(folder, random):
    """In the axes of PX4: north, east, down; forward, starboard, down. Clocks count from the start of the autopilot."""
    folder.mkdir(parents=True, exist_ok=True)

    def own(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    def data(number, t, form, *values):
        return own("D", struct.pack("<HQ" + form, number, 5_000_000 + round(t * 1e6), *values))

    def odometry(t):
        north, east, psi, u, v, r = sampled(t, random)
        speeds = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
        values = [north, east, 0.0, *quaternion(psi, 0.0), *speeds, 0.0, 0.0, 0.0, r]
        return data(0, t, "Q13fBB", 4_990_000 + round(t * 1e6), *values, NED, NED)

    def propeller(t):
        return data(2, t, "f?", 60 * revolutions(t), True) + data(3, t, "f?", 0.0, False)

    kinds = [
        (times(ODOMETRY_S), odometry),
        (times(RUDDER_S), lambda t: data(1, t, "f", rudder(t))),
        (times(PROPELLER_S), propeller),
    ]
    log = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 5_000_000) + own("B", bytes(40))
    log += b"".join(own("F", text.encode()) for text in FORMATS)
    for number, (topic, instance) in enumerate(SUBSCRIBED):
        log += own("A", struct.pack("<BH", instance, number) + topic.encode())
    events = sorted((float(t), kind) for kind, (all, _) in enumerate(kinds) for t in all)
    log += b"".join(kinds[kind][1](t) for t, kind in events)
    with tempfile.NamedTemporaryFile(suffix=".ulg") as first:
        first.write(log)
        first.flush()
        ULog(first.name).write_ulog(str(folder / "mission.ulg"))


def main():
    folder = Path(sys.argv[1])
    for k, write in enumerate((ros1, ros2, px4)):
        write(folder / write.__name__, np.random.default_rng(10 + k))


if __name__ == "__main__":
    main()
