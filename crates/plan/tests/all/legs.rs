//! Legs of the vessel of the Helsinki study.

use std::path::Path;

use maneuver::{DictionaryFile, Generator};
use plan::{
    Approach, DerivedHandling, Deviations, Grid, Handling, Mode, Repertoire, SampledVessel, Sensors, Settled,
    Side, Tolerance, mirror,
};
use ship::engine::Changes;
use ship::model::Vessel;
use trial::Piece;

use crate::handling::coaster;

const HANDLING: Handling = Handling {
    turn_rate_rad_s: 0.05,
    crawl_m_s: 0.5,
    acceleration_m_s2: 0.05,
    response_s: 30.0,
    lookahead_m: 60.0,
};
const TOLERANCE: Tolerance =
    Tolerance { distance_m: 12.0, heading_rad: 0.1, surge_m_s: 0.1, sway_m_s: 0.25, yaw_rate_rad_s: 0.0075 };
const APPROACH: Approach = Approach { run_in_s: 30.0, tolerance: TOLERANCE };

pub(crate) fn study() -> (Vessel, Vec<Piece>) {
    let (vessel, generator) = generator();
    let piece = |q: usize| {
        let samples = generator.samples(q).unwrap();
        let realized = generator.realize(q, samples).unwrap();
        let (maneuver, speed_m_s) = (generator.maneuvers()[q].name.clone(), realized.initial[0]);
        let own =
            Piece { maneuver, speed_m_s, inputs: realized.inputs, samples, longest: samples, helm: None };
        own.cut(None).unwrap()
    };
    let pieces = (0..generator.maneuvers().len()).map(piece).collect();
    (vessel, pieces)
}

/// The vessel of the study off Helsinki, and zig-zags by tables of inputs.
pub(crate) fn generator() -> (Vessel, Generator) {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = |name: &str| std::fs::read_to_string(repository.join(name)).unwrap();
    let vessel = Vessel::from_file(text("pipelines/helsinki/vessel.toml").parse().unwrap()).unwrap();
    let dictionary: DictionaryFile = text("fixtures/dictionaries/dictionary-zig-zags.toml").parse().unwrap();
    let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
    (vessel, generator)
}

pub(crate) fn grid(headings: usize) -> Grid {
    let mode = |name: &str, speed_m_s| Mode { name: name.to_owned(), speed_m_s };
    let modes = vec![mode("stop", 0.0), mode("half", 1.5), mode("ahead", 3.0)];
    Grid { nx: 44, ny: 35, headings, cell_m: 100.0, origin_m: [0.0, 0.0], modes }
}

/// Legs in a current.
pub(crate) fn repertoire<'a>(
    vessel: &'a Vessel,
    grid: &'a Grid,
    pieces: &'a [Piece],
    mirror: Option<&'a [f64]>,
    mean_current_m_s: [f64; 2],
) -> Repertoire<'a> {
    Repertoire {
        vessel,
        grid,
        handling: &HANDLING,
        approach: &APPROACH,
        pieces,
        mirror,
        mean_current_m_s,
        deviations: &Deviations::Box(0.0),
        unknown_current_m_s: 0.0,
        sensors: Sensors::default(),
        changes: Changes::default(),
        seed: 1,
    }
}

/// Vessels whose parameters are off by 30 % either way, in a current from abeam and from astern, off their node.
pub(crate) fn others(vessel: &Vessel) -> Vec<SampledVessel> {
    let other = |index: i32| {
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        let wave = |i: usize| 1.0 + 0.3 * (f64::from(index) + 2.4 * i as f64).sin();
        SampledVessel {
            parameters: vessel.nominal.iter().enumerate().map(|(i, p)| p * wave(i)).collect(),
            current_m_s: if index < 4 { [0.1 * side, 0.1] } else { [0.0, 0.15 * side] },
            off: [1.0, 2.0 * side, 0.05 * side],
            motion: [-0.05 * side, 0.1, 0.003 * side],
        }
    };
    (0..8).map(other).collect()
}

/// All legs from two neighbouring headings.
fn legs(headings: usize, current: [f64; 2], grid: &Grid, others: &[SampledVessel]) -> Vec<Settled> {
    let (vessel, pieces) = study();
    let signs = mirror(&vessel);
    let repertoire = repertoire(&vessel, grid, &pieces, signs.as_deref(), current);
    let mut legs = Vec::new();
    for level in 0..2.min(headings) {
        for mode in 0..grid.modes.len() {
            legs.extend(repertoire.basic(level, mode, others).unwrap());
        }
        for piece in 0..pieces.len() {
            legs.extend(repertoire.informative(piece, level, others).unwrap());
        }
    }
    legs.into_iter().map(|leg| leg.unwrap_or_else(|unsettled| panic!("{unsettled:?}"))).collect()
}

#[test]
fn law_every_leg_ends_settled_at_its_node_for_any_vessel() {
    let (vessel, _) = study();
    let others = others(&vessel);
    for (headings, current) in [(4, [0.0, 0.0]), (8, [0.0, 0.0]), (8, [0.2, 0.1])] {
        let grid = grid(headings);
        for Settled { leg, sailed, tracks, .. } in legs(headings, current, &grid, &others) {
            let [north, east] = grid.displacement(leg.di, leg.dj);
            let (level, mode) = grid.level_and_mode(leg.to);
            let (pose, [u, v, r]) = sailed.ends[0];
            let ends = tracks.iter().map(|track| track[track.len() - 1]).chain([pose]);
            for end in ends {
                let (off, turned) =
                    ((end.x - north).hypot(end.y - east), (end.psi - grid.heading_rad(level)).sin());
                assert!(off <= 3.0 && turned.abs() <= 0.1, "{leg:?}: {off} m, {turned} rad");
            }
            let slow = (u - grid.modes[mode].speed_m_s).abs() <= 0.1 && v.abs() <= 0.25 && r.abs() <= 0.0075;
            assert!(slow, "{leg:?}: {u} {v} {r}");
            assert_eq!(tracks.len(), others.len());
        }
    }
}

#[test]
fn law_legs_turned_by_a_quarter_are_those_of_the_next_quarter() {
    let grid = grid(4);
    let all = legs(4, [0.0, 0.0], &grid, &[]);
    let (first, second) = all.split_at(all.len() / 2);
    for (own, next) in first.iter().zip(second) {
        let turned = own.turned(1, &grid);
        assert_eq!((turned.leg.di, turned.leg.dj), (next.leg.di, next.leg.dj), "{:?}", own.leg);
        assert_eq!((turned.leg.from, turned.leg.to), (next.leg.from, next.leg.to), "{:?}", own.leg);
        assert_eq!(turned.sailed.samples.len(), next.sailed.samples.len(), "{:?}", own.leg);
        let (a, b) = (turned.sailed.ends[0].0, next.sailed.ends[0].0);
        assert!((a.x - b.x).abs() < 1e-6 && (a.y - b.y).abs() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn a_leg_that_some_do_not_settle_on_is_longer_for_their_sake() {
    let (vessel, _) = study();
    let grid = grid(8);
    let length = |others: &[SampledVessel]| {
        let all = legs(8, [0.0, 0.0], &grid, others);
        let mut first: Vec<_> =
            all.iter().filter(|own| own.leg.purpose.side() == Some(Side::AsDesigned)).collect();
        first.dedup_by(|next, own| (&next.leg.purpose, next.leg.from) == (&own.leg.purpose, own.leg.from));
        first.into_iter().map(|own| own.sailed.samples.len()).collect::<Vec<_>>()
    };
    let (alone, together) = (length(&[]), length(&others(&vessel)));
    assert!(alone.iter().zip(&together).all(|(alone, together)| alone <= together), "{alone:?} {together:?}");
    assert!(alone.iter().sum::<usize>() + 60 < together.iter().sum(), "{alone:?} {together:?}");
}

#[test]
fn informative_legs_have_a_mirror_image() {
    let all = legs(8, [0.0, 0.0], &grid(8), &[]);
    let count = |side: Side| all.iter().filter(|own| own.leg.purpose.side() == Some(side)).count();
    // Of each of three maneuvers from two headings, the first recovery and at most twelve further ones.
    assert_eq!((count(Side::AsDesigned), count(Side::Mirrored)), (69, 69));
}

#[test]
fn law_recoveries_of_a_maneuver_differ_in_their_lane_and_each_is_for_every_end_of_it() {
    let (vessel, _) = study();
    let (others, grid) = (others(&vessel), grid(8));
    let all = legs(8, [0.2, 0.1], &grid, &others);
    let lane = |own: &Settled| {
        let (level, _) = grid.level_and_mode(own.leg.to);
        let (di, dj) = grid.step_along(level);
        (level, own.leg.di * dj - own.leg.dj * di)
    };
    let maneuvers: Vec<&Settled> = all.iter().filter(|own| own.leg.purpose.side().is_some()).collect();
    let of_one = |a: &&Settled, b: &&Settled| (&a.leg.purpose, a.leg.from) == (&b.leg.purpose, b.leg.from);
    let mut further = 0;
    for recoveries in maneuvers.chunk_by(of_one) {
        further += recoveries.len() - 1;
        let first = recoveries[0];
        let done = first.sailed.samples.iter().rposition(|sample| sample.informative).unwrap();
        for (k, own) in recoveries.iter().enumerate() {
            assert!(recoveries[..k].iter().all(|before| lane(before) != lane(own)), "{:?}", own.leg);
            // The approach and the maneuver are the same, for each of the same vessels.
            assert_eq!(own.sailed.samples[..=done], first.sailed.samples[..=done]);
            assert_eq!(own.tracks.len(), others.len());
            for (track, same) in own.tracks.iter().zip(&first.tracks) {
                assert_eq!(track[..=done], same[..=done]);
                let end = track[track.len() - 1];
                let [north, east] = grid.displacement(own.leg.di, own.leg.dj);
                assert!((end.x - north).hypot(end.y - east) <= 12.0, "{:?}: {end:?}", own.leg);
            }
        }
    }
    assert!(further > 5, "{further}");
}

#[test]
fn law_no_input_of_a_leg_changes_faster_than_its_actuator_and_legs_still_end_settled() {
    let vessel = coaster("range = [-400.0, 1200.0]\nlag_s = 6.0", "lag_s = 2.0\nrate_per_s = 0.05");
    let modes =
        [("slow", 2.5), ("fast", 4.0)].map(|(name, speed_m_s)| Mode { name: name.to_owned(), speed_m_s });
    let handling = DerivedHandling::of(&vessel, &modes, 60.0).unwrap().handling;
    let grid = Grid { modes: modes.to_vec(), cell_m: 250.0, ..grid(8) };
    let tolerance = Tolerance { distance_m: 25.0, yaw_rate_rad_s: 0.0018, ..TOLERANCE };
    let approach = Approach { tolerance, ..APPROACH };
    let mirror = mirror(&vessel);
    // The rudder goes over at once, as commands do.
    let inputs: Vec<f64> = (0..240).flat_map(|k| [250.0, if k / 60 % 2 == 0 { 0.3 } else { -0.3 }]).collect();
    let (maneuver, speed_m_s) = ("zig-zag".to_owned(), 4.0);
    let piece = Piece { maneuver, speed_m_s, samples: 240, longest: 240, inputs, helm: None };
    let repertoire = Repertoire {
        handling: &handling,
        approach: &approach,
        ..repertoire(&vessel, &grid, std::slice::from_ref(&piece), mirror.as_deref(), [0.0; 2])
    };
    let mut legs = repertoire.informative(0, 0, &[]).unwrap();
    (0..2).for_each(|mode| legs.extend(repertoire.basic(0, mode, &[]).unwrap()));
    assert!(legs.len() >= 2 + 2 * 4);
    for leg in legs {
        let Settled { leg, sailed, .. } = leg.unwrap_or_else(|unsettled| panic!("{unsettled:?}"));
        for pair in sailed.samples.windows(2) {
            let turned = (pair[1].inputs[1] - pair[0].inputs[1]).abs();
            assert!(turned <= 0.05 + 1e-12, "{:?}: {turned}", leg.purpose);
        }
    }
}
