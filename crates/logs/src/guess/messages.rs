//! What is known of common messages: which of their fields is which channel.

/// Messages of a type.
pub(super) struct Known {
    /// Its name.
    pub(super) kind: &'static str,
    /// Field, channel, unit.
    pub(super) fields: &'static [(&'static str, &'static str, &'static str)],
    /// Fields of an attitude: w, x, y, z.
    pub(super) quaternion: Option<[&'static str; 4]>,
}

const fn known(
    kind: &'static str,
    fields: &'static [(&'static str, &'static str, &'static str)],
    quaternion: Option<[&'static str; 4]>,
) -> Known {
    Known { kind, fields, quaternion }
}

/// Those that tell a motion, the fullest first. Those of ROS are in its axes, east, north, up; those of PX4 are
/// north, east, down.
pub(super) const KNOWN: &[Known] = &[
    known(
        "nav_msgs/Odometry",
        &[
            ("pose.pose.position.x", "x", "m"),
            ("pose.pose.position.y", "y", "m"),
            ("twist.twist.linear.x", "y_u", "m/s"),
            ("twist.twist.linear.y", "y_v", "m/s"),
            ("twist.twist.angular.z", "y_r", "rad/s"),
        ],
        Some([
            "pose.pose.orientation.w",
            "pose.pose.orientation.x",
            "pose.pose.orientation.y",
            "pose.pose.orientation.z",
        ]),
    ),
    known(
        "vehicle_odometry",
        &[
            ("position[0]", "x", "m"),
            ("position[1]", "y", "m"),
            ("velocity[0]", "v_x", "m/s"),
            ("velocity[1]", "v_y", "m/s"),
            ("angular_velocity[2]", "y_r", "rad/s"),
        ],
        Some(["q[0]", "q[1]", "q[2]", "q[3]"]),
    ),
    known(
        "geometry_msgs/PoseStamped",
        &[("pose.position.x", "x", "m"), ("pose.position.y", "y", "m")],
        Some(["pose.orientation.w", "pose.orientation.x", "pose.orientation.y", "pose.orientation.z"]),
    ),
    known(
        "geometry_msgs/PoseWithCovarianceStamped",
        &[("pose.pose.position.x", "x", "m"), ("pose.pose.position.y", "y", "m")],
        Some([
            "pose.pose.orientation.w",
            "pose.pose.orientation.x",
            "pose.pose.orientation.y",
            "pose.pose.orientation.z",
        ]),
    ),
    known(
        "geometry_msgs/TwistStamped",
        &[
            ("twist.linear.x", "y_u", "m/s"),
            ("twist.linear.y", "y_v", "m/s"),
            ("twist.angular.z", "y_r", "rad/s"),
        ],
        None,
    ),
    known(
        "geometry_msgs/TwistWithCovarianceStamped",
        &[
            ("twist.twist.linear.x", "y_u", "m/s"),
            ("twist.twist.linear.y", "y_v", "m/s"),
            ("twist.twist.angular.z", "y_r", "rad/s"),
        ],
        None,
    ),
    known(
        "vehicle_local_position",
        &[
            ("x", "x", "m"),
            ("y", "y", "m"),
            ("vx", "v_x", "m/s"),
            ("vy", "v_y", "m/s"),
            ("heading", "psi", "rad"),
        ],
        None,
    ),
    known("vehicle_attitude", &[], Some(["q[0]", "q[1]", "q[2]", "q[3]"])),
    known("vehicle_angular_velocity", &[("xyz[2]", "y_r", "rad/s")], None),
    known(
        "sensor_msgs/Imu",
        &[("angular_velocity.z", "y_r", "rad/s")],
        Some(["orientation.w", "orientation.x", "orientation.y", "orientation.z"]),
    ),
    known(
        "sensor_msgs/NavSatFix",
        &[("latitude", "latitude_deg", "deg"), ("longitude", "longitude_deg", "deg")],
        None,
    ),
    known(
        "vehicle_global_position",
        &[("lat", "latitude_deg", "deg"), ("lon", "longitude_deg", "deg")],
        None,
    ),
];
