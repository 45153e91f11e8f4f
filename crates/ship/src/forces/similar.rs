//! The same ship at another size: geometrically similar, at the same Froude number.

use refusal::{Invalid, check_ranges, foreign};

use crate::forces::dimension::Dimension;
use crate::forces::slots::{Place, Slot, slots};
use crate::forces::{Channel, Description, Number};

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
        Dimension::of_unit(unit).map(|own| self.scaled(number, own))
    }

    /// A change per second of this unit.
    pub fn per_second(&self, number: f64, unit: &str) -> Option<f64> {
        Dimension::of_unit(unit).map(|own| self.scaled(number, own.times(Dimension::TIME, -1)))
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
        let mut own = self.clone();
        own.density_kg_m3 = by.density_kg_m3;
        own.step_s = own.step_s.map(|step| by.seconds(step));
        own.ship.length_m = by.length_m;
        own.ship.draught_m = by.metres(own.ship.draught_m);
        own.ship.speed_m_s = by.scaled(own.ship.speed_m_s, Dimension::SPEED);
        let mut all = slots(&mut own, channels)?;
        let known: Vec<Tied> = all.iter_mut().map(tied).collect();
        for slot in &mut all {
            by.apply(slot, &known)?;
        }
        drop(all);
        Ok(own)
    }
}

fn tied(slot: &mut Slot) -> Tied {
    let prime = slot.place.parts().is_some_and(|own| own.numbers[1].is_some());
    (slot.name.clone(), prime, slot.dimension.clone().ok())
}

impl Similarity {
    fn apply(&self, slot: &mut Slot, known: &[Tied]) -> Result<(), Invalid> {
        let dimension = slot.dimension.clone();
        let unscaled = |unit: &str| {
            let found = format!("a number in SI units, of a channel in `{}`", foreign(unit));
            let expected = "a channel in a unit that similarity scales, such as rad, 1/s, m/s, N";
            let remedy = "state the channel in such a unit, or write the number as `prime`";
            Invalid::new(format!("`{}`", foreign(&slot.name)), found, expected, remedy)
        };
        if let Place::Component(Number::Plain(own)) = &mut slot.place {
            if !slot.plain_prime && *own != 0.0 {
                *own = self.scaled(*own, dimension.map_err(|unit| unscaled(&unit))?);
            }
            return Ok(());
        }
        let Some(parts) = slot.place.parts() else { return Ok(()) };
        if parts.numbers[1].is_some() {
            return Ok(());
        }
        if let Some(to) = parts.tied_to {
            let Some((_, false, other)) = known.iter().find(|own| own.0 == *to) else { return Ok(()) };
            let (Ok(own), Some(other)) = (dimension, *other) else { return Ok(()) };
            *parts.factor = Some(self.scaled(parts.factor.unwrap_or(1.0), own.times(other, -1)))
                .filter(|factor| *factor != 1.0);
            return Ok(());
        }
        let dimension = dimension.map_err(|unit| unscaled(&unit))?;
        let [nominal, _] = parts.numbers;
        for own in [nominal, parts.value, parts.prior].into_iter().flatten() {
            *own = self.scaled(*own, dimension);
        }
        for end in parts.bounds.iter_mut().flatten() {
            *end = self.scaled(*end, dimension);
        }
        Ok(())
    }
}
