//! Outputs on full disks, and closed pipes.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Output};

use crate::asked;
use crate::ends::{Fault, Tally, Wrong};
use crate::grounds::files;
use crate::points::{Watched, for_every_stage};
use crate::support::{SEATRIAL, is_progress};

/// Runs a script in the folder of a stage, with the program and the words of its line.
fn script(watched: &Watched, text: &str) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", text, SEATRIAL]).args(watched.line.split_whitespace());
    command.current_dir(watched.place.path()).env("RUST_BACKTRACE", "0").output().unwrap()
}

/// Runs on a disk of `kib` KiB with the old result: it ends with the new one, or fails and leaves the old one.
fn on_small_disk(watched: &Watched, kib: u64) -> Result<bool, Fault> {
    let text = format!(
        "mount -t tmpfs -o size={kib}k tmpfs out || exit 99; cp -r old/. out/ || exit 98; \"$0\" \"$@\"; code=$?; \
         cp -r out/. seen/; exit $code"
    );
    let folder = watched.place.path();
    for name in ["old", "seen"] {
        let _ = fs::remove_dir_all(folder.join(name));
        fs::create_dir(folder.join(name)).unwrap();
    }
    crate::grounds::write(&folder.join("old"), &watched.before);
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &text, SEATRIAL]).args(watched.line.split_whitespace());
    let output = command.current_dir(folder).env("RUST_BACKTRACE", "0").output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    // A slow machine reports progress.
    let told: Vec<&str> = told.lines().filter(|line| !is_progress(line)).collect();
    let told = told.join("\n");
    let found = files(&folder.join("seen"));
    for name in ["old", "seen"] {
        fs::remove_dir_all(folder.join(name)).unwrap();
    }
    match output.status.code() {
        Some(0) if found == watched.after => Ok(true),
        // The old result alone does not fit.
        Some(98) => Ok(false),
        Some(1) if told.lines().count() != 1 => Err((Wrong::Lines, told)),
        Some(1 | 3) if found == watched.before => Ok(false),
        Some(code @ (0 | 1 | 3)) => {
            let names: Vec<&String> = found.keys().collect();
            Err((Wrong::Mixed, format!("exit code {code}, on {kib} KiB: {names:?}: {told}")))
        }
        other => Err((Wrong::Other, format!("exit code {other:?}, on {kib} KiB: {told}"))),
    }
}

/// Why no small disk can be had here.
fn no_mount() -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new("unshare");
    command.args(["-m", "mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(folder.path());
    match command.output() {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        Err(error) => Some(error.to_string()),
    }
}

#[test]
fn law_a_full_disk_leaves_the_old_files_or_the_new() {
    if let Some(reason) = no_mount() {
        println!("skipped: full disks: {reason}");
        return;
    }
    let steps = asked().map_or(2, |_| 16);
    for_every_stage("full disks", |_, ground, stage| {
        let watched = Watched::new(ground, stage);
        let pages = |files: &BTreeMap<String, Vec<u8>>| {
            files.values().map(|b| b.len() as u64 / 4096 + 1).sum::<u64>()
        };
        let (old, new) = (pages(&watched.before), pages(&watched.after));
        let mut tally = Tally::default();
        for step in 0..steps {
            // From no space besides the old result to all that the new one needs.
            let kib = 4 * (old + 2 + (new + 4) * step / steps);
            tally.fault(&watched.line, on_small_disk(&watched, kib));
        }
        tally
    });
}

#[test]
fn law_closed_or_full_outputs_are_no_panic_in_any_stage() {
    const REDIRECTIONS: [(&str, i32); 5] =
        [(">&-", 0), ("2>&-", 0), (">/dev/full", 1), ("2>/dev/full", 0), (">&- 2>&-", 0)];
    let each = asked().map_or(1, |_| REDIRECTIONS.len());
    for_every_stage("closed outputs", |stage, ground, line| {
        let watched = Watched::new(ground, line);
        let mut tally = Tally::default();
        for i in 0..each {
            let (redirection, expected) = REDIRECTIONS[(stage + i) % REDIRECTIONS.len()];
            watched.place.put_outputs(&watched.before);
            let status = script(&watched, &format!("exec \"$0\" \"$@\" {redirection}")).status;
            let found = match status.code() {
                Some(code) if code == expected => watched.is_new(true),
                _ => Err((Wrong::Other, format!("{status}"))),
            };
            tally.fault(&format!("{} {redirection}", watched.line), found);
        }
        tally
    });
}
