use serde::Deserialize;

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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
/// \[rad\], `dt` seconds apart: three channels of M values, the last of each NaN, as is what touches a missing sample.
pub fn euler(x: &[f64], y: &[f64], psi: &[f64], dt: f64) -> [Vec<f64>; 3] {
    let mut out = [const { Vec::new() }; 3];
    for k in 0..psi.len() {
        let difference = |p: &[f64]| p.get(k + 1).map_or(f64::NAN, |next| (next - p[k]) / dt);
        let [u, v] = body_velocity([difference(x), difference(y)], psi[k]);
        for (channel, value) in out.iter_mut().zip([u, v, difference(psi)]) {
            channel.push(value);
        }
    }
    out
}
