//! Names that are identifiers in every target language.

use seatrial::export::{Identifiers, file_name};

#[test]
fn names_become_identifiers_of_their_own() {
    let mut taken = Identifiers::reserved();
    let cases = [
        ("X_u", "X_u"),
        ("X__u", "X__u"),
        ("X_u|u|", "X_u_u"),
        ("X_u u", "X_u_u_2"),
        ("X_u|u", "X_u_u_3"),
        ("δ", "delta"),
        ("Δδ", "Deltadelta"),
        ("_a", "a"),
        ("1st", "x_1st"),
        ("", "x"),
        ("船", "x_2"),
        ("for", "for_2"),
        ("p", "p_2"),
        ("a\"; system(\"b", "a_system_b"),
    ];
    for (name, expected) in cases {
        assert_eq!(taken.take(name), expected, "{name}");
    }
    assert!(taken.take(&"long".repeat(50)).len() <= 63);
}

#[test]
fn files_are_named_after_the_vessel() {
    for (name, expected) in [
        ("Esso Osaka", "esso_osaka"),
        ("船", "vessel"),
        ("", "vessel"),
        ("For", "for_2"),
        ("Con", "con_2"),
        ("2nd ship", "x_2nd_ship"),
    ] {
        assert_eq!(file_name(name), expected);
    }
}
