//! The covariance predicted from stated disturbances against the spread of estimates, and against its definition.

use numerics::{LANES, Lane};
use regression::{Estimate, MeanRemoval, Noise, Outcome, meat, moments};
use ship::engine::{Weather, simulate};
use ship::model::{Source, Vessel};

use crate::support::noise::Normals;
use crate::support::{Experiment, Recording, SideBySide, dictionary, estimate, paper, truth};

const REALIZATIONS: usize = 2000;
/// Of the current's components [m/s] and of the measured states [m/s, m/s, rad/s]: the paper's variance 0.025.
const NOISE: f64 = 0.158_113_883_008_418_97;
/// Experiments of the paper's dictionary: maneuver, samples; 1000 samples together. The first is the paper's design.
const EXPERIMENTS: [&[(usize, usize)]; 3] = [
    &[(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)],
    &[(0, 198), (1, 38), (4, 63), (6, 195), (8, 231), (10, 275)],
    &[(0, 250), (5, 250), (7, 250), (10, 250)],
];

fn undisturbed(vessel: &Vessel, experiment: &Experiment) -> Recording {
    Recording {
        measured: experiment.states(vessel, Source::Value),
        instrument_states: experiment.states(vessel, Source::Nominal),
        exogenous: experiment.inputs.clone(),
        segments: experiment.segments.clone(),
    }
}

/// √diag(A⁻¹BA⁻ᵀ/N) of an undisturbed experiment, without intercepts.
fn predicted(vessel: &Vessel, experiment: &Experiment, noise: &Noise) -> Vec<f64> {
    let recording = undisturbed(vessel, experiment);
    let side = SideBySide::new(&[&recording]);
    let batch = side.batch(&vessel.model);
    let (found, meats) = (moments(&batch), meat(&batch, &truth(vessel), noise));
    let mut errors = Vec::new();
    for (m, b) in found[0].matrices.iter().zip(&meats[0]) {
        let n = m.len().isqrt();
        let mut inverse = vec![0.0; n * n];
        // M is Aᵀ: row i of A⁻¹ is column i of M⁻¹.
        numerics::inverse(n, &mut m.clone(), &mut inverse).unwrap();
        for i in 0..n - 1 {
            let row: Vec<f64> = (0..n).map(|j| inverse[j * n + i]).collect();
            let variance: f64 = (0..n * n).map(|k| row[k / n] * b[k] * row[k % n]).sum();
            errors.push((variance / found[0].samples as f64).sqrt());
        }
    }
    errors
}

fn estimates(vessel: &Vessel, experiment: &Experiment, normals: &mut Normals) -> Vec<Estimate> {
    let samples = experiment.inputs.len() / 3;
    let mut draw = || Lane(std::array::from_fn(|_| NOISE * normals.next()));
    let current: Vec<Lane> = (0..2 * samples).map(|_| draw()).collect();
    let parameters: Vec<Lane> = truth(vessel).into_iter().map(Lane::splat).collect();
    let exogenous: Vec<Lane> = experiment.inputs.iter().map(|x| Lane::splat(*x)).collect();
    let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
    let initial = experiment.initial.map(Lane::splat);
    let weather = Weather { current: &current, ..Weather::CALM };
    simulate(&vessel.model, &parameters, initial, &exogenous, &weather, &mut states);
    states.iter_mut().for_each(|s| *s += draw());
    let record = |lane: usize| Recording {
        measured: states.iter().map(|s| s[lane]).collect(),
        ..undisturbed(vessel, experiment)
    };
    let runs: Vec<Recording> = (0..LANES).map(record).collect();
    let side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
    let identified = |outcome: Outcome| match outcome {
        Outcome::Identified(estimate) => estimate,
        other => panic!("{other:?}"),
    };
    estimate(&side.batch(&vessel.model), MeanRemoval::Complete).into_iter().map(identified).collect()
}

/// Both the half-width of the central 68 % and the standard deviation.
#[test]
fn law_predicted_errors_are_the_spread_of_estimates() {
    let (vessel, mut normals) = (paper(), Normals::new(7));
    let noise = Noise { measurement: [NOISE; 3], current: NOISE };
    for plan in EXPERIMENTS {
        let experiment = Experiment::of_maneuvers(&dictionary(&vessel), plan);
        let errors = predicted(&vessel, &experiment, &noise);
        let all: Vec<Estimate> =
            (0..REALIZATIONS / LANES).flat_map(|_| estimates(&vessel, &experiment, &mut normals)).collect();
        for (i, name) in vessel.model.parameter_names().enumerate() {
            let mut values: Vec<f64> = all.iter().map(|e| e.parameters[i]).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values[(share * values.len() as f64) as usize];
            let spread = 0.5 * (at(0.8413) - at(0.1587));
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let deviation =
                values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
            let (ratio, of_deviation) = (errors[i] / spread, errors[i] / deviation.sqrt());
            println!(
                "{plan:?} {name}: predicted over spread {ratio:.3}, over standard deviation {of_deviation:.3}"
            );
            for ratio in [ratio, of_deviation] {
                assert!((ratio - 1.0).abs() < 0.15, "{plan:?} {name}: predicted over spread {ratio}");
            }
        }
    }
}

/// Without slopes the residual is e(k+1) − e(k): B by its covariance matrix, 2 on the diagonal and −1 next to it.
#[test]
fn law_of_a_model_without_states_the_residual_is_a_difference_of_errors() {
    let (vessel, mut normals) = (paper(), Normals::new(3));
    let experiment = Experiment::random(&mut normals, &[40]);
    let recording = undisturbed(&vessel, &experiment);
    let side = SideBySide::new(&[&recording]);
    let batch = side.batch(&vessel.model);
    let noise = Noise { measurement: [0.3, 0.2, 0.1], current: 0.5 };
    let found = meat(&batch, &vec![0.0; vessel.model.parameters()], &noise);
    let n = recording.samples();
    let width = vessel.model.exogenous();
    for (d, degree) in vessel.model.degrees.iter().enumerate() {
        let zeta = |k: usize| -> Vec<f64> {
            let states = recording.instrument_states[3 * k..3 * k + 3].iter();
            let all = states.chain(&recording.exogenous[width * k..width * (k + 1)]);
            let values: Vec<[f64; 1]> = all.map(|value| [*value]).collect();
            let mut term = |term: &ship::model::Term| {
                let mut out = [0.0];
                term.values(&values, &mut out);
                out[0]
            };
            degree.terms.iter().map(&mut term).chain([1.0]).collect()
        };
        let p = degree.terms.len() + 1;
        assert_eq!(found[0][d].len(), p * p);
        for (e, found) in found[0][d].iter().enumerate() {
            let pair = |k: usize, l: usize| zeta(k)[e / p] * zeta(l)[e % p];
            let own: f64 = (0..n).map(|k| 2.0 * pair(k, k)).sum();
            let neighbours: f64 = (1..n).map(|k| pair(k, k - 1) + pair(k - 1, k)).sum();
            let expected = noise.measurement[d].powi(2) * (own - neighbours) / n as f64;
            let size = noise.measurement[d].powi(2) * own.abs() / n as f64;
            assert!((found - expected).abs() < 1e-10 * size.max(1e-12), "{d} {e}");
        }
    }
}
