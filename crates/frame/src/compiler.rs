//! Libraries that a C compiler of this machine builds, where there is one.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

use crate::failure::Failure;

/// What `compiler` makes of the sources `files` (name and text) with `flags`; none where there is no such program. It works in a
/// folder of its own, whose name leaves no trace in what it makes.
///
/// # Errors
/// A folder that cannot be written, sources that do not compile.
pub fn compiled(
    compiler: &str,
    flags: &[&str],
    files: &[(String, String)],
) -> Result<Option<Vec<u8>>, Failure> {
    let failed = |what: String| Failure::Failed(format!("{compiler}: {what}"));
    let folder = tempfile::tempdir().map_err(|e| failed(format!("temporary folder: {e}")))?;
    let io = |e: std::io::Error| artifact::Error::io(folder.path(), "use", e);
    for (name, text) in files {
        fs::write(folder.path().join(name), text).map_err(io)?;
    }
    let sources = files
        .iter()
        .map(|(name, _)| name)
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == "c"));
    let mut command = Command::new(compiler);
    command.args(flags).args(sources).args(["-o", "library", "-lm"]).current_dir(&folder);
    let output = match command.output() {
        Ok(output) => output,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(error.to_string())),
    };
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let first = said.lines().find(|line| line.contains("error")).unwrap_or("no word of why").trim();
        return Err(failed(format!(
            "found that it does not compile the unit ({first}), expected a C99 compiler; name another"
        )));
    }
    Ok(Some(fs::read(folder.path().join("library")).map_err(io)?))
}
