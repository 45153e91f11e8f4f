//! Units whose compiler is killed, and channels with names that C uses otherwise.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::support::*;

/// Identifiers that C compilers and their headers define, or keywords.
const TAKEN: [&str; 16] = [
    "linux",
    "unix",
    "I",
    "errno",
    "NULL",
    "near",
    "far",
    "complex",
    "bool",
    "M_PI",
    "stdin",
    "INFINITY",
    "interface",
    "typeof",
    "new",
    "signed",
];

/// A ship with an input of each of these names.
fn ship(names: &[&str]) -> String {
    let inputs = names.iter().map(|name| format!("[[input]]\nname = \"{name}\"\nunit = \"1\"\n"));
    let term = |degree: &str, term: &str, parameter: &str| {
        format!(
            "[[{degree}]]\nparameter = \"{parameter}\"\nterm = \"{term}\"\nnominal = -0.1\nvalue = -0.1\n"
        )
    };
    let terms = names.iter().map(|name| term("surge", name, &format!("X_{name}")));
    let drag = term("surge", "u", "unix") + &term("sway", "v", "linux") + &term("yaw", "r", "far");
    let all: String = inputs.chain(terms).chain([drag]).collect();
    format!("name = \"linux\"\nsample_rate_hz = 1.0\n{all}")
}

#[test]
fn channels_called_as_macros_or_words_of_c_compile() {
    if !Command::new("cc").arg("--version").output().is_ok_and(|output| output.status.success()) {
        println!("skipped: there is no C compiler");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "vessel.toml", &ship(&TAKEN));
    run(&folder, "export --vessel vessel.toml --to c --out c").succeeds();
    run(&folder, "export --vessel vessel.toml --to fmu --out fmu").succeeds();
    let sources = fs::read_dir(folder.path().join("c")).unwrap().map(|entry| entry.unwrap().path());
    let sources: Vec<_> = sources.filter(|path| path.extension().is_some_and(|e| e == "c")).collect();
    // As compiled by hand, and with headers that define more.
    for flags in [&[][..], &["-include", "complex.h", "-include", "errno.h"]] {
        for source in &sources {
            let mut command = Command::new("cc");
            command.args(flags).arg("-c").arg(source).args(["-o", "made.o"]).current_dir(&folder);
            let output = command.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

/// A compiler that says where it works, and takes its time.
fn slow(folder: &TempDir) {
    use std::os::unix::fs::PermissionsExt;
    let script = "#!/bin/sh\nstat -c %a . > ../mode\nsleep 100 &\necho $$ $! > ../pids\nwait\n";
    put(folder, "slow", script);
    fs::set_permissions(folder.path().join("slow"), fs::Permissions::from_mode(0o755)).unwrap();
}

fn until(what: &str, holds: impl Fn() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < Duration::from_secs(20), "{what} does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_request_to_end_ends_the_compiler_and_leaves_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("temporary");
    fs::create_dir(&place).unwrap();
    put(&folder, "vessel.toml", &ship(&["n"]));
    slow(&folder);
    let program = folder.path().join("slow");
    for signal in ["TERM", "INT", "HUP"] {
        let mut command = Command::new(SEATRIAL);
        command.args(["export", "--vessel", "vessel.toml", "--to", "fmu", "--out", "unit"]);
        command.env("CC", &program).current_dir(&folder).env("TMPDIR", &place).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let pids = place.join("pids");
        let ids = || fs::read_to_string(&pids).unwrap_or_default();
        until("the compiler", || ids().ends_with('\n'));
        assert_eq!(
            fs::read_to_string(place.join("mode")).unwrap().trim(),
            "700",
            "others read what is compiled"
        );
        Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert!(!child.wait().unwrap().success());
        // A process that was not waited for yet is a zombie.
        let state =
            |id: &str| fs::read_to_string(Path::new("/proc").join(id).join("stat")).unwrap_or_default();
        let ended = |id: &str| state(id).is_empty() || state(id).contains(") Z");
        until("the compiler's end", || ids().split_whitespace().all(ended));
        ["pids", "mode"].iter().for_each(|name| fs::remove_file(place.join(name)).unwrap());
        assert_eq!(fs::read_dir(&place).unwrap().count(), 0, "{signal}: a folder is left");
        assert!(!folder.path().join("unit").exists());
    }
}
