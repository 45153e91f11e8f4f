//! What is written for people: a short front page, and no long sentences.

use std::fs;
use std::path::{Path, PathBuf};

/// Most lines of README.md.
const LINES: usize = 120;

/// Most words of a sentence.
const WORDS: usize = 30;

/// Largest picture \[bytes\].
const PICTURE: u64 = 300_000;

/// Top of the repository.
pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Pages of prose: formulas and generated tables have sentences of their own kind.
fn pages() -> Vec<PathBuf> {
    let docs = fs::read_dir(top().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let prose = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap();
        name.ends_with(".md") && name != "notation.md" && name != "results.md"
    };
    let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"];
    docs.filter(prose).chain(others.map(|name| top().join(name))).collect()
}

/// The sentences of a page, without tables, headings and commands; an item of a list ends one too.
fn sentences(text: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    let mut fenced = false;
    for line in text.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        }
        if fenced
            || line.is_empty()
            || ["|", "#", "```", "- ", "<!--"].iter().any(|mark| line.starts_with(mark))
        {
            paragraphs.push(String::new());
        }
        if !fenced && !["|", "#", "```", "<!--"].iter().any(|mark| line.starts_with(mark)) {
            let last = paragraphs.last_mut().unwrap();
            last.push_str(line);
            last.push(' ');
        }
    }
    let ends = |text: &str| text.replace(['!', '?'], ".").replace(".**", ". ");
    paragraphs.iter().flat_map(|p| ends(p).split(". ").map(str::to_owned).collect::<Vec<_>>()).collect()
}

#[test]
fn no_sentence_is_long() {
    let count =
        |sentence: &str| sentence.split_whitespace().filter(|w| w.contains(char::is_alphanumeric)).count();
    let pages = pages();
    assert!(pages.len() > 5);
    let mut long = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        let own = sentences(&text).into_iter().filter(|s| count(s) > WORDS);
        long.extend(own.map(|s| format!("{}: {} words: {s}", page.display(), count(&s))));
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn the_front_page_is_short_and_its_picture_small() {
    let text = fs::read_to_string(top().join("README.md")).unwrap();
    assert!(text.lines().count() <= LINES, "{} lines", text.lines().count());
    let picture = fs::metadata(top().join("docs/trial.svg")).unwrap().len();
    assert!(picture <= PICTURE, "{picture} bytes");
}

#[test]
fn links_between_pages_lead_somewhere() {
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let path = target.split('#').next().unwrap();
            let inside = !path.is_empty() && !path.contains("://");
            assert!(!inside || page.parent().unwrap().join(path).exists(), "{}: {target}", page.display());
        }
    }
}

#[test]
fn the_book_has_every_page() {
    let contents = fs::read_to_string(top().join("docs/SUMMARY.md")).unwrap();
    let docs = fs::read_dir(top().join("docs")).unwrap().map(|entry| entry.unwrap().file_name());
    let names: Vec<String> = docs.map(|name| name.into_string().unwrap()).collect();
    let missing = names.iter().filter(|name| name.ends_with(".md") && *name != "SUMMARY.md");
    let missing: Vec<&String> = missing.filter(|name| !contents.contains(&format!("]({name})"))).collect();
    assert!(names.len() > 15 && missing.is_empty(), "docs/SUMMARY.md lacks {missing:?}");
}

#[test]
fn places_named_in_architecture_exist() {
    let text = fs::read_to_string(top().join("ARCHITECTURE.md")).unwrap();
    let named: Vec<&str> = text.split('`').filter(|part| part.starts_with("crates/")).collect();
    let missing: Vec<&str> =
        named.iter().copied().filter(|name| !name.contains('<') && !top().join(name).exists()).collect();
    assert!(named.len() > 20 && missing.is_empty(), "{missing:?}");
}
