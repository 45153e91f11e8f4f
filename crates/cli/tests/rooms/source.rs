//! The crates of the workspace as text.

use std::fs;
use std::path::{Path, PathBuf};

/// A crate: what it depends on, and its sources.
pub struct Crate {
    pub name: String,
    /// What Cargo calls it.
    pub package: String,
    pub dependencies: Vec<String>,
    /// Lines below `src/`, comments and unit tests included.
    pub size: usize,
    /// Path below `crates/` and the lines above the file's tests.
    files: Vec<(String, Vec<String>)>,
}

impl Crate {
    /// Every line of code, with its file; no tests and no comments.
    pub fn lines(&self) -> impl Iterator<Item = (&str, &str)> {
        let all = self
            .files
            .iter()
            .flat_map(|(file, lines)| lines.iter().map(|line| (file.as_str(), line.as_str())));
        all.filter(|(_, line)| !line.trim_start().starts_with("//"))
    }

    /// The code of every file, without tests and comments.
    pub fn files(&self) -> impl Iterator<Item = (&str, String)> {
        let code = |lines: &[String]| {
            let code = lines.iter().filter(|line| !line.trim_start().starts_with("//"));
            code.map(|line| format!("{line}\n")).collect()
        };
        self.files.iter().map(move |(file, lines)| (file.as_str(), code(lines)))
    }

    /// A crate of these files.
    pub fn of(files: &[(&str, &str)]) -> Self {
        let file =
            |(name, text): &(&str, &str)| ((*name).to_owned(), text.lines().map(str::to_owned).collect());
        Self {
            name: String::new(),
            package: String::new(),
            dependencies: Vec::new(),
            size: 0,
            files: files.iter().map(file).collect(),
        }
    }
}

/// All crates of the workspace, by name.
pub fn crates() -> Vec<Crate> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut all: Vec<Crate> =
        entries(&folder).iter().filter(|path| path.is_dir()).map(|path| read(path)).collect();
    all.sort_by(|a, b| a.name.cmp(&b.name));
    all
}

fn read(folder: &Path) -> Crate {
    let manifest: toml::Table = fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap();
    let dependencies = manifest.get("dependencies").and_then(toml::Value::as_table);
    let (mut files, mut size) = (Vec::new(), 0);
    gather(&folder.join("src"), &mut |path, text| {
        size += text.lines().count();
        files.extend(code(path, text));
    });
    let package = manifest["package"]["name"].as_str().unwrap();
    Crate {
        name: package.trim_start_matches("seatrial-").to_owned(),
        package: package.to_owned(),
        dependencies: dependencies.map_or(Vec::new(), |table| table.keys().cloned().collect()),
        size,
        files,
    }
}

/// Hands every Rust file below `folder` to `each`.
fn gather(folder: &Path, each: &mut dyn FnMut(&Path, &str)) {
    for path in entries(folder) {
        if path.is_dir() {
            gather(&path, each);
        } else if path.extension().is_some_and(|e| e == "rs") {
            each(&path, &fs::read_to_string(&path).unwrap());
        }
    }
}

/// What stands above the unit tests of a file; nothing where the whole file is tests.
fn code(path: &Path, text: &str) -> Option<(String, Vec<String>)> {
    if path.file_stem().is_some_and(|stem| stem == "tests" || stem == "laws") {
        return None;
    }
    let above = text.split("\n#[cfg(test)]\n").next().unwrap_or_default();
    let name = path.display().to_string();
    let name = name.rsplit_once("/../").map_or(name.as_str(), |(_, below)| below).to_owned();
    Some((name, above.lines().map(str::to_owned).collect()))
}

/// What stands in a folder, by name.
pub fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

/// The words of a line of code.
pub fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}
