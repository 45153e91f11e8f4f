//! All numbers of a ship, one after the other: known, free, or tied to a free one.

use refusal::{Invalid, check_name, foreign};

use crate::forces::{Number, NumberSpec, Real};

/// The place of a number among those of a ship.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct At(usize);

impl At {
    /// The number, in SI units.
    #[inline(always)]
    pub fn of<X: Real>(self, numbers: &[X]) -> X {
        numbers[self.0]
    }
}

/// The range of numbers of any sign.
const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// What a number is measured in.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// Its SI unit.
    pub unit: String,
    /// What one of the prime system is in SI units, if the number can be written in it.
    pub prime: Option<f64>,
    /// Whether a plain number is in the prime system.
    pub plain_prime: bool,
    /// Between which it is for any ship.
    pub range: [f64; 2],
    /// Whether it is a mass: free runs determine forces over masses alone.
    pub mass: bool,
}

impl Measured {
    /// A number that is the same in both systems.
    pub fn pure() -> Self {
        Self::si("1").or_prime(1.0)
    }

    /// One in this SI unit alone.
    pub fn si(unit: &str) -> Self {
        Self { unit: unit.to_owned(), prime: None, plain_prime: false, range: ANY, mass: false }
    }

    /// One above 0.
    pub fn above_zero(self) -> Self {
        Self { range: [f64::MIN_POSITIVE, f64::INFINITY], ..self }
    }

    /// With what one of the prime system is.
    pub fn or_prime(self, prime: f64) -> Self {
        Self { prime: Some(prime), ..self }
    }
}

/// A number under construction.
struct Entry {
    name: String,
    spec: NumberSpec,
    measured: Measured,
    /// Whether it was written as a plain number, or not at all.
    known: bool,
    /// Whether it was written.
    stated: bool,
}

impl Entry {
    /// What one of its own system is in SI units.
    fn scale(&self) -> f64 {
        match (self.spec.prime, &self.spec.tied_to) {
            (Some(_), _) => self.measured.prime.unwrap_or(1.0),
            _ => 1.0,
        }
    }

    fn refused(&self, found: impl Into<String>, expected: impl Into<String>, remedy: &str) -> Invalid {
        Invalid::new(format!("`{}`", foreign(&self.name)), found, expected, remedy)
    }

    /// The number in its own system.
    fn written(&self) -> Option<f64> {
        self.spec.prime.or(self.spec.nominal)
    }

    /// Refuses numbers that contradict each other.
    fn check(&self) -> Result<(), Invalid> {
        let NumberSpec { nominal, prime, value, prior, bounds, fixed, tied_to, factor } = &self.spec;
        let all = [nominal, prime, value, prior, factor];
        if let Some(number) = all.into_iter().flatten().find(|number| !number.is_finite()) {
            return Err(self.refused(number.to_string(), "a finite number", "correct it"));
        }
        if nominal.is_some() && prime.is_some() {
            let given = "both `nominal` and `prime`";
            return Err(self.refused(
                given,
                "a number in SI units or in the prime system",
                "remove one of them",
            ));
        }
        if prime.is_some() && self.measured.prime.is_none() {
            let expected =
                format!("`nominal` in {}: the prime system has no such number", self.measured.unit);
            return Err(self.refused("`prime`", expected, "write it in SI units"));
        }
        if let Some(prior) = prior.filter(|prior| *prior <= 0.0) {
            let expected = "a standard deviation above 0";
            return Err(self.refused(
                format!("`prior` {prior}"),
                expected,
                "write `fixed = true` if it is known",
            ));
        }
        let [low, high] = self.measured.range;
        let outside = |end: &&f64| !(low..=high).contains(&(**end * self.scale()));
        if let Some(number) = [nominal, prime, value].into_iter().flatten().find(outside) {
            let expected = match (low, high) {
                (f64::MIN_POSITIVE, _) => "a number above 0".to_owned(),
                _ => format!("a number from {low} to {high} {}", self.measured.unit),
            };
            return Err(self.refused(number.to_string(), expected, "correct it"));
        }
        let constrained = [*fixed, tied_to.is_some()].into_iter().filter(|is_set| *is_set).count();
        if constrained > 1 || (constrained == 1 && (prior.is_some() || bounds.is_some())) {
            let given = "`fixed` or `tied_to` with `prior`, `bounds` or each other";
            return Err(self.refused(given, "one of them", "remove the others"));
        }
        if factor.is_some() && tied_to.is_none() {
            return Err(self.refused("`factor` alone", "`factor` together with `tied_to`", "remove it"));
        }
        if tied_to.is_some() && (self.written().is_some() || value.is_some()) {
            return Err(self.refused("`tied_to` with a number", "one of them", "remove the number"));
        }
        if tied_to.is_none() && self.written().is_none() {
            return Err(self.refused("no number", "`nominal` or `prime`", "add one of them"));
        }
        self.check_free()
    }

    fn check_free(&self) -> Result<(), Invalid> {
        let NumberSpec { prior, bounds, fixed, tied_to, value, .. } = &self.spec;
        if self.measured.mass && !self.known && !fixed && tied_to.is_none() && prior.is_none() {
            let expected = "a `prior`, or `fixed = true`: motion determines forces over masses, not masses";
            return Err(self.refused("a free mass without a prior", expected, "fix it, or add a `prior`"));
        }
        let inside = |number: f64, [low, high]: [f64; 2]| low <= number && number <= high;
        match (bounds, self.written()) {
            (Some(bounds), _) if bounds[0].is_nan() || bounds[1].is_nan() || bounds[0] >= bounds[1] => {
                let given = format!("`bounds` [{}, {}]", bounds[0], bounds[1]);
                Err(self.refused(given, "a lower and a higher bound", "swap or correct them"))
            }
            (Some(bounds), Some(number))
                if ![Some(number), *value].into_iter().flatten().all(|known| inside(known, *bounds)) =>
            {
                let given = format!("{number} beyond its `bounds` [{}, {}]", bounds[0], bounds[1]);
                Err(self.refused(given, "numbers within the bounds", "correct one of them"))
            }
            _ => Ok(()),
        }
    }
}

/// A number of a finished ship.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Known(f64),
    /// An element of θ times this factor.
    Free(usize, f64),
}

/// Collects the numbers of components.
#[derive(Default)]
pub(crate) struct Builder {
    entries: Vec<Entry>,
}

impl Builder {
    /// The number `key` of `owner`, `default` where it is not written.
    ///
    /// # Errors
    /// No number where none is by default, or numbers that contradict each other.
    pub fn number(
        &mut self,
        owner: &str,
        key: &str,
        number: Option<&Number>,
        default: f64,
        measured: Measured,
    ) -> Result<At, Invalid> {
        let (spec, known) = match number {
            Some(Number::Table(spec)) => (spec.clone(), false),
            Some(Number::Plain(plain)) if measured.plain_prime => {
                (NumberSpec { prime: Some(*plain), ..NumberSpec::default() }, true)
            }
            Some(Number::Plain(plain)) => {
                (NumberSpec { nominal: Some(*plain), ..NumberSpec::default() }, true)
            }
            None => (NumberSpec { nominal: Some(default), ..NumberSpec::default() }, true),
        };
        self.add(Entry { name: format!("{owner}.{key}"), spec, measured, known, stated: number.is_some() })
    }

    /// The parameter of a term.
    ///
    /// # Errors
    /// As [`Self::number`].
    pub fn parameter(&mut self, name: &str, spec: &NumberSpec, measured: Measured) -> Result<At, Invalid> {
        check_name("`parameter` of a term", name)?;
        self.add(Entry { name: name.to_owned(), spec: spec.clone(), measured, known: false, stated: true })
    }

    fn add(&mut self, entry: Entry) -> Result<At, Invalid> {
        if self.entries.iter().any(|other| other.name == entry.name) {
            return Err(entry.refused("the same name twice", "one number of a name", "rename one of them"));
        }
        entry.check()?;
        self.entries.push(entry);
        Ok(At(self.entries.len() - 1))
    }

    /// The numbers, with the free ones in order.
    ///
    /// # Errors
    /// A tie to an unknown name, to a plain number, or to one that is tied itself.
    pub fn finish(self) -> Result<Numbers, Invalid> {
        let mut numbers = Numbers::default();
        let mut free = vec![None; self.entries.len()];
        for (i, entry) in self.entries.iter().enumerate().filter(|(_, entry)| entry.spec.tied_to.is_none()) {
            if !(entry.known || entry.spec.fixed) {
                free[i] = Some(numbers.parameters.len());
                numbers.parameters.push(parameter(entry));
            }
        }
        for (entry, free) in self.entries.iter().zip(&free) {
            let slot = match (free, &entry.spec.tied_to) {
                (Some(at), _) => Slot::Free(*at, entry.scale()),
                (None, Some(to)) => self.tied(entry, to, &numbers.parameters)?,
                (None, None) => Slot::Known(entry.scale() * entry.written().unwrap_or_default()),
            };
            numbers.slots.push(slot);
        }
        let label = |entry: Entry| (entry.name, entry.measured.unit, entry.stated);
        numbers.labels = self.entries.into_iter().map(label).collect();
        Ok(numbers)
    }

    /// A number that is tied: both are in the system of the other, so that prime numbers are tied to prime numbers.
    fn tied(&self, entry: &Entry, to: &str, parameters: &[Parameter]) -> Result<Slot, Invalid> {
        let Some(at) = parameters.iter().position(|parameter| parameter.name == to) else {
            let known = parameters.iter().map(|parameter| parameter.name.as_str());
            let unknown = Invalid::unknown(format!("`{}`: tied_to", foreign(&entry.name)), to, known);
            return Err(Invalid { expected: format!("a free parameter: {}", unknown.expected), ..unknown });
        };
        let other = self.entries.iter().find(|entry| entry.name == to);
        let prime = other.is_some_and(|entry| entry.spec.prime.is_some());
        let scale = match (prime, entry.measured.prime) {
            (true, Some(scale)) => scale,
            (true, None) => {
                let expected = format!("a parameter in {}", entry.measured.unit);
                return Err(entry.refused(
                    format!("tied to `{to}` in the prime system"),
                    expected,
                    "write `nominal` there",
                ));
            }
            (false, _) => 1.0,
        };
        Ok(Slot::Free(at, scale * entry.spec.factor.unwrap_or(1.0)))
    }
}

fn parameter(entry: &Entry) -> Parameter {
    let unit = if entry.spec.prime.is_some() { "1".to_owned() } else { entry.measured.unit.clone() };
    Parameter {
        name: entry.name.clone(),
        unit,
        nominal: entry.written().unwrap_or_default(),
        value: entry.spec.value,
        prior: entry.spec.prior,
        bounds: entry.spec.bounds.unwrap_or(entry.measured.range.map(|end| end / entry.scale())),
        scale: entry.scale(),
        si_unit: entry.measured.unit.clone(),
        prime: entry.measured.prime,
    }
}

/// The numbers of a ship.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Numbers {
    slots: Vec<Slot>,
    /// The name and the unit of each slot, and whether it was written.
    labels: Vec<(String, String, bool)>,
    /// The free ones, in the order of θ.
    pub parameters: Vec<Parameter>,
}

impl Numbers {
    /// All of them in SI units, with these free ones.
    pub fn with<X: Real>(&self, theta: &[X]) -> Vec<X> {
        let number = |slot: &Slot| match *slot {
            Slot::Known(value) => X::from(value),
            Slot::Free(i, 1.0) => theta[i],
            Slot::Free(i, scale) => theta[i].times(scale),
        };
        self.slots.iter().map(number).collect()
    }

    /// All of them with their names, in SI units, with these free ones.
    pub fn quantities(&self, theta: &[f64]) -> Vec<Quantity> {
        let values = self.with(theta);
        let all = self.slots.iter().zip(&self.labels).zip(values);
        all.map(|((slot, (name, unit, stated)), value)| {
            let source = self.source(*slot, name);
            Quantity { name: name.clone(), unit: unit.clone(), value, stated: *stated, source }
        })
        .collect()
    }

    fn source(&self, slot: Slot, name: &str) -> QuantitySource {
        match slot {
            Slot::Known(_) => QuantitySource::Known,
            Slot::Free(at, _) if self.parameters[at].name == name => QuantitySource::Free(at),
            Slot::Free(at, scale) => {
                let Parameter { name, scale: one, .. } = &self.parameters[at];
                QuantitySource::Tied { to: name.clone(), factor: scale / one }
            }
        }
    }
}

/// A number of a ship in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// That of a term's parameter, or `component.key`.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Whether the ship's description has it; else the value is the default.
    pub stated: bool,
    /// Where it comes from.
    pub source: QuantitySource,
}

/// Where a number of a ship comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantitySource {
    /// It is known.
    Known,
    /// It is the free parameter with this index.
    Free(usize),
    /// It is a free number times a factor, both in SI units.
    Tied {
        /// The name of the free number.
        to: String,
        /// The factor.
        factor: f64,
    },
}

/// A free parameter: an element of θ, in the system that it was written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// That of a term, or `component.key`.
    pub name: String,
    /// Its unit; `1` in the prime system.
    pub unit: String,
    /// Its value before any estimate.
    pub nominal: f64,
    /// Its true value, where known.
    pub value: Option<f64>,
    /// Standard deviation of its prior.
    pub prior: Option<f64>,
    /// Bounds of its estimates; infinite at an open end.
    pub bounds: [f64; 2],
    /// Factor from θ to SI units: ρ, length, draught and speed of the prime system, or 1.
    pub scale: f64,
    /// Its SI unit, whatever it was written in.
    pub si_unit: String,
    /// What one of the prime system is in SI units, if the number can be written in it.
    pub prime: Option<f64>,
}

/// An input or measured disturbance, in the order of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Between which it stays, if that is known.
    pub range: Option<[f64; 2]>,
}

/// A channel as a component uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Its place in a row.
    pub channel: usize,
    /// What its unit is in that of the component.
    pub factor: f64,
}

/// What a component expects of a channel: units, with what each is in the first one.
pub(crate) type Units = [(&'static str, f64)];

/// Revolutions per second.
pub(crate) const REVOLUTIONS: &Units = &[
    ("1/s", 1.0),
    ("rps", 1.0),
    ("Hz", 1.0),
    ("rpm", 1.0 / 60.0),
    ("1/min", 1.0 / 60.0),
    ("rad/s", 0.5 * std::f64::consts::FRAC_1_PI),
];
/// Angles.
pub(crate) const ANGLES: &Units =
    &[("rad", 1.0), ("deg", std::f64::consts::PI / 180.0), ("°", std::f64::consts::PI / 180.0)];
/// Forces.
pub(crate) const FORCES: &Units = &[("N", 1.0), ("kN", 1e3)];
/// Speeds.
pub(crate) const SPEEDS: &Units = &[("m/s", 1.0), ("kn", 1852.0 / 3600.0)];

/// The channel `name` that the key `key` of `owner` needs, in one of `units`; in any without them.
pub(crate) fn driven(
    channels: &[Channel],
    owner: &str,
    key: &str,
    name: &str,
    units: &Units,
) -> Result<Driven, Invalid> {
    let Some(channel) = channels.iter().position(|channel| channel.name == name) else {
        let known = channels.iter().map(|channel| channel.name.as_str());
        return Err(Invalid::unknown(format!("`{key}` of `{}`", foreign(owner)), name, known));
    };
    let unit = channels[channel].unit.as_str();
    if units.is_empty() {
        return Ok(Driven { channel, factor: 1.0 });
    }
    let factor = units.iter().find(|(known, _)| *known == unit).map(|(_, factor)| *factor);
    let factor = factor.ok_or_else(|| {
        let expected: Vec<&str> = units.iter().map(|(known, _)| *known).collect();
        let given = format!("channel `{}` in `{}`", foreign(name), foreign(unit));
        let thing = format!("`{key}` of `{}`", foreign(owner));
        Invalid::new(thing, given, expected.join(", "), "state the channel in one of these units")
    })?;
    Ok(Driven { channel, factor })
}
