use schemars::JsonSchema;
use serde::Deserialize;

/// How a zig-zag swings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Between two levels.
    Square,
    /// As a sine.
    #[default]
    Sine,
    /// In straight ramps.
    Triangle,
}

impl Shape {
    /// Value at `phase` (in periods), within −1 and 1, starting upwards.
    pub fn at(self, phase: f64) -> f64 {
        let phase = phase - phase.floor();
        match self {
            Self::Square => {
                if phase < 0.5 {
                    1.0
                } else {
                    -1.0
                }
            }
            Self::Sine => libm::sin(std::f64::consts::TAU * phase),
            Self::Triangle => 1.0 - 4.0 * ((phase + 0.75) % 1.0 - 0.5).abs(),
        }
    }

    /// Amplitude of a signal whose derivative swings like this with amplitude 1 and period 1 s.
    pub(super) fn integral(self) -> f64 {
        match self {
            Self::Square => 0.25,
            Self::Sine => 1.0 / std::f64::consts::TAU,
            Self::Triangle => 0.125,
        }
    }
}
