//! Refuses an invalid `ingest.toml` before any log is read.

use logs::{Accepted, ChannelSpec, Checksums, FileSpec, Format, Interval, LOG_TIME, PUBLISH_TIME, TimeUnit};
use refusal::{Invalid, check_name, foreign};

use super::IngestFile;

impl IngestFile {
    /// Refuses invalid numbers and keys that exclude each other.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        self.check_windows()?;
        self.check_names()?;
        self.check_channels()?;
        self.check_segments()?;
        if !self.file.is_empty() && self.file.iter().all(|file| file.optional) {
            let (found, expected) = ("it in every [[file]]", "a kind of files that every recording has");
            return Err(Invalid::new("`optional`", found, expected, "remove it from one of them"));
        }
        self.file.iter().try_for_each(check_file)
    }

    fn check_windows(&self) -> Result<(), Invalid> {
        let rising = self.speed_classes_m_s.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising {
            let given = format!("{:?}", self.speed_classes_m_s);
            let expected = "speeds above 0 m/s that increase";
            return Err(Invalid::new("`speed_classes_m_s`", given, expected, "put them in order"));
        }
        if self.tail_s.is_some() && self.tail_s > Some(self.window_s.unwrap_or(0.0)) {
            let given = match self.window_s {
                Some(window_s) => format!("{} s beside windows of {window_s} s", self.tail_s.unwrap_or(0.0)),
                None => "no `window_s` beside it".to_owned(),
            };
            let expected = "the shortest last window, no longer than `window_s`";
            return Err(Invalid::new("`tail_s`", given, expected, "correct it or remove it"));
        }
        self.check_speed_names()
    }

    /// Refuses names that figures and pages cannot show.
    fn check_names(&self) -> Result<(), Invalid> {
        let designs =
            [("design", &self.design)].into_iter().chain(self.maneuver.iter().map(|m| ("maneuver", m)));
        let classes = self.speed_class_names.iter().flatten().map(|name| ("speed_class_names", name));
        let segments = self.segment.iter().map(|segment| ("segment.maneuver", &segment.maneuver));
        let channels = self.file.iter().flat_map(|f| &f.channel).map(|channel| ("channel", &channel.channel));
        let derived = self.derived.iter().map(|channel| ("derived.channel", &channel.channel));
        let all = designs.chain(classes).chain(segments).chain(channels).chain(derived);
        all.into_iter().try_for_each(|(key, name)| check_name(format!("`{key}`"), name))
    }

    fn check_speed_names(&self) -> Result<(), Invalid> {
        let expected = self.speed_classes_m_s.len() + 1;
        let named = self.speed_class_names.as_ref().map(Vec::len);
        if self.speed_classes_m_s.is_empty() && named.is_none() {
            return Ok(());
        }
        if self.window_s.is_none() {
            let expected = "speed classes of windows";
            let remedy = "add `window_s` or remove the speed classes";
            return Err(Invalid::new("`speed_classes_m_s`", "no `window_s` beside it", expected, remedy));
        }
        match named {
            None if expected <= 3 => Ok(()),
            Some(count) if count == expected => Ok(()),
            found => Err(Invalid::new(
                "`speed_class_names`",
                format!("{} names", found.unwrap_or(0)),
                format!("{expected}, one more than `speed_classes_m_s`"),
                "name every class",
            )),
        }
    }

    fn check_channels(&self) -> Result<(), Invalid> {
        if self.file.is_empty() {
            return Err(Invalid::new("[[file]]", "none", "at least one group of files", "add one"));
        }
        if self.file.len() > 1 && self.file.iter().any(|file| file.run_from_file.is_none()) {
            return Err(Invalid::new(
                "`run_from_file`",
                "a group of files without it beside another group",
                "a template with `{run}` in every [[file]]",
                "add it, so that files of one recording are known",
            ));
        }
        for channel in self.file.iter().flat_map(|file| &file.channel) {
            if channel.sign.abs() != 1.0 || channel.scale == 0.0 {
                return Err(Invalid::new(
                    format!("channel `{}`", channel.channel),
                    format!("sign {}, scale {}", channel.sign, channel.scale),
                    "sign 1 or -1, a scale other than 0",
                    "correct it",
                ));
            }
            check_gate(channel)?;
        }
        Ok(())
    }

    fn check_segments(&self) -> Result<(), Invalid> {
        let labels = self.file.iter().filter(|file| file.label_column.is_some()).count();
        let ways = [!self.segment.is_empty(), self.window_s.is_some(), labels > 0];
        if ways.iter().filter(|way| **way).count() > 1 || labels > 1 {
            let given = "more than one of [[segment]], `window_s` and a `label_column`";
            let expected = "one of them, or none for whole recordings";
            return Err(Invalid::new("sub-experiments", given, expected, "remove the others"));
        }
        if self.maneuver.is_some() && self.maneuver_from_file.is_some() {
            let given = "`maneuver_from_file` beside it";
            return Err(Invalid::new("`maneuver`", given, "one of the two", "remove one"));
        }
        let wrong = |s: &&Interval| s.from_s >= s.to_s;
        match self.segment.iter().find(wrong) {
            Some(segment) => Err(Invalid::new(
                format!("[[segment]] of run `{}`", segment.run),
                format!("from_s {}, to_s {}", segment.from_s, segment.to_s),
                "an end after its beginning",
                "correct it",
            )),
            None => Ok(()),
        }
    }
}

/// Refuses a channel whose values could not be distinguished from missing ones.
fn check_gate(channel: &ChannelSpec) -> Result<(), Invalid> {
    match channel.valid {
        Some([low, high]) if low >= high => Err(Invalid::new(
            format!("`valid` of channel `{}`", channel.channel),
            format!("[{low}, {high}]"),
            "the least and the greatest value",
            "correct it",
        )),
        _ => Ok(()),
    }
}

/// Refuses keys of a group of files that exclude each other or lack another.
fn check_file(file: &FileSpec) -> Result<(), Invalid> {
    let c = file.separator;
    if !c.is_ascii() || ['"', '\n', '\r'].contains(&c) {
        let expected = "one character such as `,`, `;`, a tab or a blank";
        return Err(Invalid::new("`separator`", format!("`{}`", c.escape_default()), expected, "correct it"));
    }
    if !['.', ','].contains(&file.decimal) || file.decimal == c {
        let given = format!("`{}` beside the separator `{c}`", file.decimal);
        let expected = "`.` or `,`, and another separator";
        return Err(Invalid::new("`decimal`", given, expected, "correct one of them"));
    }
    match (file.header, file.columns) {
        (true, None) | (false, Some(1..)) => {}
        (true, Some(_)) => {
            let expected = "it for files without a header, `header = false`";
            return Err(Invalid::new("`columns`", "it beside a header", expected, "remove one of the two"));
        }
        (false, _) => {
            let expected = "`columns`, how many there are in the file";
            return Err(Invalid::new("`header`", "files without header or `columns`", expected, "add it"));
        }
    }
    check_talkers(file)?;
    check_kinds(file)?;
    check_time(file)
}

/// Refuses invalid talkers, and keys of sentences for files of another kind.
fn check_talkers(file: &FileSpec) -> Result<(), Invalid> {
    let is_talker = |talker: &String| talker.len() == 2 && talker.bytes().all(|c| c.is_ascii_alphanumeric());
    if let Some(wrong) = file.prefer.iter().find(|talker| !is_talker(talker)) {
        let expected = "the two letters that sentences of a talker begin with, such as `HE` or `GP`";
        return Err(Invalid::new("`prefer`", format!("`{}`", foreign(wrong)), expected, "correct it"));
    }
    let keys = [
        ("prefer", !file.prefer.is_empty()),
        ("quality", file.quality != Accepted::default()),
        ("checksums", file.checksums != Checksums::default()),
    ];
    let other = file.pattern.iter().find(|pattern| file.format_of(pattern) != Format::Nmea);
    match (keys.iter().find(|(_, is_set)| *is_set), other) {
        (Some((key, _)), Some(pattern)) => {
            let given = format!("`{key}` of files `{pattern}`");
            let remedy = "remove it, or set `format = \"nmea\"`";
            Err(Invalid::new(format!("`{key}`"), given, "it for files of NMEA 0183", remedy))
        }
        _ => Ok(()),
    }
}

/// Refuses keys that files of a kind lack or do not have.
fn check_kinds(file: &FileSpec) -> Result<(), Invalid> {
    for pattern in &file.pattern {
        let format = file.format_of(pattern);
        if format.is_bag() != file.topic.is_some() {
            let given = if file.topic.is_some() { "it for" } else { "none for" };
            let expected = "one for every group of bags, and for no other files";
            let remedy = "add or remove it, or set the `format` where names do not end with one";
            return Err(Invalid::new("`topic`", format!("{given} `{pattern}`"), expected, remedy));
        }
        check_clock(file, pattern, format)?;
        if file.publisher.is_some() && !format.is_bag() {
            let given = format!("it for `{pattern}`");
            return Err(Invalid::new("`publisher`", given, "it for the topic of a bag", "remove it"));
        }
        let others =
            [file.label_column.is_some(), file.time.nanoseconds.is_some(), !file.quaternion.is_empty()];
        let lacks = match format {
            Format::Nmea => others.contains(&true),
            Format::Mcap | Format::Bag | Format::Db3 | Format::Ulg => {
                others[..2].contains(&true) || file.time.format.is_some()
            }
            Format::Csv | Format::Parquet => false,
        };
        if lacks {
            let given = "`label_column`, `nanoseconds`, `quaternion`, or a time as text";
            let expected = "channels that are numbers: sentences have no more, bags quaternions too";
            return Err(Invalid::new(format!("files `{pattern}`"), given, expected, "remove it"));
        }
    }
    Ok(())
}

/// Refuses times of messages that bags of a kind do not have.
fn check_clock(file: &FileSpec, pattern: &str, format: Format) -> Result<(), Invalid> {
    let column = file.time.column.as_str();
    let (expected, remedy) = match format {
        Format::Bag | Format::Db3 if column == PUBLISH_TIME => {
            ("`log_time`, or a field such as `header.stamp`", "name one of the two")
        }
        Format::Ulg if [LOG_TIME, PUBLISH_TIME].contains(&column) => {
            ("a field of the topic", "set `column = \"timestamp\"` and `unit = \"us\"`")
        }
        _ => return Ok(()),
    };
    Err(Invalid::new("`time`", format!("`{column}` of files `{pattern}`"), expected, remedy))
}

/// Whether the times of all files have a unit of their own.
fn tells_itself(file: &FileSpec) -> Option<bool> {
    let kinds = file.pattern.iter().map(|pattern| match file.format_of(pattern) {
        Format::Nmea => file.time.column != "prefix",
        Format::Mcap | Format::Bag | Format::Db3 => {
            [LOG_TIME, PUBLISH_TIME].contains(&file.time.column.as_str())
        }
        Format::Csv | Format::Parquet | Format::Ulg => false,
    });
    kinds.reduce(|a, b| a && b)
}

fn check_time(file: &FileSpec) -> Result<(), Invalid> {
    let time = &file.time;
    if tells_itself(file) == Some(true) {
        return match time.unit.is_some() || time.format.is_some() || time.zone.is_some() {
            true => {
                let given = format!("`unit` of `{}`, or its `format` or `zone`", time.column);
                Err(Invalid::new("`time`", given, "none: it is known", "remove it"))
            }
            false => Ok(()),
        };
    }
    let has_stamps = |format: Format| format.is_bag() && format != Format::Ulg;
    let is_stamped = file.pattern.iter().all(|pattern| has_stamps(file.format_of(pattern)));
    if time.unit.is_some() == time.format.is_some() && !is_stamped {
        let given = if time.unit.is_some() { "both `unit` and `format`" } else { "no `unit`" };
        let expected = "a `unit`, or the `format` of times that are text";
        return Err(Invalid::new("`time`", given, expected, "name one of the two"));
    }
    if time.zone.is_some() && !time.is_text() {
        let given = "`zone` of a time that is a number";
        return Err(Invalid::new("`time`", given, "it for times that are text", "remove `zone`"));
    }
    if time.nanoseconds.is_some() && time.unit != Some(TimeUnit::S) {
        let given = "`nanoseconds` beside another unit than seconds";
        return Err(Invalid::new("`time`", given, "whole seconds in `column`", "set `unit = \"s\"`"));
    }
    Ok(())
}
