//! Names that are refused.

use refusal::check_name;

#[test]
fn names_that_files_cannot_hold_are_refused() {
    for held in ["zig-zag 20/20", "Kehrwende (süd)", "操舵", "a&<b>\"'"] {
        check_name("maneuver", held).unwrap();
    }
    let refused = |name: &str| check_name("maneuver", name).unwrap_err().to_string();
    assert!(refused("a\u{ffff}b").contains("U+FFFF"));
    assert!(refused("a\nb").contains("U+000A") && refused("a\u{202e}b").contains("U+202E"));
    assert!(refused("").contains("no name") && refused(" ").contains("no name"));
    assert!(refused(&"x".repeat(201)).contains("201 characters"));
}
