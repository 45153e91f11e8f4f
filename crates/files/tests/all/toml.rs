//! Hand-written TOML.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Change, Changes, Digest, Error, Provenance, Result, parse_toml, read_toml};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::sample::{folder, refusal};

#[derive(Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Study {
    sample_rate_hz: f64,
    seed: u64,
    shape: Shape,
    #[serde(default)]
    maneuver: Vec<Maneuver>,
    #[serde(default)]
    limits: BTreeMap<String, f64>,
}

#[derive(Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Shape {
    Square,
    Sine,
}

#[derive(Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Maneuver {
    name: String,
}

const GOOD: &str = "# rate of the log\nsample_rate_hz = 8.0\nseed = 18446744073709551615\nshape = \"sine\"\n";

fn parse(text: &str) -> Result<Study> {
    parse_toml(text, Path::new("study.toml"))
}

fn refused(text: &str) -> String {
    refusal(parse(text))
}

#[test]
fn a_good_file_is_read_with_its_digest() {
    let folder = folder();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, GOOD).unwrap();
    let (study, digest): (Study, _) = read_toml(&path).unwrap();
    assert_eq!((study.sample_rate_hz, study.seed, study.shape), (8.0, u64::MAX, Shape::Sine));
    assert_eq!(digest, Digest::of_bytes(GOOD.as_bytes()));
    assert!(matches!(read_toml::<Study>(folder.path().join("none")), Err(Error::Io { action: "read", .. })));
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest() {
    let line = refused(&format!("{GOOD}sample_rate = 8\n"));
    let expected = "study.toml: key: found key `sample_rate` (line 5, column 1), expected a known key: `sample_rate_hz`, `seed`, \
                    `shape`, `maneuver`, `limits`; did you mean `sample_rate_hz`?";
    assert_eq!(line, expected);
    let line = refused(&format!("{GOOD}[[maneuver]]\nNAEM = \"a\"\n"));
    assert!(
        line.contains("found key `NAEM` (line 6, column 1), expected the key `name`; did you mean `name`?"),
        "{line}"
    );
}

#[test]
fn an_unknown_choice_is_refused_with_the_nearest() {
    let line = refused(&GOOD.replace("sine", "sinus"));
    assert_eq!(
        line,
        "study.toml: shape: found `sinus` (line 4, column 1), expected a known value: `square`, `sine`; did you mean `sine`?"
    );
}

#[test]
fn a_missing_key_is_named() {
    let line = refused("seed = 1\nshape = \"sine\"\n");
    assert!(
        line.contains("found no key `sample_rate_hz`") && line.ends_with("add `sample_rate_hz`"),
        "{line}"
    );
    let line = refused(&format!("{GOOD}\n[[maneuver]]\n"));
    assert!(line.contains("found no key `name` (line 6, column 3)"), "{line}");
}

#[test]
fn a_wrong_type_is_told_with_key_and_line() {
    let line = refused(&GOOD.replace("8.0", "\"8\""));
    assert_eq!(
        line,
        "study.toml: sample_rate_hz: found the text \"8\" (line 2, column 1), expected a number; correct the value"
    );
    let line = refused(&GOOD.replace("18446744073709551615", "-1"));
    assert!(
        line.contains("`seed`: found -1 (line 3, column 1), expected a whole number from 0; correct it"),
        "{line}"
    );
}

#[test]
fn broken_syntax_is_told_with_its_line() {
    for broken in ["seed = ", "seed = 1\nseed = 2\n", "[", "x = [1,\n", "= 3", "a = \"\u{7f}\nb"] {
        assert!(refused(broken).contains("(line "), "{}", refused(broken));
    }
}

#[test]
fn a_file_that_is_not_text_is_refused() {
    let folder = folder();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, b"a = 1\nb = \"\xe4\"\n").unwrap();
    assert!(refusal(read_toml::<Study>(&path)).contains("found a byte that is not UTF-8 (line 2)"));
}

/// The study in `text` with `changes`, and its provenance.
fn changed(text: &str, changes: &[&str]) -> Result<(Study, Provenance)> {
    let folder = folder();
    let path = folder.path().join("any.toml");
    std::fs::write(&path, text).unwrap();
    let changes = changes.iter().map(|change| change.parse::<Change>().unwrap()).collect();
    let mut provenance = Provenance { changes: Changes::new(changes).unwrap(), ..Provenance::default() };
    let study = provenance.read_toml::<Study>("config", "study", &path)?;
    Ok((study, provenance))
}

#[test]
fn law_changes_make_what_would_be_written() {
    let good = GOOD.replace("18446744073709551615", "7");
    let text = format!("{good}[[maneuver]]\nname = \"a b\"\n[limits]\nu = 1\n");
    let changes =
        ["study.shape=square", "study.maneuver.\"a b\".name=c", "study.limits.\"x.y\"=2.5", "other.seed=9"];
    let (study, provenance) = changed(&text, &changes).unwrap();
    let written = text.replace("sine", "square").replace("a b", "c") + "\"x.y\" = 2.5\n";
    assert_eq!(study, parse(&written).unwrap());
    let set = serde_json::json!({"study.shape": "square", "study.maneuver.\"a b\".name": "c", "study.limits.\"x.y\"": 2.5});
    assert_eq!(provenance.settings["set"], set);
    // The digest depends on the contents, not on the order of the changes.
    let other = [changes[2], changes[1], changes[0]];
    let again = changed(&text.replace("# rate", "# the rate"), &other).unwrap().1;
    assert_eq!(again.inputs, provenance.inputs);
    assert_ne!(again.inputs["config"], Digest::of_bytes(text.as_bytes()));
    let same = changed(&text, &["other.seed=9"]).unwrap().1;
    assert_eq!((same.inputs["config"], same.settings.len()), (Digest::of_bytes(text.as_bytes()), 0));
}

#[test]
fn changes_of_what_is_not_there_are_refused() {
    let good = GOOD.replace("18446744073709551615", "7");
    let refused = |text: &str, change: &str| refusal(changed(text, &[change]).map(|(study, _)| study));
    let line = refused(&good, "study.sample_rate=9");
    assert!(line.contains("any.toml: key: found key `sample_rate` (with study.sample_rate=9)"), "{line}");
    let line = refused(&format!("{good}[[maneuver]]\nname = \"a\"\n"), "study.maneuver.b.name=c");
    assert!(line.contains("`study.maneuver.b.name`: found `b`, expected a; did you mean `a`?"), "{line}");
    let line = refused(&good, "study.seed.x=1");
    assert!(line.contains("found `x` below 7, expected keys below a table or a list"), "{line}");
    // A fault of the file itself is reported with its line; values that TOML tables cannot hold, with the reason.
    assert!(refused(&format!("{good}sed = 1\n"), "study.seed=1").contains("`sed` (line 5, column 1)"));
    assert!(refused(GOOD, "study.shape=sine").contains("any.toml: text: found"));
    for none in ["study=1", "study.seed", "study..seed=1", "=1", "a.b\nc=1", "a.{b}=1"] {
        assert!(none.parse::<Change>().is_err(), "{none:?}");
    }
    let twice = ["a.b=1", "a.\"b\"=2"].map(|change| change.parse::<Change>().unwrap());
    assert!(Changes::new(twice.to_vec()).is_err());
}
