//! From patterns to files and from files to recordings.

use std::path::Path;

use artifact::Error;
use logs::{Naming, Pattern, Source};
use refusal::{Invalid, nearest};
use study::ingest_file::IngestFile;

use crate::failure::Failure;

/// Finds the recordings in `folder`, in the order of their names.
///
/// # Errors
/// A pattern without files; what [`Naming::sources`] refuses.
pub fn find(
    config: &IngestFile,
    naming: &Naming,
    config_path: &Path,
    folder: &Path,
) -> Result<Vec<Source>, Failure> {
    let mut files = Vec::with_capacity(config.file.len());
    for spec in &config.file {
        let mut group = Vec::new();
        for pattern in &spec.pattern {
            let found = matching(folder, pattern)?;
            if found.is_empty() {
                return Err(Failure::invalid(config_path, &no_file(folder, pattern)));
            }
            group.extend(found);
        }
        files.push(group);
    }
    naming.sources(&config.file, &files).map_err(|e| Failure::invalid(config_path, &e))
}

/// The files below `folder` that fit `pattern`, sorted.
fn matching(folder: &Path, pattern: &str) -> Result<Vec<String>, Failure> {
    let mut found = vec![String::new()];
    let steps: Vec<&str> = pattern.split('/').filter(|step| !step.is_empty() && *step != ".").collect();
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == steps.len();
        let glob = Pattern::new(step);
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
    let unreadable = |e: std::io::Error| Failure::from(Error::io(folder, "read", e));
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

fn no_file(folder: &Path, pattern: &str) -> Invalid {
    let name = pattern.rsplit('/').next().unwrap_or(pattern);
    let parent = pattern.strip_suffix(name).unwrap_or_default();
    let names = entries(&folder.join(parent)).unwrap_or_default();
    let near = nearest(name, names.iter().map(|(name, _)| name.as_str()));
    let meant = near.map_or(String::new(), |near| format!(" (did you mean `{parent}{near}`?)"));
    Invalid::new(
        format!("pattern `{pattern}`"),
        "no file",
        format!("at least one file in {}", folder.display()),
        format!("correct the pattern or name the folder with --logs{meant}"),
    )
}
