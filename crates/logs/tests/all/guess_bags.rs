//! What is guessed of a bag by the types of its messages and the names of its topics.

use logs::guess::{BagGuess, Needed};
use logs::{Format, Topic};

/// A topic whose fields have these values in all of 21 messages, 5 a second.
fn topic(name: &str, kind: &str, fields: &[(&str, f64)]) -> Topic {
    let row: Vec<f64> = fields.iter().map(|(_, value)| *value).collect();
    Topic {
        name: name.to_owned(),
        kind: kind.to_owned(),
        publishers: vec![0],
        fields: fields.iter().map(|(field, _)| (*field).to_owned()).collect(),
        rows: vec![row; 21],
        logged_s: [100.0, 104.0],
        messages: 21,
    }
}

/// Topic, field, channel and unit of all that is placed; and the channels that are missing.
fn guessed(format: Format, topics: &[Topic]) -> (Vec<[String; 4]>, Vec<String>) {
    let needed = [("n", "1/s"), ("delta", "rad")];
    let needed = needed.map(|(channel, unit)| Needed { channel: channel.to_owned(), unit: unit.to_owned() });
    let guess = BagGuess::of(format, topics, &needed);
    let placed = guess.topics.iter().flat_map(|topic| {
        let own = topic.placed.iter();
        own.map(|own| [&topic.topic, &own.column, &own.channel, &own.unit].map(String::clone))
    });
    (placed.collect(), guess.missing.into_iter().map(|own| own.channel).collect())
}

fn texts(rows: &[[&str; 4]]) -> Vec<[String; 4]> {
    rows.iter().map(|row| row.map(str::to_owned)).collect()
}

#[test]
fn law_motions_are_known_by_their_types_and_actuators_by_their_names() {
    let imu = topic(
        "/imu",
        "sensor_msgs/msg/Imu",
        &[("header.stamp.sec", 1.0), ("orientation.w", 0.0), ("angular_velocity.z", 0.1)],
    );
    let fix = topic(
        "/fix",
        "sensor_msgs/msg/NavSatFix",
        &[("latitude", 60.1), ("longitude", 24.9), ("altitude", 0.0)],
    );
    let command = topic("/cmd/rudder", "std_msgs/msg/Float64", &[("data", 10.0)]);
    let rudder = topic("/rudder", "std_msgs/msg/Float64", &[("data", 12.0)]);
    let shaft =
        topic("/engine", "a/msg/Engine", &[("header.stamp.sec", 1.0), ("load", 0.5), ("shaft_rps", 8.0)]);
    let (placed, missing) = guessed(Format::Bag, &[command, shaft, fix, imu, rudder]);
    let expected = texts(&[
        ["/imu", "angular_velocity.z", "y_r", "rad/s"],
        ["/fix", "latitude", "latitude_deg", "deg"],
        ["/fix", "longitude", "longitude_deg", "deg"],
        ["/engine", "shaft_rps", "n", "rps"],
        // Beyond a turn in radians; what it did, not what was commanded.
        ["/rudder", "data", "delta", "deg"],
    ]);
    assert_eq!((placed, missing), (expected, vec![]));
}

#[test]
fn velocities_of_px4_are_along_the_axes_that_it_says() {
    for (frame, channels) in [(1.0, ["v_x", "v_y"]), (3.0, ["y_u", "y_v"])] {
        let fields =
            [("timestamp", 1e6), ("velocity[0]", 2.0), ("velocity[1]", 0.1), ("velocity_frame", frame)];
        let setpoint = topic("rudder_setpoint", "rudder_setpoint", &[("timestamp", 1e6), ("angle_deg", 5.0)]);
        let (placed, missing) =
            guessed(Format::Ulg, &[topic("vehicle_odometry", "vehicle_odometry", &fields), setpoint]);
        let expected = texts(&[
            ["vehicle_odometry", "velocity[0]", channels[0], "m/s"],
            ["vehicle_odometry", "velocity[1]", channels[1], "m/s"],
        ]);
        // What was ordered is not what the rudder did.
        assert_eq!((placed, missing), (expected, ["n", "delta"].map(str::to_owned).to_vec()));
    }
}

#[test]
fn formats_are_known_by_their_endings_in_any_case() {
    for (name, format) in [
        ("a.bag", Format::Bag),
        ("A.BAG", Format::Bag),
        ("b/a_0.db3", Format::Db3),
        ("a.ulg.gz", Format::Ulg),
        ("a.bag.active", Format::Bag),
        ("*.bag*", Format::Bag),
        ("a.mcap", Format::Mcap),
        ("a.txt", Format::Csv),
        ("bag", Format::Csv),
    ] {
        assert_eq!((Format::of(name), format.is_bag()), (format, format != Format::Csv), "{name}");
    }
}

#[test]
fn a_clock_is_the_stamp_where_messages_have_one() {
    let speeds = [("twist.linear.x", 2.0), ("twist.linear.y", 0.1), ("twist.angular.z", 0.0)];
    let stamped =
        topic("/twist", "geometry_msgs/TwistStamped", &[&[("header.stamp.sec", 1.0)], &speeds[..]].concat());
    let plain = topic("/shaft_rpm", "std_msgs/Float32", &[("data", 100.0)]);
    let needed = [Needed { channel: "n".to_owned(), unit: "1/s".to_owned() }];
    let guess = BagGuess::of(Format::Mcap, &[plain, stamped], &needed);
    let clocks: Vec<(&str, f64)> = guess.topics.iter().map(|own| (own.clock, own.step_s)).collect();
    assert_eq!(clocks, [("header.stamp", 0.2), ("log_time", 0.2)]);
    assert!((guess.length_s - 4.0).abs() < 1e-12);
}
