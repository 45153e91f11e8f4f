//! The same ship at another size, and with priors for all that is free.

use crate::forces::{Channel, Description, NumberSpec, Similarity};
use refusal::{Invalid, foreign};

use super::physics::{VesselFile, preset};
use crate::model::physics::described;
use crate::model::{Formula, Vessel};

/// The channels that forces depend on, of a file.
fn channels(file: &VesselFile) -> Vec<Channel> {
    let channel =
        |name: &str, unit: &str, range| Channel { name: name.to_owned(), unit: unit.to_owned(), range };
    let inputs = file.input.iter().map(|own| channel(&own.name, &own.unit, own.range));
    let measured = file.measured.iter().map(|own| channel(&own.name, &own.unit, None));
    let derived = file.derived.iter().map(|own| channel(&own.name, &own.unit, None));
    inputs.chain(measured).chain(derived).collect()
}

impl VesselFile {
    /// The same ship, complete: her preset is put in, and the numbers of \[value\] and \[nominal\] stand at their terms.
    ///
    /// # Errors
    /// What [`Vessel::from_file`] refuses; a ship without forces.
    pub fn completed(self) -> Result<Self, Invalid> {
        let file = if self.preset.is_some() { preset(self)? } else { self };
        Vessel::from_file(file.clone())?;
        let own = described(&file)?.changed(&channels(&file), |name, own| {
            if let Some(value) = file.value.get(name) {
                own.value = Some(*value);
            }
            if let Some(nominal) = file.nominal.get(name) {
                let place = if own.prime.is_some() { &mut own.prime } else { &mut own.nominal };
                *place = Some(*nominal);
            }
        })?;
        Ok(Self {
            preset: None,
            value: Default::default(),
            nominal: Default::default(),
            ..file.with_forces(own)
        })
    }

    /// The same ship, where every free number has a prior: that of `deviations`, its own, or else the usual one; with the
    /// names of those that have the usual one.
    ///
    /// # Errors
    /// A ship without forces; a number of 0 for which nothing is usual.
    pub fn with_usual_priors(self, deviations: &[(String, f64)]) -> Result<(Self, Vec<String>), Invalid> {
        let channels = channels(&self);
        let known = described(&self)?.with_priors(deviations, &channels)?;
        let (own, usual) = known.with_usual_priors(&channels)?;
        Ok((self.with_forces(own), usual))
    }

    /// The same ship without true values, which are not known of another one.
    ///
    /// # Errors
    /// A ship without forces.
    pub fn without_truth(self) -> Result<Self, Invalid> {
        let plain = |number_spec: &mut NumberSpec| {
            let known = number_spec.nominal.is_some() || number_spec.prime.is_some();
            number_spec.value = number_spec.value.filter(|_| !known && number_spec.tied_to.is_none());
        };
        let own = described(&self)?.changed(&channels(&self), |_, own| plain(own))?;
        Ok(self.with_forces(own))
    }

    /// The geometrically similar ship of `length_m` at the same Froude number, in water of this density or in the same.
    /// Her sampling rate has as many samples per length sailed.
    ///
    /// # Errors
    /// A ship without forces, or that is not complete; a length or density that no ship has; a channel or number that no
    /// rule scales.
    pub fn similar(self, length_m: f64, density_kg_m3: Option<f64>) -> Result<Self, Invalid> {
        let description = described(&self)?;
        let by = Similarity::new(&description, length_m, density_kg_m3)?;
        let own = description.similar(&by, &channels(&self))?;
        let mut file = self.with_forces(own);
        check_derived(&file, &by)?;
        file.sample_rate_hz = file.sample_rate_hz.map(|rate| by.hertz(rate));
        for input in &mut file.input {
            let unscaled = || unscaled("input", &input.name, &input.unit);
            for end in input.range.iter_mut().flatten().chain(&mut input.dead_band) {
                *end = by.in_unit(*end, &input.unit).ok_or_else(unscaled)?;
            }
            if let Some(rate) = &mut input.rate_per_s {
                *rate = by.per_second(*rate, &input.unit).ok_or_else(unscaled)?;
            }
            input.lag_s = input.lag_s.map(|own| by.seconds(own));
            input.hold_s = input.hold_s.map(|own| by.seconds(own));
        }
        for own in &mut file.measured {
            if let Some(simulated) = &mut own.simulated {
                let scaled = by.in_unit(*simulated, &own.unit);
                *simulated = scaled.ok_or_else(|| unscaled("measured disturbance", &own.name, &own.unit))?;
            }
        }
        Vessel::from_file(file.clone())?;
        Ok(file)
    }

    fn with_forces(mut self, description: Description) -> Self {
        let Description { density_kg_m3, step_s, ship, surge, sway, yaw, .. } = description;
        (self.density_kg_m3, self.step_s, self.ship) = (Some(density_kg_m3), step_s, Some(ship));
        (self.surge, self.sway, self.yaw) = (surge, sway, yaw);
        (self.propeller, self.rudder, self.thruster) =
            (description.propeller, description.rudder, description.thruster);
        (self.wind, self.crossflow) = (description.wind, description.crossflow);
        self
    }
}

fn unscaled(kind: &str, name: &str, unit: &str) -> Invalid {
    let expected = "a unit that similarity scales, such as rad, 1/s, m/s, N";
    let thing = format!("{kind} `{}`", foreign(name));
    Invalid::new(thing, format!("`{}`", foreign(unit)), expected, "state it in such a unit")
}

/// Refuses derived channels that do not scale as their units do.
fn check_derived(file: &VesselFile, by: &Similarity) -> Result<(), Invalid> {
    let all = channels(file);
    // Rows of a ship and of the similar one, in the order of the channels.
    let first: Vec<f64> = (0..all.len()).map(|i| 0.3 + 0.1 * i as f64).collect();
    for own in &file.derived {
        let thing = || format!("derived channel `{}`", foreign(&own.name));
        let Ok(formula) = Formula::parse(&own.formula) else { continue };
        let mut scaled = Vec::new();
        let mut plain = Vec::new();
        for name in &formula.channels {
            let Some(i) = all.iter().position(|channel| channel.name == *name) else { continue };
            let unit = &all[i].unit;
            plain.push(first[i]);
            scaled.push(by.in_unit(first[i], unit).ok_or_else(|| unscaled("channel", name, unit))?);
        }
        if plain.len() < formula.channels.len() {
            continue;
        }
        let expected = by.in_unit(formula.of(|i| plain[i]), &own.unit);
        let expected = expected.ok_or_else(|| unscaled("derived channel", &own.name, &own.unit))?;
        let found: f64 = formula.of(|i| scaled[i]);
        if (found - expected).abs() > 1e-9 * (found.abs() + expected.abs()) {
            let found =
                format!("`{}` in `{}`, which do not scale alike", foreign(&own.formula), foreign(&own.unit));
            let expected = "a formula whose unit follows from those of its channels";
            return Err(Invalid::new(
                thing(),
                found,
                expected,
                "correct the unit, or log the channel itself",
            ));
        }
    }
    Ok(())
}
