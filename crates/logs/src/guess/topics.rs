//! What is in a bag, by the types of its messages and the names of its topics: a proposal for a person to check.

use std::collections::BTreeSet;

use super::names::{Named, ROLES};
use super::{Needed, Placed, usual_unit};
use crate::plan::motion_unit;
use crate::{Format, Topic};

/// A topic with channels.
#[derive(Clone, Debug, PartialEq)]
pub struct TopicGuess {
    /// Its name.
    pub topic: String,
    /// The publisher that was taken, where there are several.
    pub publisher: Option<u32>,
    /// The column of its clock.
    pub clock: &'static str,
    /// What the clock counts, where it is an ordinary field.
    pub clock_unit: Option<&'static str>,
    /// Usual time between messages \[s\].
    pub step_s: f64,
    /// Fields of an attitude: w, x, y, z.
    pub quaternion: Option<[String; 4]>,
    /// Fields with their channels.
    pub placed: Vec<Placed>,
}

/// What is in a bag.
#[derive(Clone, Debug, PartialEq)]
pub struct BagGuess {
    /// The format of the file.
    pub format: Format,
    /// Topics with channels.
    pub topics: Vec<TopicGuess>,
    /// Topics without.
    pub unused: Vec<String>,
    /// Channels of the model without a field.
    pub missing: Vec<Needed>,
    /// How long it is \[s\].
    pub length_s: f64,
}

impl BagGuess {
    /// What the bag of `format` with `topics` is likely to have for a model with the channels `needed`.
    pub fn of(format: Format, topics: &[Topic], needed: &[Needed]) -> Self {
        let mut search = TopicSearch { format, topics, guesses: Vec::new(), placed: BTreeSet::new() };
        KNOWN.into_iter().for_each(|known| search.by_type(known));
        let motion = ROLES.iter().filter(|role| !role.is_optional).map(|role| (role.channel, role.unit));
        let wanted = needed.iter().map(|need| (need.channel.as_str(), need.unit.as_str()));
        motion.chain(wanted).for_each(|(channel, unit)| search.by_name(channel, unit));
        let is_missing = |need: &&Needed| !search.placed.contains(need.channel.as_str());
        let missing = needed.iter().filter(is_missing).cloned().collect();
        let unused = topics.iter().filter(|topic| search.guesses.iter().all(|used| used.topic != topic.name));
        let length_s = topics.iter().map(|topic| times(format, topic)[1]).fold(0.0, f64::max);
        Self {
            format,
            unused: unused.map(|topic| topic.name.clone()).collect(),
            topics: search.guesses,
            missing,
            length_s,
        }
    }
}

struct TopicSearch<'a> {
    format: Format,
    topics: &'a [Topic],
    guesses: Vec<TopicGuess>,
    /// Channels so far.
    placed: BTreeSet<String>,
}

impl TopicSearch<'_> {
    /// Places the `fields` and the `attitude` of the first topic whose messages are of a type.
    fn by_type(&mut self, (kind, fields, attitude): (&str, &[[&str; 2]], &str)) {
        let is_known = |topic: &&Topic| topic.kind.replace("/msg/", "/") == kind && topic.messages > 0;
        let Some(topic) = self.topics.iter().find(is_known) else { return };
        let quaternion = quaternion(attitude);
        if !attitude.is_empty() && has_turns(topic, &quaternion) && self.is_free("psi") {
            self.placed.insert("psi".to_owned());
            self.topic(topic).quaternion = Some(quaternion);
        }
        let is_of_body = values(topic, "velocity_frame").next() == Some(BODY);
        for [field, channel] in fields {
            let channel = match *channel {
                "v_x" if is_of_body => "y_u",
                "v_y" if is_of_body => "y_v",
                other => other,
            };
            if values(topic, field).next().is_some() && self.is_free(channel) {
                let placed = Placed {
                    column: (*field).to_owned(),
                    channel: channel.to_owned(),
                    unit: unit_of(channel).to_owned(),
                    ..Placed::default()
                };
                self.place(topic, placed);
            }
        }
    }

    /// Places the field whose name fits `channel` best.
    fn by_name(&mut self, channel: &str, unit: &str) {
        if !self.is_free(channel) {
            return;
        }
        let mut best: Option<(usize, &Topic, &String, Named)> = None;
        for topic in self.topics.iter().filter(|topic| !is_known(topic)) {
            for field in topic.fields.iter().filter(|field| !is_clock(field)) {
                let name = called(topic, field);
                let Some(likeness) = name.likeness(channel).filter(|_| name.measures(channel, unit)) else {
                    continue;
                };
                // Of two that fit alike the one that says its unit.
                let rank = 2 * likeness + usize::from(name.unit.is_none());
                let is_better = best.as_ref().is_none_or(|(known, ..)| rank < *known);
                if is_better && values(topic, field).next().is_some() {
                    best = Some((rank, topic, field, name));
                }
            }
        }
        let Some((_, topic, field, name)) = best else { return };
        let largest = values(topic, field).fold(0.0, |most: f64, value| most.max(value.abs()));
        let placed = Placed {
            column: field.clone(),
            channel: channel.to_owned(),
            unit: name.unit.unwrap_or_else(|| usual_unit(unit, largest)).to_owned(),
            is_channel_guessed: true,
            is_unit_guessed: name.unit.is_none(),
            ..Placed::default()
        };
        self.place(topic, placed);
    }

    /// Whether no channel with the same information is placed yet: positions, and velocities, are logged one way.
    fn is_free(&self, channel: &str) -> bool {
        const SAME: [[&str; 2]; 4] =
            [["x", "latitude_deg"], ["y", "longitude_deg"], ["y_u", "v_x"], ["y_v", "v_y"]];
        let same = SAME.iter().find(|pair| pair.contains(&channel));
        let all = same.map_or([channel, channel], |pair| *pair);
        all.iter().all(|name| !self.placed.contains(*name))
    }

    fn place(&mut self, topic: &Topic, placed: Placed) {
        self.placed.insert(placed.channel.clone());
        self.topic(topic).placed.push(placed);
    }

    /// The guess for `topic`, a new one at first.
    fn topic(&mut self, topic: &Topic) -> &mut TopicGuess {
        let at = self.guesses.iter().position(|guess| guess.topic == topic.name).unwrap_or_else(|| {
            self.guesses.push(begun(self.format, topic));
            self.guesses.len() - 1
        });
        &mut self.guesses[at]
    }
}

/// The `velocity_frame` of PX4 whose axes are the ship's.
const BODY: f64 = 3.0;

fn begun(format: Format, topic: &Topic) -> TopicGuess {
    let (clock, clock_unit) = match format {
        Format::Ulg => ("timestamp", Some("us")),
        _ if topic.fields.iter().any(|field| field == "header.stamp.sec") => ("header.stamp", None),
        _ => ("log_time", None),
    };
    let [step_s, _] = times(format, topic);
    let publisher = topic.publishers.first().copied().filter(|_| topic.publishers.len() > 1);
    TopicGuess {
        topic: topic.name.clone(),
        publisher,
        clock,
        clock_unit,
        step_s,
        quaternion: None,
        placed: vec![],
    }
}

/// Mean time between the messages of one publisher, and the time that all take \[s\].
fn times(format: Format, topic: &Topic) -> [f64; 2] {
    let steps = topic.messages.saturating_sub(1).max(1) as f64;
    let many = topic.publishers.len().max(1) as f64;
    let mut clock = values(topic, "timestamp").map(|us| 1e-6 * us);
    let span = match (format, clock.next(), clock.last()) {
        (Format::Ulg, Some(first), Some(last)) => {
            (last - first) * steps / topic.rows.len().saturating_sub(1).max(1) as f64
        }
        (Format::Ulg, ..) => 0.0,
        _ => topic.logged_s[1] - topic.logged_s[0],
    };
    [many * span / steps, span]
}

/// The finite values of a field in the first messages.
fn values<'a>(topic: &'a Topic, field: &str) -> impl Iterator<Item = f64> + 'a {
    let at = topic.fields.iter().position(|name| name == field);
    let rows = at.map(|at| topic.rows.iter().map(move |row| row[at]));
    rows.into_iter().flatten().filter(|value| value.is_finite())
}

/// Whether the fields are an attitude that was measured: elsewhere they are zeros, or no numbers.
fn has_turns(topic: &Topic, fields: &[String; 4]) -> bool {
    let squares = fields.each_ref().map(|field| values(topic, field).next().unwrap_or(f64::NAN).powi(2));
    (squares.iter().sum::<f64>() - 1.0).abs() < 0.05
}

fn is_known(topic: &Topic) -> bool {
    KNOWN.iter().any(|(kind, ..)| topic.kind.replace("/msg/", "/") == *kind)
}

/// A field as a column: a message of one value is called like its topic.
fn called(topic: &Topic, field: &str) -> Named {
    let name = topic.name.trim_start_matches('/');
    match field {
        "data" | "value" => Named::of(name),
        field => Named::of(&format!("{name}.{field}")),
    }
}

fn is_clock(field: &str) -> bool {
    field.starts_with("header.") || field.starts_with("timestamp")
}

/// Types of messages that tell a motion, the fullest first: their fields, each with its channel, and what the fields of their
/// attitude begin with. Those of ROS are in its axes, east, north, up; those of PX4 are north, east, down.
const KNOWN: [(&str, &[[&str; 2]], &str); 12] = [
    (
        "nav_msgs/Odometry",
        &[
            ["pose.pose.position.x", "x"],
            ["pose.pose.position.y", "y"],
            ["twist.twist.linear.x", "y_u"],
            ["twist.twist.linear.y", "y_v"],
            ["twist.twist.angular.z", "y_r"],
        ],
        "pose.pose.orientation",
    ),
    (
        "vehicle_odometry",
        &[
            ["position[0]", "x"],
            ["position[1]", "y"],
            ["velocity[0]", "v_x"],
            ["velocity[1]", "v_y"],
            ["angular_velocity[2]", "y_r"],
        ],
        "q",
    ),
    ("geometry_msgs/PoseStamped", &[["pose.position.x", "x"], ["pose.position.y", "y"]], "pose.orientation"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        &[["pose.pose.position.x", "x"], ["pose.pose.position.y", "y"]],
        "pose.pose.orientation",
    ),
    (
        "geometry_msgs/TwistStamped",
        &[["twist.linear.x", "y_u"], ["twist.linear.y", "y_v"], ["twist.angular.z", "y_r"]],
        "",
    ),
    (
        "geometry_msgs/TwistWithCovarianceStamped",
        &[["twist.twist.linear.x", "y_u"], ["twist.twist.linear.y", "y_v"], ["twist.twist.angular.z", "y_r"]],
        "",
    ),
    (
        "vehicle_local_position",
        &[["x", "x"], ["y", "y"], ["vx", "v_x"], ["vy", "v_y"], ["heading", "psi"]],
        "",
    ),
    ("vehicle_attitude", &[], "q"),
    ("vehicle_angular_velocity", &[["xyz[2]", "y_r"]], ""),
    ("sensor_msgs/Imu", &[["angular_velocity.z", "y_r"]], "orientation"),
    ("sensor_msgs/NavSatFix", &[["latitude", "latitude_deg"], ["longitude", "longitude_deg"]], ""),
    ("vehicle_global_position", &[["lat", "latitude_deg"], ["lon", "longitude_deg"]], ""),
];

/// The fields w, x, y, z of the attitude `name`: in ROS by letters, in PX4 by numbers.
fn quaternion(name: &str) -> [String; 4] {
    match name {
        "q" => [0, 1, 2, 3].map(|part| format!("q[{part}]")),
        name => ["w", "x", "y", "z"].map(|part| format!("{name}.{part}")),
    }
}

/// The unit of a channel of motion in messages.
fn unit_of(channel: &str) -> &'static str {
    match channel {
        "latitude_deg" | "longitude_deg" => "deg",
        channel => motion_unit(channel).unwrap_or("1"),
    }
}
