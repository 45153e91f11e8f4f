//! From patterns to files and from files to recordings.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use files::{Error, exists, observe_names, open};
use logs::{Naming, Pattern, Source};
use refusal::{Invalid, foreign, nearest};

use super::IngestFile;
use crate::invalid;

/// Finds the recordings in `folder`, in the order of their names.
///
/// # Errors
/// A pattern without files; a bag of which a part is not there; what [`Naming::sources`] refuses.
pub fn find(
    config: &IngestFile,
    naming: &Naming,
    config_path: &Path,
    folder: &Path,
) -> Result<Vec<Source>, Error> {
    let mut files = Vec::with_capacity(config.file.len());
    for spec in &config.file {
        let mut group = Vec::new();
        for pattern in &spec.pattern {
            let names = matching(folder, pattern)?;
            if names.is_empty() && !spec.optional {
                return Err(invalid(config_path, &no_file(folder, pattern)));
            }
            if spec.format_of(pattern).is_bag() {
                check_parts(folder, &names)?;
            }
            group.extend(names);
        }
        files.push(group);
    }
    naming.sources(&config.file, &files).map_err(|e| invalid(config_path, &e))
}

/// The files below `folder` that match `pattern`, sorted.
fn matching(folder: &Path, pattern: &str) -> Result<Vec<String>, Error> {
    let mut names = vec![String::new()];
    let steps: Vec<&str> = pattern.split('/').filter(|step| !step.is_empty() && *step != ".").collect();
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == steps.len();
        let glob = Pattern::new(step);
        let mut next = Vec::new();
        for before in &names {
            observe_names(&folder.join(before), step);
            for FolderEntry { name, is_text, is_folder } in entries(&folder.join(before))? {
                if is_folder == last || !glob.fits(&name) {
                    continue;
                }
                if !is_text {
                    return Err(invalid(folder, &no_text(&name)));
                }
                next.push(if before.is_empty() { name } else { format!("{before}/{name}") });
            }
        }
        names = next;
    }
    names.sort();
    Ok(if steps.is_empty() { Vec::new() } else { names })
}

/// An entry of a folder.
struct FolderEntry {
    /// Its name, lossily converted to text.
    name: String,
    /// Whether the name is valid text.
    is_text: bool,
    is_folder: bool,
}

/// Recordings are named after their files, and documents name them in text.
fn no_text(name: &str) -> Invalid {
    Invalid::new(format!("log `{name}`"), "a name that is not UTF-8", "a name in UTF-8", "rename it")
}

/// The entries of `folder`; empty if it does not exist.
fn entries(folder: &Path) -> Result<Vec<FolderEntry>, Error> {
    let unreadable = |e: std::io::Error| Error::io(folder, "read", e);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let listed = match std::fs::read_dir(folder) {
        Ok(listed) => listed,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(unreadable(e)),
    };
    let mut names = Vec::new();
    for entry in listed {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name();
        names.push(FolderEntry {
            name: name.to_string_lossy().into_owned(),
            is_text: name.to_str().is_some(),
            is_folder: entry.path().is_dir(),
        });
    }
    Ok(names)
}

fn no_file(folder: &Path, pattern: &str) -> Invalid {
    let name = pattern.rsplit('/').next().unwrap_or(pattern);
    let parent = pattern.strip_suffix(name).unwrap_or_default();
    let names = entries(&folder.join(parent)).unwrap_or_default();
    let near = nearest(name, names.iter().map(|entry| entry.name.as_str()));
    let meant = near.map_or(String::new(), |near| format!(" (did you mean `{parent}{near}`?)"));
    let expected = format!("at least one file in {}", folder.display());
    let remedy = format!("correct the pattern or name the folder with --logs{meant}");
    Invalid::new(format!("pattern `{pattern}`"), "no file", expected, remedy)
}

// Parts of a bag of ROS 2, which its recorder lists in `metadata.yaml` beside them.

const LIST: &str = "metadata.yaml";

/// Most bytes of a list that are read.
const LONGEST: u64 = 1 << 20;

/// Refuses bags among `files` in `folder` of which a listed part is not there.
fn check_parts(folder: &Path, files: &[String]) -> Result<(), Error> {
    let split = |file: &String| file.rsplit_once('/').map_or("", |(parent, _)| parent).to_owned();
    let parents: BTreeSet<String> = files.iter().map(split).collect();
    for parent in parents {
        let path = folder.join(&parent).join(LIST);
        if !exists(&path) {
            continue;
        }
        let mut text = String::new();
        let read = open(&path)?.take(LONGEST).read_to_string(&mut text);
        read.map_err(|e| Error::io(&path, "read", e))?;
        let parts = listed(&text);
        let here = folder.join(&parent);
        parts.iter().for_each(|part| observe_names(&here, part));
        let is_own = parts.iter().any(|part| {
            let name = if parent.is_empty() { (*part).to_owned() } else { format!("{parent}/{part}") };
            files.contains(&name)
        });
        if let Some(part) = parts.iter().find(|part| is_own && !here.join(part).exists()) {
            let given = format!("no file `{}` beside it", foreign(part));
            let remedy = "copy this part too, or remove it from the list";
            return Err(invalid(&path, &Invalid::new("parts", given, "all parts that it lists", remedy)));
        }
    }
    Ok(())
}

/// The parts that a list names, without folders.
fn listed(text: &str) -> Vec<&str> {
    let after = text.lines().skip_while(|line| line.trim() != "relative_file_paths:").skip(1);
    let items = after.map_while(|line| line.trim_start().strip_prefix("- "));
    items.map(|item| base(item.trim().trim_matches(['"', '\'']))).collect()
}

fn base(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
