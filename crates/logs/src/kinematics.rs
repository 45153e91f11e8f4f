use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Explicit Euler differences at the common rate, as in the paper: [`euler`].
    Euler,
    /// Slopes of local parabolas on the channels' own clocks: [`crate::local_quadratic`].
    #[default]
    Smoother,
}

/// Surge and sway \[m/s\] from the rates of north and east \[m/s\] and the heading \[rad\]: R(ψ)ᵀ ṗ.
pub fn body_velocity([north, east]: [f64; 2], psi: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(psi);
    [north * cos + east * sin, east * cos - north * sin]
}

/// u(k), v(k) = R(ψ(k))ᵀ (p(k+1) − p(k))/dt and r(k) = (ψ(k+1) − ψ(k))/dt of M samples of x, y \[m\] and unwrapped ψ
/// \[rad\], `dt` seconds apart: M velocities, the last NaN, as is what touches a missing sample.
pub fn euler(poses: impl Iterator<Item = [f64; 3]>, dt: f64) -> impl Iterator<Item = [f64; 3]> {
    let mut poses = poses.peekable();
    std::iter::from_fn(move || {
        let pose = poses.next()?;
        let next = poses.peek().copied().unwrap_or([f64::NAN; 3]);
        let [north, east, r] = [0, 1, 2].map(|i| (next[i] - pose[i]) / dt);
        let [u, v] = body_velocity([north, east], pose[2]);
        Some([u, v, r])
    })
}
