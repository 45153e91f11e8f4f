//! Logs, and chains of instruments that make them.

mod actuator;
mod allocation;
mod angles;
mod aside;
mod assembled;
mod by_motion;
mod chain;
mod clocks;
mod declared;
mod frames;
mod gate;
mod grid;
mod guess;
mod guess_bags;
mod lever;
mod motion;
mod oracle;
mod oracle_chain;
mod patterns;
mod positions;
mod prepared;
mod quality;
mod sensors;
mod series;
mod smoother;
mod thrusters;
mod units;
mod weather;
mod wind;

/// [`logs::local_quadratic`] of all samples.
fn parabolas(t: &[f64], values: &[f64], window: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut smooth, mut slope) = (Vec::new(), Vec::new());
    logs::local_quadratic(&t.into(), &values.into(), 0..t.len(), window, |value, rate| {
        smooth.push(value);
        slope.push(rate);
    });
    (smooth, slope)
}
