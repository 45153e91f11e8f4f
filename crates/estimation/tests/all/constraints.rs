//! Parameters that are fixed, tied or bounded, and the constant as a term: by every estimator.

use std::collections::BTreeMap;

use estimation::pooled::{Estimated, Judgement, Pool, PoolError, Resampling, estimate};
use estimation::predictor::{Flow, InitialState, NoiseModel};
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use estimation::{Estimator, RunEstimate};
use regression::pooled::{DegreeRegression, Options, Part, PooledRuns, Regression, fit};
use regression::{Known, MeanRemoval, Sums};
use ship::engine::Run;
use ship::model::{InputSpec, TermSpec, Vessel, VesselFile};

use crate::support::craft::{craft_file, part, runs};
use crate::support::noise::Normals;

/// The craft with its terms changed.
fn craft(change: impl Fn(&mut VesselFile)) -> Vessel {
    let mut file = craft_file();
    change(&mut file);
    Vessel::from_file(file).unwrap()
}

fn spec<'a>(file: &'a mut VesselFile, name: &str) -> &'a mut TermSpec {
    let mut terms = [&mut file.surge, &mut file.sway, &mut file.yaw].into_iter().flatten();
    terms.find(|spec| spec.parameter == name).unwrap()
}

fn parts(count: usize) -> Vec<Part> {
    let (vessel, mut normals) = (craft(|_| ()), Normals::new(21));
    (0..count).map(|i| part(&vessel, 90, i, &mut normals, true)).collect()
}

fn pooled(vessel: &Vessel, parts: &Vec<Part>, estimator: Estimator) -> Estimated {
    Pool::new(vessel).estimate(parts, estimator).unwrap_or_else(|_| panic!("{estimator}"))
}

/// θ̂ by name, with the intercepts.
fn by_name(vessel: &Vessel, found: &Estimated) -> BTreeMap<String, f64> {
    let (theta, intercepts) = found.theta().unwrap();
    let names = vessel.model.parameter_names().map(str::to_owned);
    let constants = ["surge", "sway", "yaw"].map(str::to_owned).into_iter().zip(intercepts);
    names.zip(theta).chain(constants).collect()
}

/// Estimates of single runs, of the three kinds that start from scratch.
fn single(vessel: &Vessel, runs: &[Run]) -> Vec<RunEstimate> {
    let estimators = Estimator::OF_RUNS.to_vec();
    let levels =
        NoiseModel { measurement: [0.01, 0.01, 0.005], current: Flow::Still, force: None, drift: None };
    let (removal, initial) = (MeanRemoval::Complete, InitialState::Known);
    RunEstimators {
        vessel,
        estimators,
        removal,
        initial,
        additional: AdditionalUnknowns::default(),
        levels: Some(levels),
    }
    .estimates(runs)
    .unwrap()
}

/// θ̂ and its standard error by run, estimator and parameter, of those with an estimate.
fn each(vessel: &Vessel, found: &[RunEstimate]) -> BTreeMap<(i32, String, String), [f64; 2]> {
    let mut all = BTreeMap::new();
    for found in found {
        let (theta, errors) = found.estimate.as_ref().unwrap_or_else(|| panic!("{found:?}"));
        for ((name, theta), error) in vessel.model.parameter_names().zip(theta).zip(errors) {
            all.insert((found.run, found.estimator.to_string(), name.to_owned()), [*theta, *error]);
        }
    }
    all
}

fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs().max(1e-3), "{found} {expected}");
}

#[test]
fn law_fixing_a_parameter_at_its_estimate_changes_no_other() {
    let (free, parts) = (craft(|_| ()), parts(4));
    // Instruments are simulated with the nominal model, so those of `iv` would differ: see the next law.
    for (estimator, relative) in [(Estimator::Ls, 1e-9), (Estimator::OutputError, 2e-4)] {
        let expected = by_name(&free, &pooled(&free, &parts, estimator));
        let fixed = craft(|file| {
            let own = spec(file, "Y_ur");
            (own.fixed, own.nominal) = (true, Some(expected["Y_ur"]));
        });
        let found = by_name(&fixed, &pooled(&fixed, &parts, estimator));
        assert_eq!(found.len(), expected.len() - 1);
        found.iter().for_each(|(name, value)| close(*value, expected[name], relative));
    }
    let runs = runs(&parts[..1]);
    let expected = each(&free, &single(&free, &runs));
    for (estimator, relative) in [("ls", 1e-9), ("output-error", 1e-4), ("prediction-error", 1e-3)] {
        let at = expected[&(0, estimator.to_owned(), "Y_ur".to_owned())][0];
        let fixed = craft(|file| {
            let own = spec(file, "Y_ur");
            (own.fixed, own.nominal) = (true, Some(at));
        });
        for (key, [value, error]) in
            each(&fixed, &single(&fixed, &runs)).into_iter().filter(|(k, _)| k.1 == estimator)
        {
            close(value, expected[&key][0], relative);
            assert!(error <= expected[&key][1] * (1.0 + 1e-6) || estimator == "output-error", "{key:?}");
        }
    }
}

#[test]
fn law_with_the_same_instruments_what_is_fixed_or_held_at_a_bound_leaves_its_equation_out() {
    let (free, parts) = (craft(|_| ()), parts(3));
    let lifted = free.model.with_intercepts();
    let nominal = lifted.layout().woven(&free.nominal, [0.0; 3]);
    let estimated = |vessel: &Vessel| {
        let states = parts.iter().map(|part| part.whole().simulated(&lifted, &nominal).unwrap());
        let sums: Vec<Sums> = parts
            .iter()
            .zip(states)
            .map(|(part, states)| {
                Regression::with(&vessel.model, &part.whole(), &states).after_start().sums()
            })
            .collect();
        let options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };
        fit(&sums.iter().collect::<Vec<_>>(), &options).map(|d| d.solution.unwrap())
    };
    let expected = estimated(&free);
    // N_uv, between N_r and N_delta.
    let beyond = expected[2].theta[1] + 0.02;
    let fixed = estimated(&craft(|file| {
        (spec(file, "N_uv").fixed, spec(file, "N_uv").nominal) = (true, Some(beyond));
    }));
    let bounds = Some([beyond, f64::INFINITY]);
    let held = craft(|file| (spec(file, "N_uv").bounds, spec(file, "N_uv").nominal) = (bounds, Some(beyond)));
    let bounded = estimated(&held);
    assert_eq!((bounded[2].theta[1], &bounded[2].gain[3..6]), (beyond, &[0.0; 3][..]));
    for (i, j) in [(0, 0), (2, 1)] {
        close(bounded[2].theta[i], fixed[2].theta[j], 1e-9);
        assert!((bounded[2].theta[i] - expected[2].theta[i]).abs() > 1e-6);
    }
    let same = estimated(&craft(|file| {
        (spec(file, "N_uv").fixed, spec(file, "N_uv").nominal) = (true, Some(expected[2].theta[1]));
    }));
    [(0, 0), (2, 1)].into_iter().for_each(|(i, j)| close(same[2].theta[j], expected[2].theta[i], 1e-9));
    assert_eq!(bounded[..2], expected[..2]);
}

#[test]
fn law_two_halves_of_a_channel_that_are_tied_give_the_estimate_of_the_whole() {
    let whole = craft(|_| ());
    // `port` holds the rudder where it is below 0 with its sign changed, `starboard` where it is above.
    let halves = craft(|file| {
        let unit = "rad".to_owned();
        let channel =
            |name: &str| InputSpec { name: name.into(), unit: unit.clone(), ..InputSpec::default() };
        file.input.truncate(1);
        file.input.extend([channel("starboard"), channel("port")]);
        spec(file, "N_delta").term = "u^2 starboard".into();
        let tied = TermSpec {
            parameter: "N_port".into(),
            term: "u^2 port".into(),
            tied_to: Some("N_delta".into()),
            factor: Some(-1.0),
            ..TermSpec::default()
        };
        file.yaw.insert(0, tied);
    });
    let parts = parts(3);
    let split = |part: &Part| {
        let rows = part.exogenous.chunks_exact(2).flat_map(|r| [r[0], r[1].max(0.0), (-r[1]).max(0.0)]);
        Part { exogenous: rows.collect(), ..part.clone() }
    };
    let cut: Vec<Part> = parts.iter().map(split).collect();
    for estimator in Estimator::POOLED {
        let expected = by_name(&whole, &pooled(&whole, &parts, estimator));
        let found = by_name(&halves, &pooled(&halves, &cut, estimator));
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
        found.iter().for_each(|(name, value)| close(*value, expected[name], 1e-6));
    }
    let expected = each(&whole, &single(&whole, &runs(&parts[..1])));
    for (key, found) in each(&halves, &single(&halves, &runs(&cut[..1]))) {
        close(found[0], expected[&key][0], 1e-6);
        close(found[1], expected[&key][1], 1e-6);
    }
}

#[test]
fn law_bounds_that_do_not_bind_change_no_bit_and_those_that_do_hold_like_a_fixed_value() {
    let (free, parts) = (craft(|_| ()), parts(3));
    let bounded = |name: &'static str, bounds: [f64; 2], nominal: f64| {
        craft(move |file| (spec(file, name).bounds, spec(file, name).nominal) = (Some(bounds), Some(nominal)))
    };
    let wide = bounded("X_vr", [-50.0, f64::INFINITY], 0.5);
    for estimator in Estimator::POOLED {
        let (found, expected) = (pooled(&wide, &parts, estimator), pooled(&free, &parts, estimator));
        assert_eq!(found.degrees, expected.degrees, "{estimator}");
    }
    let runs = runs(&parts[..1]);
    let expected = single(&free, &runs);
    assert_eq!(single(&wide, &runs), expected);
    // Output error held at a bound is output error with the parameter fixed there, and the data favour values beyond:
    // without the bound the estimate lies there.
    let at = by_name(&free, &pooled(&free, &parts, Estimator::OutputError))["X_vr"] + 0.1;
    let held = bounded("X_vr", [at, 10.0], at + 0.1);
    let fixed = craft(|file| (spec(file, "X_vr").fixed, spec(file, "X_vr").nominal) = (true, Some(at)));
    let found = pooled(&held, &parts, Estimator::OutputError);
    let (found_by, expected_by) =
        (by_name(&held, &found), by_name(&fixed, &pooled(&fixed, &parts, Estimator::OutputError)));
    assert_eq!(found_by["X_vr"], at);
    expected_by.iter().for_each(|(name, value)| close(found_by[name], *value, 1e-3));
    let (best, _) = found.searched.as_ref().unwrap();
    let n = best.parameters.len();
    assert!((0..n).all(|j| best.covariance[n + j] == 0.0) && best.covariance[0] > 0.0);
    let (found, expected) = (each(&held, &single(&held, &runs)), each(&fixed, &single(&fixed, &runs)));
    for estimator in ["ls", "output-error", "prediction-error"] {
        let of = |name: &str| found[&(0, estimator.to_owned(), name.to_owned())];
        // One run alone may have its estimate within the bound.
        if of("X_vr") == [at, 0.0] {
            close(of("X_u")[0], expected[&(0, estimator.to_owned(), "X_u".to_owned())][0], 2e-3);
        }
    }
    assert!(found.iter().any(|(key, [value, error])| key.2 == "X_vr" && *value == at && *error == 0.0));
}

#[test]
fn law_the_constant_as_a_term_is_the_intercept() {
    let (without, parts) = (craft(|_| ()), parts(3));
    let with = craft(|file| {
        let constant =
            TermSpec { parameter: "Y_0".into(), term: "1".into(), nominal: Some(0.0), ..TermSpec::default() };
        file.sway.insert(1, constant);
    });
    for estimator in Estimator::POOLED {
        let expected = by_name(&without, &pooled(&without, &parts, estimator));
        let found = by_name(&with, &pooled(&with, &parts, estimator));
        close(found["Y_0"], expected["sway"], 1e-4);
        assert_eq!(found["sway"], 0.0);
        expected
            .iter()
            .filter(|(name, _)| *name != "sway")
            .for_each(|(name, value)| close(found[name], *value, 1e-4));
    }
    let runs = runs(&parts[..1]);
    let (found, expected) = (each(&with, &single(&with, &runs)), each(&without, &single(&without, &runs)));
    for (key, [value, error]) in expected {
        let share = match key.1.as_str() {
            "ls" | "iv" => 1e-8,
            _ => 0.02,
        };
        assert!((found[&key][0] - value).abs() <= share * error, "{key:?} {:?} {value} {error}", found[&key]);
        close(found[&key][1], error, share);
    }
    assert!(found.iter().all(|(key, [_, error])| key.2 != "Y_0" || *error > 0.0));
    let refused = MeanRemoval::Batch.check(&with.model).unwrap_err().to_string();
    assert!(refused.contains("`Y_0`") && refused.contains("every segment"), "{refused}");
    assert!(MeanRemoval::Batch.check(&without.model).is_ok() && MeanRemoval::None.check(&with.model).is_ok());
}

#[test]
fn bounds_that_exclude_every_estimate_leave_none_and_say_which() {
    let bounds = |file: &mut VesselFile| {
        for name in ["Y_v", "Y_ur"] {
            (spec(file, name).bounds, spec(file, name).nominal) = (Some([2.0, 3.0]), Some(2.5));
        }
    };
    let (vessel, parts) = (craft(bounds), parts(3));
    let runs = PooledRuns::new(runs(&parts), &BTreeMap::new());
    let judgement = Judgement { replicates: 0, seed: 1 };
    let Err(PoolError::Bounded(reasons)) =
        estimate(&Pool::new(&vessel), &runs, Estimator::Ls, &judgement, Resampling::Drawn(&|_| ()))
    else {
        panic!("an estimate")
    };
    assert!(reasons[0].contains("sway") && reasons[0].contains("`Y_v` between 2 and 3"), "{reasons:?}");
    let strong = Pool { strength: 0.1, ..Pool::new(&vessel) };
    assert!(strong.check().unwrap_err().to_string().contains("prior"));
}

#[test]
fn an_estimate_at_a_bound_has_no_standard_error_and_is_told() {
    let bound = |file: &mut VesselFile| {
        (spec(file, "N_uv").bounds, spec(file, "N_uv").nominal) = (Some([0.0, 1.0]), Some(0.1))
    };
    let (vessel, parts) = (craft(bound), parts(3));
    let runs = PooledRuns::new(runs(&parts), &BTreeMap::new());
    let judgement = Judgement { replicates: 0, seed: 1 };
    for estimator in [Estimator::Ls, Estimator::OutputError] {
        let found =
            estimate(&Pool::new(&vessel), &runs, estimator, &judgement, Resampling::Drawn(&|_| ())).unwrap();
        let own = &found.degrees[2].parameters[1];
        assert_eq!((own.estimate, own.standard_error, own.at_bound), (Some(0.0), None, true), "{estimator}");
        assert!(
            found.degrees[2].parameters.iter().filter(|p| !p.at_bound).all(|p| p.standard_error > Some(0.0))
        );
        assert!(
            found
                .statements
                .iter()
                .any(|s| s.starts_with("yaw: held at a bound") && s.contains("`N_uv` at 0"))
        );
        let covariance = found.delivered.as_ref().unwrap().covariance.as_ref().unwrap();
        let (n, at) =
            (covariance.names.len(), covariance.names.iter().position(|name| name == "N_uv").unwrap());
        assert!(
            (0..n).all(|i| covariance.entries[at * n + i] == 0.0 && covariance.entries[i * n + at] == 0.0)
        );
        assert_eq!(found.as_run(estimator).estimate.unwrap().1[6], 0.0);
    }
}

#[test]
fn oracle_least_squares_within_bounds() {
    let cases: Vec<serde_json::Value> =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/bounded.json")).unwrap();
    assert_eq!(cases.len(), 3);
    let numbers = |value: &serde_json::Value| serde_json::from_value::<Vec<f64>>(value.clone()).unwrap();
    let degrees: Vec<DegreeRegression> = cases
        .iter()
        .map(|case| DegreeRegression {
            parameters: 4,
            phi: numbers(&case["phi"]),
            zeta: numbers(&case["phi"]),
            target: numbers(&case["target"]),
            known: Known { constant: false, bounds: serde_json::from_value(case["bounds"].clone()).unwrap() },
        })
        .collect();
    let sums = Regression { samples: 40, degrees: degrees.try_into().unwrap() }.sums();
    let options = Options { removal: MeanRemoval::None, prior: None, most: f64::INFINITY };
    for (found, case) in fit(&[&sums], &options).into_iter().zip(&cases) {
        let solution = found.solution.unwrap();
        // With A = Σ φφᵀ the gain is the covariance for errors of variance 1.
        let expected = [numbers(&case["theta"]), numbers(&case["covariance"])].concat();
        for (found, expected) in solution.theta.iter().chain(&solution.gain).zip(&expected) {
            close(*found, *expected, 1e-9);
        }
        assert!(solution.gain.iter().zip(&expected[4..]).all(|(a, b)| (*a == 0.0) == (*b == 0.0)));
    }
}
