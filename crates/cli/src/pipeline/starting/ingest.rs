//! The text of a new `ingest.toml`.

use std::fmt::Write;

use logs::guess::{BagGuess, ColumnChoice, Guess, Head, Needed, Placed, Question, SentenceGuess};
use logs::{Format, TimeUnit};

use crate::commands::SEARCHED;
use crate::pipeline::settings::HEAD;
use crate::pipeline::starting::bags::{self, MARK, PARQUET, quoted};
use crate::pipeline::starting::looking::{LogGuess, Looked};
use crate::pipeline::starting::presets::Preset;

/// Rows that a gap may be as long as.
const GAP_ROWS: f64 = 5.0;

/// The text of `ingest.toml` for logs as `looked` found them, of a ship like `preset`.
pub(super) fn written(looked: &Looked, preset: &Preset) -> String {
    let rate_hz = preset.sample_rate_hz();
    let mut text = match &looked.found {
        LogGuess::Table(head, guess) => {
            let lacks = looked.half_a_wind();
            let placed: String = guess.placed.iter().map(|placed| channel(placed, lacks)).collect();
            let step_s = guess.clock.as_ref().map_or(1.0, |clock| clock.step_s);
            general(looked, guess, rate_hz, step_s) + &files(looked, head, guess) + &placed
        }
        LogGuess::Bag(guess) => {
            general_of_bags(looked, guess, rate_hz) + &bags::groups(guess, &looked.patterns, &looked.files)
        }
        LogGuess::Sentences(guess) => {
            general_of_sentences(looked, guess, rate_hz) + &bags::group(guess, &looked.patterns)
        }
    };
    let questions = match &looked.found {
        LogGuess::Table(_, guess) => &guess.asked[..],
        LogGuess::Bag(bag) => &bag.guess.asked,
        LogGuess::Sentences(_) => &[],
    };
    questions.iter().for_each(|question| text += &asked(question));
    let is_asked = |need: &&Needed| questions.iter().any(|question| question.channel == need.channel);
    let missed = looked.missing().iter().filter(|need| !is_asked(need));
    missed.for_each(|need| text += &missing(need, &looked.found));
    text += &unplaced(looked);
    text += preset.thrusters();
    text
}

/// Samples that a model is to predict on its own, and that recordings are cut into.
const WINDOW: f64 = 100.0;

/// Part of a usual recording that a window may be at most: its ends are lost where channels are resampled.
const PART: f64 = 0.9;

/// The longest window that a ship with forces is fitted and tried on \[s\].
const FORCES_WINDOW_S: f64 = 100.0;

/// The length of a window \[s\], in whole samples of `rate_hz`.
fn window_s(looked: &Looked, rate_hz: f64) -> f64 {
    (PART * looked.usual_s * rate_hz).floor().clamp(2.0, WINDOW) / rate_hz
}

/// `study.toml` of a study with logs as `looked` found them, of a ship like `preset`.
pub(super) fn settings(looked: &Looked, preset: &Preset) -> String {
    let folder = looked.folder.canonicalize().unwrap_or_else(|_| looked.folder.clone());
    let mut text = format!("{HEAD}# The folder of the logs.\nlogs = {}\n", quoted(&folder.to_string_lossy()));
    let test: Vec<String> = looked.kept_apart().into_iter().map(quoted).collect();
    if !test.is_empty() {
        let _ = write!(
            text,
            "# Recordings that a second model is not fitted to, and that the page shows beside its predictions. Every fifth was \
             picked.\ntest = [{}]\n",
            test.join(", ")
        );
    }
    let rate_hz = preset.sample_rate_hz();
    let forces_s = |part: f64| {
        let usual_s = part * or(looked.usual_s, FORCES_WINDOW_S);
        rounded(usual_s.clamp(2.0 / rate_hz, FORCES_WINDOW_S))
    };
    let (is_searched, is_of_forces) = (looked.files.len() >= SEARCHED, preset.is_of_forces());
    let window_s = match is_of_forces {
        true => forces_s(if is_searched { PART } else { 1.0 }),
        false => window_s(looked, rate_hz),
    };
    text += &match (is_searched, is_of_forces) {
        (true, _) => of_search(window_s),
        (false, true) => of_forces(window_s),
        (false, false) => of_terms(window_s),
    };
    text + &format!("\n[compare]\nwindow_s = {window_s}\n")
}

fn of_search(window_s: f64) -> String {
    format!(
        "\n# Models are found by a search, and averaged with the fitted forces of a ship that has these; structure = \"own\" fits\n\
         # the model of vessel.toml alone. They are fitted over windows of this length [s], and predict these on recordings left out.\n\
         [estimate]\nfitted_window_s = {window_s}\nwindow_s = {window_s}\n"
    )
}

fn of_forces(window_s: f64) -> String {
    format!(
        "\n# The fit simulates windows of at most this length [s], each from an initial state that it finds.\n\
         [estimate]\nfitted_window_s = {window_s}\n\
         # Models predict windows of this length [s] on recordings that they were not fitted to.\n\
         window_s = {window_s}\n"
    )
}

fn of_terms(window_s: f64) -> String {
    format!(
        "\n# Instruments restart with every part of a recording; parts are at most as long as this [s]. Bootstrap samples [1] that\n\
         # standard errors rest on: more take longer.\n[estimate]\npart_s = {window_s}\nbootstrap = 100\n\
         # Models predict windows of this length [s] on recordings that they were not fitted to.\n\
         window_s = {window_s}\n"
    )
}

/// The keys of the whole file, for bags.
fn general_of_bags(looked: &Looked, guess: &BagGuess, rate_hz: f64) -> String {
    let topics = guess.topics();
    let steps = topics.iter().map(|topic| topic.step_s);
    let (fastest, slowest) = (steps.clone().fold(f64::INFINITY, f64::min), steps.fold(0.0, f64::max));
    let mut text = format!(
        "# What is in the logs: {} bags. Lines marked \"guessed\" were guessed by names and numbers: check them.\n\
         sample_rate_hz = {rate_hz:?}            # rate of the trajectories [Hz]: that of vessel.toml\n\
         max_gap_s = {:?}{MARK}: five messages of the slowest topic [s]; over longer gaps nothing is interpolated\n",
        looked.files.len(),
        gap_s(slowest, rate_hz),
    );
    if or(fastest, 1.0 / rate_hz) * rate_hz < 0.5 {
        text += &average(rate_hz);
    }
    let (frame, body, whose) = match (guess.guess.is_east, guess.format) {
        (false, Format::Ulg) => ("ned", "frd", "of PX4: x north, y east; body x forward, y starboard"),
        (false, _) => ("ned", "frd", "by motion: x north, y east; body x forward, y starboard"),
        (true, _) => ("enu", "flu", "of ROS: x east, y north; body x forward, y port"),
    };
    let _ = writeln!(text, "frame = \"{frame}\"{MARK}: axes {whose}\nbody = \"{body}\"{MARK}");
    text
}

/// The keys of the whole file, for sentences.
fn general_of_sentences(looked: &Looked, guess: &SentenceGuess, rate_hz: f64) -> String {
    let [fastest_s, slowest_s] = guess.steps_s;
    let mut text = format!(
        "# What is in the logs: {} files of NMEA 0183. Lines marked \"guessed\" were guessed by the kinds of sentences: check them.\n\
         sample_rate_hz = {rate_hz:?}            # rate of the trajectories [Hz]: that of vessel.toml\n\
         max_gap_s = {:?}{MARK}: five times that between values of the slowest field [s]; over longer gaps nothing is interpolated\n",
        looked.files.len(),
        gap_s(slowest_s, rate_hz),
    );
    if or(fastest_s, 1.0 / rate_hz) * rate_hz < 0.5 {
        text += &average(rate_hz);
    }
    let window_s = rounded(or(5.0 * slowest_s, 1.0).max(1.0));
    text + &format!(
        "# Speeds that are not logged are slopes of positions: of parabolas over `window_s` [s].\n\
         velocities = {{ method = \"smoother\", window_s = {window_s:?} }}{MARK}\n"
    )
}

fn average(rate_hz: f64) -> String {
    let average_s = rounded(0.5 / rate_hz);
    format!("average_s = {average_s:?}{MARK}: half a sample [s] over which channels are averaged\n")
}

/// The keys of the whole file, for tables with a row every `step_s`.
fn general(looked: &Looked, guess: &Guess, rate_hz: f64, step_s: f64) -> String {
    let max_gap_s = gap_s(step_s, rate_hz);
    let is_fast = step_s * rate_hz < 0.5;
    let mut text = format!(
        "# What is in the logs: {} files in {}. Lines marked \"guessed\" were guessed by motion and by names: check them.\n\
         sample_rate_hz = {rate_hz:?}            # rate of the trajectories [Hz]: that of vessel.toml\n\
         max_gap_s = {max_gap_s:?}{MARK}: five rows of the logs [s]; over longer gaps nothing is interpolated\n",
        looked.files.len(),
        if looked.files[0].to_lowercase().ends_with(PARQUET[0]) { "Parquet" } else { "CSV" },
    );
    if is_fast {
        text += &average(rate_hz);
    }
    let axes = match guess.is_east {
        true => [
            "enu",
            "flu",
            "x east, y north, heading counter-clockwise from east; body x forward, y port",
            "ned",
            "frd",
        ],
        false => [
            "ned",
            "frd",
            "x north, y east, heading clockwise from north; body x forward, y starboard",
            "enu",
            "flu",
        ],
    };
    let [frame, body, words, other_frame, other_body] = axes;
    let _ = writeln!(text, "\n# Axes: {words}. The other choice is \"{other_frame}\", \"{other_body}\".");
    let _ = writeln!(text, "frame = \"{frame}\"{MARK}\nbody = \"{body}\"{MARK}");
    if looked.patterns.iter().any(|pattern| pattern.contains('/')) {
        text += "\n# The maneuver of a recording is named after its folder.\n";
        let _ = writeln!(text, "maneuver_from_file = \"{{kind}}/*\"{MARK}");
    }
    text += "\n# Speeds that are not logged are slopes of positions: of parabolas over `window_s` [s], or Euler differences.\n[velocities]\n";
    if is_fast {
        let _ =
            writeln!(text, "method = \"smoother\"\nwindow_s = {:?}{MARK}", rounded((10.0 * step_s).max(1.0)));
    } else {
        let _ = writeln!(text, "method = \"euler\"{MARK}");
    }
    text
}

/// Where `step_s` lies between values, the longest gap.
fn gap_s(step_s: f64, rate_hz: f64) -> f64 {
    rounded(GAP_ROWS * or(step_s, 1.0 / rate_hz))
}

/// A time of the logs \[s\], or `other` where they are too short to have one.
fn or(time_s: f64, other: f64) -> f64 {
    if time_s.is_finite() && time_s > 1e-6 { time_s } else { other }
}

/// Two significant figures.
fn rounded(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

/// The group of files and its clock.
fn files(looked: &Looked, head: &Head, guess: &Guess) -> String {
    let patterns: Vec<String> = looked.patterns.iter().map(|pattern| quoted(pattern)).collect();
    let mut text = format!("\n[[file]]\npattern = [{}]\n", patterns.join(", "));
    if head.separator != ',' {
        let _ = writeln!(text, "separator = {}", quoted(&head.separator.to_string()));
    }
    if head.decimal != '.' {
        let _ = writeln!(text, "decimal = {}", quoted(&head.decimal.to_string()));
    }
    let skipped = head.skip_lines + usize::from(guess.is_numbered && head.has_header);
    if guess.is_numbered {
        let _ = writeln!(
            text,
            "# Columns are called by their numbers.\nheader = false\ncolumns = {}",
            head.columns.len()
        );
    }
    if skipped > 0 {
        let _ = writeln!(text, "skip_lines = {skipped}");
    }
    if let Some(clock) = &guess.clock {
        let unit = match clock.unit {
            TimeUnit::S => "s",
            TimeUnit::Ms => "ms",
            TimeUnit::Us => "us",
            TimeUnit::Ns => "ns",
            TimeUnit::Iso8601 => "iso8601",
        };
        let mark = if clock.is_unit_guessed { MARK } else { "" };
        let _ = write!(
            text,
            "\n# A row about every {} s.\n[file.time]\ncolumn = {}\nunit = \"{unit}\"{mark}\n",
            rounded(clock.step_s),
            quoted(&clock.column)
        );
    }
    text
}

fn channel(placed: &Placed, lacks: Option<[&str; 2]>) -> String {
    let mark = |guessed: bool, why: &str| {
        let why = placed.by_motion.as_deref().unwrap_or(why);
        if guessed { format!("{MARK}: {why}") } else { String::new() }
    };
    let mut text = format!(
        "\n[[file.channel]]\ncolumn = {}\nchannel = {}{}\nunit = {}{}\n",
        quoted(&placed.column),
        quoted(&placed.channel),
        mark(placed.is_channel_guessed, "by the column's name"),
        quoted(&placed.unit),
        mark(placed.is_unit_guessed, "the column's name says none"),
    );
    if placed.is_reversed {
        let _ = writeln!(text, "sign = -1.0{MARK}: by motion");
    }
    if placed.is_optional {
        let why = match lacks {
            Some([channel, what]) if channel == placed.channel => {
                format!("not used: no {what} of the wind is logged")
            }
            _ => "the model does without it".to_owned(),
        };
        let _ = writeln!(text, "optional = true            # {why}");
    }
    text
}

/// Columns that may be a channel, as comments.
fn asked(question: &Question) -> String {
    let mut text = format!(
        "\n# Several columns may be `{}`: name the right one.\n# [[file.channel]]\n",
        question.channel
    );
    for ColumnChoice { placed, why } in &question.choices {
        let topic =
            if placed.topic.is_empty() { "" } else { &format!("topic = {}, ", quoted(&placed.topic)) };
        let sign = if placed.is_reversed { ", sign = -1.0" } else { "" };
        let column = quoted(&placed.column);
        let _ = writeln!(text, "# {topic}column = {column}{sign}          # in {}: {why}", placed.unit);
    }
    let first = question.choices.first().map_or("", |choice| choice.placed.unit.as_str());
    let _ = writeln!(text, "# channel = {}\n# unit = {}", quoted(&question.channel), quoted(first));
    text
}

fn missing(needed: &Needed, found: &LogGuess) -> String {
    let [channel, unit] = [&needed.channel, &needed.unit].map(|text| quoted(text));
    match found {
        LogGuess::Table(..) => format!(
            "\n# The model needs this channel, and no column was recognised as it: name its column.\n# [[file.channel]]\n\
             # column = \"\"\n# channel = {channel}\n# unit = {unit}\n"
        ),
        LogGuess::Bag(_) | LogGuess::Sentences(_) => format!(
            "\n# The model needs this channel, and no field was recognised as it: name its field in a `channel` above.\n\
             #    {{ column = \"\", channel = {channel}, unit = {unit} }},\n"
        ),
    }
}

/// Columns that were not placed, and logs of other formats.
fn unplaced(looked: &Looked) -> String {
    let line = |name: &String| format!("#   {}\n", quoted(name));
    let mut text = String::new();
    if let LogGuess::Table(_, guess) = &looked.found
        && !guess.unplaced.is_empty()
    {
        text += "\n# Columns that are not used:\n";
        guess.unplaced.iter().for_each(|name| text += &line(name));
    }
    if !looked.others.is_empty() {
        text += "\n# Logs of other formats that are not used:\n";
        looked.others.iter().for_each(|name| text += &line(name));
    }
    text
}
