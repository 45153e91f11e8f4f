//! From the names of files to recordings.

use std::collections::BTreeMap;

use refusal::{Invalid, check_name, foreign};

use crate::stamp::moment;
use crate::suspicion::{Oddity, WarningKind};
use crate::{Channels, FileSpec};

/// The files of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Name of the recording.
    pub name: String,
    /// Per group of files, its parts in the order of their names, relative to the folder of the logs, with
    /// `/` between folders.
    pub files: Vec<Vec<String>>,
    /// Its kind of maneuver.
    pub kind: String,
}

/// How recordings are recognized by the names of their files.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// Per group of files, where the recording's name stands; without a template each file is a recording,
    /// named like the file.
    pub recordings: Vec<Option<Template>>,
    /// Their maneuvers.
    pub kind: ManeuverKind,
}

/// The kind of maneuver of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum ManeuverKind {
    /// The same in all.
    Given(String),
    /// As the name of the file of the first group says.
    Named(Template),
    /// The recording's name.
    Recording,
}

impl Naming {
    /// The recordings that the `files` of `specs`, group by group, belong to, in the order of their names.
    /// Files of one group and one recording are its parts.
    ///
    /// # Errors
    /// A template that does not fit a file, a recording that lacks files of one of the groups, or that has two files where
    /// there is no template.
    pub fn sources(&self, specs: &[FileSpec], files: &[Vec<String>]) -> Result<Vec<Source>, Invalid> {
        let mut recordings: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
        for (group, (template, files)) in self.recordings.iter().zip(files).enumerate() {
            for file in files {
                let name = match template {
                    Some(template) => named(template, file)?,
                    None => stem(file).to_owned(),
                };
                let groups =
                    recordings.entry(name.clone()).or_insert_with(|| vec![Vec::new(); self.recordings.len()]);
                let parts = &mut groups[group];
                match parts.first() {
                    Some(other) if template.is_none() && other != file => {
                        let remedy = "rename a file, or say in `run_from_file` which are parts of one run";
                        let files = format!("`{}` and `{}`", foreign(other), foreign(file));
                        return Err(Invalid::new(called(&name), files, "one file", remedy));
                    }
                    _ if parts.contains(file) => {}
                    _ => parts.push(file.clone()),
                }
            }
        }
        recordings.into_iter().map(|(name, files)| self.source(name, specs, files)).collect()
    }

    fn source(
        &self,
        name: String,
        specs: &[FileSpec],
        mut files: Vec<Vec<String>>,
    ) -> Result<Source, Invalid> {
        let is_lacking = |(spec, parts): &(&FileSpec, &Vec<String>)| parts.is_empty() && !spec.optional;
        if let Some((spec, _)) = specs.iter().zip(&files).find(is_lacking) {
            let expected = format!("a file of every group; none of `{}`", spec.pattern.join("`, `"));
            let remedy = "add the file, narrow the patterns, or set `optional = true` in its [[file]]";
            return Err(Invalid::new(called(&name), "some of its files", expected, remedy));
        }
        files.iter_mut().for_each(|parts| parts.sort_by_key(|name| counted(name)));
        let first = files.iter().flatten().next().map_or("", String::as_str);
        let kind = match &self.kind {
            ManeuverKind::Given(kind) => kind.clone(),
            ManeuverKind::Named(template) => named(template, first)?,
            ManeuverKind::Recording => name.clone(),
        };
        let made = Source { name, kind, files: Vec::new() };
        check_name(format!("recording of `{}`", foreign(first)), &made.name)?;
        check_name(format!("maneuver of `{}`", foreign(first)), &made.kind)?;
        Ok(Source { files, ..made })
    }
}

/// A sort key of a name in natural order: `a_10` after `a_9`.
fn counted(name: &str) -> Vec<(bool, String, String)> {
    let mut chunks: Vec<(bool, String, String)> = Vec::new();
    for c in name.chars() {
        let is_digit = c.is_ascii_digit();
        match chunks.last_mut().filter(|(last, ..)| *last == is_digit) {
            Some((_, chunk, _)) => chunk.push(c),
            None => chunks.push((is_digit, c.to_string(), String::new())),
        }
    }
    for (is_number, chunk, tail) in &mut chunks {
        if *is_number {
            // Longer numbers are larger; leading zeros count last.
            let digits = chunk.trim_start_matches('0').to_owned();
            *tail = std::mem::replace(chunk, format!("{:06}{digits}", digits.len()));
        }
    }
    chunks
}

/// The template's part of a file's name, or of its path where the template has a `/`.
fn named(template: &Template, file: &str) -> Result<String, Invalid> {
    let subject = if template.text().contains('/') { file } else { base(file) };
    template.part(subject).map(str::to_owned).ok_or_else(|| {
        let expected = format!("a name that fits `{}`", template.text());
        let remedy = "correct the template or narrow the pattern";
        Invalid::new("file name", format!("`{file}`"), expected, remedy)
    })
}

/// How messages name a recording.
pub(crate) fn called(name: &str) -> String {
    format!("run `{name}`")
}

fn base(file: &str) -> &str {
    file.rsplit('/').next().unwrap_or(file)
}

/// The file's name up to its extension.
fn stem(file: &str) -> &str {
    let name = base(file);
    let name = name.strip_suffix(".gz").unwrap_or(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

// Patterns of file names: `*` for anything but `/`, and `{name}` for a part to be extracted.

/// A token of a pattern.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Text(String),
    /// Anything, also nothing.
    Any,
    /// At least one character: the part to be extracted.
    Part,
    /// At least one character.
    Some,
}

/// A pattern in which only `*` is special.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern(Vec<Token>);

impl Pattern {
    /// Parses a pattern.
    pub fn new(text: &str) -> Self {
        Self(tokens(text))
    }

    /// Whether `text` fits.
    pub fn fits(&self, text: &str) -> bool {
        fit(&self.0, text).is_some()
    }
}

/// A pattern in which `*` and `{name}` are special, with one such part to be extracted.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    text: String,
    tokens: Vec<Token>,
}

impl Template {
    /// Parses a template with a part called `name`; `None` where there is no such part, a brace is unclosed
    /// or its name empty.
    pub fn new(text: &str, name: &str) -> Option<Self> {
        let mut matches = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            matches.extend(tokens(before));
            let (named, after) = after.split_once('}')?;
            if named.is_empty() || named.contains('{') {
                return None;
            }
            let first = named == name && !matches.contains(&Token::Part);
            matches.push(if first { Token::Part } else { Token::Some });
            rest = after;
        }
        matches.extend(tokens(rest));
        matches.contains(&Token::Part).then(|| Self { text: text.to_owned(), tokens: matches })
    }

    /// As written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The extracted part where `text` fits; parts are as short as possible.
    pub fn part<'a>(&self, text: &'a str) -> Option<&'a str> {
        fit(&self.tokens, text)?
    }
}

/// Texts, and [`Token::Any`] where stars are between them.
fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    for (i, part) in text.split('*').enumerate() {
        tokens.extend((i > 0).then_some(Token::Any));
        tokens.extend((!part.is_empty()).then(|| Token::Text(part.to_owned())));
    }
    tokens
}

/// Whether `text` fits `tokens`, and then the extracted part.
fn fit<'a>(tokens: &[Token], text: &'a str) -> Option<Option<&'a str>> {
    let Some((token, rest)) = tokens.split_first() else { return text.is_empty().then_some(None) };
    if let Token::Text(known) = token {
        return fit(rest, text.strip_prefix(known.as_str())?);
    }
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]);
    let ends = ends.skip(usize::from(*token != Token::Any)).take_while(|end| !text[..*end].contains('/'));
    let fitting = |end: usize| {
        let captured = fit(rest, &text[end..])?;
        Some(if *token == Token::Part { Some(&text[..end]) } else { captured })
    };
    ends.into_iter().find_map(fitting)
}

/// Share of a recording that some needed channel may not cover.
const UNCOVERED: f64 = 0.1;

/// Needed channels by their first and last times \[s\].
pub(crate) struct Spans(Vec<([f64; 2], Vec<String>)>);

impl Spans {
    /// Of those of `channels` that are `needed`, whose clock starts at `start_s`.
    pub(crate) fn of<'a>(channels: &Channels, needed: impl Iterator<Item = &'a str>, start_s: f64) -> Self {
        let mut all: Vec<([f64; 2], Vec<String>)> = Vec::new();
        for name in needed {
            let Some(t) = channels.get(name).map(|series| &series.t) else { continue };
            let (Some(first), Some(last)) = (t.first(), t.last()) else { continue };
            let span = [start_s + first, start_s + last];
            match all.iter_mut().find(|(other, _)| *other == span) {
                Some((_, names)) => names.push(format!("`{name}`")),
                None => all.push((span, vec![format!("`{name}`")])),
            }
        }
        Self(all)
    }

    /// The time that all have in common, and the channels that begin last and end first (or last, where these are the same), in
    /// words.
    fn common(&self) -> Option<([f64; 2], String)> {
        let late = self.0.iter().max_by(|a, b| a.0[0].total_cmp(&b.0[0]))?;
        let early = self.0.iter().min_by(|a, b| a.0[1].total_cmp(&b.0[1]))?;
        let other = self.0.iter().filter(|entry| entry.0 != late.0).max_by(|a, b| a.0[1].total_cmp(&b.0[1]));
        let is_dated = self.0.iter().any(|([_, to], _)| *to > 1e8);
        let said = |([from, to], names): &([f64; 2], Vec<String>)| {
            let [from, to] =
                [from, to].map(|end| if is_dated { moment(*end) } else { format!("{end:.1} s") });
            format!("{} from {from} to {to}", names.join(", "))
        };
        let first = if early.0 == late.0 { other? } else { early };
        Some(([late.0[0], early.0[1]], format!("{}; {}", said(late), said(first))))
    }

    /// Refuses channels that were never logged at the same time.
    pub(crate) fn check(&self, source: &Source) -> Result<(), Invalid> {
        let Some((_, said)) = self.common().filter(|([from, to], _)| from > to) else { return Ok(()) };
        Err(Invalid::new(
            called(&source.name),
            said,
            "channels that were logged at the same time",
            "check the clock of each [[file]]: simulated time beside a computer's? Name one that all have as `time`, such as \
             `log_time` of bags, or set its `offset_s`",
        ))
    }

    /// The warning where not all channels cover much of the recording.
    pub(crate) fn uncovered(&self, max_gap_s: f64) -> Option<(String, Oddity)> {
        let ([from, to], said) = self.common()?;
        let end =
            |end: usize, more: fn(f64, f64) -> f64| self.0.iter().map(|entry| entry.0[end]).reduce(more);
        let whole_s = end(1, f64::max)? - end(0, f64::min)?;
        let lost_s = whole_s - (to - from);
        let text = format!(
            "and others cover different times, {lost_s:.1} s of {whole_s:.1} s ({:.0} %) are not covered by all: {said}; compare the \
             clocks",
            100.0 * lost_s / whole_s
        );
        let name = said.split('`').nth(1)?.to_owned();
        (lost_s > (UNCOVERED * whole_s).max(2.0 * max_gap_s)).then_some((name, (WarningKind::Clock, 1, text)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_as_people_count() {
        let mut names = ["a_10.csv", "a_9.csv", "a_1.csv", "a_01.csv", "a_2_b.csv", "b_0.csv"];
        names.sort_by_key(|name| counted(name));
        assert_eq!(names, ["a_01.csv", "a_1.csv", "a_2_b.csv", "a_9.csv", "a_10.csv", "b_0.csv"]);
    }
}
