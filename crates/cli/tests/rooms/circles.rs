//! Circles of files: `use` and paths through modules, each followed through re-exports to the file that defines the name.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::Crate;

/// Modules of a crate by their path, `chain::wind`; the crate's root is the empty path.
type Modules<'a> = BTreeMap<String, Module<'a>>;

struct Module<'a> {
    file: &'a str,
    /// Every path that its code names, relative ones made absolute; and whether it only passes the name on.
    paths: Vec<(Vec<String>, bool)>,
}

impl<'a> Module<'a> {
    fn new(file: &'a str, code: &str, names: &BTreeSet<String>) -> Self {
        let own = module_of(file);
        let paths = paths(code).into_iter();
        Self {
            file,
            paths: paths.filter_map(|(path, passed)| Some((absolute(&own, path, names)?, passed))).collect(),
        }
    }
}

/// The files of every circle in `one`.
pub fn circles(one: &Crate) -> Vec<Vec<String>> {
    let names: BTreeSet<String> = one.files().map(|(file, _)| module_of(file)).collect();
    let modules: Modules =
        one.files().map(|(file, code)| (module_of(file), Module::new(file, &code, &names))).collect();
    let arrows: BTreeMap<&str, BTreeSet<&str>> =
        modules.iter().map(|(name, module)| (name.as_str(), arrows(name, module, &modules))).collect();
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        arrows.keys().map(|from| (*from, reached(from, &arrows))).collect();
    let mut found: BTreeSet<Vec<String>> = BTreeSet::new();
    for (from, there) in &reach {
        let circle = there.iter().filter(|to| reach[*to].contains(from));
        let files: Vec<String> = circle.map(|name| modules[*name].file.to_owned()).collect();
        if !files.is_empty() {
            found.insert(files);
        }
    }
    found.into_iter().collect()
}

/// The modules that `module` needs: those that define what it names.
fn arrows<'a>(name: &str, module: &Module, modules: &'a Modules) -> BTreeSet<&'a str> {
    let needed = module.paths.iter().filter(|(_, passed)| !passed);
    let defined = needed.filter_map(|(path, _)| definition(path, modules, 8));
    defined.filter(|to| *to != name).collect()
}

/// The module that defines what `path` ends in; `hops` re-exports are followed at most.
fn definition<'a>(path: &[String], modules: &'a Modules, hops: u32) -> Option<&'a str> {
    let depth = (0..=path.len()).rev().find(|depth| modules.contains_key(&path[..*depth].join("::")))?;
    let (name, module) = modules.get_key_value(&path[..depth].join("::"))?;
    let item = path.get(depth);
    let passed = module.paths.iter().filter(|(_, passed)| *passed).map(|(path, _)| path);
    let next = passed.into_iter().find(|other| item.is_some() && other.last() == item && **other != path);
    match next.filter(|_| hops > 0) {
        Some(next) => definition(next, modules, hops - 1),
        None => Some(name),
    }
}

/// What can be reached from `from` in at least one step.
fn reached<'a>(from: &str, arrows: &BTreeMap<&str, BTreeSet<&'a str>>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&str> = arrows[from].iter().copied().collect();
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(&arrows[next]);
        }
    }
    found
}

/// The path of the module in `file`, such as `logs/src/chain/wind.rs`.
fn module_of(file: &str) -> String {
    let below = file.split_once("/src/").map_or(file, |(_, below)| below).trim_end_matches(".rs");
    let below = below.strip_suffix("/mod").unwrap_or(below);
    if matches!(below, "lib" | "main" | "mod") { String::new() } else { below.replace('/', "::") }
}

/// `path` from the crate's root, as seen from the module `own`; none for other crates and the standard library.
fn absolute(own: &str, path: Vec<String>, modules: &BTreeSet<String>) -> Option<Vec<String>> {
    let own: Vec<String> = own.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
    let supers = path.iter().take_while(|part| *part == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([own, path[1..].to_vec()].concat()),
        "super" => Some([own[..own.len().checked_sub(supers)?].to_vec(), path[supers..].to_vec()].concat()),
        first => {
            let below = [own.clone(), vec![first.to_owned()]].concat().join("::");
            modules.contains(&below).then(|| [own, path].concat())
        }
    }
}

/// The paths that `code` names, and whether each is only passed on by a `pub use`.
fn paths(code: &str) -> Vec<(Vec<String>, bool)> {
    let mut found = Vec::new();
    let mut rest = code.to_owned();
    while let Some(start) = rest.find("use ").filter(|start| is_statement(&rest[..*start])) {
        let end = rest[start..].find(';').map_or(rest.len(), |end| start + end);
        let passed = rest[..start].lines().last().is_some_and(|line| line.trim_start().starts_with("pub"));
        let mut tree = Vec::new();
        expand(rest[start + 4..end].trim(), &[], &mut tree);
        found.extend(tree.into_iter().map(|path| (path, passed)));
        rest.replace_range(..end, "");
    }
    found.extend(inline(code));
    found
}

fn is_statement(before: &str) -> bool {
    before.is_empty() || before.ends_with(['\n', ' '])
}

/// Paths in the middle of code that begin with `crate::` or `super::`, and those of a lower-case first part.
fn inline(code: &str) -> Vec<(Vec<String>, bool)> {
    let is_use = |line: &str| {
        let line = line.trim_start();
        line.starts_with("use ") || line.starts_with("pub") && line.contains(" use ")
    };
    let lines = code.lines().filter(|line| !is_use(line));
    let tokens = lines.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':'));
    let paths = tokens.filter(|token| token.contains("::") && token.starts_with(char::is_lowercase));
    paths
        .map(|path| (path.split("::").filter(|p| !p.is_empty()).map(str::to_owned).collect(), false))
        .collect()
}

/// The leaves of a tree of `use`, each with its whole path.
fn expand(tree: &str, before: &[String], found: &mut Vec<Vec<String>>) {
    let Some((head, inner)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        let parts = path
            .split("::")
            .map(str::trim)
            .filter(|part| !matches!(*part, "" | "*" | "self") || before.is_empty());
        found.push(before.iter().cloned().chain(parts.map(str::to_owned)).collect());
        return;
    };
    let head = head.split("::").map(str::trim).filter(|part| !part.is_empty());
    let before: Vec<String> = before.iter().cloned().chain(head.map(str::to_owned)).collect();
    let (mut depth, mut start) = (0, 0);
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let part = inner[start..at].trim();
                if !part.is_empty() {
                    expand(part, &before, found);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

#[test]
fn a_circle_through_a_re_export_is_seen() {
    let files = [
        ("a/src/lib.rs", "mod b;\nmod c;\npub use b::{Ship, deep::Keel};\n"),
        ("a/src/b.rs", "use crate::c::sail;\n"),
        ("a/src/c.rs", "use super::Ship;\n"),
        ("a/src/d.rs", "use crate::{c::sail, b::Ship};\n"),
    ];
    assert_eq!(circles(&Crate::of(&files)), [["a/src/b.rs", "a/src/c.rs"]]);
}
