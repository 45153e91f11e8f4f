//! Names that routes, figures and pages cannot hold, refused by the first stage that reads them.

use crate::support::*;

/// Invalid parts of a name in TOML, and their refusals.
const STRANGE: [(&str, &str); 5] = [
    ("a\\uFFFFb", "U+FFFF"),
    ("a\\nb", "U+000A"),
    ("a\\u202Eb", "U+202E"),
    ("a\\u0000b", "U+0000"),
    ("  ", "no name"),
];

#[test]
fn names_that_nothing_can_hold_are_refused_where_they_are_read() {
    for (name, said) in STRANGE {
        for (file, from, line) in [
            ("dictionary.toml", "name = \"decelerate\"", DICTIONARY),
            ("campaign.toml", "name = \"telegraph\"", VALIDATION),
        ] {
            let folder = with(&[]);
            edit(&folder, file, from, &format!("name = \"{name}\""));
            refused(&folder, 3, line, &[file, "`name`", said]);
        }
        let folder = with(&[]);
        edit(&folder, "vessel.toml", "preset", &format!("name = \"{name}\"\npreset"));
        refused(&folder, 3, DICTIONARY, &["vessel.toml", "`name` of the vessel", said]);
    }
    let folder = with(&[]);
    edit(&folder, "dictionary.toml", "name = \"decelerate\"", &format!("name = \"{}\"", "x".repeat(10_000)));
    refused(&folder, 3, DICTIONARY, &["dictionary.toml", "10000 characters", "1 to 200 visible characters"]);
}
