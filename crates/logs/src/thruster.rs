use std::f64::consts::{FRAC_PI_2, PI, TAU};

use serde::Deserialize;

use crate::Setting;

/// A thruster's force from its speed n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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
    /// Where it is, from the reference point: forward and to starboard \[m\].
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
        let (sin, cos) = alpha.sin_cos();
        let (forward, starboard) = (force * cos, force * sin);
        let [x, y] = self.position_m;
        [forward, starboard, x * starboard - y * forward]
    }

    /// The setting that pushes with `force` (forward, to starboard) \[N\]: of the two, ahead and reversed, the one whose
    /// direction is nearer to `alpha` \[rad\], and within a quarter turn of it. Without force `alpha` stays.
    pub fn setting(&self, [forward, starboard]: [f64; 2], alpha: f64) -> Setting {
        let force = forward.hypot(starboard);
        if force == 0.0 {
            return Setting { n: 0.0, alpha };
        }
        let turn = (starboard.atan2(forward) - alpha + PI).rem_euclid(TAU) - PI;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const AFT_STARBOARD: Thruster =
        Thruster { law: Law::Quadratic, coefficient: 2.0, position_m: [-0.4, 0.1] };

    #[test]
    fn a_thruster_on_the_starboard_side_that_pushes_forward_turns_the_bow_to_port() {
        let [forward, starboard, moment] = AFT_STARBOARD.forces(3.0, 0.0);
        assert_eq!((forward, starboard), (18.0, 0.0));
        approx::assert_abs_diff_eq!(moment, -1.8, epsilon = 1e-15);
    }

    #[test]
    fn a_stern_that_is_pushed_to_starboard_turns_the_bow_to_port() {
        let moment = AFT_STARBOARD.forces(3.0, FRAC_PI_2)[2];
        approx::assert_abs_diff_eq!(moment, -0.4 * 18.0, epsilon = 1e-14);
    }

    #[test]
    fn law_reversing_reverses_the_force() {
        for law in [Law::Quadratic, Law::Linear] {
            let thruster = Thruster { law, ..AFT_STARBOARD };
            assert_eq!(thruster.forces(-3.0, 0.7), thruster.forces(3.0, 0.7).map(|f| -f));
        }
    }
}
