use std::f64::consts::{FRAC_PI_2, PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The setting of an azimuth thruster: speed n \[1/s\] and direction of its push, from forward to starboard
/// \[rad\], not wrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setting {
    /// Speed; negative when reversed.
    pub n: f64,
    /// Direction.
    pub alpha: f64,
}

/// A thruster's force from its speed n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// c n |n|.
    #[default]
    Quadratic,
    /// c n, as in the paper's static model.
    Linear,
}

/// A thruster: body axes x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thruster {
    /// Force from speed.
    pub law: Law,
    /// c: force per speed, or per speed squared.
    pub coefficient: f64,
    /// Its position relative to the reference point: forward and to starboard \[m\].
    pub position_m: [f64; 2],
}

impl Thruster {
    /// τ1 (forward), τ2 (to starboard), τ3 (moment, bow to starboard) at speed `n`, pushing in direction `alpha` \[rad\],
    /// counted from forward towards starboard. With F = c n|n| (or c n):
    ///
    /// τ1 = F cos α,  τ2 = F sin α,  τ3 = l_x F sin α − l_y F cos α.
    ///
    /// τ3 is the z component of l × F. The paper prints + l_y n cos α; with these axes the sign is minus: a thruster on
    /// the starboard side (l_y > 0) that pushes forward turns the bow to port.
    pub fn forces(&self, n: f64, alpha: f64) -> [f64; 3] {
        let force = match self.law {
            Law::Quadratic => self.coefficient * n * n.abs(),
            Law::Linear => self.coefficient * n,
        };
        let (sin, cos) = libm::sincos(alpha);
        let (forward, starboard) = (force * cos, force * sin);
        let [x, y] = self.position_m;
        [forward, starboard, x * starboard - y * forward]
    }

    /// The setting that pushes with `force` (forward, to starboard) \[N\]: of the two, ahead and reversed,
    /// the one whose direction is nearer to `alpha` \[rad\], within a quarter turn of it. Without force
    /// `alpha` stays.
    pub fn setting(&self, [forward, starboard]: [f64; 2], alpha: f64) -> Setting {
        let force = libm::hypot(forward, starboard);
        if force == 0.0 {
            return Setting { n: 0.0, alpha };
        }
        let turn = (libm::atan2(starboard, forward) - alpha + PI).rem_euclid(TAU) - PI;
        let (sign, turn) = if turn > FRAC_PI_2 {
            (-1.0, turn - PI)
        } else if turn < -FRAC_PI_2 {
            (-1.0, turn + PI)
        } else {
            (1.0, turn)
        };
        let speed = match self.law {
            Law::Quadratic => (force / self.coefficient).sqrt(),
            Law::Linear => force / self.coefficient,
        };
        Setting { n: sign * speed, alpha: alpha + turn }
    }
}
