//! What is said of logs that are refused: in terms of `ingest.toml`, whose keys mend it.

use std::fmt::Display;

use logs::{
    ChannelError, CsvError, IntervalError, KINEMATIC, LogError, MissingColumns, RecordError, SourceError,
    Turned, UNITS, Unassembled, UnitRatio,
};
use refusal::{Invalid, nearest};

use super::IngestFile;

/// Channels that do not become trajectories of the vessel in `vessel_file`.
pub fn about_channels(error: &ChannelError, vessel_file: impl Display) -> Invalid {
    match error {
        ChannelError::UnknownUnit(name) => {
            let known = || UNITS.iter().map(|unit| unit.name);
            let near = nearest(name, known()).unwrap_or_default();
            Invalid::new(
                format!("unit `{name}`"),
                "no unit that is known",
                known().collect::<Vec<_>>().join(", "),
                format!("did you mean `{near}`? (or use \"1\" with a `scale`)"),
            )
        }
        ChannelError::Unit { channel, unit, expected } => Invalid::new(
            format!("unit of channel `{channel}`"),
            format!("`{unit}`"),
            format!("a unit that converts to {expected}"),
            "correct the unit or the channel",
        ),
        ChannelError::NoSource { of, source_channel, known } => Invalid::new(
            format!("source of channel `{of}`"),
            format!("`{source_channel}`, which nothing before it provides"),
            format!("one of {}", known.join(", ")),
            format!("did you mean `{}`?", nearest_of(source_channel, known)),
        ),
        ChannelError::Twice(name) => about_name(name, "given twice"),
        ChannelError::Name(name) => about_name(name, "a name that is taken or no plain name"),
        ChannelError::TwoPositions => Invalid::new(
            "position",
            "both x, y and latitude_deg, longitude_deg",
            "one of the two",
            "remove one",
        ),
        ChannelError::OneCoordinate => Invalid::new(
            "position",
            "one coordinate",
            "x and y, or latitude_deg and longitude_deg",
            "add the other",
        ),
        ChannelError::NoMotion(_) => Invalid::new(
            "channels",
            error.to_string(),
            "y_u, y_v, y_r, or x, y (or latitude_deg, longitude_deg) and psi to make them from",
            "add a [[file.channel]] for each",
        ),
        ChannelError::NoHeading => Invalid::new(
            "`antenna_m`",
            "positions without psi",
            "a heading to turn it by",
            "add psi or remove the positions",
        ),
        ChannelError::Rate { found, expected } => Invalid::new(
            "`sample_rate_hz`",
            format!("{found} Hz"),
            format!("{expected} Hz, which the parameters in {vessel_file} hold for"),
            "make them equal",
        ),
        ChannelError::Missing { missing, provided } => Invalid::new(
            "channels",
            format!("{error}, which {vessel_file} needs"),
            format!("channels among {}", provided.join(", ")),
            missing.iter().map(|name| add_channel(name, provided)).collect::<Vec<_>>().join(" "),
        ),
        ChannelError::VesselUnit { channel, unit, expected } => Invalid::new(
            format!("unit of channel `{channel}`"),
            format!("`{unit}`"),
            format!("`{expected}`, as declared in {vessel_file}"),
            "correct one of them",
        ),
    }
}

fn nearest_of<'a>(name: &str, known: &'a [String]) -> &'a str {
    nearest(name, known.iter().map(String::as_str)).unwrap_or_default()
}

fn about_name(name: &str, found: &str) -> Invalid {
    let remedy = match name {
        "u" | "v" | "r" => format!("measured states are called y_{name}"),
        _ => "rename it".to_owned(),
    };
    let expected = "letters, digits and _, each name once, no column of the trajectories";
    Invalid::new(format!("channel `{name}`"), found, expected, remedy)
}

fn add_channel(name: &str, provided: &[String]) -> String {
    let others = provided.iter().map(String::as_str);
    match nearest(name, others.filter(|other| KINEMATIC.iter().all(|(motion, _)| motion != other))) {
        Some(near) => format!("did you mean `{name}` by `{near}`?"),
        None => format!("add a [[file.channel]] for `{name}`"),
    }
}

/// CSV that cannot be read.
pub fn about_csv(error: &CsvError) -> Invalid {
    match error {
        CsvError::Unreadable(error) => {
            let cut = error.kind() == std::io::ErrorKind::UnexpectedEof;
            let found = if cut { "an end within the compressed data".to_owned() } else { error.to_string() };
            let remedy = "the file is truncated or damaged: copy it again";
            Invalid::new("file", found, "a whole gzip file", remedy)
        }
        CsvError::NotText(_) => {
            Invalid::new("text", error.to_string(), "UTF-8 text", "save the file as UTF-8")
        }
        CsvError::Width { line, found, expected } => {
            let comma = if found > expected { " (decimal commas: export with decimal points)" } else { "" };
            Invalid::new(
                format!("line {line}"),
                format!("{found} cells"),
                format!("{expected}, as in the header"),
                format!("correct the line, or `separator` in ingest.toml{comma}"),
            )
        }
        CsvError::NoNumber { line, column, found } => {
            let comma = found.replacen(',', ".", 1).parse::<f64>().is_ok();
            let remedy =
                if comma { "export with decimal points" } else { "correct the cell or leave it empty" };
            Invalid::new(cell(*line, column), format!("`{found}`"), "a number", remedy)
        }
        CsvError::Separator { cells, found, expected } => Invalid::new(
            "line 1",
            format!("{cells} cells separated by {found:?}"),
            format!("cells separated by {expected:?}"),
            format!("set `separator = {:?}` in ingest.toml", found.to_string()),
        ),
        CsvError::Columns(missing) => about_columns(missing),
    }
}

fn cell(line: usize, column: &str) -> String {
    format!("line {line}, column `{column}`")
}

/// Columns that a file does not have.
pub fn about_columns(MissingColumns { missing, header }: &MissingColumns) -> Invalid {
    let remedy = |column: &String| match nearest(column, header.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}` instead of `{column}`?"),
        None => format!("add `{column}`"),
    };
    Invalid::new(
        if missing.len() == 1 { "column" } else { "columns" },
        format!("no `{}`", missing.join("`, `")),
        format!("columns among `{}`", header.join("`, `")),
        missing.iter().map(remedy).collect::<Vec<_>>().join(" "),
    )
}

/// Columns that are no log.
pub fn about_log(error: &LogError) -> Invalid {
    match error {
        LogError::NoRows { .. } => Invalid::new(
            "file",
            error.to_string(),
            "at least one row",
            "remove the file or narrow the pattern",
        ),
        LogError::NoTime { line, column, found } => Invalid::new(
            cell(*line, column),
            format!("`{found}`"),
            "a date and time such as 2020-07-31T13:04:24.5Z",
            "correct the cell, or the time's `unit` in ingest.toml",
        ),
        LogError::Backwards { line, column, time, latest } => Invalid::new(
            cell(*line, column),
            format!("{time} s after {latest} s"),
            "time that does not go backwards",
            "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
        ),
        LogError::Turned(Turned { line, column, before, after, turn, unit }) => Invalid::new(
            cell(*line, column),
            format!("{after} after {before}, a turn in {turn}"),
            format!("angles in {unit}, as its `unit` says"),
            format!("it looks like {turn}: set `unit = \"{turn}\"`"),
        ),
    }
}

/// A recording, `run`, that becomes no runs.
pub fn about_recording(error: &RecordError, run: &str) -> Invalid {
    match error {
        RecordError::Unassembled { why, slowest } => {
            let remedy = match slowest {
                Some((name, step)) if *why == Unassembled::NoOverlap => format!(
                    "compare `max_gap_s` with the longest step, {step:.3} s in `{name}`, and check the clocks"
                ),
                _ => "check the file's columns and clocks".to_owned(),
            };
            let expected = "a stretch without gaps in which all needed channels are known";
            Invalid::new(format!("run `{run}`"), why.to_string(), expected, remedy)
        }
        RecordError::Unit(UnitRatio { channel, gain, unit, of_velocity }) => {
            let of = if *channel == "y_r" { "`psi`" } else { "`x` and `y`" };
            let remedy = match (of_velocity, *channel) {
                (true, _) => format!("`{channel}` may be in {unit}: correct its `unit`, or that of {of}"),
                (false, "y_r") => format!("{of} may be in deg: correct its `unit`, or that of `{channel}`"),
                (false, _) => format!("{of} may be in another unit: correct it, or that of `{channel}`"),
            };
            let found = format!("{gain:.4} times the derivative of {of}");
            Invalid::new(format!("unit of channel `{channel}`"), found, "about 1 times it", remedy)
        }
    }
}

/// Files that make no recordings.
pub fn about_sources(error: &SourceError, config: &IngestFile) -> Invalid {
    match error {
        SourceError::Unnamed { file, template } => Invalid::new(
            "file name",
            format!("`{file}`"),
            format!("a name that fits `{template}`"),
            "correct the template or narrow the pattern",
        ),
        SourceError::Two { run, files: [first, second] } => Invalid::new(
            format!("run `{run}`"),
            format!("`{first}` and `{second}`"),
            "one file of each group",
            "correct `run_from_file` or rename a file",
        ),
        SourceError::NoFile { run, group } => Invalid::new(
            format!("run `{run}`"),
            "some of its files",
            format!("a file of every group; none of `{}`", config.file[*group].pattern.join("`, `")),
            "add the file or narrow the patterns",
        ),
    }
}

/// Intervals that do not fit the recordings.
pub fn about_intervals(error: &IntervalError) -> Invalid {
    match error {
        IntervalError::NoRecording { run, known } => Invalid::new(
            "`run` of a [[segment]]",
            format!("`{run}`, which no file has"),
            format!("one of {}", known.join(", ")),
            format!("did you mean `{}`?", nearest_of(run, known)),
        ),
        IntervalError::Overlap { run, first, second } => Invalid::new(
            format!("[[segment]] of run `{run}`"),
            format!("{} to {} s and {} to {} s", first[0], first[1], second[0], second[1]),
            "intervals without overlap",
            "correct one of them",
        ),
    }
}
