//! Recordings that are drawn, and dealt into folds.

use estimation::search::{Cut, Recording, draw_again, draw_most, folds, folds_of_drawn};
use regression::pooled::Part;
use ship::engine::Streams;

/// A recording of so many samples.
fn recording(name: String, samples: usize) -> Recording {
    let part = Part {
        label: String::new(),
        source: String::new(),
        measured: vec![0.0; 3 * (samples + 1)],
        instrument_exogenous: Vec::new(),
        exogenous: vec![0.0; samples],
    };
    Recording::new(name, vec![part], Cut { window: 10, every: 5, scored: None })
}

#[test]
fn law_as_many_of_each_kind_are_drawn_each_as_often_and_doubles_share_a_fold() {
    let names = (0..4).map(|i| format!("turn{i}")).chain((0..8).map(|i| format!("zigzag{i}")));
    let all: Vec<Recording> = names.enumerate().map(|(i, name)| recording(name, 10 + i)).collect();
    let streams = Streams::new(3, "bootstrap");
    let mut seen = [0; 12];
    for number in 0..600 {
        let drawn = draw_again(&all, &streams, number);
        assert_eq!((drawn.len(), drawn.iter().filter(|i| **i < 4).count()), (12, 4));
        drawn.iter().for_each(|i| seen[*i] += 1);
        let folds = folds_of_drawn(&all, &drawn, 6);
        let pairs = drawn.windows(2).zip(folds.windows(2));
        assert!(pairs.into_iter().all(|(places, folds)| places[0] != places[1] || folds[0] == folds[1]));
        let distinct = drawn.chunk_by(|a, b| a == b).count();
        assert_eq!(folds.iter().max().unwrap() + 1, 6.min(distinct));
    }
    // 600 each, within four standard deviations.
    assert!(seen.iter().all(|n| (500..=700).contains(n)), "{seen:?}");
    assert_eq!(draw_again(&all, &streams, 7), draw_again(&all, &streams, 7));
    assert_ne!(draw_again(&all, &streams, 7), draw_again(&all, &streams, 8));
}

#[test]
fn law_folds_have_some_of_every_kind_and_are_about_as_long() {
    let lengths = [("turn", [90, 20, 60, 30, 80, 40]), ("zigzag", [50, 10, 40, 20, 30, 70])];
    let all: Vec<Recording> = lengths
        .iter()
        .flat_map(|(kind, lengths)| lengths.iter().enumerate().map(move |(i, n)| (format!("{kind}_{i}"), *n)))
        .map(|(name, samples)| recording(name, samples))
        .collect();
    let found = folds(&all.iter().collect::<Vec<_>>(), 3);
    let of = |fold: usize| all.iter().zip(&found).filter(move |(_, own)| **own == fold).map(|(r, _)| r);
    for fold in 0..3 {
        let kinds = |kind: &str| of(fold).filter(|r| r.kind() == kind).count();
        assert_eq!([kinds("turn"), kinds("zigzag")], [2, 2]);
        // A third of all is 180.
        let samples: usize = of(fold).map(Recording::samples).sum();
        assert!((160..=200).contains(&samples), "{samples} in fold {fold}: {found:?}");
    }
}

#[test]
fn law_seven_tenths_of_each_kind_are_drawn_and_every_recording_as_often() {
    let all: Vec<Recording> = (0..10)
        .map(|i| recording(format!("turning{i:02}"), 1))
        .chain((0..13).map(|i| recording(format!("zigzag{i:02}"), 1)))
        .collect();
    let all: Vec<&Recording> = all.iter().collect();
    let streams = Streams::new(5, "average");
    let mut seen = [0; 23];
    for number in 0..400 {
        let drawn = draw_most(&all, &streams, number);
        let turning = drawn.iter().filter(|own| own.kind() == "turning").count();
        assert_eq!(drawn.len(), 16);
        assert!((6..=7).contains(&turning), "{turning}");
        assert!(drawn.windows(2).all(|pair| pair[0].name < pair[1].name || pair[0].kind() != pair[1].kind()));
        let place = |own: &&Recording| all.iter().position(|other| other.name == own.name).unwrap();
        drawn.iter().for_each(|own| seen[place(own)] += 1);
    }
    // 278 each, within four standard deviations.
    assert!(seen.iter().all(|n| (240..=316).contains(n)), "{seen:?}");
    let again = draw_most(&all, &streams, 7);
    assert!(again.iter().zip(draw_most(&all, &streams, 7)).all(|(a, b)| a.name == b.name));
    assert!(again.iter().zip(draw_most(&all, &streams, 8)).any(|(a, b)| a.name != b.name));
}
