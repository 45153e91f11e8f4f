//! Solving designs.

use design::{Candidates, Options, solve};
use maneuver::{DictionaryFile, Generator, Kept, ManeuverKind, ManeuverSpec, Shape};
use serde_json::{Value, json};
use ship::model::Source;

use crate::paper::Paper;
use crate::timing::fastest;

/// Time of one solve from equal shares.
pub fn measure(candidates: &Candidates, tolerance: f64, repetitions: usize) -> anyhow::Result<Value> {
    let options = Options { tolerance, random_starts: 0, ..Options::default() };
    let (seconds, design) = fastest(repetitions, || Ok(solve(candidates, &options)?))?;
    let relative_gap = design.gap / candidates.dimension() as f64;
    Ok(json!({"candidates": candidates.len(), "seconds": seconds, "relative_gap": relative_gap}))
}

/// Moments of `count` zig-zags and spirals of different speeds, amplitudes and periods.
pub fn generated(paper: &Paper, count: usize) -> anyhow::Result<Candidates> {
    let fraction = |i: usize, step: f64| (i as f64 * step).fract();
    let maneuver = |i: usize| {
        let speed_m_s = 0.2 + fraction(i, 0.754_877_666_246_693) * 0.95;
        let yaw_rate = 0.05 + fraction(i, 0.569_840_290_998_053) * 0.45;
        let kind = if i.is_multiple_of(3) {
            ManeuverKind::Spiral {
                speed_m_s,
                yaw_rate_from_rad_s: 0.0,
                yaw_rate_to_rad_s: -yaw_rate,
                sway_speed_m_s: Some(0.2 * fraction(i, 0.381_966_011_250_105)),
            }
        } else {
            ManeuverKind::ZigZag {
                shape: if i % 3 == 1 { Shape::Sine } else { Shape::Square },
                speed_m_s,
                yaw_rate_amplitude_rad_s: Some(yaw_rate),
                heading_amplitude_rad: None,
                sway_amplitude_m_s: None,
                period_s: 4.0 + fraction(i, 0.618_033_988_749_895) * 26.0,
            }
        };
        ManeuverSpec {
            name: format!("m{i}"),
            description: String::new(),
            duration_s: None,
            keeps: Kept::default(),
            executed: maneuver::Executed::Inputs,
            feedback: None,
            approach: None,
            kind,
        }
    };
    let dictionary = DictionaryFile {
        duration_s: Some(12.5),
        inputs_from: Source::Value,
        maneuvers: (0..count).map(maneuver).collect(),
        tolerance: maneuver::Tolerance::default(),
        generate: None,
        limits: maneuver::StatedLimits::default(),
    };
    paper.candidates_of(&Generator::without_tables(&paper.vessel, &dictionary)?)
}
