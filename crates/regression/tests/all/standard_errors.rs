//! Standard errors against the spread of estimates over many realizations.

use numerics::{LANES, Lane};
use regression::{Estimate, MeanRemoval, Outcome};
use ship::engine::{Weather, simulate};
use ship::model::{Source, Vessel};

use crate::support::noise::Normals;
use crate::support::{Experiment, Recording, SideBySide, dictionary, estimate, paper, truth};

/// Enough to estimate the spread to 1.6 %.
const REALIZATIONS: usize = 2000;
/// Of the current's components [m/s] and of the measured states [m/s, m/s, rad/s]: the paper's variance 0.025.
const NOISE: f64 = 0.158_113_883_008_418_97;
/// The paper's optimized experiment: maneuver of the dictionary, samples. 1000 samples together.
const OPTIMIZED: [(usize, usize); 6] = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];

/// [`LANES`] realizations with a current and measurement noise of their own.
fn realizations(vessel: &Vessel, experiment: &Experiment, normals: &mut Normals) -> Vec<Recording> {
    let samples = experiment.inputs.len() / 3;
    let mut draw = |std: f64| Lane(std::array::from_fn(|_| std * normals.next()));
    let current: Vec<Lane> = (0..2 * samples).map(|_| draw(NOISE)).collect();
    let parameters: Vec<Lane> = truth(vessel).into_iter().map(Lane::splat).collect();
    let exogenous: Vec<Lane> = experiment.inputs.iter().map(|x| Lane::splat(*x)).collect();
    let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
    simulate(
        &vessel.model,
        &parameters,
        experiment.initial.map(Lane::splat),
        &exogenous,
        &Weather { current: &current, ..Weather::CALM },
        &mut states,
    );
    states.iter_mut().for_each(|s| *s += draw(NOISE));
    let record = |lane: usize| Recording {
        measured: states.iter().map(|s| s[lane]).collect(),
        instrument_states: experiment.states(vessel, Source::Nominal),
        exogenous: experiment.inputs.clone(),
        segments: experiment.segments.clone(),
    };
    (0..LANES).map(record).collect()
}

fn estimates(vessel: &Vessel, experiment: &Experiment, normals: &mut Normals) -> Vec<Estimate> {
    let runs = realizations(vessel, experiment, normals);
    let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
    let identified = |outcome: Outcome| match outcome {
        Outcome::Identified(estimate) => estimate,
        other => panic!("{other:?}"),
    };
    let all = estimate(&side_by_side.batch(&vessel.model), MeanRemoval::Complete);
    all.into_iter().map(identified).collect()
}

#[test]
fn law_standard_errors_predict_the_spread_of_estimates() {
    let (vessel, mut normals) = (paper(), Normals::new(2024));
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &OPTIMIZED);
    let all: Vec<Estimate> =
        (0..REALIZATIONS / LANES).flat_map(|_| estimates(&vessel, &experiment, &mut normals)).collect();
    for (i, name) in vessel.model.parameter_names().enumerate() {
        let values = all.iter().map(|e| e.parameters[i]);
        let mean = values.clone().sum::<f64>() / all.len() as f64;
        let variance = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (all.len() - 1) as f64;
        let mut errors: Vec<f64> = all.iter().map(|e| e.standard_errors[i]).collect();
        errors.sort_by(f64::total_cmp);
        let ratio = errors[errors.len() / 2] / variance.sqrt();
        println!("{name}: median standard error over spread {ratio:.3}");
        assert!((ratio - 1.0).abs() < 0.15, "{name}: median standard error over spread {ratio}");
    }
}
