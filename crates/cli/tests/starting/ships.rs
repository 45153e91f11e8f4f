//! Ships before their first trial: scaled ones, and guesses from main dimensions.

use tempfile::TempDir;

use crate::support::*;

/// A file without its comments.
fn plain(folder: &TempDir, name: &str) -> String {
    let text = String::from_utf8(bytes(folder, name)).unwrap();
    let lines = text.lines().map(|line| line.split("  # ").next().unwrap_or_default());
    lines.filter(|line| !line.starts_with('#')).map(|line| line.to_owned() + "\n").collect()
}

/// A number at the first line that begins with `key = `.
fn number(folder: &TempDir, name: &str, key: &str) -> f64 {
    let text = plain(folder, name);
    let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = ")));
    line.unwrap_or_else(|| panic!("{name} has no {key}: {text}")).parse().unwrap()
}

/// A figure of the maneuver `name` in merit.json.
fn figure(folder: &TempDir, name: &str, figure: &str) -> f64 {
    let found = json(folder, "merit.json");
    let all = found["data"]["maneuvers"].as_array().unwrap();
    let own = all.iter().find(|own| own["name"] == name).unwrap();
    let own = own["figures"].as_array().unwrap().iter().find(|own| own["name"] == figure);
    own.unwrap_or_else(|| panic!("{name} has no {figure}: {found:#}"))["value"].as_f64().unwrap()
}

/// Judges a turn with 35° of rudder and a 20°/20° zig-zag of `vessel`, at these revolutions.
fn judge(folder: &TempDir, vessel: &str, [length, speed, n]: [f64; 3]) {
    let second = length / speed;
    let dictionary = format!(
        "[[maneuver]]\nname = \"turn\"\nkind = \"turning-circle\"\nspeed_m_s = {speed:?}\nduration_s = {:?}\n\
         helm = {{ delta = 0.6 }}\nto = \"starboard\"\napproach = {{ n = {n:?} }}\n\
         [[maneuver]]\nname = \"zigzag\"\nkind = \"zig-zag-test\"\nspeed_m_s = {speed:?}\nduration_s = {:?}\n\
         helm = {{ delta = 0.349 }}\nheading_rad = 0.349\nto = \"starboard\"\napproach = {{ n = {n:?} }}\n",
        30.0 * second,
        30.0 * second
    );
    put(folder, "dictionary.toml", &dictionary);
    let line = format!(
        "validate merit --vessel {vessel} --dictionary dictionary.toml --length-m {length} --out merit.json"
    );
    run(folder, &line).succeeds();
}

const FIGURES: [(&str, &str); 4] = [
    ("turn", "advance"),
    ("turn", "tactical_diameter"),
    ("zigzag", "overshoot_1"),
    ("zigzag", "overshoot_2"),
];

#[test]
fn law_a_scaled_ship_turns_and_checks_as_her_model_does() {
    let folder = TempDir::new().unwrap();
    put(&folder, "model.toml", "preset = \"kvlcc2-l7\"\n");
    judge(&folder, "model.toml", [7.0, 1.179, 10.4]);
    let first = FIGURES.map(|(name, own)| figure(&folder, name, own));
    let said = run(&folder, "new ship --vessel kvlcc2-l7 --scale length_m=320,density_kg_m3=1025").succeeds();
    assert!(said.stdout.contains("7.9715 m/s"), "{said}");
    let root = (320.0_f64 / 7.0).sqrt();
    judge(&folder, "ship/vessel.toml", [320.0, 1.179 * root, 10.4 / root]);
    for ((name, own), first) in FIGURES.into_iter().zip(first) {
        let found = figure(&folder, name, own);
        assert!((found - first).abs() <= 1e-9 * first.abs().max(1.0), "{name} {own}: {found} {first}");
    }
    assert_eq!(plain(&folder, "ship/vessel.toml").matches("prior = ").count(), 26);
}

/// Whether two texts are the same but for roundings in the last digits of numbers.
fn same_numbers(one: &str, other: &str) -> bool {
    let words = |text: &str| {
        text.replace(['[', ']', ',', '{', '}'], " ").split_whitespace().map(str::to_owned).collect()
    };
    let (one, other): (Vec<String>, Vec<String>) = (words(one), words(other));
    let same = |(a, b): (&String, &String)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-15 * a.abs(),
        _ => a == b,
    };
    one.len() == other.len() && one.iter().zip(&other).all(same)
}

#[test]
fn law_there_and_back_is_the_same_file() {
    let folder = TempDir::new().unwrap();
    let back = |ship: &str, own: &str, other: &str| {
        let scale = |vessel: &str, length: &str, out: &str| {
            _ = std::fs::remove_dir_all(folder.path().join(out));
            run(&folder, &format!("new {out} --vessel {vessel} --scale length_m={length}")).succeeds();
            plain(&folder, &format!("{out}/vessel.toml"))
        };
        let first = scale(ship, own, "first");
        assert_ne!(first, scale(ship, other, "other"));
        (first, scale("other/vessel.toml", own, "back"))
    };
    let (first, again) = back("kvlcc2-l7", "7", "320");
    assert_eq!(first, again);
    // Their numbers have 16 digits, of which the last may change.
    for (ship, own, other) in [("mariner", "160.93", "5"), ("otter", "2", "3"), ("otter", "2", "8")] {
        let (first, back) = back(ship, own, other);
        assert!(same_numbers(&first, &back), "{first}\n{back}");
    }
}

#[test]
fn a_scaled_fit_has_its_estimates_and_priors_from_its_errors() {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", "preset = \"kvlcc2-l7\"\nsample_rate_hz = 2.0\n");
    put(
        &folder,
        "dictionary.toml",
        "[[maneuver]]\nname = \"z\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.1\nhelm = { delta = 0.35 }\n\
         heading_rad = 0.35\nto = \"starboard\"\nduration_s = 200.0\napproach = { n = 10.5 }\n",
    );
    run(&folder, "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet")
        .succeeds();
    run(
        &folder,
        "estimate --structure own --vessel vessel.toml --trajectories d.parquet --out estimate.json",
    )
    .succeeds();
    run(&folder, "new ship --vessel model.json --scale length_m=320").succeeds();
    let parameters = json(&folder, "model.json")["data"]["forces"]["parameters"].as_array().unwrap().clone();
    let text = plain(&folder, "ship/vessel.toml");
    let text = text.split("[value]").next().unwrap();
    assert!(!text.contains("value = "), "{text}");
    for own in
        parameters.iter().filter(|own| own["unit"] == "1" && !own["name"].as_str().unwrap().contains('.'))
    {
        let number = |key: &str| own[key].as_f64().unwrap();
        let prior = number("standard_error").max(0.3 * number("prior_deviation"));
        let expected = format!("prime = {:?}, prior = {prior:?} }}", number("value"));
        assert!(text.contains(&expected), "{expected}: {text}");
    }
    run(
        &folder,
        "validate merit --vessel ship/vessel.toml --dictionary dictionary.toml --length-m 320 --out m.json",
    )
    .refuses(3, &["dictionary.toml"]);
}

#[test]
fn law_guesses_of_published_ships_turn_and_check_within_what_ships_do() {
    let folder = TempDir::new().unwrap();
    let vessel = "guessed/vessel.toml";
    for (dimensions, length) in [
        ("length_m=320,beam_m=58,draught_m=20.8,block=0.81,speed_m_s=7.97", 320.0),
        ("length_m=160.93,beam_m=23.17,draught_m=8.23,block=0.6,speed_m_s=7.7175", 160.93),
        ("length_m=100,beam_m=16,draught_m=6,block=0.7", 100.0),
        ("length_m=7,beam_m=1.27,draught_m=0.455,block=0.81,density_kg_m3=1000,speed_m_s=1.179", 7.0),
    ] {
        _ = std::fs::remove_dir_all(folder.path().join("guessed"));
        let said = run(&folder, &format!("new guessed --guess {dimensions}")).succeeds();
        let text = String::from_utf8(bytes(&folder, vessel)).unwrap();
        let n = text.split("at n = ").nth(1).and_then(|own| own.split(' ').next()).unwrap();
        let speed = number(&folder, vessel, "speed_m_s");
        judge(&folder, vessel, [length, speed, n.parse().unwrap()]);
        let [advance, diameter, first, second] = FIGURES.map(|(name, own)| figure(&folder, name, own));
        // IMO MSC.137(76): 4.5 and 5 lengths, 25° and 40°; no ship turns in less than two lengths.
        assert!(
            (2.0..4.5).contains(&advance) && (2.0..5.0).contains(&diameter),
            "{advance} {diameter} {said}"
        );
        assert!((3.0..25.0).contains(&first) && (3.0..40.0).contains(&second), "{first} {second}");
        let terms = text.lines().filter(|line| line.contains("parameter = "));
        let is_known = |line: &str| line.contains("prior = ") || line.contains("fixed = true");
        assert!(terms.clone().count() == 19 && terms.clone().all(is_known), "{text}");
        assert!(
            text.lines().filter(|line| line.contains("nominal = ")).all(|line| line.contains("  # ")),
            "{text}"
        );
    }
    run(&folder, &format!("new larger --vessel {vessel} --scale length_m=14")).succeeds();
}

#[test]
fn what_cannot_be_scaled_or_guessed_is_refused_in_one_line() {
    let folder = TempDir::new().unwrap();
    put(&folder, "terms.toml", "preset = \"ljungberg-model-ship\"\n");
    for (flags, code, pieces) in [
        (
            "kvlcc2-l7 --scale length_m=320,draught_m=22",
            3,
            ["kvlcc2-l7: the draught: found 22 m, expected 21.0286", "--guess"],
        ),
        ("kvlcc2-l7 --scale length_m=320,beam_m=58", 2, ["--scale: key: found key `beam_m`", "`draught_m`"]),
        (
            "kvlcc2-l7 --scale lenght_m=320",
            2,
            ["--scale: key: found key `lenght_m`", "did you mean `length_m`?"],
        ),
        ("kvlcc2-l7 --scale draught_m=20", 2, ["--scale", "`length_m`"]),
        ("kvlcc2-l7 --scale length_m=long", 2, ["--scale", "must be quoted"]),
        ("kvlcc2-l7 --scale length_m=0", 3, ["`the length`: found 0", "0.1 to 1000 m"]),
        ("kvlcc2-l7 --scale length_m=320,density_kg_m3=1", 3, ["`the density`: found 1", "900 to 1100"]),
        ("kvlcc2 --scale length_m=320", 3, ["`preset`: found `kvlcc2`", "did you mean `kvlcc2-l7`"]),
        ("terms.toml --scale length_m=320", 3, ["terms.toml: `model`: found terms per sample", "forces"]),
        ("none.toml --scale length_m=320", 1, ["none.toml", "No such file"]),
    ] {
        refused(&folder, code, &format!("new mine --vessel {flags}"), &pieces);
    }
    let main = "length_m=320,draught_m=20.8";
    for (more, pieces) in [
        ("beam_m=58,block=1.2", ["--guess: `the block coefficient`: found 1.2", "0.3 to 0.95"]),
        ("beam_m=400,block=0.8", ["--guess: the beam: found 400", "2.5 to 12 beams"]),
        ("beam_m=58,block=0.8,mass_kg=1e6", ["--guess: the mass: found 1000000", "displaced water"]),
        ("beam_m=58,block=0.8,speed_m_s=50", ["--guess: the speed: found 50", "Froude"]),
        ("beam_m=58,block=0.8,propeller_diameter_m=30", ["propeller's diameter: found 30", "draughts"]),
        ("beam_m=58", ["--guess", "`block`"]),
        ("beam_m=58,block=0.8,speed=8", ["--guess: key: found key `speed`", "did you mean `speed_m_s`?"]),
    ] {
        refused(&folder, 2, &format!("new mine --guess {main},{more}"), &pieces);
    }
    assert!(!folder.path().join("mine").exists());
    for (gone, remedy) in [("guess", "--guess length_m="), ("scale", "--scale length_m=")] {
        refused(&folder, 2, &format!("{gone} --length 320 --out vessel.toml"), &[gone, "it is gone", remedy]);
    }
    // A ship without a rudder has her file alone.
    let ran = run(&folder, "new larger --vessel otter --scale length_m=3").succeeds();
    assert!(ran.stdout.contains("vessel.toml;") && ran.stdout.contains("write dictionary.toml"), "{ran}");
}

#[test]
fn a_guess_comes_to_its_page_by_two_commands() {
    let folder = TempDir::new().unwrap();
    let guess = "--guess length_m=3,beam_m=0.5,draught_m=0.2,block=0.75";
    run(&folder, &format!("new mine {guess}")).succeeds();
    let number = |name: &str, key: &str| number(&folder, name, key);
    assert_eq!(number("mine/dictionary.toml", "speed_m_s"), number("mine/vessel.toml", "speed_m_s"));
    assert_eq!(number("mine/vessel.toml", "\"X_0\""), -number("mine/vessel.toml", "\"X_0\"").abs());
    let short = "--set campaign.realizations=1 --set campaign.duration_s=90";
    let ran = run(&folder, &format!("run mine --quiet {short}")).succeeds();
    assert!(ran.stdout.starts_with("out/mine/report.html: "), "{ran}");
    let merit = json(&folder, "out/mine/merit.json");
    assert!(merit["data"]["maneuvers"].as_array().unwrap().len() >= 8, "{merit}");
    // With a seed she is another ship of the same priors, and the same one again.
    let drawn = |seed: u64| {
        let made = format!("new of-{seed} {guess} --seed {seed}");
        run(&folder, &made).succeeds();
        String::from_utf8(bytes(&folder, &format!("of-{seed}/vessel.toml"))).unwrap()
    };
    let first = drawn(1);
    assert!(
        first.contains("drawn from the priors with seed 1") && !first.contains("\"hull.drag\" = 0.8\n"),
        "{first}"
    );
    assert_ne!(first.split("[value]").nth(1), drawn(2).split("[value]").nth(1));
    std::fs::remove_dir_all(folder.path().join("of-1")).unwrap();
    assert_eq!(first, drawn(1));
}
