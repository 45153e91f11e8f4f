use refusal::Invalid;
use ship::model::Vessel;

use super::spec::{Settings, Standard, steps};
use crate::signal::LONGEST_S;

/// The most steps of a spiral to one side.
const MOST_STEPS: u32 = 1000;

impl Standard<'_> {
    /// Its numbers with their keys.
    pub(crate) fn numbers(&self) -> Vec<(&'static str, f64)> {
        let speed = ("speed_m_s", self.speed_m_s());
        match self {
            Self::ZigZagTest(own) => vec![speed, ("heading_rad", own.heading_rad)],
            Self::TurningCircle(own) => vec![speed, ("turn_rad", own.turn_rad)],
            Self::ReverseSpiral(own) => vec![speed, ("yaw_rate_rad_s", own.yaw_rate_rad_s)],
            Self::PullOut(_) | Self::SpiralTest(_) | Self::Stop(_) => vec![speed],
        }
    }

    /// Refuses what cannot be carried out by any ship; `name` is the maneuver's.
    pub(crate) fn check(&self, name: &str, duration_s: Option<f64>) -> Result<(), Invalid> {
        let refuse = |key: &str, found: String, expected: &str| {
            Err(Invalid::new(format!("maneuver `{name}`, `{key}`"), found, expected, "correct it"))
        };
        let seconds = |key: &'static str, value: f64, zero: bool| match value {
            _ if (zero && value == 0.0) || (value > 0.0 && value <= LONGEST_S) => Ok(()),
            _ => refuse(key, value.to_string(), &format!("more than 0 s, at most {LONGEST_S:e} s")),
        };
        let above = |key: &'static str, value: f64, most: f64, unit: &str| match value {
            _ if value > 0.0 && value <= most => Ok(()),
            _ => refuse(key, value.to_string(), &format!("more than 0, at most {most} {unit}")),
        };
        let (key, settings) = self.settings();
        if let Some((input, found)) = settings.iter().find(|(_, value)| !value.is_finite()) {
            return refuse(&format!("{key}.{input}"), found.to_string(), "a finite number");
        }
        if !matches!(self, Self::Stop(_)) && settings.values().all(|value| *value == 0.0) {
            return refuse(
                key,
                "none".to_owned(),
                "changes of inputs that turn the ship to starboard, such as { rudder = 0.35 }",
            );
        }
        above("speed_m_s", self.speed_m_s(), 100.0, "m/s")?;
        match self {
            Self::ZigZagTest(own) => {
                above("heading_rad", own.heading_rad, std::f64::consts::PI, "rad")?;
                seconds("hold_s", own.hold_s, true)?;
                seconds("delay_s", own.delay_s, true)?;
                own.every_s.map_or(Ok(()), |every| seconds("every_s", every, false))
            }
            Self::TurningCircle(own) => {
                above("turn_rad", own.turn_rad, 100.0, "rad")?;
                seconds("hold_s", own.hold_s, true)
            }
            Self::PullOut(own) => {
                seconds("hold_s", own.hold_s, true)?;
                seconds("turn_s", own.turn_s, false)?;
                enough(name, own.hold_s + own.turn_s, duration_s)
            }
            Self::SpiralTest(own) => {
                spiral(name, own.steps, own.dwell_s)?;
                enough(name, own.dwell_s * steps(own.steps, true).count() as f64, duration_s)
            }
            Self::ReverseSpiral(own) => {
                above("yaw_rate_rad_s", own.yaw_rate_rad_s, 10.0, "rad/s")?;
                spiral(name, own.steps, own.dwell_s)?;
                enough(name, own.dwell_s * steps(own.steps, false).count() as f64, duration_s)
            }
            Self::Stop(own) => seconds("hold_s", own.hold_s, true),
        }
    }

    /// Refuses names that are no inputs of `vessel`, and followers of others.
    pub(crate) fn check_inputs(&self, name: &str, vessel: &Vessel) -> Result<(), Invalid> {
        let (key, settings) = self.settings();
        check_names(name, key, settings, vessel)
    }
}

/// Refuses names in `key` of maneuver `name` that are no inputs of `vessel`, and followers of others.
pub(crate) fn check_names(
    name: &str,
    key: &str,
    settings: &Settings,
    vessel: &Vessel,
) -> Result<(), Invalid> {
    let inputs = vessel.model.input_variables();
    let free = |i: &usize| vessel.couplings[*i].is_none();
    for input in settings.keys() {
        let place = inputs.iter().position(|own| own.name == *input);
        if place.filter(free).is_none() {
            let known: Vec<String> =
                (0..inputs.len()).filter(free).map(|i| format!("`{}`", inputs[i].name)).collect();
            let found = if place.is_some() { "an input that follows another" } else { "no input" };
            return Err(Invalid::new(
                format!("maneuver `{name}`, `{key}.{input}`"),
                found,
                format!("one of {} of the vessel", known.join(", ")),
                "correct the name",
            ));
        }
    }
    Ok(())
}

fn spiral(name: &str, steps: u32, dwell_s: f64) -> Result<(), Invalid> {
    let refuse = |key: &str, found: String, expected: String| {
        Err(Invalid::new(format!("maneuver `{name}`, `{key}`"), found, expected, "correct it"))
    };
    if !(1..=MOST_STEPS).contains(&steps) {
        return refuse("steps", steps.to_string(), format!("1 to {MOST_STEPS}"));
    }
    if !(dwell_s > 0.0 && dwell_s <= LONGEST_S) {
        return refuse("dwell_s", dwell_s.to_string(), format!("more than 0 s, at most {LONGEST_S:e} s"));
    }
    Ok(())
}

/// Refuses a maneuver of `needed` seconds in a shorter `duration_s`.
fn enough(name: &str, needed: f64, duration_s: Option<f64>) -> Result<(), Invalid> {
    match duration_s {
        Some(seconds) if needed > seconds * (1.0 + 1e-9) => Err(Invalid::new(
            format!("maneuver `{name}`, `duration_s`"),
            format!("{seconds} s"),
            format!("at least {needed} s for all of its steps"),
            "lengthen it",
        )),
        _ => Ok(()),
    }
}
