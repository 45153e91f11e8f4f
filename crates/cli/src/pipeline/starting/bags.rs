//! Bags in a folder of logs: what is in the first of them, and which are parts of one recording.

use std::fmt::Write;
use std::path::Path;

use files::{Error, budget};
use logs::guess::{BagGuess, Needed, Placed, TopicGuess};
use logs::{Format, Topic, bag_census, database_census};
use refusal::foreign;
use study::ingest_file::read::{check_format, database};
use study::refuse;

use super::reading::{reader, wrong};
use super::text::{MARK, channel, quoted};

/// Endings of bags.
pub(super) const BAGS: [&str; 8] =
    [".mcap", ".mcap.gz", ".bag", ".bag.gz", ".bag.active", ".db3", ".ulg", ".ulg.gz"];

/// What is in the first of `files` in `folder`, for a model that needs the channels `needed`.
///
/// # Errors
/// Files of several formats; a file that cannot be read; one without a topic from which the motion follows.
pub(super) fn guessed(folder: &Path, files: &[String], needed: &[Needed]) -> Result<BagGuess, Error> {
    let (first, format) = (&files[0], Format::of(&files[0]));
    if let Some(other) = files.iter().find(|file| Format::of(file) != format) {
        let found = format!("`{}` beside `{}`", foreign(other), foreign(first));
        let remedy =
            "name a folder with those of one format, or write ingest.toml yourself (docs/own-logs.md)";
        return Err(refuse(folder, "logs", &found, "bags of one format", remedy));
    }
    let path = folder.join(first);
    let topics = topics(&path, format)?;
    let guess = BagGuess::of(format, &topics, needed);
    if guess.topics.is_empty() {
        let found = format!("none among {} topics", topics.len());
        let expected = "a topic with a motion, such as one of nav_msgs/Odometry or vehicle_odometry";
        let remedy = "write ingest.toml yourself (docs/own-logs.md)";
        return Err(refuse(&path, "topic", &found, expected, remedy));
    }
    Ok(guess)
}

fn topics(path: &Path, format: Format) -> Result<Vec<Topic>, Error> {
    check_format(path, format, true)?;
    let topics = match format {
        Format::Db3 => database_census(&database(path)?, budget().bytes()),
        _ => bag_census(reader(path)?, format, budget().bytes()),
    };
    topics.map_err(|error| wrong(path, error))
}

/// The template of a recording's name. A bag of ROS 2 is a folder of its parts. Elsewhere files are parts where the first
/// is number 0.
fn run_from_file(files: &[String]) -> String {
    let end = files[0].rsplit_once('.').map_or("", |(_, end)| end);
    let depth = files[0].matches('/').count();
    let is_even = files.iter().all(|file| file.matches('/').count() == depth);
    if end == "db3" && depth > 0 && is_even {
        return format!("{}{{run}}/*.db3", "*/".repeat(depth - 1));
    }
    let is_numbered = |file: &String| {
        let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
        stem.rsplit_once('_').is_some_and(|(_, number)| number.parse::<u32>().is_ok())
    };
    let is_first = |file: &String| file.ends_with(&format!("_0.{end}"));
    match files.len() > 1 && files.iter().all(is_numbered) && files.iter().any(is_first) {
        true => format!("{{run}}_*.{end}"),
        false => format!("{{run}}.{end}"),
    }
}

/// The groups of files of `ingest.toml`, one per topic.
pub(super) fn groups(guess: &BagGuess, patterns: &[String], files: &[String]) -> String {
    let patterns: Vec<String> = patterns.iter().map(|pattern| quoted(pattern)).collect();
    let (patterns, template) = (patterns.join(", "), run_from_file(files));
    let mut text = String::new();
    for topic in &guess.topics {
        let _ = write!(text, "\n[[file]]\npattern = [{patterns}]\nrun_from_file = {}", quoted(&template));
        let mark = if template.contains('*') { MARK } else { "" };
        let _ = writeln!(text, "{mark}\ntopic = {}", quoted(&topic.topic));
        if let Some(publisher) = topic.publisher {
            let _ = writeln!(text, "publisher = \"{publisher}\"{MARK}: the first of several");
        }
        text += &clock(topic);
        if let Some([w, x, y, z]) =
            topic.quaternion.as_ref().map(|parts| parts.each_ref().map(|part| quoted(part)))
        {
            let _ = writeln!(text, "quaternion = [{{ w = {w}, x = {x}, y = {y}, z = {z} }}]");
        }
        text += &channels(&topic.placed);
    }
    if !guess.unused.is_empty() {
        let names: Vec<String> = guess.unused.iter().map(|name| quoted(name)).collect();
        let _ = writeln!(text, "\n# Topics that are not used: {}", names.join(", "));
    }
    text
}

fn clock(topic_guess: &TopicGuess) -> String {
    let unit = topic_guess.clock_unit.map_or(String::new(), |unit| format!(", unit = {}", quoted(unit)));
    format!("time = {{ column = {}{unit} }}\n", quoted(topic_guess.clock))
}

/// The channels of a topic, on one line where they are few and have one mark.
fn channels(placed: &[Placed]) -> String {
    let is_short = placed.len() == 1 || placed.len() == 2 && placed.iter().all(|own| mark(own).is_empty());
    match placed {
        [] => String::new(),
        [.., last] if is_short => {
            let all: Vec<String> = placed.iter().map(channel).collect();
            format!("channel = [{}]{}\n", all.join(", "), mark(last))
        }
        _ => {
            let line = |placed: &Placed| format!("    {},{}\n", channel(placed), mark(placed));
            format!("channel = [\n{}]\n", placed.iter().map(line).collect::<String>())
        }
    }
}

fn mark(placed: &Placed) -> String {
    match (placed.is_channel_guessed, placed.is_unit_guessed) {
        (false, false) => String::new(),
        (true, false) => format!("{MARK}: by the name of the topic"),
        (_, true) => format!("{MARK}: by the name of the topic, which says no unit"),
    }
}
