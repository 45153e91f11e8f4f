//! Ships that are none, or unusual ones: mistakes of unit, sign, system and scale, and ships that diverge. Those of `../shared/cases-2`
//! are left out where that folder is absent.

use tempfile::TempDir;

use crate::support::*;

const MERIT: &str =
    "validate merit --vessel vessel.toml --dictionary dictionary.toml --length-m 7 --out merit.json";
const SIMULATE: &str =
    "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out dictionary.parquet";
const KVLCC2: &str = include_str!("../../../ship/presets/kvlcc2-l7.toml");
const TURN: &str = "[[maneuver]]\nname = \"circle\"\nkind = \"turning-circle\"\nspeed_m_s = 1.179\nduration_s = 300.0\n\
                    helm = { delta = 0.6 }\nto = \"starboard\"\napproach = { n = 11.85, delta = 0.0 }\n";

/// The tanker's model with these texts replaced by others, and a turn.
fn tanker(changes: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let text = changes.iter().fold(KVLCC2.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no {from}");
        text.replace(from, to)
    });
    put(&folder, "vessel.toml", &text);
    put(&folder, "dictionary.toml", TURN);
    folder
}

/// A case of `../shared/cases-2`, carried out.
#[track_caller]
fn shared(case: &str, line: &str, words: &[&str]) {
    let own = repository().join("../shared/cases-2").join(case);
    if !own.is_dir() {
        eprintln!("skipped: there is no {}", own.display());
        return;
    }
    let folder = TempDir::new().unwrap();
    for name in ["vessel.toml", "dictionary.toml"] {
        put(&folder, name, &std::fs::read_to_string(own.join(name)).unwrap());
    }
    refused(&folder, if case.starts_with("12") { 4 } else { 3 }, line, words);
}

#[test]
fn mistakes_of_unit_sign_system_and_scale_are_refused_with_the_key() {
    for (case, words) in [
        ("01-rudder-in-lengths", ["vessel.toml", "`rudder.x_m`", "amidships", "unusual = "]),
        ("02-prime-as-si", ["vessel.toml", "`X_0`", "prime system", "`prime`"]),
        (
            "04-added-mass-fossen-sign",
            ["vessel.toml", "`ship.added_mass.surge`", "-0.0758", "numbers above 0"],
        ),
        ("06-mass-with-added-mass", ["vessel.toml", "`mass_kg`", "block coefficient", "without added mass"]),
        ("11-helm-in-degrees", ["dictionary.toml", "`helm`", "35 rad", "0.6109"]),
        ("16-inertia-less-than-possible", ["vessel.toml", "`inertia_kg_m2`", "less than mass", "204"]),
    ] {
        shared(case, MERIT, &words);
    }
    let line = MERIT.replace("-m 7 ", "-m 320 ");
    shared("22-length-of-another-ship", &line, &["vessel.toml", "--length-m", "320 m", "7 m"]);
    let mass = "mass_kg = 3270.0";
    let gyration = "gyration_m = 1.75";
    let rudder = "x_m = { prime = -0.5, fixed = true }\ninflow";
    let own: [(&str, &str, &str); 24] = [
        (rudder, "x_m = 3.5\ninflow", "`rudder.x_m`"),
        (rudder, "x_m = -0.5\ninflow", "`rudder.x_m`"),
        ("x_m = { prime = -0.48,", "x_m = { nominal = -0.48,", "`propeller.x_m`"),
        ("interaction_x_m = { prime", "interaction_x_m = { nominal", "`rudder.interaction_x_m`"),
        ("area_m2 = 0.0539", "area_m2 = 112.6", "`rudder.area_m2`"),
        ("height_m = 0.345", "height_m = 15.8", "`rudder.height_m`"),
        ("diameter_m = 0.216", "diameter_m = 9.86", "`propeller.diameter_m`"),
        ("lift_slope = 2.747", "lift_slope = 0.048", "`rudder.lift_slope`"),
        (
            "wake = { nominal = 0.40, value = 0.40,",
            "wake = { nominal = 40.0, value = 40.0,",
            "`propeller.wake`",
        ),
        (mass, "mass_kg = 3.27", "`mass_kg`"),
        (mass, "mass_kg = 3.2e8", "`mass_kg`"),
        (mass, "mass_kg = 7209.0", "`mass_kg`"),
        ("length_m = 7.0", "length_m = 320.0", "_m"),
        ("draught_m = 0.46", "draught_m = 1.51", "`draught_m`"),
        ("draught_m = 0.46", "draught_m = 20.8", "`draught_m`"),
        ("speed_m_s = 1.179", "speed_m_s = 15.5", "`speed_m_s`"),
        ("speed_m_s = 1.179", "speed_m_s = 2.29", "`speed_m_s`"),
        ("x_g_m = 0.25", "x_g_m = -0.25", "`x_g_m`"),
        (gyration, "gyration_m = 0.25", "`gyration_m`"),
        (gyration, "inertia_kg_m2 = 10.2", "`inertia_kg_m2`"),
        ("sway = 0.223, yaw", "sway = { nominal = 0.223, fixed = true }, yaw", "`ship.added_mass.sway`"),
        ("speed_m_s = 1.179\nmass", "speed_m_s = 1.179\narea = \"LL\"\nmass", "unusual"),
        ("prime = -0.315, value = -0.315", "prime = 0.315, value = 0.315", "`Y_v`"),
        ("density_kg_m3 = 1000.0", "density_kg_m3 = 1.0", "`density_kg_m3`"),
    ];
    for (from, to, key) in own {
        refused(&tanker(&[(from, to)]), 3, SIMULATE, &["vessel.toml", key]);
    }
    let degrees = tanker(&[("[-0.6108652381980153, 0.6108652381980153]", "[-35.0, 35.0]")]);
    refused(&degrees, 3, SIMULATE, &["vessel.toml", "`range`", "delta = -35 rad", "1.5708 rad"]);
    // A turn at 2.29 knots that are taken for m/s.
    let knots = tanker(&[]);
    edit(&knots, "dictionary.toml", "speed_m_s = 1.179", "speed_m_s = 2.29");
    refused(&knots, 3, SIMULATE, &["dictionary.toml", "maneuver `circle`, `speed_m_s`", "2.29 m/s", "1 kn"]);
}

#[test]
fn what_is_unusual_passes_if_it_is_accepted_and_what_no_ship_is_does_not() {
    let accepted = ("model = \"forces\"", "unusual = \"accepted\"\nmodel = \"forces\"");
    let broad = tanker(&[accepted, ("mass_kg = 3270.0", "mass_kg = 5771.0")]);
    run(&broad, SIMULATE).succeeds();
    let none = tanker(&[accepted, ("surge = 0.022,", "surge = -0.022,")]);
    refused(&none, 3, SIMULATE, &["vessel.toml", "`ship.added_mass.surge`"]);
    // Every stage that reads a ship refuses her.
    let folder = tanker(&[("mass_kg = 3270.0", "mass_kg = 5771.0")]);
    for line in [
        "new scaled --vessel vessel.toml --scale length_m=320",
        "export --vessel vessel.toml --to python --out model.py",
        MERIT,
    ] {
        refused(&folder, 3, line, &["vessel.toml", "`mass_kg`"]);
    }
    // What `guess` makes of dimensions at the ends of its range is a ship, and says what is unusual of her.
    for (dimensions, unusual) in [
        ("length_m=320,beam_m=58,draught_m=20.8,block=0.81,speed_m_s=15.5", "Froude number 0.28"),
        ("length_m=0.3,beam_m=0.119,draught_m=0.016,block=0.94", "length over beam"),
        ("length_m=600,beam_m=51,draught_m=42,block=0.31", "beam over draught"),
        ("length_m=320,beam_m=58,draught_m=20.8,block=0.81", ""),
    ] {
        for made in ["guessed", "scaled"] {
            _ = std::fs::remove_dir_all(broad.path().join(made));
        }
        let made = run(&broad, &format!("new guessed --guess {dimensions}")).succeeds();
        assert!(made.stdout.contains(unusual), "{}", made.stdout);
        assert_eq!(made.stdout.contains("beyond the usual"), !unusual.is_empty(), "{}", made.stdout);
        run(&broad, "new scaled --vessel guessed/vessel.toml --scale length_m=10").succeeds();
    }
}

#[test]
fn a_ship_that_turns_to_the_side_that_was_not_ordered_is_refused_with_the_sign() {
    let line = MERIT.replace("-m 7 ", "-m 160.93 ");
    let words = ["turned to port", "starboard was ordered", "check the sign"];
    shared("12-rudder-sign-of-source", &line, &words);
    let mirrored = tanker(&[]);
    edit(&mirrored, "dictionary.toml", "delta = 0.6 ", "delta = -0.6 ");
    refused(&mirrored, 4, MERIT, &words);
    refused(&mirrored, 4, SIMULATE, &["dictionary.toml", "to the other side", "check the sign"]);
    put(&mirrored, "dictionary.toml", &TURN.replace("turning-circle", "pull-out").replace("0.6 ", "-0.6 "));
    edit(&mirrored, "dictionary.toml", "to = ", "turn_s = 100.0\nto = ");
    refused(&mirrored, 4, MERIT, &words);
}

/// Every kind of standard maneuver.
const KINDS: [&str; 6] = [
    "kind = \"zig-zag-test\"\nhelm = { delta = 0.3 }\nheading_rad = 0.3",
    "kind = \"turning-circle\"\nhelm = { delta = 0.3 }",
    "kind = \"pull-out\"\nhelm = { delta = 0.3 }\nturn_s = 100.0",
    "kind = \"spiral-test\"\nhelm = { delta = 0.3 }\nsteps = 2\ndwell_s = 20.0",
    "kind = \"reverse-spiral\"\nhelm = { delta = 0.3 }\nsteps = 2\ndwell_s = 20.0\nyaw_rate_rad_s = 0.01",
    "kind = \"stop\"",
];

#[test]
fn a_ship_that_diverges_is_refused_by_maneuver_and_second_in_every_kind_of_maneuver() {
    let accepted = ("model = \"forces\"", "unusual = \"accepted\"\nmodel = \"forces\"");
    let forces = tanker(&[accepted, ("prime = -0.022, value = -0.022", "prime = 0.22, value = 0.22")]);
    let (terms, swung) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let text = std::fs::read_to_string(repository().join("crates/cli/presets/coaster/vessel.toml"));
    let text = text.unwrap();
    put(&terms, "vessel.toml", &text.replace("value = -0.000525\n", "value = 0.0525\n"));
    // She swings to the other side in every sample, further each time: a zig-zag of hers went on for ever within one.
    put(&swung, "vessel.toml", &text.replace("value = -0.03\n", "value = -3.5\n"));
    for (folder, speed, held, kinds) in [
        (&forces, 1.179, "n = 11.85, delta = 0.0", &KINDS[..]),
        (&terms, 7.0, "n = 1.0, delta = 0.01", &KINDS[..]),
        (&swung, 7.0, "n = 1.0, delta = 0.01", &KINDS[..1]),
    ] {
        for kind in kinds {
            let more = format!("speed_m_s = {speed}\nduration_s = 400.0\napproach = {{ {held} }}\n");
            put(folder, "dictionary.toml", &format!("[[maneuver]]\nname = \"m\"\n{kind}\n{more}"));
            for line in [SIMULATE, MERIT] {
                let ran = run(folder, line);
                let is_said = ran.stderr.contains("vessel.toml") && ran.stderr.contains("maneuver `m`");
                let is_timed = ran.stderr.contains("diverges") && ran.stderr.contains(" s, ");
                assert!(ran.code == Some(3) && is_said && is_timed, "{kind}\n{}", ran.stderr);
            }
        }
    }
}
