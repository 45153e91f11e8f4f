//! What of a vessel is beyond a rudder's angles, a ship's speeds and her length.

use refusal::{Invalid, foreign};

use crate::model::{Unusual, Vessel, VesselFile};

/// The greatest angle of a rudder \[°\].
const HARD_OVER_DEG: f64 = 90.0;
/// Names of rudders among inputs, where nothing else says what they are.
const RUDDERS: [&str; 4] = ["rudder", "helm", "delta", "δ"];
/// By how much of it a stated length may differ from the ship's.
const ROUNDING: f64 = 0.01;

impl VesselFile {
    /// The same file, which accepts what is unusual of ships if that is all that it is refused for; and what that is.
    ///
    /// # Errors
    /// What [`Vessel::from_file`] refuses besides.
    pub fn accepting_unusual(self) -> Result<(Self, Option<Invalid>), Invalid> {
        let Err(unusual) = Vessel::from_file(self.clone()) else { return Ok((self, None)) };
        let accepting = Self { unusual: Some(Unusual::Accepted), ..self };
        Vessel::from_file(accepting.clone())?;
        Ok((accepting, Some(unusual)))
    }
}

impl Vessel {
    /// The greatest angle of input `i` in its unit, if it is a rudder.
    fn hard_over(&self, i: usize) -> Option<f64> {
        let input = &self.model.input_variables()[i];
        let most = match input.unit.as_str() {
            "rad" => HARD_OVER_DEG.to_radians(),
            "deg" | "°" => HARD_OVER_DEG,
            _ => return None,
        };
        let forces = self.model.forces.as_ref().map(|own| (&own.forces, own.forces.description()));
        let drives = |(own, parts): &(&crate::forces::Forces, &crate::forces::Description)| {
            (0..parts.rudder.len()).any(|k| own.rudder_input(k).0.channel == i)
        };
        let turns = |(own, parts): &(&crate::forces::Forces, &crate::forces::Description)| {
            (0..parts.thruster.len())
                .any(|k| own.thruster_inputs(k).1.is_some_and(|angle| angle.channel == i))
        };
        let name = input.name.to_lowercase();
        let is_called = !self.accepts_unusual && RUDDERS.iter().any(|rudder| name.starts_with(rudder));
        let is_one = forces.is_some_and(|own| drives(&own) || (is_called && !turns(&own)));
        (is_one || (forces.is_none() && is_called)).then_some(most * (1.0 + 1e-9))
    }

    /// Refuses a setting in `what` with which a rudder is beyond 90°: it is in degrees, most likely.
    ///
    /// # Errors
    /// Names the input.
    pub fn check_helm(&self, inputs: &[f64], what: impl Fn() -> String) -> Result<(), Invalid> {
        let over = |(i, own): (usize, &f64)| {
            self.hard_over(i).filter(|most| own.abs() > *most).map(|most| (i, *own, most))
        };
        let Some((i, own, most)) = inputs.iter().enumerate().find_map(over) else { return Ok(()) };
        let input = &self.model.input_variables()[i];
        let (name, unit) = (foreign(&input.name), foreign(&input.unit));
        let found = format!("{name} = {own} {unit}");
        let expected = format!("a rudder angle of at most {most:.4} {unit}, {HARD_OVER_DEG}°");
        Err(Invalid::new(what(), found, expected, "give it in the unit of the input: 35° are 0.6109 rad"))
    }

    /// Refuses ranges of rudders beyond 90°.
    pub(crate) fn check_rudders(&self) -> Result<(), Invalid> {
        let ends =
            [0, 1].map(|end| self.actuators.iter().map(move |own| own.range.map_or(0.0, |range| range[end])));
        ends.into_iter().try_for_each(|ends| {
            self.check_helm(&ends.collect::<Vec<_>>(), || "`range` of an input".to_owned())
        })
    }

    /// Refuses a speed in `what` that is unusual of such a ship, unless her file accepts that.
    ///
    /// # Errors
    /// Names the speed.
    pub fn check_speed(&self, speed_m_s: f64, what: impl Fn() -> String) -> Result<(), Invalid> {
        let Some(own) = self.model.forces.as_ref().filter(|_| !self.accepts_unusual) else { return Ok(()) };
        let (froude, most) = own.forces.usual_speed();
        if speed_m_s.abs() <= most {
            return Ok(());
        }
        let expected =
            format!("at most {most:.4} m/s, a Froude number of {froude:.2} for a hull as full as this");
        let remedy = "give m/s at this ship's length: 1 kn is 0.514 m/s; or write `unusual = \"accepted\"` in the vessel's file";
        Err(Invalid::new(what(), format!("{speed_m_s} m/s"), expected, remedy))
    }

    /// Refuses a length in `what` that is not that of the ship's file, where that has one.
    ///
    /// # Errors
    /// Names both.
    pub fn check_length(&self, length_m: f64, what: &str, most: Option<f64>) -> Result<(), Invalid> {
        let Some(own) = self.model.forces.as_ref().map(|own| own.forces.description().ship.length_m) else {
            return Ok(());
        };
        if (length_m / own - 1.0).abs() <= most.unwrap_or(ROUNDING) {
            return Ok(());
        }
        let expected = format!("{own} m, as `length_m` of [ship] in the vessel's file");
        Err(Invalid::new(
            what,
            format!("{length_m} m"),
            expected,
            "give the length of this ship, or correct her file",
        ))
    }
}
