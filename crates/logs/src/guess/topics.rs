//! What is in a bag: by the types of its messages, by motion, and by names: a proposal for a person to check.

use super::names::Named;
use super::tables::{Guess, TableSearch, is_called};
use super::{MOST, Needed, Placed, SAME};
use crate::by_motion::{FoundChannel, FoundMotion, LoggedTable, ROWS, motion_of};
use crate::plan::motion_unit;
use crate::{Format, Topic, factor};

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
    /// Fields with their channels, and what is asked; the columns of attitudes are in the unit [`ATTITUDE`].
    pub guess: Guess,
    /// All topics, without their channels.
    known: Vec<TopicGuess>,
    /// How long it is \[s\].
    pub length_s: f64,
}

/// The unit of a column that stands for four fields.
pub const ATTITUDE: &str = "quaternion";

impl BagGuess {
    /// What bags of `format` with the topics of `recordings` are likely to have for a model with the channels `needed`.
    pub fn of(format: Format, recordings: &[Vec<Topic>], needed: &[Needed]) -> Self {
        let topics = recordings.first().map_or(&[][..], Vec::as_slice);
        let mut typed: Vec<Placed> = Vec::new();
        KNOWN.into_iter().for_each(|known| by_type(topics, known, &mut typed));
        let columns = BagColumn::all(topics, &typed, needed);
        let names: Vec<Named> = columns.iter().map(|column| column.name.clone()).collect();
        let fits =
            |at: usize, unit: &str| names[at].unit.is_none_or(|entry| factor(entry, unit) == Some(1.0));
        let looked: Vec<usize> =
            (0..columns.len().min(MOST)).filter(|at| columns[*at].rank < STILL).collect();
        let moved = match table(recordings, topics, &columns[..looked.len()]) {
            Some((table, time)) => motion_of(&table, &time, &looked, &fits),
            None => FoundMotion::default(),
        };
        let place = |placed: &Placed| {
            let is = |column: &BagColumn| {
                topics[column.topic].name == placed.topic && column.column == placed.column
            };
            Some((placed.channel.clone(), columns.iter().position(is)?))
        };
        let typed_at: Vec<(String, usize)> = typed.iter().filter_map(place).collect();
        let differs = |entry: &FoundChannel| {
            let of = |(channel, at): &(String, usize)| {
                let is_near = *at == entry.column || entry.rivals.iter().any(|(rival, _)| rival == at);
                channel == entry.channel && (!is_near || entry.sign < 0.0)
            };
            typed_at.iter().any(of)
        };
        let is_doubted = moved.channels.iter().any(differs);
        let mut search = TableSearch {
            columns: columns
                .iter()
                .map(|column| [topics[column.topic].name.clone(), column.column.clone()])
                .collect(),
            names: names.clone(),
            needed,
            is_doubted,
            largest: columns.iter().map(|column| column.largest(&topics[column.topic])).collect(),
            free: columns
                .iter()
                .map(|column| column.rank != TYPED && !is_known(&topics[column.topic]))
                .collect(),
            found: moved,
            typed: typed_at,
            placed: typed,
            ..TableSearch::default()
        };
        search.all();
        let TableSearch { found, mut placed, mut asked, missing, typed, .. } = search;
        let all = placed.iter_mut().chain(
            asked
                .iter_mut()
                .flat_map(|question| question.choices.iter_mut().map(|choice| &mut choice.placed)),
        );
        for entry in all.filter(|entry| !typed.iter().any(|(channel, _)| *channel == entry.channel)) {
            entry.is_channel_guessed = true;
        }
        let attitudes: Vec<(&str, &str)> = columns
            .iter()
            .filter(|column| column.fields.len() > 1)
            .map(|column| (topics[column.topic].name.as_str(), column.column.as_str()))
            .collect();
        let all = placed.iter_mut().chain(
            asked
                .iter_mut()
                .flat_map(|question| question.choices.iter_mut().map(|choice| &mut choice.placed)),
        );
        for entry in all.filter(|entry| attitudes.contains(&(&entry.topic, &entry.column))) {
            entry.unit = ATTITUDE.to_owned();
        }
        // Where the axes of messages are not known by their types, headings beside latitudes tell them.
        let on_earth = |channel: &str| channel.ends_with("tude_deg");
        let tells = found.is_known && found.channels.iter().any(|entry| on_earth(entry.channel));
        let is_east = match tells && typed.iter().all(|(channel, _)| on_earth(channel)) {
            true => found.is_east,
            false => format != Format::Ulg,
        };
        let known: Vec<TopicGuess> = topics.iter().map(|topic| begun(format, topic)).collect();
        let length_s = topics.iter().map(span_s).fold(0.0, f64::max);
        let (unplaced, is_numbered) = (Vec::new(), false);
        let guess = Guess { clock: None, placed, asked, unplaced, missing, is_east, is_numbered };
        Self { format, guess, known, length_s }
    }

    /// The topics with channels, in the order in which these were placed.
    pub fn topics(&self) -> Vec<TopicGuess> {
        let mut all: Vec<TopicGuess> = Vec::new();
        for placed in &self.guess.placed {
            let at = all.iter().position(|topic| topic.topic == placed.topic).or_else(|| {
                all.push(self.known.iter().find(|topic| topic.topic == placed.topic)?.clone());
                Some(all.len() - 1)
            });
            match at {
                Some(at) if placed.unit == ATTITUDE => all[at].quaternion = quaternion(&placed.column),
                Some(at) => all[at].placed.push(placed.clone()),
                None => {}
            }
        }
        all
    }

    /// Topics without channels.
    pub fn unused(&self) -> impl Iterator<Item = &str> {
        let is_used =
            |topic: &&TopicGuess| self.guess.placed.iter().any(|placed| placed.topic == topic.topic);
        self.known.iter().filter(move |topic| !is_used(topic)).map(|topic| topic.topic.as_str())
    }
}

/// Ranks of columns: of a known type, called like a channel, others, and those that stand still.
const TYPED: usize = 0;
const CALLED: usize = 1;
const OTHER: usize = 2;
const STILL: usize = 3;

/// A field of a topic, or an attitude.
struct BagColumn {
    topic: usize,
    /// The fields, one or those of an attitude.
    fields: Vec<usize>,
    column: String,
    name: Named,
    rank: usize,
}

impl BagColumn {
    /// The columns of `topics`, the likeliest first.
    fn all(topics: &[Topic], typed: &[Placed], needed: &[Needed]) -> Vec<Self> {
        let mut all = Vec::new();
        for (topic, listed) in topics.iter().enumerate() {
            let names = listed.fields.iter().map(String::as_str);
            let attitudes: Vec<(&str, Vec<usize>)> =
                names.filter_map(|first| Some((first, attitude(listed, first)?))).collect();
            let is_part = |at: &usize| attitudes.iter().any(|(_, parts)| parts.contains(at));
            let fields = (0..listed.fields.len()).filter(|at| !is_clock(&listed.fields[*at]) && !is_part(at));
            let fields: Vec<(&str, Vec<usize>)> =
                fields.map(|at| (listed.fields[at].as_str(), vec![at])).collect();
            for (column, fields) in attitudes.iter().cloned().chain(fields) {
                let placed =
                    typed.iter().find(|placed| placed.topic == listed.name && placed.column == column);
                // Beside what a type says there are covariances and the like.
                let mut name = if is_known(listed) { Named::of("") } else { called(listed, column) };
                if let Some(placed) = placed {
                    name.unit = Some(unit_of(&placed.channel));
                } else if fields.len() > 1 {
                    name.unit = Some("rad");
                } else if is_known(listed) {
                    continue;
                }
                let mut column = Self { topic, fields, column: column.to_owned(), name, rank: TYPED };
                let mut values = column.values(listed).into_iter().filter(|value| value.is_finite());
                let Some(first) = values.next() else { continue };
                column.rank = match placed {
                    _ if values.all(|value| value == first) => STILL,
                    Some(_) => TYPED,
                    None if is_called(&column.name, needed) => CALLED,
                    None => OTHER,
                };
                all.push(column);
            }
        }
        all.sort_by_key(|column| column.rank);
        all
    }

    /// The values in the rows of `topic`; of an attitude the heading \[rad\].
    fn values(&self, topic: &Topic) -> Vec<f64> {
        let of = |row: &Vec<f64>| match self.fields[..] {
            [w, x, y, z] => {
                let [w, x, y, z] = [w, x, y, z].map(|at| row[at]);
                libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
            }
            _ => row[self.fields[0]],
        };
        topic.rows.iter().map(of).collect()
    }

    /// The largest modulus, and whether a value is below zero.
    fn largest(&self, topic: &Topic) -> (f64, bool) {
        let values = self.values(topic).into_iter().filter(|value| value.is_finite());
        values.fold((0.0, false), |(most, has), value| (value.abs().max(most), has || value < 0.0))
    }
}

/// Fewer rows of a recording tell nothing.
const FEWEST: usize = 20;

/// The columns of all recordings on one clock each, and its times.
fn table(
    recordings: &[Vec<Topic>],
    topics: &[Topic],
    columns: &[BagColumn],
) -> Option<(LoggedTable, Vec<f64>)> {
    let mut all: Vec<(usize, Vec<Vec<f64>>)> = Vec::new();
    for recording in recordings {
        let of = |column: &BagColumn| {
            let first = &topics[column.topic];
            recording.iter().find(|topic| topic.name == first.name && topic.fields == first.fields)
        };
        let listed: Vec<Option<&Topic>> = columns.iter().map(of).collect();
        let spans = listed.iter().flatten().map(|topic| span_s(topic));
        let half_s = 0.5 * spans.fold(0.0, f64::max);
        let listed: Vec<Option<&Topic>> = listed
            .into_iter()
            .map(|topic| topic.filter(|topic| topic.rows.len() > 1 && span_s(topic) > half_s))
            .collect();
        let ends = |topic: &&Topic| (topic.times[0], topic.times[topic.times.len() - 1]);
        let used = || listed.iter().flatten().copied();
        let from = used().map(|topic| ends(&topic).0).fold(f64::NEG_INFINITY, f64::max);
        let until = used().map(|topic| ends(&topic).1).fold(f64::INFINITY, f64::min);
        let step = |topic: &Topic| span_s(topic) / (topic.rows.len() - 1) as f64;
        let step_s = used().map(step).fold(f64::INFINITY, f64::min).max((until - from) / ROWS as f64);
        let rows = ((until - from) / step_s).floor();
        if rows.is_nan() || rows < FEWEST as f64 {
            continue;
        }
        let time: Vec<f64> = (0..rows as usize).map(|row| from + step_s * row as f64).collect();
        let on_clock = |(column, topic): (&BagColumn, &Option<&Topic>)| {
            topic.map_or(vec![f64::NAN; time.len()], |topic| {
                at_times(&topic.times, &column.values(topic), &time)
            })
        };
        let mut values: Vec<Vec<f64>> = columns.iter().zip(&listed).map(on_clock).collect();
        // A recording that lacks a column of the first one says nothing.
        let lacks = |(_, known): &(usize, Vec<Vec<f64>>)| {
            known.iter().zip(&values).any(|(known, entry)| known[0].is_finite() && !entry[0].is_finite())
        };
        if !all.first().is_some_and(lacks) {
            values.push(time.iter().map(|time| time - from).collect());
            all.push((1, values));
        }
    }
    let mut table = LoggedTable::of(all);
    let time = table.columns.pop()?;
    Some((table, time))
}

/// Values between those at `times`; jumps, such as of angles, stay jumps.
fn at_times(times: &[f64], values: &[f64], wanted: &[f64]) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        times.iter().copied().zip(values.iter().copied()).filter(|(_, value)| value.is_finite()).collect();
    let [low, high] = known.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (_, value)| {
        [low.min(*value), high.max(*value)]
    });
    let mut at = 0;
    let of = |time: &f64| {
        while at + 1 < known.len() && known[at + 1].0 <= *time {
            at += 1;
        }
        let Some((before, value)) = known.get(at) else { return f64::NAN };
        match known.get(at + 1) {
            Some((after, next)) if time > before && (next - value).abs() < 0.5 * (high - low) => {
                value + (next - value) * (time - before) / (after - before)
            }
            _ => *value,
        }
    };
    wanted.iter().map(of).collect()
}

/// Places the `fields` and the attitude `turned` of the first topic whose messages are of a type.
fn by_type(topics: &[Topic], (kind, fields, turned): (&str, &[[&str; 2]], &str), placed: &mut Vec<Placed>) {
    let is_known = |topic: &&Topic| topic.kind.replace("/msg/", "/") == kind && topic.messages > 0;
    let Some(topic) = topics.iter().find(is_known) else { return };
    let mut place = |column: &str, channel: &str, unit: &str| {
        if is_free(placed, channel) {
            let [topic, column, channel, unit] = [&topic.name, column, channel, unit].map(str::to_owned);
            placed.push(Placed { topic, column, channel, unit, ..Placed::default() });
        }
    };
    if attitude(topic, turned).is_some() {
        place(turned, "psi", ATTITUDE);
    }
    let is_of_body = values(topic, "velocity_frame").next() == Some(BODY);
    for [field, channel] in fields {
        let channel = match *channel {
            "v_x" if is_of_body => "y_u",
            "v_y" if is_of_body => "y_v",
            other => other,
        };
        if values(topic, field).next().is_some() {
            place(field, channel, unit_of(channel));
        }
    }
}

/// Whether no channel with the same information is placed yet: positions, and velocities, are logged one way.
fn is_free(placed: &[Placed], channel: &str) -> bool {
    let same = SAME.iter().find(|pair| pair.contains(&channel));
    let all = same.map_or([channel, channel], |pair| *pair);
    all.iter().all(|name| placed.iter().all(|entry| entry.channel != *name))
}

/// The `velocity_frame` of PX4 whose axes are the ship's.
const BODY: f64 = 3.0;

fn begun(format: Format, topic: &Topic) -> TopicGuess {
    let (clock, clock_unit) = match format {
        Format::Ulg => ("timestamp", Some("us")),
        _ if topic.fields.iter().any(|field| field == "header.stamp.sec") => ("header.stamp", None),
        _ => ("log_time", None),
    };
    let publisher = topic.publishers.first().copied().filter(|_| topic.publishers.len() > 1);
    let step_s = span_s(topic) / topic.messages.saturating_sub(1).max(1) as f64;
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

/// The time that all messages take \[s\].
fn span_s(topic: &Topic) -> f64 {
    let (Some(first), Some(last)) = (topic.times.first(), topic.times.last()) else { return 0.0 };
    let whole = topic.messages.saturating_sub(1) as f64;
    (last - first) * whole / ((topic.times.len() - 1) * topic.every).max(1) as f64
}

/// The finite values of a field.
fn values<'a>(topic: &'a Topic, field: &str) -> impl Iterator<Item = f64> + 'a {
    let rows = topic.place(field).map(|at| topic.rows.iter().map(move |row| row[at]));
    rows.into_iter().flatten().filter(|value| value.is_finite())
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

/// Types of messages that tell a motion, the fullest first: their fields, each with its channel, and the first field
/// of their attitude. Those of ROS are in its axes, east, north, up; those of PX4 are north, east, down.
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
        "pose.pose.orientation.w",
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
        "q[0]",
    ),
    (
        "geometry_msgs/PoseStamped",
        &[["pose.position.x", "x"], ["pose.position.y", "y"]],
        "pose.orientation.w",
    ),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        &[["pose.pose.position.x", "x"], ["pose.pose.position.y", "y"]],
        "pose.pose.orientation.w",
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
    ("vehicle_attitude", &[], "q[0]"),
    ("vehicle_angular_velocity", &[["xyz[2]", "y_r"]], ""),
    ("sensor_msgs/Imu", &[["angular_velocity.z", "y_r"]], "orientation.w"),
    ("sensor_msgs/NavSatFix", &[["latitude", "latitude_deg"], ["longitude", "longitude_deg"]], ""),
    ("vehicle_global_position", &[["lat", "latitude_deg"], ["lon", "longitude_deg"]], ""),
];

/// The fields w, x, y, z of the attitude whose first one is `first`: in ROS by letters, in PX4 by numbers.
fn quaternion(first: &str) -> Option<[String; 4]> {
    if let Some(name) = first.strip_suffix("[0]") {
        return Some([0, 1, 2, 3].map(|part| format!("{name}[{part}]")));
    }
    first.strip_suffix('w').map(|stem| ["w", "x", "y", "z"].map(|part| format!("{stem}{part}")))
}

/// The places of the fields of an attitude that was measured: elsewhere they are zeros, or no numbers.
fn attitude(topic: &Topic, first: &str) -> Option<Vec<usize>> {
    let parts: Vec<usize> = quaternion(first)?.iter().filter_map(|part| topic.place(part)).collect();
    let square = |row: &Vec<f64>| parts.iter().map(|at| row[*at] * row[*at]).sum::<f64>();
    let mut squares = topic.rows.iter().map(square).filter(|square| square.is_finite()).peekable();
    (parts.len() == 4 && squares.peek().is_some() && squares.all(|square| (square - 1.0).abs() < 0.05))
        .then_some(parts)
}

/// The unit of a channel of motion in messages.
fn unit_of(channel: &str) -> &'static str {
    match channel {
        "latitude_deg" | "longitude_deg" => "deg",
        channel => motion_unit(channel).unwrap_or("1"),
    }
}
