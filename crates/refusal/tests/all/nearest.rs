//! Suggested names.

use refusal::nearest;

#[test]
fn the_first_of_the_likest_names_is_suggested_in_any_case() {
    assert_eq!(nearest("SURGE", ["yaw", "surge", "sway"]), Some("surge"));
    assert_eq!(nearest("x", ["a", "b"]), Some("a"));
    assert_eq!(nearest("x", []), None);
}
