//! Properties of estimates by simulation and prediction.

use estimation::predictor::{
    Fitted, Flow, ForceNoise, InitialState, NoiseModel, Recordings, RunFit, Sensitivities, Spread, Unknown,
    output_error, prediction_error,
};
use estimation::runs::{AdditionalUnknowns, UnknownCurrent};
use numerics::{LANES, Lane};
use regression::{Batch, MeanRemoval, Outcome, estimate_prefiltered};
use ship::engine::{RunView, Weather, simulate};
use ship::model::{Model, Source, Vessel};

use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};

const NOISE: f64 = 0.158_113_883_008_418_97;

fn experiment(vessel: &Vessel) -> Experiment {
    let plan = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];
    Experiment::of_maneuvers(&dictionary(vessel), &plan)
}

fn splat(values: &[f64]) -> Vec<Lane> {
    values.iter().copied().map(Lane::splat).collect()
}

fn recordings<'a>(model: &'a Model, experiment: &'a Experiment, measured: &'a [Lane]) -> Recordings<'a> {
    Recordings {
        model,
        measured,
        exogenous: splat(&experiment.inputs).leak(),
        initial: experiment.initial.map(Lane::splat),
        samples: [experiment.inputs.len() / 3; LANES],
    }
}

fn converged(fits: Vec<RunFit>) -> Vec<Fitted> {
    let found = |fit: RunFit| match fit {
        RunFit::Converged(found) => found,
        other => panic!("{other:?}"),
    };
    fits.into_iter().map(found).collect()
}

/// Every lane a run of its own.
fn runs<'a>(experiment: &'a Experiment, measured: &[Lane]) -> Vec<RunView<'a>> {
    let one = |lane: usize| {
        let own: Vec<f64> = measured.iter().map(|y| y[lane]).collect();
        RunView {
            measured: own.leak(),
            instrument_exogenous: &experiment.inputs,
            exogenous: &experiment.inputs,
            initial: experiment.initial,
        }
    };
    (0..LANES).map(one).collect()
}

/// From `theta` and no intercepts in every lane.
fn starts(vessel: &Vessel, theta: &[f64]) -> Vec<Vec<Vec<f64>>> {
    vec![vec![vessel.model.layout().with_intercepts().woven(theta, [0.0; 3])]; LANES]
}

/// Output error of every lane, from the nominal model.
fn free_fits(
    vessel: &Vessel,
    experiment: &Experiment,
    measured: &[Lane],
    initial: InitialState,
) -> Vec<RunFit> {
    let runs = runs(experiment, measured);
    let (model, starts) = (vessel.model.with_intercepts(), starts(vessel, &vessel.nominal));
    output_error(&model, &runs, &starts, initial, Spread::Blocks)
}

#[test]
fn law_sensitivities_are_difference_quotients() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = splat(&experiment.states(&vessel, Source::Value));
    let model = vessel.model.with_intercepts();
    let data = recordings(&model, &experiment, &measured);
    let at =
        [model.layout().woven(&truth(&vessel), [0.002, -0.001, 0.003]), vec![0.05, -0.02, 0.01]].concat();
    let free: Vec<usize> = (0..at.len()).collect();
    let found = Sensitivities::of(&data, &splat(&at), &free, true);
    for i in &free {
        let step = 1e-6 * at[*i].abs().max(1e-3);
        let moved = |by: f64| {
            let mut unknowns = at.clone();
            unknowns[*i] += by;
            Sensitivities::of(&data, &splat(&unknowns), &[], true).states
        };
        let (up, down) = (moved(step), moved(-step));
        let quotient: Vec<f64> =
            up.iter().zip(&down).map(|(up, down)| (up[2] - down[2]) / (2.0 * step)).collect();
        let size = quotient.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
        for (k, expected) in quotient.iter().enumerate() {
            let found = found.by(k / 3, *i)[k % 3][2];
            assert!((found - expected).abs() < 1e-6 * size, "unknown {i}, entry {k}: {found}, {expected}");
        }
    }
}

#[test]
fn law_undisturbed_runs_give_the_truth_and_lanes_do_not_touch_each_other() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let truth = truth(&vessel);
    let mut measured = splat(&experiment.states(&vessel, Source::Value));
    let clean = measured.clone();
    let mut normals = Normals::new(4);
    measured.iter_mut().for_each(|y| (1..LANES).for_each(|lane| y[lane] += NOISE * normals.next()));
    let fit = |measured: &[Lane]| converged(free_fits(&vessel, &experiment, measured, InitialState::Known));
    let (alone, among) = (fit(&clean), fit(&measured));
    assert_eq!(alone[0], among[0]);
    for (found, truth) in alone[0].parameters.iter().zip(&truth) {
        approx::assert_relative_eq!(*found, *truth, max_relative = 1e-7);
    }
}

#[test]
fn law_intercepts_take_a_constant_force_and_the_offset_an_unknown_start() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let samples = experiment.inputs.len() / 3;
    let (force, offset) = ([0.002, -0.001, 0.0005], [0.1, 0.02, -0.03]);
    let forces: Vec<Lane> = (0..samples).flat_map(|_| force.map(Lane::splat)).collect();
    let start = [0, 1, 2].map(|d: usize| Lane::splat(experiment.initial[d] + offset[d]));
    let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
    let weather = Weather { current: &[], turning: 0.0, force: &forces };
    let parameters = splat(&truth(&vessel));
    simulate(&vessel.model, &parameters, start, &experiment.inputs, &weather, &mut measured);
    let found = converged(free_fits(&vessel, &experiment, &measured, InitialState::Estimated));
    for d in 0..3 {
        approx::assert_relative_eq!(found[1].intercepts[d], force[d], max_relative = 1e-5);
        approx::assert_relative_eq!(found[1].offset[d], offset[d], max_relative = 1e-5);
    }
}

/// A current that is constant over ground while the vessel turns in it: two unknowns take it, and the parameters are
/// the true ones; no intercept does that.
#[test]
fn law_a_constant_current_is_found_with_the_parameters() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let (samples, water) = (experiment.inputs.len() / 3, [0.05, -0.03]);
    let currents: Vec<Lane> = (0..samples).flat_map(|_| water.map(Lane::splat)).collect();
    let start = [0, 1, 2].map(|d: usize| Lane::splat(experiment.initial[d]));
    let parameters = splat(&truth(&vessel));
    let turning = 1.0 / vessel.sample_rate_hz;
    let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
    let weather = Weather { current: &currents, turning, force: &[] };
    simulate(&vessel.model, &parameters, start, &experiment.inputs, &weather, &mut measured);
    let runs = runs(&experiment, &measured);
    let starts = vec![vec![vessel.nominal.clone()]; LANES];
    let fits = |current| {
        let additional = AdditionalUnknowns { current, ..AdditionalUnknowns::default() };
        let unknown = Unknown::new(InitialState::Known, additional, turning);
        converged(output_error(&vessel.model, &runs, &starts, unknown, Spread::Blocks)).swap_remove(0)
    };
    let found = fits(UnknownCurrent::Earth);
    // Simulations turn by sines, searches by polynomials that agree with them to 1e-9.
    for (found, truth) in found.parameters.iter().zip(truth(&vessel)) {
        approx::assert_relative_eq!(*found, truth, max_relative = 1e-4);
    }
    for (found, truth) in found.current.unwrap()[0].iter().zip(water) {
        approx::assert_relative_eq!(*found, truth, max_relative = 1e-4);
    }
    let without = fits(UnknownCurrent::None);
    assert_eq!(without.current, None);
    let mut pairs = without.parameters.iter().zip(truth(&vessel));
    assert!(pairs.any(|(found, truth)| (found / truth - 1.0).abs() > 0.05));
}

#[test]
fn a_run_that_never_turns_is_not_identifiable_and_a_wild_start_does_not_converge() {
    let vessel = paper();
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(1, 300)]);
    let measured = splat(&experiment.states(&vessel, Source::Value));
    let fits = free_fits(&vessel, &experiment, &measured, InitialState::Known);
    assert!(matches!(fits[0], RunFit::NotIdentifiable(_)), "{:?}", fits[0]);
    let wild = starts(&vessel, &vec![5.0; vessel.model.parameters()]);
    let runs = runs(&experiment, &measured);
    let fits =
        output_error(&vessel.model.with_intercepts(), &runs, &wild, InitialState::Known, Spread::Blocks);
    assert!(matches!(fits[0], RunFit::NotConverged(_)), "{:?}", fits[0]);
}

/// Without process noise the filter is a simulation: both estimate the same.
#[test]
fn law_prediction_error_without_disturbances_is_output_error() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let mut normals = Normals::new(9);
    let mut measured = splat(&experiment.states(&vessel, Source::Value));
    measured.iter_mut().for_each(|y| (0..LANES).for_each(|lane| y[lane] += NOISE * normals.next()));
    let free = converged(free_fits(&vessel, &experiment, &measured, InitialState::Known));
    let levels = |lane: usize| NoiseModel {
        measurement: free[lane].rmse,
        current: Flow::Still,
        force: None,
        drift: None,
    };
    let (runs, from) = (runs(&experiment, &measured), starts(&vessel, &vessel.nominal));
    let model = vessel.model.with_intercepts();
    let found = converged(prediction_error(&model, &runs, &from, InitialState::Known, &levels(6)));
    for (a, b) in found[6].parameters.iter().zip(&free[6].parameters) {
        approx::assert_relative_eq!(*a, *b, max_relative = 1e-5);
    }
}

/// Cramér and Rao's bound from measurement noise alone, without intercepts, in still water: the bound that README.md
/// compares the estimators with.
#[test]
fn law_measurement_noise_bounds_what_the_papers_experiment_can_tell() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = splat(&experiment.states(&vessel, Source::Value));
    let data = recordings(&vessel.model, &experiment, &measured);
    let truth = truth(&vessel);
    let (p, unknowns) = (truth.len(), splat(&[&truth[..], &[0.0; 3]].concat()));
    let found = Sensitivities::of(&data, &unknowns, &(0..p).collect::<Vec<_>>(), true);
    let mut information = vec![0.0; p * p];
    for k in 0..=data.longest() {
        let relative = |i: usize, d: usize| found.by(k, i)[d][0] * truth[i] / NOISE;
        for (k, entry) in information.iter_mut().enumerate() {
            *entry += (0..3).map(|d| relative(k / p, d) * relative(k % p, d)).sum::<f64>();
        }
    }
    let mut inverse = vec![0.0; p * p];
    numerics::inverse(p, &mut information, &mut inverse).unwrap();
    let bound = (0..p).map(|i| inverse[i * p + i]).sum::<f64>().sqrt();
    println!("root mean square of the parameter error, at least: {bound:.3}");
    assert!((bound - 1.28).abs() < 0.02, "{bound}");
}

/// Estimators whose standard errors follow from stated levels.
#[derive(Clone, Copy, Debug)]
enum By {
    PrefilteredInstruments,
    OutputError,
    PredictionError,
}

/// Parameters and standard errors of the lanes of `measured`, searched for from the truth.
fn estimates(
    by: By,
    vessel: &Vessel,
    experiment: &Experiment,
    measured: &[Lane],
    levels: &NoiseModel,
) -> Vec<(Vec<f64>, Vec<f64>)> {
    let (runs, from) = (runs(experiment, measured), starts(vessel, &truth(vessel)));
    let (model, known) = (vessel.model.with_intercepts(), InitialState::Known);
    let fits = match by {
        By::PrefilteredInstruments => {
            let batch = Batch {
                model: &vessel.model,
                measured,
                instrument_states: &splat(&experiment.states(vessel, Source::Value)),
                instrument_exogenous: &splat(&experiment.inputs),
                exogenous: &splat(&experiment.inputs),
                segments: [&[0]; LANES],
            };
            let (poles, noise) = (splat(&truth(vessel)), levels.white());
            let found = estimate_prefiltered(&batch, &poles, MeanRemoval::Complete, noise.as_ref());
            let identified = |outcome: Outcome| match outcome {
                Outcome::Identified(found) => (found.parameters, found.standard_errors),
                other => panic!("{other:?}"),
            };
            return found.into_iter().map(identified).collect();
        }
        By::OutputError => output_error(&model, &runs, &from, known, Spread::Stated(levels)),
        By::PredictionError => prediction_error(&model, &runs, &from, known, levels),
    };
    converged(fits).into_iter().map(|found| (found.parameters, found.standard_errors)).collect()
}

/// Mean standard error over the standard deviation of estimates, parameter by parameter, over `runs` runs in `levels`.
fn ratios(levels: &NoiseModel, runs: usize, by: By, seed: u64) -> Vec<f64> {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let samples = experiment.inputs.len() / 3;
    let mut normals = Normals::new(seed);
    let Flow::White { std } = levels.current else { panic!("white") };
    let mut all = Vec::new();
    for _ in 0..runs / LANES {
        let mut draw = |std: f64| Lane(std::array::from_fn(|_| std * normals.next()));
        let current: Vec<Lane> = (0..2 * samples).map(|_| draw(std)).collect();
        let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
        let initial = experiment.initial.map(Lane::splat);
        let parameters = splat(&truth(&vessel));
        let weather = Weather { current: &current, ..Weather::CALM };
        simulate(&vessel.model, &parameters, initial, &experiment.inputs, &weather, &mut measured);
        measured.iter_mut().enumerate().for_each(|(i, y)| *y += draw(levels.measurement[i % 3]));
        all.extend(estimates(by, &vessel, &experiment, &measured, levels));
    }
    let ratio = |i: usize| {
        let mean = all.iter().map(|(theta, _)| theta[i]).sum::<f64>() / all.len() as f64;
        let square = all.iter().map(|(theta, _)| (theta[i] - mean).powi(2)).sum::<f64>();
        let spread = (square / (all.len() - 1) as f64).sqrt();
        all.iter().map(|(_, errors)| errors[i]).sum::<f64>() / all.len() as f64 / spread
    };
    (0..truth(&vessel).len()).map(ratio).collect()
}

#[test]
fn law_standard_errors_are_the_spread_of_estimates() {
    let levels =
        NoiseModel { measurement: [NOISE; 3], current: Flow::White { std: NOISE }, force: None, drift: None };
    for by in [By::PrefilteredInstruments, By::OutputError, By::PredictionError] {
        let ratios = ratios(&levels, 400, by, 31);
        println!("{by:?}: predicted over spread {ratios:.3?}");
        for (i, ratio) in ratios.iter().enumerate() {
            assert!((ratio - 1.0).abs() < 0.15, "parameter {i}, {by:?}: {ratio}");
        }
    }
}

/// The filter turns a current in earth axes with the heading: with the true levels the innovations are white.
#[test]
fn law_whitened_innovations_of_the_true_filter_have_unit_variance() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let samples = experiment.inputs.len() / 3;
    let mut normals = Normals::new(77);
    let (std, factor, gust, keep) = (0.1, 0.98, [0.004, 0.003, 0.002], 0.95_f64);
    let mut process = |width: usize, std: &[f64], factor: f64| {
        let mut out: Vec<Lane> = Vec::new();
        for i in 0..width * samples {
            let fresh = if i < width { 1.0 } else { (1.0 - factor * factor).sqrt() };
            let drawn = Lane(std::array::from_fn(|_| fresh * std[i % width] * normals.next()));
            let before = if i < width { Lane::ZERO } else { out[i - width] };
            out.push(Lane::splat(factor) * before + drawn);
        }
        out
    };
    let (current, force) = (process(2, &[std; 2], factor), process(3, &gust, keep));
    let weather = Weather { current: &current, turning: 1.0 / 8.0, force: &force };
    let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
    let initial = experiment.initial.map(Lane::splat);
    let parameters = splat(&truth(&vessel));
    simulate(&vessel.model, &parameters, initial, &experiment.inputs, &weather, &mut measured);
    measured.iter_mut().for_each(|y| *y += Lane(std::array::from_fn(|_| 0.05 * normals.next())));
    let levels = NoiseModel {
        measurement: [0.05; 3],
        current: Flow::Markov { std, factor, turning: 1.0 / 8.0 },
        force: Some(ForceNoise { std: gust, factor: [keep; 3] }),
        drift: None,
    };
    let (runs, from) = (runs(&experiment, &measured), starts(&vessel, &truth(&vessel)));
    let model = vessel.model.with_intercepts();
    let found = converged(prediction_error(&model, &runs, &from, InitialState::Known, &levels));
    let mean = (0..LANES).flat_map(|lane| found[lane].rmse).map(|r| r * r).sum::<f64>() / (3 * LANES) as f64;
    // 24,000 squares less 13 unknowns per run: a standard error of 0.009.
    assert!((mean - (1.0 - 13.0 / 3003.0)).abs() < 0.04, "{mean}");
}
