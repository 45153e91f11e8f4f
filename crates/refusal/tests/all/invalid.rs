//! Messages in one line.

use refusal::Invalid;

#[test]
fn a_message_is_always_one_line() {
    let invalid = Invalid::new("`a`", "x\r\n\u{2028}y", "z", "correct it");
    assert_eq!(invalid.to_string(), "`a`: found x y, expected z; correct it");
    let invalid = Invalid::new("`a`", "x".repeat(300_000), "z", "correct it").to_string();
    assert!(invalid.chars().count() < 500 && invalid.ends_with("…, expected z; correct it"));
}
