//! Lags and dead times of thrusters, which delay what is commanded.

use crate::forces::{Body, Real};

/// The shortest time constant \[s\]: a shorter one is none.
const SHORTEST_S: f64 = 1e-9;

impl<X: Real> Body<'_, X> {
    /// What acts in every sample where thrusters follow their inputs with dead time and lag: rows as `inputs`, which have
    /// `width` entries each, `sample_s` apart and linear between. Before the first row the inputs were as in it. Tangents of the inputs themselves are not followed.
    pub fn acting<E: Copy + Into<X>>(&self, inputs: &[E], width: usize, sample_s: f64) -> Vec<X> {
        let mut rows: Vec<X> = inputs.iter().map(|input| (*input).into()).collect();
        for thruster in &self.forces.thrusters {
            let Some([lag, dead]) = thruster.delay else { continue };
            let (lag, dead) = (lag.of(&self.numbers), dead.of(&self.numbers));
            let channel = thruster.input();
            let commanded: Vec<X> = inputs.chunks_exact(width).map(|row| row[channel].into()).collect();
            let followed = late(&commanded, dead, lag, sample_s);
            rows.chunks_exact_mut(width).zip(followed).for_each(|(row, own)| row[channel] = own);
        }
        rows
    }
}

/// What follows `commanded`, linear between samples `sample_s` apart, after `dead` seconds and with a time constant of `lag`
/// seconds. Before the first sample it was as in that.
pub fn late<X: Real>(commanded: &[X], dead: X, lag: X, sample_s: f64) -> Vec<X> {
    let begun: Vec<X> = (0..commanded.len()).map(|k| before(commanded, k, dead, sample_s)).collect();
    lagging(&begun, lag, sample_s)
}

/// The input `dead` seconds before sample `k`, linear between samples.
fn before<X: Real>(all: &[X], k: usize, dead: X, sample_s: f64) -> X {
    let samples = dead.times(1.0 / sample_s);
    let whole = X::of(|place| samples.at(place).max(0.0).floor());
    let at = |more: f64| X::of(|place| all[k - (whole.at(place) + more).min(k as f64) as usize].at(place));
    let (near, far) = (at(0.0), at(1.0));
    near + (samples - whole) * (far - near)
}

/// What follows `all`, linear between samples, with a time constant of `lag` seconds: the exact solution.
fn lagging<X: Real>(all: &[X], lag: X, sample_s: f64) -> Vec<X> {
    let lag = (lag - X::from(SHORTEST_S)).if_positive(lag, X::from(SHORTEST_S));
    let left = X::from(-sample_s).over(lag).exponential();
    let mut out: Vec<X> = all.iter().take(1).copied().collect();
    for ends in all.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        // Behind an input that changes steadily by as much as it changes in a time constant.
        let behind = (to - from).times(1.0 / sample_s) * lag;
        let start = out.last().copied().unwrap_or(X::ZERO);
        out.push(to - behind + left * (start - from + behind));
    }
    out
}
