//! From the names of files to recordings.

use std::collections::BTreeMap;

use refusal::{Invalid, check_name, foreign};

use crate::{FileSpec, Template};

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

impl Naming {
    /// The recordings that the `files` of `specs`, group by group, are of, in the order of their names.
    ///
    /// # Errors
    /// A template that does not fit a file, a recording that lacks a file of one of the groups or has two.
    pub fn sources(&self, specs: &[FileSpec], files: &[Vec<String>]) -> Result<Vec<Source>, Invalid> {
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
                        let remedy = "correct `run_from_file` or rename a file";
                        let found = format!("`{other}` and `{file}`");
                        return Err(Invalid::new(called(&name), found, "one file of each group", remedy));
                    }
                    _ => {}
                }
            }
        }
        recordings.into_iter().map(|(name, files)| self.source(name, specs, files)).collect()
    }

    fn source(
        &self,
        name: String,
        specs: &[FileSpec],
        files: Vec<Option<String>>,
    ) -> Result<Source, Invalid> {
        if let Some((spec, _)) = specs.iter().zip(&files).find(|(_, file)| file.is_none()) {
            let expected = format!("a file of every group; none of `{}`", spec.pattern.join("`, `"));
            let remedy = "add the file or narrow the patterns";
            return Err(Invalid::new(called(&name), "some of its files", expected, remedy));
        }
        let files: Vec<String> = files.into_iter().flatten().collect();
        let kind = match &self.kind {
            Kind::Given(kind) => kind.clone(),
            Kind::Named(template) => named(template, &files[0])?,
            Kind::Recording => name.clone(),
        };
        check_name(format!("recording of `{}`", foreign(&files[0])), &name)?;
        check_name(format!("maneuver of `{}`", foreign(&files[0])), &kind)?;
        Ok(Source { name, files, kind })
    }
}

/// The part of a file's name, or of its path where the template has a `/`.
fn named(template: &Template, file: &str) -> Result<String, Invalid> {
    let subject = if template.text().contains('/') { file } else { base(file) };
    template.part(subject).map(str::to_owned).ok_or_else(|| {
        let expected = format!("a name that fits `{}`", template.text());
        let remedy = "correct the template or narrow the pattern";
        Invalid::new("file name", format!("`{file}`"), expected, remedy)
    })
}

/// What messages call a recording.
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
