//! From the names of files to recordings.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::Template;

/// The files of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Name of the recording.
    pub name: String,
    /// Per group of files, the file relative to the folder of the logs, with `/` between folders.
    pub files: Vec<String>,
    /// Its kind of maneuver.
    pub kind: String,
}

/// How recordings are known by the names of their files.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// Per group of files, where the recording's name stands; without a template each file is a recording, named as the
    /// file.
    pub recordings: Vec<Option<Template>>,
    /// Their maneuvers.
    pub kind: Kind,
}

/// What maneuver is run in a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// The same in all.
    Given(String),
    /// As the name of the file of the first group says.
    Named(Template),
    /// It is called as the recording.
    Recording,
}

/// Why files make no recordings.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SourceError {
    /// A file whose name has no such part.
    #[error("the name of `{file}` does not fit `{template}`")]
    Unnamed {
        /// The file.
        file: String,
        /// The template.
        template: String,
    },
    /// Two files of a group for one recording.
    #[error("`{}` and `{}` for run `{run}`", .files[0], .files[1])]
    Two {
        /// The recording.
        run: String,
        /// The files.
        files: [String; 2],
    },
    /// No file of a group for a recording.
    #[error("no file of group {group} for run `{run}`")]
    NoFile {
        /// The recording.
        run: String,
        /// The group, from 0.
        group: usize,
    },
}

impl Naming {
    /// The recordings that `files`, group by group, are of, in the order of their names.
    ///
    /// # Errors
    /// A template that does not fit a file, a recording that lacks a file of one of the groups or has two.
    pub fn sources(&self, files: &[Vec<String>]) -> Result<Vec<Source>, SourceError> {
        let mut recordings: BTreeMap<String, Vec<Option<String>>> = BTreeMap::new();
        for (group, (template, files)) in self.recordings.iter().zip(files).enumerate() {
            for file in files {
                let name = match template {
                    Some(template) => named(template, file)?,
                    None => stem(file).to_owned(),
                };
                let own = recordings.entry(name.clone()).or_insert_with(|| vec![None; self.recordings.len()]);
                match own[group].replace(file.clone()) {
                    Some(other) if other != *file => {
                        return Err(SourceError::Two { run: name, files: [other, file.clone()] });
                    }
                    _ => {}
                }
            }
        }
        recordings.into_iter().map(|(name, files)| self.source(name, files)).collect()
    }

    fn source(&self, name: String, files: Vec<Option<String>>) -> Result<Source, SourceError> {
        if let Some(group) = files.iter().position(Option::is_none) {
            return Err(SourceError::NoFile { run: name, group });
        }
        let files: Vec<String> = files.into_iter().flatten().collect();
        let kind = match &self.kind {
            Kind::Given(kind) => kind.clone(),
            Kind::Named(template) => named(template, &files[0])?,
            Kind::Recording => name.clone(),
        };
        Ok(Source { name, files, kind })
    }
}

/// The part of a file's name, or of its path where the template has a `/`.
fn named(template: &Template, file: &str) -> Result<String, SourceError> {
    let subject = if template.text().contains('/') { file } else { base(file) };
    template.part(subject).map(str::to_owned).ok_or_else(|| {
        let template = template.text().to_owned();
        SourceError::Unnamed { file: file.to_owned(), template }
    })
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
