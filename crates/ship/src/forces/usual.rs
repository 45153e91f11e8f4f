//! What is usually known of a ship's numbers before any recording: standard deviations of their priors.

use refusal::{Invalid, check_ranges, foreign};

use crate::forces::slots::{Dimension, Place, Slot, slots};
use crate::forces::term::factors;
use crate::forces::{Area, Channel, Description, Factor, Forces, Number, NumberSpec, Parameter, TermSpec};

/// Standard deviations of derivatives in the prime system of ½ρLd, by powers of v and r: surge, sway, yaw. They are those
/// with which free runs of tankers were fitted.
const DERIVATIVES: [&[([usize; 2], f64)]; 3] = [
    &[([0, 0], 0.02), ([2, 0], 0.1), ([1, 1], 0.1), ([0, 2], 0.05), ([4, 0], 0.3)],
    &[
        ([0, 0], 0.003),
        ([1, 0], 0.3),
        ([0, 1], 0.1),
        ([2, 0], 1.0),
        ([1, 1], 1.0),
        ([0, 2], 0.2),
        ([3, 0], 1.5),
        ([2, 1], 1.0),
        ([1, 2], 1.0),
        ([0, 3], 0.2),
    ],
    &[
        ([0, 0], 0.001),
        ([1, 0], 0.1),
        ([0, 1], 0.05),
        ([2, 0], 0.3),
        ([1, 1], 0.3),
        ([0, 2], 0.1),
        ([3, 0], 0.5),
        ([2, 1], 0.5),
        ([1, 2], 0.3),
        ([0, 3], 0.1),
    ],
];

/// Standard deviations of numbers of propellers and rudders, by key.
const COMPONENTS: [(&str, f64); 8] = [
    ("wake", 0.3),
    ("deduction", 0.3),
    ("epsilon", 0.4),
    ("gamma.0", 0.4),
    ("gamma.1", 0.4),
    ("interaction", 0.4),
    ("kappa", 0.3),
    ("ell", 0.5),
];

/// That of a rudder's deduction.
const RUDDER_DEDUCTION: f64 = 0.4;

/// Standard deviation of all others, over the number itself.
const SHARE: f64 = 0.5;

impl Description {
    /// The same ship, where every free number has a prior: its own, or else the usual one, with the names of the latter.
    ///
    /// # Errors
    /// What [`Forces::new`] refuses; a number of 0 for which nothing is usual.
    pub fn with_usual_priors(&self, channels: &[Channel]) -> Result<(Self, Vec<String>), Invalid> {
        let forces = Forces::new(self, channels)?;
        let without = forces.parameters().iter().filter(|parameter| parameter.prior.is_none());
        let all = without.map(|without| Ok((without.name.clone(), self.usual(without, channels)?)));
        let all: Vec<(String, f64)> = all.collect::<Result<_, Invalid>>()?;
        let ship = self.with_priors(&all, channels)?;
        Ok((ship, all.into_iter().map(|(name, _)| name).collect()))
    }

    /// The same ship with these standard deviations of priors, in the systems that the numbers are written in.
    ///
    /// # Errors
    /// A term that is none.
    pub fn with_priors(&self, deviations: &[(String, f64)], channels: &[Channel]) -> Result<Self, Invalid> {
        self.changed(channels, |name, number| {
            if let Some((_, deviation)) = deviations.iter().find(|known| known.0 == name) {
                number.prior = Some(*deviation);
            }
        })
    }

    /// The same ship with other numbers: `change` is called with the name and the number of every one that is no plain one.
    ///
    /// # Errors
    /// A term that is none.
    pub fn changed(
        &self,
        channels: &[Channel],
        mut change: impl FnMut(&str, &mut NumberSpec),
    ) -> Result<Self, Invalid> {
        let mut ship = self.clone();
        for slot in &mut slots(&mut ship, channels)? {
            let Some(parts) = slot.place.parts() else { continue };
            let [nominal, prime] = parts.numbers;
            let mut number = NumberSpec {
                nominal: *nominal,
                prime: *prime,
                value: *parts.value,
                prior: *parts.prior,
                bounds: *parts.bounds,
                tied_to: parts.tied_to.clone(),
                factor: *parts.factor,
                fixed: false,
            };
            change(&slot.name, &mut number);
            (*nominal, *prime, *parts.value) = (number.nominal, number.prime, number.value);
            (*parts.prior, *parts.bounds, *parts.factor) = (number.prior, number.bounds, number.factor);
        }
        Ok(ship)
    }

    /// The usual standard deviation of a number, in the system that it is written in.
    fn usual(&self, parameter: &Parameter, channels: &[Channel]) -> Result<f64, Invalid> {
        let terms = [&self.surge, &self.sway, &self.yaw];
        let written = |terms: &[TermSpec]| terms.iter().position(|spec| spec.parameter == parameter.name);
        let place = terms.iter().enumerate().find_map(|(d, terms)| Some((d, &terms[written(terms)?])));
        let share = SHARE * parameter.nominal.abs();
        let deviation = match place {
            Some((d, spec)) => {
                // By ½ρL², where the ship's forces are, numbers are smaller.
                let area = match self.ship.area {
                    Some(Area::LengthSquared) => self.ship.draught_m / self.ship.length_m,
                    _ => 1.0,
                };
                let one = area * parameter.prime.unwrap_or(parameter.scale) / parameter.scale;
                let least = DERIVATIVES[d][0].1 * one;
                derivative(spec, d, channels)?.map_or(share.max(least), |deviation| deviation * one)
            }
            None => {
                let all = of_component(self).into_iter();
                let usual = all.filter(|(owner, key, _)| parameter.name == format!("{owner}.{key}"));
                usual.map(|number| number.2).next().unwrap_or(share)
            }
        };
        if deviation > 0.0 {
            return Ok(deviation);
        }
        let expected = "a `prior`: no standard deviation of such a number is usual";
        Err(Invalid::new(
            format!("`{}`", foreign(&parameter.name)),
            "0 without a `prior`",
            expected,
            "add one",
        ))
    }
}

/// That of a derivative in the prime system; none where nothing is usual, as for products with `du` or a channel.
fn derivative(spec: &TermSpec, d: usize, channels: &[Channel]) -> Result<Option<f64>, Invalid> {
    Ok(powers(&factors(spec, channels)?).and_then(|found_powers| of_powers(d, found_powers)))
}

/// The powers of v and r of a product; none for products with `du` or a channel, or with a division by v or r.
pub(crate) fn powers(factors: &[Factor]) -> Option<[usize; 2]> {
    let mut powers = [0, 0];
    for factor in factors {
        match factor.motion() {
            "v" => powers[0] += 1,
            "r" => powers[1] += 1,
            "u" | "U" | "U_s" => {}
            _ => return None,
        }
    }
    Some(powers)
}

/// The usual standard deviation of a derivative by powers of v and r, in the prime system.
pub(crate) fn of_powers(d: usize, powers: [usize; 2]) -> Option<f64> {
    DERIVATIVES[d].iter().find(|known| known.0 == powers).map(|known| known.1)
}

/// The names and keys of the numbers of propellers and rudders that have a usual standard deviation, with it.
pub(crate) fn of_component(ship: &Description) -> Vec<(&str, &'static str, f64)> {
    let rudders = ship.rudder.iter().map(|rudder| (rudder.name.as_str(), RUDDER_DEDUCTION));
    let propellers = ship.propeller.iter().map(|propeller| (propeller.name.as_str(), COMPONENTS[1].1));
    let of = |(name, deduction)| {
        COMPONENTS.map(|(key, usual)| (name, key, if key == "deduction" { deduction } else { usual }))
    };
    rudders.chain(propellers).flat_map(of).collect()
}

/// A number this close to one of 12 digits is that one, so that a ship that is scaled back has her own numbers.
const SAME: f64 = 2e-14;

/// From a ship to a similar one of another length, in other water. Speeds and times change by the root of the ratio of
/// lengths, revolutions and yaw rates by its inverse, forces by its cube and the ratio of densities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Her length \[m\].
    pub length_m: f64,
    /// The density of her water \[kg/m³\].
    pub density_kg_m3: f64,
    /// Her length over that of the first ship.
    ratio: f64,
    /// The density of her water over that of the first ship.
    water: f64,
}

impl Similarity {
    /// From the ship of `description` to one of `length_m`, in water of `density_kg_m3`, or in the same.
    ///
    /// # Errors
    /// A length or density that no ship or water has.
    pub fn new(
        description: &Description,
        length_m: f64,
        density_kg_m3: Option<f64>,
    ) -> Result<Self, Invalid> {
        let density_kg_m3 = density_kg_m3.unwrap_or(description.density_kg_m3);
        check_ranges([
            ("the length", length_m, 0.1..=1000.0, "m"),
            ("the density", density_kg_m3, 900.0..=1100.0, "kg/m³"),
        ])?;
        let ratio = length_m / description.ship.length_m;
        Ok(Self { length_m, density_kg_m3, ratio, water: density_kg_m3 / description.density_kg_m3 })
    }

    /// A number of the first ship that is made of `dimension`, for the similar one.
    fn scaled(&self, number: f64, dimension: Dimension) -> f64 {
        if dimension == Dimension::NONE || number == 0.0 || !number.is_finite() {
            return number;
        }
        settled(number * dimension.factor(self.ratio, self.water))
    }

    /// A number of this unit, for the similar ship; none where no rule scales the unit.
    pub fn in_unit(&self, number: f64, unit: &str) -> Option<f64> {
        Dimension::of_unit(unit).map(|dimension| self.scaled(number, dimension))
    }

    /// A change per second of this unit.
    pub fn per_second(&self, number: f64, unit: &str) -> Option<f64> {
        Dimension::of_unit(unit).map(|dimension| self.scaled(number, dimension.times(Dimension::TIME, -1)))
    }

    /// A length \[m\].
    pub fn metres(&self, number: f64) -> f64 {
        self.scaled(number, Dimension::length(1))
    }

    /// A time \[s\].
    pub fn seconds(&self, number: f64) -> f64 {
        self.scaled(number, Dimension::TIME)
    }

    /// A number of events per second \[Hz\].
    pub fn hertz(&self, number: f64) -> f64 {
        self.scaled(number, Dimension::RATE)
    }
}

/// `number`, or one of 12 digits that it is but for rounding.
fn settled(number: f64) -> f64 {
    let short = format!("{number:.11e}").parse().unwrap_or(number);
    if (short - number).abs() <= SAME * number.abs() { short } else { number }
}

/// What a number can be tied to: its name, whether it is in the prime system, and what it is made of.
type Tied = (String, bool, Option<Dimension>);

impl Description {
    /// The similar ship. Numbers of the prime system, angles and pure numbers stay.
    ///
    /// # Errors
    /// A number in SI units that depends on a channel whose unit no rule scales; a term that is none.
    pub fn similar(&self, by: &Similarity, channels: &[Channel]) -> Result<Self, Invalid> {
        let mut ship = self.clone();
        ship.density_kg_m3 = by.density_kg_m3;
        ship.step_s = ship.step_s.map(|step| by.seconds(step));
        ship.ship.length_m = by.length_m;
        ship.ship.draught_m = by.metres(ship.ship.draught_m);
        ship.ship.speed_m_s = by.scaled(ship.ship.speed_m_s, Dimension::SPEED);
        let mut all = slots(&mut ship, channels)?;
        let known: Vec<Tied> = all.iter_mut().map(tied).collect();
        for slot in &mut all {
            by.apply(slot, &known)?;
        }
        drop(all);
        Ok(ship)
    }
}

fn tied(slot: &mut Slot) -> Tied {
    let prime = slot.place.parts().is_some_and(|parts| parts.numbers[1].is_some());
    (slot.name.clone(), prime, slot.dimension.clone().ok())
}

impl Similarity {
    fn apply(&self, slot: &mut Slot, known: &[Tied]) -> Result<(), Invalid> {
        let dimension = slot.dimension.clone();
        let unscaled = |unit: &str| {
            let given = format!("a number in SI units, of a channel in `{}`", foreign(unit));
            let expected = "a channel in a unit that similarity scales, such as rad, 1/s, m/s, N";
            let remedy = "state the channel in such a unit, or write the number as `prime`";
            Invalid::new(format!("`{}`", foreign(&slot.name)), given, expected, remedy)
        };
        if let Place::Component(Number::Plain(plain)) = &mut slot.place {
            if !slot.plain_prime && *plain != 0.0 {
                *plain = self.scaled(*plain, dimension.map_err(|unit| unscaled(&unit))?);
            }
            return Ok(());
        }
        let Some(parts) = slot.place.parts() else { return Ok(()) };
        if parts.numbers[1].is_some() {
            return Ok(());
        }
        if let Some(to) = parts.tied_to {
            let Some((_, false, other)) = known.iter().find(|tied| tied.0 == *to) else { return Ok(()) };
            let (Ok(own_dimension), Some(other)) = (dimension, *other) else { return Ok(()) };
            *parts.factor = Some(self.scaled(parts.factor.unwrap_or(1.0), own_dimension.times(other, -1)))
                .filter(|factor| *factor != 1.0);
            return Ok(());
        }
        let dimension = dimension.map_err(|unit| unscaled(&unit))?;
        let [nominal, _] = parts.numbers;
        for number in [nominal, parts.value, parts.prior].into_iter().flatten() {
            *number = self.scaled(*number, dimension);
        }
        for end in parts.bounds.iter_mut().flatten() {
            *end = self.scaled(*end, dimension);
        }
        Ok(())
    }
}
