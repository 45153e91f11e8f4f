//! Units and their conversions.

use logs::{UNITS, factor, shaft_factor};

#[test]
fn conversions_are_those_of_the_tables_of_units() {
    for (value, from, expected, to) in [
        (180.0, "deg", std::f64::consts::PI, "rad"),
        (90.0, "deg/s", std::f64::consts::FRAC_PI_2, "rad/s"),
        (60.0, "deg/min", std::f64::consts::PI / 180.0, "rad/s"),
        (120.0, "rpm", 2.0, "1/s"),
        (3.0, "rps", 3.0, "1/s"),
        (1.0, "knot", 0.514_444_444_444_444_4, "m/s"),
        (1.0, "kn", 0.514_444_444_444_444_4, "m/s"),
        (36.0, "km/h", 10.0, "m/s"),
        (250.0, "mm", 0.25, "m"),
        (250.0, "mm/s", 0.25, "m/s"),
        (3.0, "kN", 3000.0, "N"),
        (4000.0, "N", 4.0, "kN"),
        (2.5, "kN m", 2500.0, "N m"),
        (2.5, "Nm", 2.5, "N m"),
        (1.0, "nmi", 1852.0, "m"),
        (50.0, "%", 0.5, "1"),
        (10.0, "ft", 3.048, "m"),
    ] {
        let found = value * factor(from, to).unwrap();
        approx::assert_relative_eq!(found, expected, max_relative = 1e-14);
    }
}

#[test]
fn units_of_different_things_do_not_convert() {
    for (from, to) in [("kn", "kN"), ("rpm", "rad/s"), ("deg", "m"), ("furlong", "m"), ("m", "furlong")] {
        assert_eq!(factor(from, to), None, "{from} to {to}");
    }
    assert_eq!(factor("m^2/s^2", "m^2/s^2"), Some(1.0));
}

#[test]
fn turning_converts_to_revolutions_of_a_shaft_alone() {
    for (from, to, expected) in [
        ("rad/s", "1/s", 1.0 / std::f64::consts::TAU),
        ("rad/s", "rpm", 60.0 / std::f64::consts::TAU),
        ("rpm", "rad/s", std::f64::consts::TAU / 60.0),
        ("rpm", "1/s", 1.0 / 60.0),
    ] {
        approx::assert_relative_eq!(shaft_factor(from, to).unwrap(), expected, max_relative = 1e-15);
    }
    assert_eq!(shaft_factor("rad", "1/s"), None);
}

#[test]
fn law_every_unit_has_a_name_of_its_own_and_converts_there_and_back() {
    for (i, unit) in UNITS.iter().enumerate() {
        assert!(UNITS[..i].iter().all(|other| other.name != unit.name), "{}", unit.name);
        let there = factor(unit.name, unit.si).unwrap();
        approx::assert_relative_eq!(there * factor(unit.si, unit.name).unwrap(), 1.0, max_relative = 1e-15);
    }
}
