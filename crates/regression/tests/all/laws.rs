//! Properties that hold by theory for any data.

use crate::support::explicit::{Regression, sizes};
use crate::support::noise::Normals;
use crate::support::{Experiment, Recording, SideBySide, dictionary, estimate, paper, truth};
use numerics::{LANES, Lane};
use proptest::prelude::*;
use regression::{
    Batch, DegreeSums, Instruments, Known, MeanRemoval, Outcome, Sums, estimate_prefiltered, moments,
};

const REMOVALS: [MeanRemoval; 3] = [MeanRemoval::Complete, MeanRemoval::Batch, MeanRemoval::None];

fn random_run(seed: u64, lengths: &[usize], noise: f64) -> Recording {
    let mut normals = Normals::new(seed);
    Experiment::random(&mut normals, lengths).record(&paper(), noise, &mut normals)
}

/// Outcomes of the runs, estimated side by side.
fn outcomes(runs: &[&Recording], removal: MeanRemoval) -> Vec<Outcome> {
    let vessel = paper();
    let side_by_side = SideBySide::new(runs);
    let mut all = estimate(&side_by_side.batch(&vessel.model), removal);
    all.truncate(runs.len());
    all
}

fn theta(outcome: &Outcome) -> &[f64] {
    match outcome {
        Outcome::Identified(estimate) => &estimate.parameters,
        other => panic!("{other:?}"),
    }
}

fn close(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs()
}

/// An intercept per group is equivalent to subtracting the group's instrument mean, and the crate agrees with both.
#[test]
fn law_an_intercept_is_the_subtraction_of_the_instruments_mean() {
    let runs: Vec<Recording> = (0..8).map(|seed| random_run(seed, &[130, 70, 100], 0.02)).collect();
    let least_squares: Vec<Recording> = runs.iter().map(Recording::with_own_instruments).collect();
    for runs in [&runs, &least_squares] {
        for removal in REMOVALS {
            let found = outcomes(&runs.iter().collect::<Vec<_>>(), removal);
            for (run, outcome) in runs.iter().zip(&found) {
                let groups: &[usize] = match removal {
                    MeanRemoval::None => &[],
                    MeanRemoval::Batch => &run.segments,
                    MeanRemoval::Complete => &[0],
                };
                check_both_forms(run, groups, theta(outcome));
            }
        }
    }
}

fn check_both_forms(run: &Recording, groups: &[usize], found: &[f64]) {
    let mut next = 0;
    for d in 0..3 {
        let mut subtracted = Regression::of(run, d);
        let mut lifted = Regression::of(run, d);
        let p = subtracted.parameters();
        subtracted.subtract_instrument_means(groups);
        lifted.lift(groups);
        let forms = [subtracted.solve(), lifted.solve()];
        for i in 0..p {
            for form in &forms {
                let found = found[next + i];
                assert!(close(found, form[i], 1e-8), "{d} {i}: found {found}, expected {}", form[i]);
            }
        }
        next += p;
    }
}

/// Sums of one degree of freedom by their definitions.
fn explicit_sums(run: &Recording, d: usize) -> DegreeSums {
    let mut regression = Regression::of(run, d);
    let p = regression.parameters();
    let squares = |rows: &[Vec<f64>]| sizes(rows).iter().map(|s| s * s * rows.len() as f64).collect();
    let (instrument_squares, regressor_squares) = (squares(&regression.zeta), squares(&regression.phi));
    regression.lift(&[0]);
    let (mut a, mut b) = (vec![0.0; (p + 1) * (p + 1)], vec![0.0; p + 1]);
    for ((phi, zeta), target) in regression.phi.iter().zip(&regression.zeta).zip(&regression.target) {
        for i in 0..=p {
            b[i] += zeta[i] * target;
            for j in 0..=p {
                a[i * (p + 1) + j] += zeta[i] * phi[j];
            }
        }
    }
    DegreeSums { a, b, instrument_squares, regressor_squares, known: Known::default() }
}

fn explicit(run: &Recording) -> Sums {
    Sums { samples: run.samples() as u64, degrees: (0..3).map(|d| explicit_sums(run, d)).collect() }
}

/// Largest difference of two arrays, relative to the largest entry that the sums could have.
fn assert_sums_close(found: &[f64], expected: &[f64], size: impl Fn(usize) -> f64) {
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= 1e-12 * size(k), "{k}: found {found}, expected {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The sums of two segments add to those of the whole, and the crate's moments are these sums over N.
    #[test]
    fn law_sums_of_pieces_merge_into_those_of_the_whole(seed in 0u64..1000, cut in 1usize..99) {
        let run = random_run(seed, &[100], 0.05);
        let (vessel, segments) = (paper(), [run.segment(0, cut), run.segment(cut, 100)]);
        let whole = explicit(&run);
        let mut merged = Sums::default();
        segments.iter().for_each(|own| merged.merge(&explicit(own)));
        prop_assert_eq!(merged.samples, 100);
        let of = |run: &Recording| moments(&SideBySide::new(&[run]).batch(&vessel.model)).swap_remove(0);
        let (all, parts) = (of(&run), segments.each_ref().map(of));
        prop_assert_eq!(all.samples, parts[0].samples + parts[1].samples);
        for d in 0..3 {
            let (merged, whole) = (&merged.degrees[d], &whole.degrees[d]);
            let lifted = whole.b.len();
            let squares = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(100.0).sqrt();
            let size = |k: usize| squares(&whole.instrument_squares, k / lifted) * squares(&whole.regressor_squares, k % lifted);
            assert_sums_close(&merged.a, &whole.a, size);
            assert_sums_close(&merged.b, &whole.b, |i| 100.0 * squares(&whole.instrument_squares, i));
            assert_sums_close(&merged.instrument_squares, &whole.instrument_squares, |i| whole.instrument_squares[i]);
            assert_sums_close(&merged.regressor_squares, &whole.regressor_squares, |i| whole.regressor_squares[i]);
            let sum = |k: usize| parts.iter().map(|part| part.samples as f64 * part.matrices[d][k]).sum::<f64>();
            let sums: Vec<f64> = (0..lifted * lifted).map(sum).collect();
            let transposed = |k: usize| (k % lifted) * lifted + k / lifted;
            let total: Vec<f64> = all.matrices[d].iter().map(|m| 100.0 * m).collect();
            let own: Vec<f64> = (0..lifted * lifted).map(|k| whole.a[transposed(k)]).collect();
            assert_sums_close(&sums, &total, |k| size(transposed(k)));
            assert_sums_close(&total, &own, |k| size(transposed(k)));
        }
    }

    #[test]
    fn law_data_without_noise_give_the_true_parameters(seed in 0u64..1_000_000) {
        let run = random_run(seed, &[150, 100, 150], 0.0);
        let truth = truth(&paper());
        for run in [&run, &run.with_own_instruments()] {
            for removal in REMOVALS {
                let found = outcomes(&[run], removal);
                for (i, (found, truth)) in theta(&found[0]).iter().zip(&truth).enumerate() {
                    prop_assert!(close(*found, *truth, 1e-8), "{i}: found {found}, expected {truth}");
                }
            }
        }
    }

    /// Every lane has the same bits, regardless of its neighbours and their segments.
    #[test]
    fn law_an_estimate_does_not_depend_on_its_neighbours(seed in 0u64..1000, lane in 0usize..LANES) {
        let run = random_run(seed, &[120, 80, 100], 0.1);
        let neighbour = |i: u64| random_run(1000 + 10 * seed + i, &[50 + 7 * i as usize, 250 - 7 * i as usize], 0.2);
        let neighbours: Vec<Recording> = (0..LANES as u64).map(neighbour).collect();
        let mut mixed: Vec<&Recording> = neighbours.iter().collect();
        mixed[lane] = &run;
        for removal in REMOVALS {
            let alone = outcomes(&[&run], removal).swap_remove(0);
            let among = outcomes(&mixed, removal).swap_remove(lane);
            prop_assert_eq!(format!("{alone:?}"), format!("{among:?}"));
        }
    }

    /// Instruments that runs share, as numbers instead of lanes and computed for other data, give the same bits.
    #[test]
    fn law_shared_instruments_are_the_instruments_of_every_run(seed in 0u64..1000) {
        let (vessel, lengths) = (paper(), [61, 80, 100]);
        let mut normals = Normals::new(seed);
        let experiment = Experiment::random(&mut normals, &lengths);
        let runs: Vec<Recording> = (0..LANES).map(|_| experiment.record(&vessel, 0.1, &mut normals)).collect();
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let own = side_by_side.batch(&vessel.model);
        let unmeasured = vec![Lane::ZERO; own.measured.len()];
        let shared = Batch {
            model: own.model,
            measured: &unmeasured,
            instrument_states: runs[0].instrument_states.as_slice(),
            instrument_exogenous: runs[0].exogenous.as_slice(),
            exogenous: runs[0].exogenous.as_slice(),
            segments: own.segments,
        };
        for removal in REMOVALS {
            let instruments = Instruments::new(&shared, removal);
            let found = instruments.estimate(&Batch { measured: own.measured, ..shared });
            prop_assert_eq!(format!("{found:?}"), format!("{:?}", estimate(&own, removal)));
        }
    }

    /// An additional channel that no term uses changes nothing.
    #[test]
    fn law_a_channel_that_no_term_has_changes_no_bit(seed in 0u64..1000, lengths in [20usize..90, 20usize..90]) {
        let vessel = paper();
        let mut any = vessel.model.clone();
        any.variables.push(ship::model::Variable { name: "idle".to_owned(), unit: "1".to_owned() });
        let mut normals = Normals::new(seed);
        let experiment = Experiment::random(&mut normals, &lengths);
        let runs: Vec<Recording> = (0..LANES).map(|_| experiment.record(&vessel, 0.1, &mut normals)).collect();
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let own = side_by_side.batch(&vessel.model);
        let wider: Vec<Lane> =
            own.exogenous.chunks_exact(3).flat_map(|row| row.iter().copied().chain([Lane::ONE])).collect();
        let shared = Batch {
            model: own.model,
            measured: own.measured,
            instrument_states: runs[0].instrument_states.as_slice(),
            instrument_exogenous: runs[0].exogenous.as_slice(),
            exogenous: runs[0].exogenous.as_slice(),
            segments: own.segments,
        };
        let wider_numbers: Vec<f64> =
            shared.exogenous.chunks_exact(3).flat_map(|row| row.iter().copied().chain([1.0])).collect();
        let theta: Vec<Lane> = truth(&vessel).into_iter().map(Lane::splat).collect();
        for removal in REMOVALS {
            let found = format!("{:?}", estimate_prefiltered(&own, &theta, removal, None));
            let general = Batch { model: &any, exogenous: &wider, instrument_exogenous: &wider, ..own };
            prop_assert_eq!(&found, &format!("{:?}", estimate_prefiltered(&general, &theta, removal, None)));
            let found = format!("{:?}", estimate(&own, removal));
            let general = estimate(&Batch { model: &any, exogenous: &wider, instrument_exogenous: &wider, ..own }, removal);
            prop_assert_eq!(&found, &format!("{general:?}"));
            prop_assert_eq!(&found, &format!("{:?}", estimate(&shared, removal)));
            let general = estimate(&Batch { model: &any, exogenous: &wider_numbers, instrument_exogenous: &wider_numbers, ..shared }, removal);
            prop_assert_eq!(&found, &format!("{general:?}"));
        }
    }
}

/// A vessel that only slows down says nothing about sway and yaw, nor about the surge that they cause.
#[test]
fn law_a_run_that_only_decelerates_does_not_identify_sway_and_yaw() {
    let (vessel, mut normals) = (paper(), Normals::new(5));
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(0, 300)]);
    for noise in [0.0, 0.05] {
        let run = experiment.record(&vessel, noise, &mut normals);
        for removal in REMOVALS {
            let side_by_side = SideBySide::new(&[&run]);
            let batch = side_by_side.batch(&vessel.model);
            let (outcome, excitation) =
                Instruments::new(&batch, removal).estimate_with_excitation(&batch).swap_remove(0);
            let Outcome::NotIdentifiable(direction) = outcome else { panic!("{outcome:?}") };
            // The first that is missing is the surge force of sway times yaw rate (or, where the instruments' mean is
            // removed, the thrust that never varies); sway and yaw are missing as a whole.
            let first = vessel.model.degrees[direction.degree].terms[direction.parameter].text.as_str();
            assert!(direction.degree == 0 && ["v r", "tau1"].contains(&first), "{first}");
            assert!(excitation.iter().all(|e| e.condition.is_infinite()), "{excitation:?}");
        }
    }
}

/// The same with a surge equation that decelerating does excite: the named direction is sway.
#[test]
fn law_the_direction_that_is_not_excited_is_named() {
    let (mut vessel, mut normals) = (paper(), Normals::new(6));
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(0, 300)]);
    let run = experiment.record(&vessel, 0.01, &mut normals);
    vessel.model.degrees[0].terms.truncate(1);
    vessel.model.degrees[0].parameters.truncate(1);
    let side_by_side = SideBySide::new(&[&run]);
    let found = estimate(&side_by_side.batch(&vessel.model), MeanRemoval::Complete).swap_remove(0);
    let Outcome::NotIdentifiable(direction) = found else { panic!("{found:?}") };
    assert_eq!((direction.degree, direction.parameter), (1, 0));
}

/// Runs with poles from `parameters`, their instruments simulated with the nominal model.
fn prefiltered(runs: &[&Recording], parameters: &[f64], removal: MeanRemoval) -> Vec<Outcome> {
    let vessel = paper();
    let side_by_side = SideBySide::new(runs);
    let parameters: Vec<Lane> = parameters.iter().copied().map(Lane::splat).collect();
    let mut all = estimate_prefiltered(&side_by_side.batch(&vessel.model), &parameters, removal, None);
    all.truncate(runs.len());
    all
}

#[test]
fn law_a_filter_without_memory_leaves_instrumental_variables_as_they_are() {
    let runs: Vec<Recording> = (0..8).map(|seed| random_run(seed, &[130, 70, 100], 0.02)).collect();
    let runs: Vec<&Recording> = runs.iter().collect();
    // Increments that more than cancel the own state: negative poles, which are clamped to zero.
    let mut damped = vec![0.0; paper().model.parameters()];
    [0, 4, 7].iter().for_each(|own| damped[*own] = -2.0);
    for removal in REMOVALS {
        let plain = outcomes(&runs, removal);
        for (found, plain) in prefiltered(&runs, &damped, removal).iter().zip(&plain) {
            for (found, expected) in theta(found).iter().zip(theta(plain)) {
                assert!(close(*found, *expected, 1e-8), "{removal:?}: found {found}, expected {expected}");
            }
        }
    }
}

#[test]
fn law_prefiltered_runs_without_noise_give_the_truth_and_lanes_do_not_touch_each_other() {
    let vessel = paper();
    let (clean, noisy) = (random_run(5, &[130, 170], 0.0), random_run(6, &[130, 170], 0.1));
    for removal in REMOVALS {
        let among = prefiltered(&[&clean, &noisy], &vessel.nominal, removal);
        assert_eq!(among[..1], prefiltered(&[&clean], &vessel.nominal, removal));
        assert_eq!(among[1..], prefiltered(&[&noisy], &vessel.nominal, removal));
        for (found, truth) in theta(&among[0]).iter().zip(truth(&vessel)) {
            assert!(close(*found, truth, 1e-7), "{removal:?}: found {found}, expected {truth}");
        }
    }
}
