//! Port and starboard shafts in units of their own: their sum, their difference and their forces.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// 30 seconds of t,u,v,r,port,starboard: revolutions of 3 + 0.1 t and of 2 per second, in rad/s and in rpm.
fn two_shafts() -> String {
    let port = |t: usize| std::f64::consts::TAU * (3.0 + 0.1 * t as f64);
    let row = |t: usize| format!("{t},{:.2},0.02,0.001,{:.9},120\n", 0.1 + 0.01 * t as f64, port(t));
    "t,u,v,r,port,starboard\n".to_owned() + &(0..30).map(row).collect::<String>()
}

/// Both shafts as channels; `more` after them.
fn of_two(more: &str) -> String {
    let shaft = |(name, unit): (&str, &str)| {
        format!("[[file.channel]]\ncolumn = \"{name}\"\nchannel = \"{name}\"\nunit = \"{unit}\"\n")
    };
    let [port, starboard] = [("port", "rad/s"), ("starboard", "rpm")].map(shaft);
    let text = config("");
    let without_n = text.replace("[[file.channel]]\ncolumn = \"n\"\nchannel = \"n\"\nunit = \"rpm\"\n", "");
    without_n + &port + &starboard + more
}

fn derived(name: &str, formula: &str, unit: &str) -> String {
    format!("[[derived]]\nchannel = \"{name}\"\nformula = \"{formula}\"\nunit = \"{unit}\"\n")
}

fn made_of(text: &str) -> Made {
    ingest(folder(&[("ingest.toml", text), ("a.csv", &two_shafts())]).path(), &CONFIG)
}

#[track_caller]
fn near(made: &Made, name: &str, of: impl Fn(f64) -> f64) {
    for row in 0..made.rows - 1 {
        let (found, expected) = (made.f64(name)[row], of(made.f64("t")[row]));
        assert!((found - expected).abs() < 1e-8, "{name}: {found} for {expected}");
    }
}

#[test]
fn law_sums_and_differences_of_shafts_are_in_revolutions_whatever_their_units() {
    let both =
        derived("sum", "port + starboard", "1/s") + &derived("difference", "0.5 port - 0.5 starboard", "1/s");
    let made = made_of(&of_two(&both));
    near(&made, "sum", |t| 5.0 + 0.1 * t);
    near(&made, "difference", |t| 0.5 * (1.0 + 0.1 * t));
    near(&made, "port", |t| 3.0 + 0.1 * t);
    // Without a sum a channel stays in its unit.
    near(&made_of(&of_two("")), "port", |t| std::f64::consts::TAU * (3.0 + 0.1 * t));
}

#[test]
fn sums_of_different_things_or_in_another_unit_are_refused() {
    for (formula, unit, found) in [
        ("port - starboard", "rpm", "`rpm` for a sum of `port` in rad/s"),
        ("port - starboard", "rad/s", "`rad/s` for a sum of `starboard` in 1/s"),
        ("y_u + starboard", "m/s", "`m/s` for a sum of `starboard` in 1/s"),
    ] {
        let text = of_two(&derived("difference", formula, unit));
        refused(&text, &two_shafts(), &["ingest.toml: unit of channel `difference`", found]);
    }
}

#[test]
fn law_a_thruster_takes_its_speed_in_radians_per_second() {
    let thruster = |speed: &str| {
        format!(
            "[[thruster]]\nkind = \"azimuth\"\nspeed = \"{speed}\"\nangle = \"a\"\nposition_m = [-2.0, 0.5]\ncoefficient = 10.0\n"
        )
    };
    let ahead = derived("a", "0 port port", "rad");
    let made = made_of(&of_two(&(ahead + &thruster("port"))));
    near(&made, "tau1", |t| 10.0 * (3.0 + 0.1 * t).powi(2));
}

#[test]
fn a_vessels_shaft_is_converted_from_radians_per_second() {
    let vessel = "name = \"a\"\nsample_rate_hz = 1.0\ninput = [{ name = \"port\", unit = \"1/s\" }]\n\
         surge = [{ parameter = \"a\", term = \"u\", nominal = -0.1 }, { parameter = \"b\", term = \"port\", nominal = 0.1 }]\n\
         sway = [{ parameter = \"c\", term = \"v\", nominal = -0.1 }]\nyaw = [{ parameter = \"d\", term = \"r\", nominal = -0.1 }]\n";
    let files = [("ingest.toml", of_two("")), ("vessel.toml", vessel.to_owned()), ("a.csv", two_shafts())];
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let made = ingest(folder(&files).path(), &[&CONFIG[..], &["--vessel", "vessel.toml"]].concat());
    near(&made, "port", |t| 3.0 + 0.1 * t);
    assert_eq!(made.units["port"], "1/s");
}
