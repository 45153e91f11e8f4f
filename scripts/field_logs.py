#!/usr/bin/env python3
"""Writes fixtures/field: logs as three ships bring them from the field, of one known motion with known noise.

    pip install numpy mcap mcap-ros2-support
    python3 scripts/field_logs.py fixtures/field

- autopilot/: CSV with local times, decimal commas and attitudes as quaternions
- survey/:    NMEA 0183 of a receiver, a gyro, a rudder and a propeller; some sentences are damaged
- robot/:     an MCAP of ROS 2: odometry in CDR, actuators on their own clocks, one of them as JSON; and a bag of LZ4 chunks

The motion is known in closed form (`motion`), crates/cli/tests/ingest/field.rs has the same formulas. Messages are written by
mcap and mcap-ros2-support, so that reading them is checked against another implementation.
"""

import json
import sys
from datetime import datetime, timedelta, timezone
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as JsonWriter
from mcap_ros2.writer import Writer

SECONDS = 120.0
START = datetime(2025, 4, 11, 9, 8, 20, tzinfo=timezone.utc)
LATITUDE, LONGITUDE = 60.1, 24.9
# Standard deviations of the noise.
POSITION_M, ANGLE_RAD, SPEED_M_S, RATE_RAD_S = 0.01, 0.001, 0.02, 0.001


def motion(t):
    """Surge, sway [m/s] and yaw rate [rad/s]."""
    return 2.0 + 0.4 * np.sin(0.11 * t), 0.2 * np.sin(0.17 * t), 0.08 * np.cos(0.13 * t)


def heading(t):
    return 1.2 + 0.08 / 0.13 * np.sin(0.13 * t)


def rudder(t):
    return np.radians(15.0 * np.sin(0.13 * t + 0.4))


def revolutions(t):
    """1/s"""
    return 8.0 + np.sin(0.11 * t + 0.2)


def places():
    """North and east [m] every millisecond, integrated by the midpoint rule."""
    dt = 1e-3
    middle = np.arange(0.5 * dt, SECONDS + 1.0, dt)
    u, v, _ = motion(middle)
    psi = heading(middle)
    rates = np.stack([u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)])
    return np.concatenate([np.zeros((2, 1)), np.cumsum(rates, axis=1) * dt], axis=1)


PLACES = places()


def place(t):
    return PLACES[:, np.rint(np.asarray(t) * 1000).astype(int)]


def quaternion(yaw, roll):
    """w, x, y, z of a turn about the vertical by `yaw`, then about the forward axis by `roll`."""
    cz, sz, cx, sx = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(roll / 2), np.sin(roll / 2)
    return cz * cx, cz * sx, sz * sx, sz * cx


def autopilot(folder, random):
    t = np.arange(0.0, SECONDS, 0.1)
    u, v, r = motion(t)
    psi = heading(t) + ANGLE_RAD * random.standard_normal(t.size)
    q = quaternion(psi, 0.05 * np.sin(0.8 * t))
    u, v = (own + SPEED_M_S * random.standard_normal(t.size) for own in (u, v))
    r = np.degrees(r + RATE_RAD_S * random.standard_normal(t.size))
    zone = ZoneInfo("Europe/Helsinki")
    lines = ["Pilot 3.2", "Zeit;q_w;q_x;q_y;q_z;vorwaerts;seitwaerts;gier;ruder;drehzahl"]
    for k, own in enumerate(t):
        time = (START + timedelta(seconds=round(float(own), 1))).astimezone(zone)
        stamp = time.strftime("%d.%m.%Y %H:%M:%S.") + str(time.microsecond // 100000)
        values = [*(part[k] for part in q)]
        cells = [f"{value:.6f}" for value in values] + [f"{u[k]:.3f}", f"{v[k]:.3f}", f"{r[k]:.3f}"]
        cells += [f"{np.degrees(rudder(own)):.2f}", f"{60 * revolutions(own):.1f}"]
        lines.append(";".join([stamp, *(cell.replace(".", ",") for cell in cells)]))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pilot.csv").write_text("\n".join(lines) + "\n")


def sentence(body):
    checksum = 0
    for byte in body.encode():
        checksum ^= byte
    return f"${body}*{checksum:02X}"


def degrees_minutes(angle, digits):
    whole = int(abs(angle))
    return f"{whole:0{digits}d}{60 * (abs(angle) - whole):010.7f}"


def geographic(north, east):
    """Latitude and longitude [deg] on the ellipsoid of WGS 84 near the start, by its radii of curvature there."""
    a, e2 = 6378137.0, 6.69437999014e-3
    phi = np.radians(LATITUDE)
    w = np.sqrt(1 - e2 * np.sin(phi) ** 2)
    meridian, transverse = a * (1 - e2) / w**3, a / w
    return LATITUDE + np.degrees(north / meridian), LONGITUDE + np.degrees(east / (transverse * np.cos(phi)))


def survey(folder, random):
    lines = []
    for tenth in range(int(10 * SECONDS)):
        t = tenth / 10
        u, v, r = motion(t)
        psi = heading(t) + ANGLE_RAD * random.standard_normal()
        if tenth % 10 == 0:
            north, east = place(t) + POSITION_M * random.standard_normal(2)
            latitude, longitude = geographic(north, east)
            time = START + timedelta(seconds=t)
            clock = time.strftime("%H%M%S.00")
            where = f"{degrees_minutes(latitude, 2)},N,{degrees_minutes(longitude, 3)},E"
            course = np.degrees(heading(t) + np.arctan2(v, u)) % 360
            knots = np.hypot(u, v) * 3600 / 1852
            lines.append(sentence(f"GPRMC,{clock},A,{where},{knots:.2f},{course:.1f},{time:%d%m%y},,,A"))
            lines.append(sentence(f"GPGGA,{clock},{where},4,12,0.7,2.1,M,18.0,M,1.0,0001"))
            lines.append(sentence(f"GPVTG,{course:.1f},T,,M,{knots:.2f},N,{1.852 * knots:.2f},K,A"))
            lines.append(sentence(f"IIRPM,S,1,{60 * revolutions(t):.1f},100.0,A"))
        if tenth % 5 == 0:
            lines.append(sentence(f"IIRSA,{np.degrees(rudder(t)):.2f},A,,V"))
        lines.append(sentence(f"HEHDT,{np.degrees(psi) % 360:.3f},T"))
        rate = np.degrees(r + RATE_RAD_S * random.standard_normal()) * 60
        lines.append(sentence(f"HEROT,{rate:.2f},A"))
        if tenth % 300 == 7:
            lines.append(sentence("AIVDM,1,1,,A,0,0").replace("$", "!"))
        if tenth % 400 == 9:
            # Two bytes changed on a bad line.
            lines[-1] = lines[-1].replace("HEROT,", "HEROT#,")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "line.nmea").write_text("\r\n".join(lines) + "\r\n")


ODOMETRY = """\
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================================================================================
MSG: geometry_msgs/Pose
Point position
Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1
================================================================================
MSG: geometry_msgs/TwistWithCovariance
Twist twist
float64[36] covariance
================================================================================
MSG: geometry_msgs/Twist
Vector3 linear
Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""

JOINTS = """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def nanoseconds(t):
    return int(START.timestamp()) * 10**9 + int(round(t * 1e9))


def header(t):
    time = nanoseconds(t)
    return {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "odom"}


def odometry(t, random):
    """Of a robot: east, north, up; forward, port, up."""
    u, v, r = motion(t)
    north, east = place(t) + POSITION_M * random.standard_normal(2)
    w, x, y, z = quaternion(np.pi / 2 - heading(t) + ANGLE_RAD * random.standard_normal(), 0.05 * np.sin(0.8 * t))
    du, dv = SPEED_M_S * random.standard_normal(2)
    zeros = [0.0] * 36
    pose = {
        "position": {"x": float(east), "y": float(north), "z": 0.0},
        "orientation": {"x": float(x), "y": float(y), "z": float(z), "w": float(w)},
    }
    twist = {
        "linear": {"x": float(u + du), "y": float(-v - dv), "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": float(-r + RATE_RAD_S * random.standard_normal())},
    }
    return {
        "header": header(t),
        "child_frame_id": "base_link",
        "pose": {"pose": pose, "covariance": zeros},
        "twist": {"twist": twist, "covariance": zeros},
    }


def joints(t):
    return {
        "header": header(t),
        "name": ["port rudder", "rudder"],
        "position": [0.5, float(rudder(t))],
        "velocity": [],
        "effort": [],
    }


def robot(folder, random):
    folder.mkdir(parents=True, exist_ok=True)
    events = [(float(t), "/odometry") for t in np.arange(0.0, SECONDS, 0.1)]
    events += [(float(t), "/joints") for t in np.arange(0.035, SECONDS, 0.2)]
    events += [(float(t), "/propeller") for t in np.arange(0.5, SECONDS, 0.5)]
    with open(folder / "mission.mcap", "wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        inner = writer._writer
        own = writer.register_msgdef("nav_msgs/msg/Odometry", ODOMETRY)
        other = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        schema = inner.register_schema("propeller", "jsonschema", b'{"type": "object"}')
        channel = inner.register_channel("/propeller", "json", schema)
        image = inner.register_schema("sensor_msgs.Image", "protobuf", b"")
        camera = inner.register_channel("/camera", "protobuf", image)
        inner.add_message(camera, nanoseconds(0.0), b"\x0a", nanoseconds(0.0))
        for t, topic in sorted(events):
            # Messages are logged 4 ms after they happen.
            logged = nanoseconds(t + 0.004)
            if topic == "/odometry":
                writer.write_message(topic, own, odometry(t, random), logged, nanoseconds(t))
            elif topic == "/joints":
                writer.write_message(topic, other, joints(t), logged, nanoseconds(t))
            else:
                text = json.dumps({"shaft": [{"rps": round(float(revolutions(t)), 4)}]})
                inner.add_message(channel, logged, text.encode(), nanoseconds(t))
        writer.finish()
    with open(folder / "short-lz4.mcap", "wb") as stream:
        writer = JsonWriter(stream, compression=CompressionType.LZ4)
        writer.start()
        schema = writer.register_schema("speeds", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/speeds", "json", schema)
        for k in range(20):
            text = json.dumps({"u": 1.0 + 0.1 * k, "v": 0.0, "r": 0.01, "n": 60})
            writer.add_message(channel, nanoseconds(k), text.encode(), nanoseconds(k))
        writer.finish()


def main():
    folder = Path(sys.argv[1])
    for k, write in enumerate((autopilot, survey, robot)):
        write(folder / write.__name__, np.random.default_rng(k))


if __name__ == "__main__":
    main()
