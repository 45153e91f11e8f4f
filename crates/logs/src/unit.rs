/// A unit that a log may be in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub name: &'static str,
    /// The unit that it is converted to: SI, radians, revolutions per second.
    pub si: &'static str,
    /// How many of those it is.
    pub factor: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn of(name: &'static str, si: &'static str, factor: f64) -> Unit {
    Unit { name, si, factor }
}

/// All units that are known. Letters' case matters: `kn` is a knot, `kN` a kilonewton.
pub const UNITS: &[Unit] = &[
    of("1", "1", 1.0),
    of("%", "1", 0.01),
    of("s", "s", 1.0),
    of("ms", "s", 1e-3),
    of("min", "s", 60.0),
    of("m", "m", 1.0),
    of("mm", "m", 1e-3),
    of("cm", "m", 1e-2),
    of("km", "m", 1e3),
    of("ft", "m", 0.3048),
    of("nmi", "m", 1852.0),
    of("m/s", "m/s", 1.0),
    of("mm/s", "m/s", 1e-3),
    of("cm/s", "m/s", 1e-2),
    of("km/h", "m/s", 1.0 / 3.6),
    of("knot", "m/s", 1852.0 / 3600.0),
    of("kn", "m/s", 1852.0 / 3600.0),
    of("kt", "m/s", 1852.0 / 3600.0),
    of("ft/s", "m/s", 0.3048),
    of("m/s^2", "m/s^2", 1.0),
    of("rad", "rad", 1.0),
    of("deg", "rad", DEGREE),
    of("rad/s", "rad/s", 1.0),
    of("deg/s", "rad/s", DEGREE),
    of("deg/min", "rad/s", DEGREE / 60.0),
    of("1/s", "1/s", 1.0),
    of("rps", "1/s", 1.0),
    of("Hz", "1/s", 1.0),
    of("rpm", "1/s", 1.0 / 60.0),
    of("1/min", "1/s", 1.0 / 60.0),
    of("N", "N", 1.0),
    of("kN", "N", 1e3),
    of("MN", "N", 1e6),
    of("N m", "N m", 1.0),
    of("Nm", "N m", 1.0),
    of("kN m", "N m", 1e3),
    of("kNm", "N m", 1e3),
    of("MN m", "N m", 1e6),
    of("W", "W", 1.0),
    of("kW", "W", 1e3),
    of("V", "V", 1.0),
    of("mV", "V", 1e-3),
    of("A", "A", 1.0),
    of("Pa", "Pa", 1.0),
    of("hPa", "Pa", 1e2),
    of("kPa", "Pa", 1e3),
];

/// The unit called `name`.
pub fn unit(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

/// What a number in `from` is multiplied by to be in `to`; none if they measure different things. Units that are not in
/// the table fit only themselves.
pub fn factor(from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    let (from, to) = (unit(from)?, unit(to)?);
    (from.si == to.si).then(|| if to.factor == 1.0 { from.factor } else { from.factor / to.factor })
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn law_every_unit_has_a_name_of_its_own_and_converts_there_and_back() {
        for (i, unit) in UNITS.iter().enumerate() {
            assert!(UNITS[..i].iter().all(|other| other.name != unit.name), "{}", unit.name);
            let there = factor(unit.name, unit.si).unwrap();
            approx::assert_relative_eq!(
                there * factor(unit.si, unit.name).unwrap(),
                1.0,
                max_relative = 1e-15
            );
        }
    }
}
