//! The range of validity: magnitudes of motions.

use std::collections::BTreeMap;

use regression::pooled::PooledRuns;
use ship::engine::Run;
use ship::model::{Model, Vessel};
use validation::comparison::{Magnitudes, STRETCH_S, Validity};

/// Samples of a stretch at one sample per second.
const STRETCH: usize = STRETCH_S as usize;

fn model() -> Model {
    Vessel::preset("ljungberg-model-ship").unwrap().model
}

/// A run of `samples` samples whose channels are `value` of sample and channel.
fn run(model: &Model, number: i32, samples: usize, value: impl Fn(usize, usize) -> f64) -> Run {
    let width = model.exogenous();
    let rows = |rows: usize, from: usize, count: usize| {
        (0..rows).flat_map(|k| (0..count).map(move |i| (k, from + i))).map(|(k, i)| value(k, i)).collect()
    };
    Run {
        design: "measured".to_owned(),
        run: number,
        segments: Vec::new(),
        measured: rows(samples + 1, 0, 3),
        instrument_exogenous: Vec::new(),
        exogenous: rows(samples, 3, width),
        initial: [0.0; 3],
    }
}

fn magnitudes(model: &Model, runs: &[Run]) -> Magnitudes {
    let Ok(found) = Magnitudes::of(model, &PooledRuns::new(runs.to_vec(), &BTreeMap::new()), 1.0);
    found.unwrap()
}

fn validity(known: &Magnitudes, runs: &[Run]) -> Validity {
    Validity::of(known, runs.iter().map(Run::view), 1.0).unwrap()
}

fn swinging(model: &Model, number: i32, size: f64) -> Run {
    run(model, number, 3 * STRETCH + 7, |k, i| size * (0.3 * k as f64 + i as f64).sin())
}

#[test]
fn law_data_are_inside_their_own_range_and_motion_of_another_size_is_not() {
    let model = model();
    let all = [swinging(&model, 0, 1.0), swinging(&model, 1, 1.5)];
    let known = magnitudes(&model, &all);
    assert_eq!((known.stretches, known.channels.len()), (6, model.variables.len()));
    // The root mean square of a sine is its amplitude over √2, for any phase.
    for channel in &known.channels {
        assert!((channel.low * 2.0_f64.sqrt() - 1.0).abs() < 0.03, "{channel:?}");
        assert!((channel.high * 2.0_f64.sqrt() - 1.5).abs() < 0.03, "{channel:?}");
    }
    let own = validity(&known, &all);
    assert_eq!((own.outside, own.stretches, own.statement()), (0, 6, None));
    // Smaller motion stays inside the ranges of all channels, but is smaller than all that was fitted.
    let smaller = validity(&known, &[swinging(&model, 2, 0.3)]);
    assert_eq!((smaller.outside, smaller.stretches), (3, 3));
    assert!(smaller.channels.iter().all(|channel| (channel.below, channel.above) == (3, 0)));
    let said = smaller.statement().unwrap();
    assert!(said.starts_with("outside the range of validity in 3 of 3 stretches of 60 s"), "{said}");
    let larger = validity(&known, &[swinging(&model, 3, 3.0)]);
    assert!(larger.channels.iter().all(|channel| (channel.below, channel.above) == (0, 3)));
    let both = Validity::together(Some(smaller), Some(larger)).unwrap();
    assert_eq!((both.outside, both.stretches, both.channels[0].below, both.channels[0].above), (6, 6, 3, 3));
}

#[test]
fn runs_shorter_than_a_stretch_say_nothing() {
    let model = model();
    let short = run(&model, 0, STRETCH - 1, |_, _| 1.0);
    let Ok(none) = Magnitudes::of(&model, &PooledRuns::new(vec![short.clone()], &BTreeMap::new()), 1.0);
    assert_eq!(none, None);
    let known = magnitudes(&model, &[swinging(&model, 1, 1.0)]);
    assert_eq!(Validity::of(&known, [short.view()].into_iter(), 1.0), None);
}

/// A pseudo-random number between 0 and 1 for each index.
fn scattered(place: u64) -> f64 {
    let mut x = place.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (x ^ (x >> 31)) as f64 / u64::MAX as f64
}

#[test]
fn law_a_stretch_like_n_others_is_outside_of_them_twice_in_n_plus_one() {
    let (model, n, tries) = (model(), 9, 300);
    let noise = |number: usize, stretches: usize| {
        run(&model, number as i32, stretches * STRETCH, |k, i| {
            scattered(((number * 10_000 + k) * 16 + i) as u64)
        })
    };
    let mut outside = 0;
    for i in 0..tries {
        let known = magnitudes(&model, &[noise(2 * i, n)]);
        let found = validity(&known, &[noise(2 * i + 1, 1)]);
        outside += found.channels.iter().map(|channel| channel.below + channel.above).sum::<u64>();
    }
    let trials = (tries * model.variables.len()) as f64;
    let (share, expected) = (outside as f64 / trials, 2.0 / (n as f64 + 1.0));
    let spread = (expected * (1.0 - expected) / trials).sqrt();
    assert!((share - expected).abs() < 4.0 * spread, "{share} instead of {expected} ± {spread}");
}
