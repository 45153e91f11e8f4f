//! Bands and intervals of ships with forces, from the covariance of their fits to simulated runs.

use std::collections::BTreeMap;

use estimation::fitting::{Inputs, Prior, Problem, RecordingView, Settings};
use estimation::pooled::{Covariance, Uncertain};
use maneuver::{DictionaryFile, Generator};
use regression::pooled::PooledRuns;
use ship::engine::{Run, Streams, simulate_command, simulate_one};
use ship::model::{Vessel, VesselFile};
use validation::comparison::{
    CompareOptions, Compared, Contestant, EstimatedErrors, Ship, Standing, compare,
};
use validation::merit::Merit;

const RATE_HZ: f64 = 2.0;
const NOISE: [f64; 3] = [0.005, 0.005, 0.0005];

/// The tanker KVLCC2.
fn tanker() -> Vessel {
    let text = format!("preset = \"kvlcc2-l7\"\nsample_rate_hz = {RATE_HZ:?}\n");
    Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap()
}

fn zigzag((degrees, n): (f64, f64)) -> String {
    format!(
        "[[maneuver]]\nname = \"z{degrees}\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.1\nto = \"starboard\"\n\
         helm = {{ delta = {0} }}\nheading_rad = {0}\nduration_s = 200.0\napproach = {{ n = {n:?} }}\n",
        degrees.to_radians()
    )
}

fn circle((degrees, to): (f64, &str)) -> String {
    format!(
        "[[maneuver]]\nname = \"{to}\"\nkind = \"turning-circle\"\nspeed_m_s = 1.1\nto = \"{to}\"\n\
         helm = {{ delta = {} }}\nduration_s = 250.0\napproach = {{ n = 11.0 }}\n",
        degrees.to_radians()
    )
}

fn fitted_to() -> String {
    [(5.0, 9.5), (12.0, 10.5), (25.0, 11.0), (35.0, 11.5)].map(zigzag).concat() + &circle((25.0, "port"))
}

fn others() -> String {
    [(10.0, 11.0), (20.0, 11.0)].map(zigzag).concat() + &circle((35.0, "starboard"))
}

fn generator(vessel: &Vessel, text: &str) -> Generator {
    let dictionary: DictionaryFile = text.parse().unwrap();
    Generator::new(vessel, &dictionary, |name| panic!("{name}")).unwrap()
}

/// Every maneuver of `text` once, with noise of the measured states.
fn trial(vessel: &Vessel, text: &str, streams: &Streams) -> Vec<Run> {
    let (generator, truth) = (generator(vessel, text), vessel.nominal.as_slice());
    let run = |index: usize| {
        let samples = generator.samples(index).unwrap();
        let realized = generator.realize(index, samples).unwrap();
        let helm = realized.helm.as_ref().unwrap();
        let found = simulate_command(&vessel.model, truth, realized.initial, samples, RATE_HZ, helm);
        let mut normals = vec![0.0; found.states.len()];
        streams.normals(index as u32, 0, &mut normals);
        let noisy = found.states.iter().zip(normals).enumerate();
        let measured: Vec<f64> = noisy.map(|(i, (state, z))| state + NOISE[i % 3] * z).collect();
        Run {
            design: "simulated".to_owned(),
            run: index as i32,
            segments: Vec::new(),
            exogenous: found.exogenous,
            instrument_exogenous: Vec::new(),
            initial: [measured[0], measured[1], measured[2]],
            measured,
        }
    };
    (0..generator.maneuvers().len()).map(run).collect()
}

fn recording(run: &Run) -> RecordingView<'_> {
    RecordingView { name: "", inputs: &run.exogenous, measured: &run.measured }
}

/// A ship that was fitted to runs.
struct Fitted {
    vessel: Vessel,
    covariance: Covariance,
    rmse: [f64; 3],
}

/// The fit to a trial of its own, with priors that are off the truth by as much as they may be.
fn fitted(truth: &Vessel, seed: u64) -> Fitted {
    let streams = Streams::new(seed, "fitted");
    let runs = trial(truth, &fitted_to(), &streams);
    let forces = &truth.model.forces.as_ref().unwrap().forces;
    let settings =
        Settings { inputs: Inputs::Held, prior_weight: 0.1, ..Settings::new(1.0 / truth.sample_rate_hz) };
    let mut off = vec![0.0; truth.nominal.len()];
    streams.normals(1000, 0, &mut off);
    let prior = |(own, z): (&ship::forces::Parameter, &f64)| {
        own.prior.map(|deviation| Prior { mean: own.nominal + z * deviation, deviation })
    };
    let priors = forces.parameters().iter().zip(&off).map(prior).collect();
    let width = truth.model.exogenous();
    let problem = Problem::new(forces, runs.iter().map(recording).collect(), width, settings).unwrap();
    let problem = problem.with_priors(priors);
    let fit = problem.fit().unwrap();
    let estimates = problem.estimates(&fit).unwrap();
    let names = estimates.parameters.iter().map(|own| own.name.clone()).collect();
    let (mut squares, mut samples) = ([0.0; 3], 0.0);
    for run in &runs {
        let states = simulate_one(&truth.model, &fit.theta, run.initial, &run.exogenous);
        for (i, (own, measured)) in states.iter().zip(&run.measured).enumerate().skip(3) {
            squares[i % 3] += (own - measured).powi(2);
        }
        samples += run.samples() as f64;
    }
    Fitted {
        covariance: Covariance { joint: true, names, entries: estimates.covariance.clone(), parts: None },
        rmse: squares.map(|sum: f64| (sum / samples).sqrt()),
        vessel: Vessel {
            value: fit.theta.iter().map(|own| Some(*own)).collect(),
            nominal: fit.theta,
            ..truth.clone()
        },
    }
}

fn compared(own: &Fitted, known: bool, runs: Vec<Run>) -> Compared {
    let ship = Ship { model: &own.vessel.model, theta: &own.vessel.nominal, columns: None };
    let known: &[EstimatedErrors] =
        &[EstimatedErrors { covariance: Some(&own.covariance), rmse: own.rmse }][..usize::from(known)];
    let options = CompareOptions {
        vessel: "",
        window: Some(200),
        known,
        covered: &[],
        magnitudes: None,
        rate_hz: RATE_HZ,
    };
    let runs = PooledRuns::new(runs, &BTreeMap::new()).with_inputs_held(true);
    let contestant = Contestant { standing: Standing::Model, place: None, ships: vec![ship] };
    compare(&[contestant], &runs, &options).unwrap().0
}

#[test]
fn law_bands_of_forces_hold_most_samples_of_other_maneuvers() {
    let truth = tanker();
    let mut inside = [0.0; 3];
    const TRIALS: u64 = 8;
    for seed in 1..=TRIALS {
        let runs = trial(&truth, &others(), &Streams::new(seed, "others"));
        let bands = compared(&fitted(&truth, seed), true, runs).bands.unwrap();
        for (sum, own) in inside.iter_mut().zip([bands.inside_u, bands.inside_v, bands.inside_r]) {
            *sum += own / TRIALS as f64;
        }
    }
    println!("{inside:?} of the samples lie inside");
    // Yaw errs less in these maneuvers than in those that the ship was fitted to, so its band is wide.
    let mean = inside.iter().sum::<f64>() / 3.0;
    assert!((0.90..=0.97).contains(&mean) && inside.iter().all(|own| *own >= 0.90), "{inside:?}");
}

/// Figures whose intervals were found to hold the truth in some 59 % of trials, 176 of 300: draws of a ship that is unstable on
/// course overshoot more, and take longer, than the ship.
const LESS_SURE: [&str; 5] = ["check_time_1", "check_time_2", "nomoto_time", "overshoot_2", "period"];

#[test]
fn law_intervals_of_figures_hold_the_truth() {
    let truth = tanker();
    let length_m = 7.0;
    let figures = |vessel: &Vessel, uncertain: Option<&Uncertain>, seed: u64| {
        let generator = generator(vessel, &others());
        let mut merit = Merit::new(vessel, Some(&generator), length_m).unwrap();
        match uncertain {
            Some(uncertain) => merit.simulate_drawn(uncertain, 100, seed),
            None => merit.simulate(&vessel.nominal, 0).unwrap(),
        }
        merit.summary(uncertain.is_some()).unwrap()
    };
    let true_figures = figures(&truth, None, 0);
    let mut counted: BTreeMap<String, [u32; 2]> = BTreeMap::new();
    for seed in 1..=30 {
        let own = fitted(&truth, seed);
        let uncertain = Uncertain::new(&own.vessel, own.vessel.nominal.clone(), &own.covariance).unwrap();
        for (own, truth) in figures(&own.vessel, Some(&uncertain), seed).iter().zip(&true_figures) {
            for figure in &own.figures {
                let truth = truth.figures.iter().find(|own| own.name == figure.name).unwrap().value;
                let [held, all] = counted.entry(figure.name.clone()).or_default();
                *held += u32::from((figure.low.unwrap()..=figure.high.unwrap()).contains(&truth));
                *all += 1;
            }
        }
    }
    println!("intervals of figures that hold the truth, of how many: {counted:?}");
    let (less, sure): (Vec<_>, Vec<_>) =
        counted.iter().partition(|(name, _)| LESS_SURE.contains(&name.as_str()));
    assert!(sure.iter().all(|(_, [held, all])| 10 * held >= 9 * all), "{sure:?}");
    let [held, all] = less.iter().fold([0, 0], |[held, all], (_, own)| [held + own[0], all + own[1]]);
    assert!((50..=70).contains(&(100 * held / all)), "{less:?}");
}

#[test]
fn law_one_step_residuals_of_forces_are_noise_where_the_ship_is_known() {
    let truth = tanker();
    let own = Fitted {
        covariance: Covariance { joint: true, names: Vec::new(), entries: Vec::new(), parts: None },
        rmse: [0.0; 3],
        vessel: truth.clone(),
    };
    let runs = trial(&truth, &others(), &Streams::new(1, "others"));
    let found = compared(&own, false, runs);
    assert_eq!(found.bands, None);
    // What noise of the one sample and of the next one makes of a residual correlates by about −½ in neighbours.
    for own in &found.correlations[..3] {
        assert!((own.own[0] + 0.5).abs() < 0.1, "{} {:?}", own.state, &own.own[..3]);
        assert!(own.own[1].abs() < 3.0 * own.bound, "{} {:?}", own.state, &own.own[..3]);
    }
}
