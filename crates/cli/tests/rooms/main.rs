//! The house of ARCHITECTURE.md as it is built: which crate may use which, what the science may know, how large a room is.

mod circles;
mod features;
mod library;
mod pages;
mod source;
mod surface;

use std::collections::BTreeMap;

use source::Crate;

/// Crates from the ground up: one may use those of the rows above its own.
const FLOORS: [&[&str]; 10] = [
    &["refusal", "numerics"],
    &["files", "ship", "design", "chart"],
    &["maneuver", "regression"],
    &["estimation", "logs"],
    &["trial", "validation"],
    &["plan"],
    &["study"],
    &["report", "seatrial"],
    &["cli"],
    &["workspace-hack"],
];

/// The crates that compute.
const SCIENCE: &[&str] = &[
    "numerics",
    "ship",
    "maneuver",
    "regression",
    "estimation",
    "validation",
    "design",
    "plan",
    "chart",
    "logs",
    "trial",
];

/// What the sources of some crates must not contain: crates, words, why.
const WORDS: [(&[&str], &[&str], &str); 5] = [
    (SCIENCE, &["Path", "PathBuf", "fs"], "science knows no files"),
    (SCIENCE, &["clap", "ValueEnum"], "science has no command line"),
    (SCIENCE, &["println", "eprintln", "indicatif"], "science prints nothing"),
    (SCIENCE, &["ThreadPoolBuilder", "spawn"], "science starts no threads"),
    (
        &["seatrial"],
        &["fs", "println", "eprintln", "ThreadPoolBuilder", "spawn"],
        "the library reads by `study`, prints nothing, starts no threads",
    ),
];

/// Functions of the standard library whose last bits are the system's own; those of `libm` are the same everywhere.
const SYSTEMS: [&str; 16] = [
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".exp(",
    ".exp_m1(",
    ".ln(",
    ".ln_1p(",
    ".log10(",
    ".powf(",
    ".hypot(",
    ".tanh(",
];

/// What some crates must not depend on: crates, dependencies, why.
const DEPENDENCIES: [(&[&str], &[&str], &str); 5] = [
    (SCIENCE, &["files", "study", "clap", "indicatif"], "science knows no files and no command line"),
    (&["design"], &["ship", "chart"], "a design is of information, not of ships"),
    (&["study"], &["libm"], "documents compute nothing"),
    (
        &["report"],
        &["trial", "chart", "plan", "maneuver", "design", "estimation", "validation"],
        "a report draws from documents alone",
    ),
    (
        &["study", "report"],
        &["clap", "indicatif", "rayon"],
        "only the programs have flags, progress and threads",
    ),
];

/// The largest share of all lines below `src/` that a crate may have.
const SHARE: f64 = 0.12;

/// What does not hold yet: rule, crate, how much of it is left.
const NOT_YET: &[(&str, &str, usize)] =
    &[("share of all lines", "estimation", 620), ("share of all lines", "logs", 1650)];

/// What breaks the rules, by rule and crate.
#[derive(Default)]
struct Broken(BTreeMap<(String, String), (usize, String)>);

impl Broken {
    /// `amount` too much of what `rule` forbids in `room`.
    fn add(&mut self, rule: &str, room: &str, amount: usize, example: &str) {
        let known = self.0.entry((rule.to_owned(), room.to_owned())).or_insert((0, example.to_owned()));
        known.0 += amount;
    }

    /// Fails if there is more of anything than what is known not to hold yet.
    fn check(self) {
        let allowed = |rule: &str, room: &str| {
            NOT_YET.iter().find(|(r, c, _)| *r == rule && *c == room).map_or(0, |(_, _, count)| *count)
        };
        let told: Vec<String> = self
            .0
            .iter()
            .filter(|((rule, room), (amount, _))| *amount > allowed(rule, room))
            .map(|((rule, room), (amount, example))| format!("{room}: {rule}: {amount} ({example})"))
            .collect();
        assert!(told.is_empty(), "\n{}\n", told.join("\n"));
    }
}

#[test]
fn arrows_between_crates_go_down() {
    let mut broken = Broken::default();
    let floor = |name: &str| FLOORS.iter().position(|floor| floor.contains(&name));
    let all = source::crates();
    for one in &all {
        let Some(own) = floor(&one.name) else {
            panic!("crates/{}: on no floor; name it in FLOORS", one.name)
        };
        let ours = one.dependencies.iter().filter_map(|other| Some((other, floor(other)?)));
        for (other, _) in ours.filter(|(_, floor)| *floor >= own) {
            broken.add("arrows go down", &one.name, 1, other);
        }
        for (_, forbidden, why) in DEPENDENCIES.iter().filter(|(of, _, _)| of.contains(&&*one.name)) {
            for other in one.dependencies.iter().filter(|other| forbidden.contains(&&***other)) {
                broken.add(why, &one.name, 1, other);
            }
        }
    }
    assert!(all.len() >= SCIENCE.len() && SCIENCE.iter().all(|name| all.iter().any(|c| c.name == *name)));
    broken.check();
}

/// Libraries that the project was asked to be built on.
const ASKED_FOR: [&str; 8] = ["faer", "serde", "serde_json", "arrow2", "parquet", "clap", "rayon", "argmin"];

#[test]
fn libraries_that_were_asked_for_are_at_work() {
    let all = source::crates();
    for name in ASKED_FOR {
        let at_work = |one: &&Crate| {
            let known = one.dependencies.iter().any(|own| own == name);
            known && one.lines().any(|(_, line)| source::words(line).any(|word| word == name))
        };
        assert!(
            all.iter().find(at_work).is_some(),
            "{name} is in no source but that of tests and measurements"
        );
    }
}

#[test]
fn science_knows_no_files_and_no_command_line() {
    let mut broken = Broken::default();
    for one in source::crates() {
        for (_, forbidden, why) in WORDS.iter().filter(|(of, _, _)| of.contains(&&*one.name)) {
            for (file, line) in
                one.lines().filter(|(_, line)| source::words(line).any(|w| forbidden.contains(&w)))
            {
                broken.add(why, &one.name, 1, &format!("{file}: {}", line.trim()));
            }
        }
    }
    broken.check();
}

#[test]
fn elementary_functions_have_one_implementation() {
    let mut broken = Broken::default();
    for one in source::crates() {
        for (file, line) in one.lines().filter(|(_, line)| SYSTEMS.iter().any(|name| line.contains(name))) {
            let found = format!("{file}: {}", line.trim());
            broken.add("elementary functions are those of libm", &one.name, 1, &found);
        }
    }
    broken.check();
}

#[test]
fn no_crate_is_too_large() {
    let mut broken = Broken::default();
    let all = source::crates();
    let total: usize = all.iter().map(|one| one.size).sum();
    for Crate { name, size, .. } in &all {
        let excess = size.saturating_sub((SHARE * total as f64) as usize);
        if excess > 0 {
            broken.add(
                "share of all lines",
                name,
                excess,
                &format!("lines too many of {size}, {total} in all"),
            );
        }
    }
    broken.check();
}

#[test]
fn files_need_each_other_one_way() {
    let all: Vec<Vec<String>> = source::crates().iter().flat_map(circles::circles).collect();
    assert!(all.is_empty(), "{all:#?}");
}
