//! The library `seatrial`: what it brings along, what its signatures name, and its examples.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::pages::top;
use crate::source::{self, crates, words};

/// What is the programs' own.
const PROGRAMS_OWN: [&str; 5] = ["clap", "clap_complete", "mimalloc", "indicatif", "signal-hook"];

/// Most lines of an example.
const LINES: usize = 40;

/// What every type may be made of.
const STANDARD: [&str; 18] = [
    "Box", "Clone", "Copy", "Debug", "Default", "Err", "Fn", "Into", "Ok", "Option", "Path", "PathBuf",
    "Range", "Result", "Self", "String", "Sync", "Vec",
];

/// By package: the packages that it depends on, as `Cargo.lock` has them.
fn locked() -> BTreeMap<String, Vec<String>> {
    let lock: toml::Table = fs::read_to_string(top().join("Cargo.lock")).unwrap().parse().unwrap();
    let text = |value: &toml::Value| value.as_str().unwrap().split(' ').next().unwrap().to_owned();
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in lock["package"].as_array().unwrap() {
        let needed = package.get("dependencies").and_then(toml::Value::as_array);
        all.entry(text(&package["name"])).or_default().extend(needed.into_iter().flatten().map(text));
    }
    all
}

#[test]
fn it_brings_nothing_of_the_programs() {
    let (mut all, own) = (locked(), crates());
    // Of our own crates what their tests need does not count.
    all.extend(own.into_iter().map(|one| (one.name, one.dependencies)));
    let (mut open, mut found) = (vec!["seatrial".to_owned()], BTreeSet::new());
    while let Some(next) = open.pop() {
        open.extend(all[&next].iter().filter(|name| !found.contains(*name)).cloned());
        found.insert(next);
    }
    assert!(found.contains("parquet") && found.len() > 100, "{found:?}");
    let brought: Vec<&str> = PROGRAMS_OWN.into_iter().filter(|name| found.contains(*name)).collect();
    assert!(brought.is_empty(), "the library brings {brought:?}");
}

#[test]
fn no_library_sets_an_allocator() {
    for one in crates().iter().filter(|one| one.name != "cli") {
        let set = one.lines().find(|(_, line)| line.contains("global_allocator"));
        assert!(set.is_none(), "{set:?}");
    }
}

/// The types that `code` names in its public functions, fields and variants.
fn named(code: &str) -> BTreeSet<&str> {
    let functions = code.split("pub fn ").skip(1).map(|rest| rest.split('{').next().unwrap_or_default());
    let fields = code.lines().filter(|line| line.starts_with("    pub ") && line.ends_with(','));
    let variants = code.lines().filter(|line| line.starts_with("    ") && line.ends_with("),"));
    let held = variants
        .filter(|line| line[4..].starts_with(char::is_uppercase))
        .filter_map(|line| line.split_once('('));
    let all = functions.chain(fields).chain(held.map(|(_, held)| held)).flat_map(words);
    // One letter is a parameter.
    all.filter(|word| word.starts_with(char::is_uppercase) && word.len() > 1).collect()
}

#[test]
fn types_of_its_signatures_are_its_own() {
    let all = crates();
    let library = all.iter().find(|one| one.name == "seatrial").unwrap();
    let (_, root) = library.files().find(|(file, _)| file.ends_with("/lib.rs")).unwrap();
    let exported: BTreeSet<&str> = words(&root).collect();
    // Models in other languages have their types at `seatrial::export`.
    let files: Vec<(&str, String)> =
        library.files().filter(|(file, _)| !file.contains("/src/export/")).collect();
    let signatures: BTreeSet<&str> = files.iter().flat_map(|(_, code)| named(code)).collect();
    let missing = signatures.iter().filter(|name| !exported.contains(*name) && !STANDARD.contains(name));
    let missing: Vec<_> = missing.collect();
    assert!(signatures.len() > 40 && missing.is_empty(), "{missing:?}");
}

#[test]
fn its_examples_are_short_and_are_run_as_tests() {
    let folder = top().join("crates/seatrial");
    let manifest: toml::Table = fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap();
    let run = |name: &str| {
        let all = manifest["example"].as_array().unwrap();
        let own = all.iter().find(|own| own["name"].as_str() == Some(name));
        own.is_some_and(|own| own["test"].as_bool() == Some(true) && own["harness"].as_bool() == Some(false))
    };
    let files = source::entries(&folder.join("examples"));
    for path in &files {
        let (name, text) = (path.file_stem().unwrap().to_str().unwrap(), fs::read_to_string(path).unwrap());
        assert!(text.lines().count() <= LINES, "{name}: {} lines", text.lines().count());
        assert!(run(name), "{name}: not run by `cargo test`");
    }
    assert!(files.len() >= 3);
}
