//! Parts of a bag of ROS 2, which its recorder lists in `metadata.yaml` beside them.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use files::{Error, exists, observe_names, open};
use refusal::{Invalid, foreign};

use crate::invalid;

const LIST: &str = "metadata.yaml";

/// Most bytes of a list that are read.
const LONGEST: u64 = 1 << 20;

/// Refuses bags among `files` in `folder` of which a listed part is not there.
///
/// # Errors
/// A part that is not there; a list that cannot be read.
pub(super) fn check_parts(folder: &Path, files: &[String]) -> Result<(), Error> {
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
            let found = format!("no file `{}` beside it", foreign(part));
            let remedy = "copy this part too, or remove it from the list";
            return Err(invalid(&path, &Invalid::new("parts", found, "all parts that it lists", remedy)));
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
