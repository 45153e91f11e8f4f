use serde::Deserialize;
use vessel::Invalid;

use super::{check, check_positive};
use crate::{Law, Setting, Thruster};

/// An azimuth thruster with its limits and its sensors. Axes: x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Forward and to starboard of the reference point \[m\].
    pub position_m: [f64; 2],
    /// Force per speed squared \[N s²\], or per speed \[N s\].
    pub coefficient: f64,
    /// Force from speed.
    #[serde(default)]
    pub law: Law,
    /// Highest speed, ahead or reversed \[1/s\].
    pub speed_limit_rps: Option<f64>,
    /// Fastest change of speed \[1/s²\].
    pub speed_rate_limit_rps_s: Option<f64>,
    /// Fastest turn \[rad/s\].
    pub angle_rate_limit_rad_s: Option<f64>,
    /// White noise of the logged speed \[1/s\].
    #[serde(default)]
    pub speed_std_rps: f64,
    /// Step of the logged speed \[1/s\]; 0: none.
    #[serde(default)]
    pub speed_resolution_rps: f64,
    /// White noise of the logged angle \[rad\].
    #[serde(default)]
    pub angle_std_rad: f64,
    /// Step of the logged angle \[rad\]; 0: none.
    #[serde(default)]
    pub angle_resolution_rad: f64,
}

/// Samples at which a thruster could not follow its command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hits {
    /// The speed is beyond its limit.
    pub speed: usize,
    /// The speed changes too fast.
    pub speed_rate: usize,
    /// The angle changes too fast.
    pub angle_rate: usize,
}

impl Actuator {
    /// The thruster without limits.
    pub fn thruster(&self) -> Thruster {
        Thruster { law: self.law, coefficient: self.coefficient, position_m: self.position_m }
    }

    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let given = |limit: Option<f64>| limit.unwrap_or(1.0);
        check_positive(&[
            ("thruster.coefficient", self.coefficient),
            ("thruster.speed_limit_rps", given(self.speed_limit_rps)),
            ("thruster.speed_rate_limit_rps_s", given(self.speed_rate_limit_rps_s)),
            ("thruster.angle_rate_limit_rad_s", given(self.angle_rate_limit_rad_s)),
        ])?;
        let numbers = [
            ("thruster.speed_std_rps", self.speed_std_rps),
            ("thruster.speed_resolution_rps", self.speed_resolution_rps),
            ("thruster.angle_std_rad", self.angle_std_rad),
            ("thruster.angle_resolution_rad", self.angle_resolution_rad),
        ];
        check(0.0, &numbers)?;
        check(f64::MIN, &self.position_m.map(|metres| ("thruster.position_m", metres)))
    }

    /// Where it can be, `dt` seconds after `from` (none: at the start, where it has had time), when `wanted` is commanded.
    pub fn follow(&self, from: Option<Setting>, wanted: Setting, dt: f64, hits: &mut Hits) -> Setting {
        let n = within(0.0, wanted.n, self.speed_limit_rps, &mut hits.speed);
        let Some(from) = from else { return Setting { n, ..wanted } };
        let step = |rate: Option<f64>| rate.map(|rate| rate * dt);
        Setting {
            n: within(from.n, n, step(self.speed_rate_limit_rps_s), &mut hits.speed_rate),
            alpha: within(from.alpha, wanted.alpha, step(self.angle_rate_limit_rad_s), &mut hits.angle_rate),
        }
    }
}

/// `wanted`, or as near to it as `most` from `centre` allows: then counts a hit.
fn within(centre: f64, wanted: f64, most: Option<f64>, hits: &mut usize) -> f64 {
    match most.filter(|most| (wanted - centre).abs() > most * (1.0 + 1e-12)) {
        Some(most) => {
            *hits += 1;
            centre + most.copysign(wanted - centre)
        }
        None => wanted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACTUATOR: Actuator = Actuator {
        position_m: [-0.4, 0.1],
        coefficient: 2.0,
        law: Law::Quadratic,
        speed_limit_rps: Some(10.0),
        speed_rate_limit_rps_s: Some(4.0),
        angle_rate_limit_rad_s: Some(0.5),
        speed_std_rps: 0.0,
        speed_resolution_rps: 0.0,
        angle_std_rad: 0.0,
        angle_resolution_rad: 0.0,
    };

    #[test]
    fn a_thruster_gets_there_in_steps_and_says_so() {
        let (mut hits, mut at) = (Hits::default(), Some(Setting::default()));
        let wanted = Setting { n: -12.0, alpha: 0.3 };
        let mut speeds = Vec::new();
        for _ in 0..6 {
            at = Some(ACTUATOR.follow(at, wanted, 0.5, &mut hits));
            speeds.push(at.unwrap().n);
        }
        assert_eq!(speeds, [-2.0, -4.0, -6.0, -8.0, -10.0, -10.0]);
        assert_eq!(at.unwrap().alpha, 0.3);
        assert_eq!(hits, Hits { speed: 6, speed_rate: 4, angle_rate: 1 });
    }

    #[test]
    fn at_the_start_it_is_where_it_is_wanted() {
        let mut hits = Hits::default();
        let found = ACTUATOR.follow(None, Setting { n: 9.0, alpha: 3.0 }, 0.1, &mut hits);
        assert_eq!((found, hits), (Setting { n: 9.0, alpha: 3.0 }, Hits::default()));
    }

    #[test]
    fn numbers_without_meaning_are_refused() {
        assert!(ACTUATOR.check().is_ok());
        let refused = Actuator { speed_limit_rps: Some(0.0), ..ACTUATOR }.check().unwrap_err();
        assert_eq!(refused.thing, "`thruster.speed_limit_rps`");
        let refused = Actuator { angle_std_rad: -1.0, ..ACTUATOR }.check().unwrap_err();
        assert_eq!(refused.thing, "`thruster.angle_std_rad`");
    }
}
