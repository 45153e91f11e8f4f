//! From patterns to recordings.

use std::collections::BTreeMap;
use std::path::Path;

use vessel::nearest;

use super::config::IngestFile;
use super::pattern::Pattern;
use crate::failure::Failure;

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

/// Finds the recordings in `folder`, in the order of their names.
///
/// # Errors
/// A pattern without files, a template that fits no file, a recording that lacks a file of one of the groups or has two.
pub fn find(config: &IngestFile, config_path: &Path, folder: &Path) -> Result<Vec<Source>, Failure> {
    let refuse = |thing: String, found: &str, expected: &str, remedy: &str| {
        Err(Failure::refuse(config_path, &thing, found, expected, remedy))
    };
    let groups = config.file.len();
    let mut recordings: BTreeMap<String, Vec<Option<String>>> = BTreeMap::new();
    for (group, spec) in config.file.iter().enumerate() {
        let template =
            spec.run_from_file.as_deref().map(|text| template(config_path, "run_from_file", text, "run"));
        let template = template.transpose()?;
        for pattern in &spec.pattern {
            let found = matching(folder, pattern)?;
            if found.is_empty() {
                let expected = format!("at least one file in {}", folder.display());
                return refuse(
                    format!("pattern `{pattern}`"),
                    "no file",
                    &expected,
                    &remedy(folder, pattern),
                );
            }
            for file in found {
                let name = match &template {
                    Some((template, text)) => named(config_path, template, text, &file, "run")?,
                    None => stem(&file).to_owned(),
                };
                let files = recordings.entry(name.clone()).or_insert_with(|| vec![None; groups]);
                match files[group].replace(file.clone()) {
                    Some(other) if other != file => {
                        let found = format!("`{other}` and `{file}`");
                        let thing = format!("run `{name}`");
                        return refuse(
                            thing,
                            &found,
                            "one file of each group",
                            "correct `run_from_file` or rename a file",
                        );
                    }
                    _ => {}
                }
            }
        }
    }
    let kind = config
        .maneuver_from_file
        .as_deref()
        .map(|text| template(config_path, "maneuver_from_file", text, "kind"));
    let kind = kind.transpose()?;
    let mut sources = Vec::with_capacity(recordings.len());
    for (name, files) in recordings {
        if let Some(group) = files.iter().position(Option::is_none) {
            let patterns = config.file[group].pattern.join("`, `");
            let expected = format!("a file of every group; none of `{patterns}`");
            return refuse(
                format!("run `{name}`"),
                "some of its files",
                &expected,
                "add the file or narrow the patterns",
            );
        }
        let files: Vec<String> = files.into_iter().flatten().collect();
        let kind = match (&kind, &config.maneuver) {
            (Some((template, text)), _) => named(config_path, template, text, &files[0], "kind")?,
            (None, Some(maneuver)) => maneuver.clone(),
            (None, None) => name.clone(),
        };
        sources.push(Source { name, files, kind });
    }
    Ok(sources)
}

/// A template that names a part `part`.
fn template<'a>(path: &Path, key: &str, text: &'a str, part: &str) -> Result<(Pattern, &'a str), Failure> {
    match Pattern::template(text).filter(|template| template.names(part)) {
        Some(template) => Ok((template, text)),
        None => Err(Failure::refuse(
            path,
            &format!("`{key}`"),
            &format!("`{text}`"),
            &format!("a template such as `{{{part}}}_*.csv`"),
            &format!("say where `{{{part}}}` is"),
        )),
    }
}

fn named(path: &Path, template: &Pattern, text: &str, file: &str, part: &str) -> Result<String, Failure> {
    let subject = if text.contains('/') { file } else { name_of(file) };
    template.part(subject, part).map(str::to_owned).ok_or_else(|| {
        let expected = format!("a name that fits `{text}`");
        Failure::refuse(
            path,
            "file name",
            &format!("`{file}`"),
            &expected,
            "correct the template or narrow the pattern",
        )
    })
}

fn name_of(file: &str) -> &str {
    file.rsplit('/').next().unwrap_or(file)
}

/// The file's name up to its extension.
fn stem(file: &str) -> &str {
    let name = name_of(file);
    let name = name.strip_suffix(".gz").unwrap_or(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// The files below `folder` that fit `pattern`, sorted.
fn matching(folder: &Path, pattern: &str) -> Result<Vec<String>, Failure> {
    let mut found = vec![String::new()];
    let steps: Vec<&str> = pattern.split('/').filter(|step| !step.is_empty() && *step != ".").collect();
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == steps.len();
        let glob = Pattern::glob(step);
        let mut next = Vec::new();
        for before in &found {
            for (name, is_folder) in entries(&folder.join(before))? {
                if is_folder != last && glob.fits(&name) {
                    next.push(if before.is_empty() { name } else { format!("{before}/{name}") });
                }
            }
        }
        found = next;
    }
    found.sort();
    Ok(if steps.is_empty() { Vec::new() } else { found })
}

/// Names in `folder` and whether they are folders; none where there is no such folder.
fn entries(folder: &Path) -> Result<Vec<(String, bool)>, Failure> {
    let unreadable = |e: std::io::Error| Failure::from(artifact::Error::io(folder, "read", e));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let listed = match std::fs::read_dir(folder) {
        Ok(listed) => listed,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(unreadable(e)),
    };
    let mut names = Vec::new();
    for entry in listed {
        let path = entry.map_err(unreadable)?.path();
        if let Some(name) = path.file_name().and_then(|name| name.to_str()) {
            names.push((name.to_owned(), path.is_dir()));
        }
    }
    Ok(names)
}

fn remedy(folder: &Path, pattern: &str) -> String {
    let name = name_of(pattern);
    let parent = pattern.strip_suffix(name).unwrap_or_default();
    let names: Vec<String> =
        entries(&folder.join(parent)).unwrap_or_default().into_iter().map(|(name, _)| name).collect();
    match nearest(name, names.iter().map(String::as_str)) {
        Some(near) => {
            format!("correct the pattern or name the folder with --logs (did you mean `{parent}{near}`?)")
        }
        None => "correct the pattern or name the folder with --logs".to_owned(),
    }
}
