use std::f64::consts::TAU;

/// A unit that a log may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub name: &'static str,
    /// The unit that it is converted to: SI, radians, revolutions per second.
    pub si: &'static str,
    /// Its size in that unit.
    pub factor: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn of(name: &'static str, si: &'static str, factor: f64) -> Unit {
    Unit { name, si, factor }
}

/// All known units. Case matters: `kn` is a knot, `kN` a kilonewton.
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

/// [`factor`], and from turning in radians to revolutions of a shaft, or back.
pub fn shaft_factor(from: &str, to: &str) -> Option<f64> {
    let of = |from: &Unit, to: &Unit| match (from.si, to.si) {
        ("rad/s", "1/s") => Some(from.factor / to.factor / TAU),
        ("1/s", "rad/s") => Some(from.factor / to.factor * TAU),
        _ => None,
    };
    factor(from, to).or_else(|| of(unit(from)?, unit(to)?))
}

/// The factor from `from` to `to`; `None` if they measure different things. Units that are not in the table
/// match only themselves.
pub fn factor(from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    let (from, to) = (unit(from)?, unit(to)?);
    (from.si == to.si).then(|| if to.factor == 1.0 { from.factor } else { from.factor / to.factor })
}
