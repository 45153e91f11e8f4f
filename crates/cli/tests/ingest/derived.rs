//! Channels that the vessel's file derives, in addition to those of the configuration.

use crate::runner::*;

const VESSEL: &str = r#"
name = "coaster"
sample_rate_hz = 1.0
input = [{ name = "n", unit = "1/s" }]
derived = [{ name = "thrust", unit = "1/s^2", formula = "n |n|" }, { name = "push", unit = "1/s^2", formula = "positive(thrust)" }]
surge = [{ parameter = "a", term = "u", nominal = -0.1 }, { parameter = "b", term = "push", nominal = 0.1 }]
sway = [{ parameter = "c", term = "v", nominal = -0.1 }]
yaw = [{ parameter = "d", term = "r", nominal = -0.1 }]
"#;

const DERIVED: &str = "\n[[derived]]\nchannel = \"thrust\"\nformula = \"n |n|\"\nunit = \"1/s^2\"\n";

fn files(top: &str, more: &str) -> tempfile::TempDir {
    let config = config(top) + more;
    folder(&[("ingest.toml", &config), ("vessel.toml", VESSEL), ("a.csv", &log(8))])
}

const FLAGS: [&str; 4] = ["--config", "ingest.toml", "--vessel", "vessel.toml"];

#[test]
fn law_derived_channels_follow_the_inputs_of_the_same_sample_averaged_or_not() {
    for top in ["", "average_s = 2.0"] {
        let made = ingest(files(top, "").path(), &FLAGS);
        assert_eq!(made.units["push"], "1/s^2");
        for row in 0..made.rows - 1 {
            let n = made.f64("n")[row];
            assert_eq!((made.f64("thrust")[row], made.f64("push")[row]), (n * n.abs(), n * n.abs()));
        }
        assert!(made.columns["push"].is_null(made.rows - 1));
    }
}

#[test]
fn a_configuration_may_derive_the_same_and_nothing_else() {
    let (once, twice) = (ingest(files("", "").path(), &FLAGS), ingest(files("", DERIVED).path(), &FLAGS));
    assert_eq!(once.f64("thrust")[..6], twice.f64("thrust")[..6]);
    let logged = "\n[[file.channel]]\ncolumn = \"n\"\nchannel = \"thrust\"\nunit = \"1\"\n";
    for (more, found) in [
        (DERIVED.replace("n |n|", "n n"), "another formula"),
        (DERIVED.replace("1/s^2", "1"), "the same in 1,"),
        (logged.to_owned(), "a logged channel in 1,"),
    ] {
        let folder = files("", &more);
        let ran = run(folder.path(), &[&FLAGS[..], &["--out", "trajectories.parquet"]].concat());
        assert_eq!((ran.code, ran.stderr.lines().count()), (Some(3), 1), "{}", ran.stderr);
        for piece in ["ingest.toml", "channel `thrust`", found, "`n |n|` in 1/s^2, which vessel.toml derives"]
        {
            assert!(ran.stderr.contains(piece), "`{piece}` is missing: {}", ran.stderr);
        }
        assert!(!folder.path().join("trajectories.parquet").exists());
    }
}
