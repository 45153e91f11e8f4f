//! Output error and the Kalman filter against numbers computed independently: `fixtures/oracle/output_error.json`.

use estimation::predictor::{
    Drift, Fitted, Flow, ForceNoise, InitialState, NoiseModel, Recordings, RunFit, Sensitivities, Spread,
    innovations, output_error,
};
use numerics::{LANES, Lane, dot, quadratic};
use regression::{Batch, MeanRemoval, Outcome, estimate_prefiltered};
use serde_json::Value;
use ship::engine::{RunView, Weather, simulate};
use ship::model::Vessel;

use crate::support::{paper, truth};

const ORACLE: &str = include_str!("../../../../fixtures/oracle/output_error.json");

fn oracle() -> Value {
    serde_json::from_str(ORACLE).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(many) => many.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

/// A run of the oracle, the same in every lane.
struct Run {
    vessel: Vessel,
    measured: Vec<Lane>,
    inputs: Vec<Lane>,
    initial: [Lane; 3],
    expected: Value,
}

impl Run {
    fn all() -> Vec<Self> {
        let whole = oracle();
        let run = |run: &Value| Self {
            vessel: paper(),
            measured: numbers(&run["measured"]).into_iter().map(Lane::splat).collect(),
            inputs: numbers(&run["inputs"]).into_iter().map(Lane::splat).collect(),
            initial: <[f64; 3]>::try_from(numbers(&run["initial"])).unwrap().map(Lane::splat),
            expected: run.clone(),
        };
        whole["runs"].as_array().unwrap().iter().map(run).collect()
    }

    fn recordings(&self) -> Recordings<'_> {
        Recordings {
            model: &self.vessel.model,
            measured: &self.measured,
            exogenous: &self.inputs,
            initial: self.initial,
            samples: [self.inputs.len() / 3; LANES],
        }
    }

    /// From the nominal model and from twice the truth, in turns.
    fn fits(&self, initial: InitialState, spread: Spread) -> Vec<Fitted> {
        let twice: Vec<f64> = truth(&self.vessel).iter().map(|t| 1.2 * t).collect();
        let start = |run: usize| if run.is_multiple_of(2) { &self.vessel.nominal } else { &twice };
        let model = self.vessel.model.with_intercepts();
        let woven = |run: usize| model.layout().woven(start(run), [0.0; 3]);
        let starts: Vec<Vec<Vec<f64>>> = (0..LANES).map(|run| vec![woven(run)]).collect();
        let first = |lanes: &[Lane]| lanes.iter().map(|lane| lane[0]).collect::<Vec<f64>>();
        let (measured, exogenous) = (first(&self.measured), first(&self.inputs));
        let run = RunView {
            measured: &measured,
            instrument_exogenous: &exogenous,
            exogenous: &exogenous,
            initial: self.initial.map(|x| x[0]),
        };
        let fits = output_error(&model, &[run; LANES], &starts, initial, spread);
        let converged = |fit: RunFit| match fit {
            RunFit::Converged(found) => found,
            other => panic!("{other:?}"),
        };
        fits.into_iter().map(converged).collect()
    }
}

fn stated() -> NoiseModel {
    let whole = oracle();
    NoiseModel {
        measurement: numbers(&whole["measurement_std"]).try_into().unwrap(),
        current: Flow::White { std: whole["current_std"].as_f64().unwrap() },
        force: None,
        drift: None,
    }
}

/// The filter's levels: `white`, `markov`, `all`.
fn levels(kind: &str) -> NoiseModel {
    let (whole, step) = (oracle(), 1.0 / 8.0);
    let factor = |key: &str| (-step / whole[key]["time_constant_s"].as_f64().unwrap()).exp();
    let markov = Flow::Markov {
        std: whole["markov"]["std"].as_f64().unwrap(),
        factor: factor("markov"),
        turning: step,
    };
    let gusts =
        ForceNoise { std: numbers(&whole["gusts"]["std"]).try_into().unwrap(), factor: [factor("gusts"); 3] };
    let white = stated();
    match kind {
        "white" => white,
        "markov" => NoiseModel { current: markov, ..white },
        _ => NoiseModel { current: markov, force: Some(gusts), ..white },
    }
}

#[test]
fn law_an_estimate_does_not_depend_on_the_runs_that_are_searched_for_beside_it() {
    let all = Run::all();
    let (vessel, truth) = (&all[0].vessel, truth(&all[0].vessel));
    let model = vessel.model.with_intercepts();
    // Other errors and starts for each: some searches end early, some late, some diverge and restart.
    let measured = |i: usize| -> Vec<f64> {
        let own = all[i % all.len()].measured.iter().enumerate();
        own.map(|(k, y)| y[0] + 0.03 * ((k * (i + 3)) as f64).sin()).collect()
    };
    let measured: Vec<Vec<f64>> = (0..2 * LANES + 3).map(measured).collect();
    let exogenous: Vec<Vec<f64>> = all.iter().map(|run| run.inputs.iter().map(|x| x[0]).collect()).collect();
    let runs: Vec<RunView> = measured
        .iter()
        .enumerate()
        .map(|(i, measured)| {
            let run = i % all.len();
            RunView {
                measured,
                instrument_exogenous: &exogenous[run],
                exogenous: &exogenous[run],
                initial: all[run].initial.map(|x| x[0]),
            }
        })
        .collect();
    let start = |factor: f64| {
        let theta: Vec<f64> = truth.iter().map(|t| factor * t).collect();
        model.layout().woven(&theta, [0.0; 3])
    };
    let factors = [1.0, -3.0, 0.3, 1.2];
    let starts: Vec<Vec<Vec<f64>>> =
        (0..runs.len()).map(|i| vec![start(factors[i % 4]), start(0.9)]).collect();
    let together = output_error(&model, &runs, &starts, InitialState::Known, Spread::Blocks);
    assert!(together.iter().any(|fit| matches!(fit, RunFit::Converged(_))));
    for (i, fit) in together.iter().enumerate() {
        let alone = output_error(&model, &runs[i..=i], &starts[i..=i], InitialState::Known, Spread::Blocks);
        assert_eq!(alone, std::slice::from_ref(fit), "run {i}");
    }
}

#[test]
fn oracle_output_error_estimates_agree_with_least_squares_of_scipy() {
    for run in Run::all() {
        for (initial, key) in [(InitialState::Known, "known"), (InitialState::Estimated, "estimated")] {
            let expected = numbers(&run.expected[key]["unknowns"]);
            let rmse = numbers(&run.expected[key]["rmse"]);
            for found in run.fits(initial, Spread::Blocks) {
                let unknowns = found.parameters.iter().chain(&found.intercepts).chain(&found.offset);
                let errors = numbers(&run.expected["standard_errors"]);
                for (i, (found, expected)) in unknowns.zip(&expected).enumerate() {
                    let size = expected.abs().max(errors.get(i).copied().unwrap_or(0.1));
                    assert!(
                        (found - expected).abs() < 1e-5 * size,
                        "{key} {i}: {found}, expected {expected}"
                    );
                }
                for (found, expected) in found.rmse.iter().zip(&rmse) {
                    // Searches end within 1e-5 standard errors of the minimum.
                    approx::assert_relative_eq!(*found, *expected, max_relative = 1e-7);
                }
            }
        }
    }
}

#[test]
fn oracle_standard_errors_agree_with_the_response_to_every_draw() {
    for run in Run::all() {
        let levels = stated();
        let found = run.fits(InitialState::Known, Spread::Stated(&levels));
        let expected = numbers(&run.expected["standard_errors"]);
        for (i, error) in found[3].standard_errors.iter().enumerate() {
            // The oracle's differences straddle the kink of u |u| at standstill.
            approx::assert_relative_eq!(*error, expected[i], max_relative = 2e-4);
        }
    }
}

/// Drift of the sensors enters as it is measured: by its covariance at all pairs of samples.
#[test]
fn oracle_standard_errors_under_drifting_sensors_are_those_of_all_pairs_of_samples() {
    let (std, factor) = ([0.3, 0.2, 0.1], 0.9_f64);
    let levels = NoiseModel {
        measurement: [0.02, 0.03, 0.01],
        current: Flow::Still,
        force: None,
        drift: Some(Drift { std, factor }),
    };
    let run = &Run::all()[0];
    let found = &run.fits(InitialState::Known, Spread::Stated(&levels))[0];
    let model = run.vessel.model.with_intercepts();
    let recordings = Recordings { model: &model, ..run.recordings() };
    let unknowns = model.layout().woven(&found.parameters, found.intercepts).into_iter().chain([0.0; 3]);
    let unknowns: Vec<Lane> = unknowns.map(Lane::splat).collect();
    let n = model.layout().parameters();
    let all = Sensitivities::of(&recordings, &unknowns, &(0..n).collect::<Vec<_>>(), false);
    let samples = recordings.longest();
    let weights = found.rmse.map(|rmse| rmse.powi(-2));
    let column = |i: usize, d: usize| (1..=samples).map(|k| all.by(k, i)[d][0]).collect::<Vec<f64>>();
    let (mut normal, mut meat) = (vec![0.0; n * n], vec![0.0; n * n]);
    for d in 0..3 {
        let columns: Vec<Vec<f64>> = (0..n).map(|i| column(i, d)).collect();
        let covariance = |k: usize, l: usize| {
            let white = if k == l { levels.measurement[d].powi(2) } else { 0.0 };
            white + std[d] * std[d] * factor.powi(k.abs_diff(l) as i32)
        };
        let coloured = |own: &Vec<f64>| -> Vec<f64> {
            (0..samples).map(|k| (0..samples).map(|l| covariance(k, l) * own[l]).sum()).collect()
        };
        let coloured: Vec<Vec<f64>> = columns.iter().map(coloured).collect();
        for e in 0..n * n {
            normal[e] += weights[d] * dot(&columns[e / n], &columns[e % n]);
            meat[e] += weights[d] * weights[d] * dot(&columns[e / n], &coloured[e % n]);
        }
    }
    let mut inverted = vec![0.0; n * n];
    numerics::inverse(n, &mut normal, &mut inverted).unwrap();
    let errors: Vec<f64> = inverted.chunks_exact(n).map(|row| quadratic(row, &meat).sqrt()).collect();
    for (found, expected) in found.standard_errors.iter().zip(model.layout().theta(&errors)) {
        approx::assert_relative_eq!(*found, expected, max_relative = 1e-5);
    }
}

/// First samples of the segments of the oracle's runs.
const SEGMENTS: [&[usize]; 2] = [&[0, 60, 160, 260], &[0, 80, 200]];

#[test]
fn oracle_prefiltered_instrumental_variables_agree_with_triangular_matrices() {
    for (run, segments) in Run::all().iter().zip(SEGMENTS) {
        let truth = truth(&run.vessel);
        let lanes: Vec<Lane> = truth.iter().copied().map(Lane::splat).collect();
        let mut states = vec![Lane::ZERO; run.measured.len()];
        simulate(&run.vessel.model, &lanes, run.initial, &run.inputs, &Weather::CALM, &mut states);
        let batch = Batch {
            model: &run.vessel.model,
            measured: &run.measured,
            instrument_states: &states,
            instrument_exogenous: &run.inputs,
            exogenous: &run.inputs,
            segments: [segments; LANES],
        };
        let removals =
            [("complete", MeanRemoval::Complete), ("batch", MeanRemoval::Batch), ("none", MeanRemoval::None)];
        for (key, removal) in removals {
            let expected = &run.expected["prefiltered"][key];
            let (theta, errors) = (numbers(&expected["theta"]), numbers(&expected["standard_errors"]));
            for outcome in estimate_prefiltered(&batch, &lanes, removal, None) {
                let Outcome::Identified(found) = outcome else { panic!("{key}: {outcome:?}") };
                for i in 0..theta.len() {
                    assert!(
                        (found.parameters[i] - theta[i]).abs() < 1e-7 * errors[i],
                        "{key} {i}: {}, expected {}",
                        found.parameters[i],
                        theta[i]
                    );
                    approx::assert_relative_eq!(found.standard_errors[i], errors[i], max_relative = 1e-7);
                }
            }
        }
    }
}

#[test]
fn oracle_innovations_agree_with_a_filter_in_plain_matrices() {
    for run in Run::all() {
        let unknowns: Vec<Lane> = truth(&run.vessel).into_iter().chain([0.0; 3]).map(Lane::splat).collect();
        for kind in ["white", "markov", "all"] {
            let expected = numbers(&run.expected["innovations"][kind]);
            let found = innovations(&run.recordings(), &unknowns, &levels(kind), InitialState::Known);
            assert_eq!(found.len(), expected.len());
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert!((found[5] - expected).abs() < 1e-7, "{kind} {i}: {}, expected {expected}", found[5]);
            }
        }
    }
}
