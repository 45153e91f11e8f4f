//! Damage that was a fault once: it stays refused, and in plain words.

use crate::ends::{ends, start, wait};
use crate::grounds::all;
use crate::places::{Place, unsealed};

/// A damaged input.
struct Case {
    /// How the command line begins.
    line: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
    code: i32,
    /// What the refusal says.
    says: &'static [&'static str],
}

const CORPUS: [Case; 2] = [
    // It said: expected usize.
    Case {
        line: "plan --problem",
        file: "problem.json",
        from: "\"nx\": 6",
        to: "\"nx\": \"6\"",
        code: 3,
        says: &["found the text \"6\"", "expected a whole number from 0"],
    },
    // It said: expected struct MoveFile.
    Case {
        line: "plan --problem",
        file: "problem.json",
        from: "\"moves\": [",
        to: "\"moves\": [-32768,",
        code: 3,
        says: &["found the number -32768", "expected a table"],
    },
];

#[test]
fn what_was_a_fault_once_is_none() {
    for case in &CORPUS {
        let (ground, stage) = all().into_iter().find(|(_, stage)| stage.line.starts_with(case.line)).unwrap();
        let mut place = Place::on(ground);
        let text = String::from_utf8(unsealed(place.original(case.file))).unwrap();
        assert!(text.contains(case.from), "{}: no `{}`", case.file, case.from);
        place.put(case.file, text.replacen(case.from, case.to, 1).as_bytes());
        let line = stage.line_into("out/");
        assert_eq!(ends(&place, &line), Ok(case.code), "{line}: {}", case.to);
        let told = wait(&place, start(&place, &line, "")).told;
        assert!(case.says.iter().all(|piece| told.contains(piece)), "{told}");
    }
}
