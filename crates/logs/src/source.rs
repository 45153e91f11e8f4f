//! From the names of files to recordings.

use std::collections::BTreeMap;

use refusal::{Invalid, check_name, foreign};

use crate::{FileSpec, Template};

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
    pub kind: Kind,
}

/// The kind of maneuver of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
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
                let own =
                    recordings.entry(name.clone()).or_insert_with(|| vec![Vec::new(); self.recordings.len()]);
                let parts = &mut own[group];
                match parts.first() {
                    Some(other) if template.is_none() && other != file => {
                        let remedy = "rename a file, or say in `run_from_file` which are parts of one run";
                        let found = format!("`{}` and `{}`", foreign(other), foreign(file));
                        return Err(Invalid::new(called(&name), found, "one file", remedy));
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
            Kind::Given(kind) => kind.clone(),
            Kind::Named(template) => named(template, first)?,
            Kind::Recording => name.clone(),
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
