//! How much there is to know: no more than `scripts/surface.most` says, whose numbers only fall.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Output};

use crate::pages::top;

const MOST: &str = "scripts/surface.most";

/// By figure: its number.
fn numbers(text: &str) -> BTreeMap<&str, f64> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let pair = |line| {
        let (name, number): (&str, &str) = str::split_once(line, ' ')?;
        Some((name, number.parse().ok()?))
    };
    lines
        .map(|line| pair(line).unwrap_or_else(|| panic!("found `{line}`, expected a name and a number")))
        .collect()
}

/// What `later` has above a number of `earlier`, or lacks.
fn risen(earlier: &str, later: &str) -> Vec<String> {
    let (earlier, later) = (numbers(earlier), numbers(later));
    let risen = earlier.iter().filter_map(|(name, most)| match later.get(name) {
        Some(number) if number <= most => None,
        Some(number) => {
            Some(format!("{name}: found {number}, expected at most {most}; delete before you add"))
        }
        None => Some(format!("{name}: found no number, expected at most {most}; write it")),
    });
    risen.collect()
}

/// The output of a program at the top of the repository; says why there is none.
fn run(program: &str, words: &[&str]) -> Option<Output> {
    let mut command = Command::new(program);
    command.args(words).current_dir(top());
    // Not those of a hook that runs the tests
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"] {
        command.env_remove(name);
    }
    match command.output() {
        Ok(output) => Some(output),
        Err(e) => {
            println!("skipped: {program} does not run here: {e}");
            None
        }
    }
}

/// The file as it is in `commit`; says why it is not known.
fn committed(commit: &str) -> Option<String> {
    let output = run("git", &["show", &format!("{commit}:./{MOST}")])?;
    if !output.status.success() {
        println!("skipped: no {MOST} of {commit}: {}", String::from_utf8_lossy(&output.stderr).trim());
        return None;
    }
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn numbers_of_the_surface_only_fall() {
    let here = fs::read_to_string(top().join(MOST)).unwrap();
    let Some(head) = committed("HEAD") else { return };
    let now = risen(&head, &here);
    assert!(now.is_empty(), "{MOST}, since HEAD: {now:#?}");
    let Some(parent) = committed("HEAD~1") else { return };
    let then = risen(&parent, &head);
    assert!(then.is_empty(), "{MOST}, in HEAD: {then:#?}");
}

#[test]
fn a_number_that_rises_or_goes_is_seen() {
    let earlier = "# Head\nlines 10\nfiles 4\nprogram-mb 62.9\n";
    assert!(risen(earlier, "program-mb 62.9\nlines 9\nfiles 4\ntypes 7\n").is_empty());
    let told = risen(earlier, "lines 11\nprogram-mb 63\n").join("\n");
    assert_eq!(told.lines().count(), 3, "{told}");
    for part in
        ["files: found no number", "lines: found 11, expected at most 10", "found 63, expected at most 62.9"]
    {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn the_surface_is_not_above_its_numbers() {
    let Some(output) = run("sh", &["scripts/surface.sh", "--static"]) else { return };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (figures, most) =
        (String::from_utf8(output.stdout).unwrap(), fs::read_to_string(top().join(MOST)).unwrap());
    let most = numbers(&most);
    let missing: Vec<&str> = numbers(&figures).into_keys().filter(|name| !most.contains_key(name)).collect();
    assert!(
        figures.lines().count() > 10 && missing.is_empty(),
        "{MOST} lacks {missing:?}: sh scripts/surface.sh --write"
    );
}
