//! What is guessed of a bag by the types of its messages and the names of its topics.

use logs::guess::{BagGuess, Needed, Placed};
use logs::{Format, Topic};

use crate::by_motion::{NAMES, PUBLISHED, published, trials};

/// A topic whose fields have these values in all of 21 messages, 5 a second.
fn topic(name: &str, kind: &str, fields: &[(&str, f64)]) -> Topic {
    let row: Vec<f64> = fields.iter().map(|(_, value)| *value).collect();
    Topic {
        name: name.to_owned(),
        kind: kind.to_owned(),
        publishers: vec![0],
        fields: fields.iter().map(|(field, _)| (*field).to_owned()).collect(),
        rows: vec![row; 21],
        times: (0..21).map(|k| 100.0 + 0.2 * f64::from(k)).collect(),
        every: 1,
        messages: 21,
    }
}

/// Topic, field, channel and unit of all that is placed; and the channels that are missing.
fn guessed(format: Format, topics: &[Topic]) -> (Vec<[String; 4]>, Vec<String>) {
    let needed = [("n", "1/s"), ("delta", "rad")];
    let needed = needed.map(|(channel, unit)| Needed { channel: channel.to_owned(), unit: unit.to_owned() });
    let guess = BagGuess::of(format, &[topics.to_vec()], &needed).guess;
    let placed =
        guess.placed.iter().map(|own| [&own.topic, &own.column, &own.channel, &own.unit].map(String::clone));
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
    let guess = BagGuess::of(Format::Mcap, &[vec![plain, stamped]], &needed);
    let clocks: Vec<(&str, f64)> = guess.topics().iter().map(|own| (own.clock, own.step_s)).collect();
    assert_eq!(clocks, [("header.stamp", 0.2), ("log_time", 0.2)]);
    assert!((guess.length_s - 4.0).abs() < 1e-12);
}

/// Topics of types that nobody knows, with these columns: arrays, an attitude, messages of one value and noise, each on its own clock.
fn unknown(columns: &[Vec<f64>]) -> Vec<Topic> {
    let [t, psi] = [&columns[0], &columns[3]];
    let half = |f: fn(f64) -> f64| psi.iter().map(|psi| f(0.5 * psi)).collect::<Vec<f64>>();
    let still = vec![0.0; t.len()];
    let noise: Vec<f64> = (0..t.len()).map(|row| ((row * row) as f64).sin()).collect();
    let of = |name: &str, fields: &[(&str, &[f64])], every: usize, late: f64| {
        let rows = (0..t.len()).step_by(every);
        Topic {
            name: name.to_owned(),
            kind: "our_msgs/msg/Thing".to_owned(),
            publishers: vec![0],
            fields: fields.iter().map(|(field, _)| (*field).to_owned()).collect(),
            rows: rows.clone().map(|row| fields.iter().map(|(_, values)| values[row]).collect()).collect(),
            times: rows.clone().map(|row| 1e9 + t[row] + late).collect(),
            every: 1,
            messages: rows.count(),
        }
    };
    let step = t[1] - t[0];
    vec![
        of("/a", &[("data[0]", &columns[1]), ("data[1]", &noise), ("data[2]", &columns[2])], 1, 0.0),
        of(
            "/b",
            &[("k.w", &half(f64::cos)), ("k.x", &still), ("k.y", &still), ("k.z", &half(f64::sin))],
            1,
            0.0,
        ),
        of(
            "/c",
            &[("data[0]", &columns[4]), ("data[1]", &columns[5]), ("data[2]", &columns[6])],
            1,
            0.1 * step,
        ),
        of("/d", &[("data", &columns[7])], 2, 0.2 * step),
        of("/e", &[("data", &columns[8])], 2, 0.0),
        of("/f", &[("data", &noise)], 3, 0.0),
    ]
}

/// Where each of [`NAMES`] is.
const PLACES: [[&str; 2]; 9] = [
    ["", ""],
    ["/a", "data[0]"],
    ["/a", "data[2]"],
    ["/b", "k.w"],
    ["/c", "data[0]"],
    ["/c", "data[1]"],
    ["/c", "data[2]"],
    ["/d", "data"],
    ["/e", "data"],
];

/// How many channels of these recordings are sure, and how many others are listed; none is wrong.
fn counted(recordings: &[Vec<Vec<f64>>]) -> [usize; 2] {
    let topics: Vec<Vec<Topic>> = recordings.iter().map(|columns| unknown(columns)).collect();
    let needed = [("n", "1/s"), ("delta", "rad")];
    let needed = needed.map(|(channel, unit)| Needed { channel: channel.to_owned(), unit: unit.to_owned() });
    let guess = BagGuess::of(Format::Mcap, &topics, &needed).guess;
    let is = |own: &Placed| {
        let at = NAMES.iter().position(|name| *name == own.channel);
        at.is_some_and(|at| PLACES[at] == [&own.topic, &own.column])
    };
    for own in &guess.placed {
        assert!(is(own) && own.by_motion.is_some(), "{own:?}");
    }
    let listed = guess.asked.iter().filter(|asked| asked.choices.iter().any(|choice| is(&choice.placed)));
    [guess.placed.len(), listed.count()]
}

#[test]
fn law_fields_of_unknown_messages_are_found_by_motion_and_none_wrongly() {
    for seed in 0..6 {
        let [sure, listed] = counted(&trials(20 + seed, 4));
        assert!(sure >= 6 && sure + listed == 8, "{seed}: {sure}, {listed}");
    }
}

#[test]
fn oracle_fields_of_published_logs_are_found_by_motion_and_none_wrongly() {
    for set in &PUBLISHED {
        let Some((recordings, places)) = published(set) else { return };
        let of = |columns: &Vec<Vec<f64>>| places.iter().map(|at| columns[*at].clone()).collect();
        let [sure, listed] = counted(&recordings.iter().map(of).collect::<Vec<_>>());
        println!("{}: {sure} sure, {listed} listed of 8", set.0);
        assert!(sure >= 6 && sure + listed >= 7, "{}: {sure}, {listed}", set.0);
    }
}
