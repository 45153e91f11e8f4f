//! Laws of fits to simulated recordings.

use estimation::fitting::{Inputs, Prior, Problem, Settings, SimulatedRun, Starts};
use rayon::ThreadPoolBuilder;
use ship::forces::Forces;

use crate::fitting::ship::{KVLCC2, Normals, Recorded, forces, trial};

const NOISE: [f64; 3] = [0.005, 0.005, 0.0005];

fn problem<'a>(forces: &'a Forces, recorded: &'a [Recorded], settings: Settings) -> Problem<'a> {
    Problem::new(forces, recorded.iter().map(Recorded::recording).collect(), 2, settings).unwrap()
}

/// Priors about numbers that are off the truth by as much as they may be.
fn drawn(forces: &Forces, normals: &mut Normals) -> Vec<Option<Prior>> {
    let one = |own: &ship::forces::Parameter| {
        let deviation = own.prior.unwrap();
        Some(Prior { mean: own.nominal + deviation * normals.next(), deviation })
    };
    forces.parameters().iter().map(one).collect()
}

#[test]
fn law_derivatives_of_the_cost_are_central_differences() {
    let forces = forces(KVLCC2);
    let truth = forces.nominal();
    let recorded = trial(&forces, &truth, 1.0, NOISE, 1);
    let settings = Settings { starts: Starts::Measured, ..Settings::new(1.0) };
    let mut normals = Normals::new(2);
    let problem = problem(&forces, &recorded, settings).with_priors(drawn(&forces, &mut normals));
    let theta: Vec<f64> = truth.iter().map(|own| own * (1.0 + 0.05 * normals.next())).collect();
    let (_, slopes) = problem.cost_and_slopes(&theta);
    for (i, slope) in slopes.iter().enumerate() {
        let step = 1e-6 * theta[i].abs().max(1e-3);
        let at = |sign: f64| {
            let mut theta = theta.clone();
            theta[i] += sign * step;
            problem.cost(&theta)
        };
        let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
        let name = &forces.parameters()[i].name;
        // Where flow across the rudder changes its sign, differences are of two slopes.
        assert!((difference - slope).abs() < 1e-4 * slope.abs() + 1e-6, "{name}: {slope} {difference}");
    }
}

#[test]
fn law_a_ship_without_noise_is_found() {
    let forces = forces(KVLCC2);
    let truth = forces.nominal();
    let recorded = trial(&forces, &truth, 1.0, [0.0; 3], 1);
    let settings = Settings { prior_weight: 1e-9, ..Settings::new(1.0) };
    let mut normals = Normals::new(3);
    let about = drawn(&forces, &mut normals);
    let fit = problem(&forces, &recorded, settings)
        .with_priors(about)
        .fit_from(&truth.iter().map(|own| own * (1.0 + 0.1 * normals.next())).collect::<Vec<_>>());
    let fit = fit.unwrap();
    assert!(fit.rms.iter().all(|own| *own < 1e-3), "{:?}", fit.rms);
}

#[test]
fn law_intervals_hold_the_truth_with_unknown_starts() {
    let forces = forces(KVLCC2);
    let truth = forces.nominal();
    let (mut held, mut all, mut errors) = (0, 0, Vec::new());
    for seed in 1..=8 {
        let recorded = trial(&forces, &truth, 1.0, NOISE, seed);
        let settings = Settings { prior_weight: 0.1, ..Settings::new(1.0) };
        let priors = drawn(&forces, &mut Normals::new(100 + seed));
        let problem = problem(&forces, &recorded, settings).with_priors(priors);
        let fit = problem.fit().unwrap();
        let estimates = problem.estimates(&fit).unwrap();
        for (own, truth) in estimates.parameters.iter().zip(&truth) {
            let error = (own.value - truth) / own.standard_error.unwrap();
            held += usize::from(error.abs() <= 1.96);
            all += 1;
            errors.push(format!("{} {error:.2} {:.2}", own.name, own.prior_share));
        }
    }
    let coverage = held as f64 / all as f64;
    println!("{held} of {all} intervals hold the truth");
    assert!((0.90..=0.97).contains(&coverage), "{coverage} {errors:?}");
}

#[test]
fn law_any_number_of_threads_gives_the_same_bits() {
    let forces = forces(KVLCC2);
    let recorded = trial(&forces, &forces.nominal(), 1.0, NOISE, 5);
    let settings = Settings { window_s: 20.0, ..Settings::new(1.0) };
    let problem = problem(&forces, &recorded, settings);
    let with = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| problem.fit().unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn law_bounds_hold_and_have_no_standard_error() {
    let text = KVLCC2
        .replace("prime = -0.137, value = -0.137, prior = 0.1", "prime = -0.2, bounds = [-0.25, -0.15]");
    let forces = forces(&text);
    let truth = crate::fitting::ship::forces(KVLCC2);
    let recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, 6);
    let problem = problem(&forces, &recorded, Settings::new(1.0));
    let fit = problem.fit().unwrap();
    let estimates = problem.estimates(&fit).unwrap();
    let own = estimates.parameters.iter().find(|own| own.name == "N_v").unwrap();
    assert_eq!((own.value, own.standard_error), (-0.15, None));
    assert!(estimates.parameters.iter().filter(|own| own.standard_error.is_none()).count() == 1);
}

#[test]
fn law_a_prior_weighs_as_much_at_any_rate() {
    let forces = forces(KVLCC2);
    let shares = [1.0, 0.2].map(|sample_s| {
        let recorded = trial(&forces, &forces.nominal(), sample_s, NOISE, 7);
        let problem = problem(&forces, &recorded, Settings::new(sample_s));
        let fit = problem.fit().unwrap();
        problem.estimates(&fit).unwrap().parameters.iter().map(|own| own.prior_share).collect::<Vec<_>>()
    });
    for (slow, fast) in shares[0].iter().zip(&shares[1]) {
        assert!((slow - fast).abs() < 0.1, "{slow} {fast}");
    }
}

/// The recordings of a trial, where every row of inputs acted during its whole sample, as in simulated runs.
fn held(forces: &Forces, sample_s: f64, noise: [f64; 3], seed: u64) -> Vec<Recorded> {
    let (truth, mut normals) = (forces.nominal(), Normals::new(seed));
    let mut recorded = trial(forces, &truth, sample_s, [0.0; 3], seed);
    for own in &mut recorded {
        let initial = [0, 1, 2].map(|d| own.measured[d]);
        let states = SimulatedRun { initial, inputs: &own.inputs, width: 2, sample_s }.states(forces, &truth);
        let noisy = states.iter().flat_map(|own| [0, 1, 2].map(|d| own[d] + noise[d] * normals.next()));
        own.measured = noisy.collect();
    }
    recorded
}

#[test]
fn law_fits_of_simulated_runs_are_unbiased() {
    let forces = forces(KVLCC2);
    let truth = forces.nominal();
    const TRIALS: usize = 4;
    // Mean squares over the numbers of the mean error, in its standard errors: 1 without bias.
    let square = [Inputs::Held, Inputs::Linear].map(|inputs| {
        let mut means = vec![0.0; truth.len()];
        for seed in 1..=TRIALS as u64 {
            let recorded = held(&forces, 1.0, NOISE, seed);
            let settings = Settings { prior_weight: 0.01, inputs, ..Settings::new(1.0) };
            let problem = problem(&forces, &recorded, settings);
            let fit = problem.fit().unwrap();
            let estimates = problem.estimates(&fit).unwrap();
            for ((mean, own), truth) in means.iter_mut().zip(&estimates.parameters).zip(&truth) {
                *mean += (own.value - truth) / own.standard_error.unwrap() / TRIALS as f64;
            }
        }
        means.iter().map(|mean| mean * mean * TRIALS as f64).sum::<f64>() / means.len() as f64
    });
    println!("held {:.2}, linear {:.2}", square[0], square[1]);
    assert!(square[0] < 1.6 && square[1] > 2.0 * square[0], "{square:?}");
}
