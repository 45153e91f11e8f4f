use std::f64::consts::PI;

use refusal::{Invalid, check_numbers};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{above_zero, finite, from_zero};

/// Density of air at 15 °C \[kg/m³\].
const AIR: f64 = 1.225;

/// The aerodynamic areas and coefficients of a ship that is symmetric fore and aft. Coefficients as in Fossen
/// (Handbook of Marine Craft Hydrodynamics and Motion Control, 8.1.3): c_x 0.5 to 0.9, c_y 0.7 to 0.95, c_n
/// 0.05 to 0.2.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Frontal projected area \[m²\].
    pub frontal_area_m2: f64,
    /// Lateral projected area \[m²\].
    pub lateral_area_m2: f64,
    /// Length over all \[m\].
    pub length_m: f64,
    /// Coefficient of the longitudinal force \[1\].
    pub c_x: f64,
    /// Coefficient of the lateral force \[1\].
    pub c_y: f64,
    /// Coefficient of the moment \[1\].
    pub c_n: f64,
}

/// Wind: a mean with gusts along it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    /// Mean speed \[m/s\].
    pub speed_m_s: f64,
    /// Direction it comes from, clockwise from north \[rad\].
    pub from_rad: f64,
    /// Standard deviation of the gusts \[m/s\].
    #[serde(default)]
    pub gust_std_m_s: f64,
    /// Their correlation time \[s\].
    pub gust_time_s: Option<f64>,
}

impl Wind {
    /// Velocity of the air, north and east \[m/s\], at speed `speed_m_s`.
    pub fn velocity(&self, speed_m_s: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.from_rad + PI);
        [speed_m_s * cos, speed_m_s * sin]
    }

    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let speeds = [("wind.speed_m_s", self.speed_m_s), ("wind.gust_std_m_s", self.gust_std_m_s)];
        let expected = "from 0 to 100 m/s, which no wind exceeds";
        check_numbers(speeds, expected, |speed| (0.0..=100.0).contains(&speed))?;
        finite([("wind.from_rad", self.from_rad)])?;
        above_zero([("wind.gust_time_s", self.gust_time_s.unwrap_or(1.0))])
    }
}

impl Hull {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        from_zero([
            ("hull.frontal_area_m2", self.frontal_area_m2),
            ("hull.lateral_area_m2", self.lateral_area_m2),
            ("hull.length_m", self.length_m),
            ("hull.c_x", self.c_x),
            ("hull.c_y", self.c_y),
            ("hull.c_n", self.c_n),
        ])
    }

    /// Forward and starboard force \[N\] and moment \[N m\] when the ship moves through the air with `u`, `v`
    /// \[m/s\] (body axes).
    ///
    /// With V² = u² + v² and γ = −atan2(v, u): X = −½ρV² c_x cos γ A_F, Y = ½ρV² c_y sin γ A_L, N = ½ρV² c_n sin 2γ A_L L.
    pub fn forces(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let pressure = 0.5 * AIR * (u * u + v * v);
        let gamma = -libm::atan2(v, u);
        [
            -pressure * self.c_x * libm::cos(gamma) * self.frontal_area_m2,
            pressure * self.c_y * libm::sin(gamma) * self.lateral_area_m2,
            pressure * self.c_n * libm::sin(2.0 * gamma) * self.lateral_area_m2 * self.length_m,
        ]
    }
}
