//! Legs of the vessel of the Helsinki study.

use std::path::Path;

use trial::{Approach, Grid, Handling, Leg, Mode, Piece, Repertoire, Side, basic_legs, mirror};
use vessel::{DictionaryFile, Generator, Vessel};

const HANDLING: Handling = Handling {
    turn_rate_rad_s: 0.05,
    crawl_m_s: 0.5,
    acceleration_m_s2: 0.05,
    response_s: 30.0,
    lookahead_m: 60.0,
};
const APPROACH: Approach = Approach { run_in_s: 30.0, tolerance_m: 10.0, tolerance_rad: 0.1 };

fn study() -> (Vessel, Vec<Piece>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/helsinki");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let vessel = Vessel::from_file(toml::from_str(&text("vessel.toml")).unwrap()).unwrap();
    let dictionary: DictionaryFile = toml::from_str(&text("dictionary.toml")).unwrap();
    let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
    let piece = |q: usize| {
        let samples = generator.samples(q).unwrap();
        let realized = generator.realize(q, samples).unwrap();
        let (maneuver, speed_m_s) = (generator.maneuvers()[q].name.clone(), realized.initial[0]);
        Piece { maneuver, speed_m_s, inputs: realized.inputs, samples }.cut(None).unwrap()
    };
    let pieces = (0..generator.maneuvers().len()).map(piece).collect();
    (vessel, pieces)
}

fn grid(headings: usize) -> Grid {
    let mode = |name: &str, speed_m_s| Mode { name: name.to_owned(), speed_m_s };
    let modes = vec![mode("stop", 0.0), mode("half", 1.5), mode("ahead", 3.0)];
    Grid { nx: 44, ny: 35, headings, cell_m: 100.0, origin_m: [0.0, 0.0], modes }
}

/// Legs in still water.
fn repertoire<'a>(vessel: &'a Vessel, grid: &'a Grid, pieces: &'a [Piece]) -> Repertoire<'a> {
    Repertoire {
        vessel,
        grid,
        handling: &HANDLING,
        approach: &APPROACH,
        pieces,
        mirror: None,
        mean_current_m_s: [0.0, 0.0],
    }
}

fn legs(headings: usize, current: [f64; 2]) -> Vec<(Leg, f64, f64, f64)> {
    let (vessel, pieces) = study();
    let grid = grid(headings);
    let signs = mirror(&vessel);
    let still = repertoire(&vessel, &grid, &pieces);
    let repertoire = Repertoire { mirror: signs.as_deref(), mean_current_m_s: current, ..still };
    let mut legs = basic_legs(&grid, &HANDLING);
    for piece in 0..pieces.len() {
        legs.extend(repertoire.informative(piece).unwrap());
    }
    legs.into_iter()
        .map(|leg| {
            let (sailed, end) = repertoire.rehearse(&leg).unwrap();
            let [north, east] = grid.displacement(leg.di, leg.dj);
            let (level, _) = grid.level_and_mode(leg.to);
            let turned = (end.psi - grid.heading_rad(level)).sin().abs();
            (leg, (end.x - north).hypot(end.y - east), turned, sailed.samples.len() as f64)
        })
        .collect()
}

#[test]
fn every_leg_ends_at_its_node() {
    for headings in [4, 8, 16] {
        for (leg, off, turned, seconds) in legs(headings, [0.0, 0.0]) {
            println!(
                "{headings} {:?} {} -> {} ({}, {}): {off:.1} m {turned:.3} rad {seconds} s",
                leg.purpose, leg.from, leg.to, leg.di, leg.dj
            );
            assert!(off < 12.0 && turned < 0.12, "{leg:?}: {off} m, {turned} rad");
        }
    }
}

#[test]
fn every_basic_leg_ends_at_about_the_speed_that_its_mode_is_under_way_at() {
    let (vessel, pieces) = study();
    let grid = grid(8);
    let repertoire = repertoire(&vessel, &grid, &pieces);
    for leg in basic_legs(&grid, &HANDLING) {
        let (sailed, _) = repertoire.rehearse(&leg).unwrap();
        let (_, mode) = grid.level_and_mode(leg.to);
        let [u, v, r] = sailed.ends[0].1;
        let wanted = grid.modes[mode].speed_m_s;
        assert!(wanted == 0.0 || (u - wanted).abs() < 0.35 && v.abs() < 0.2, "{leg:?}: {u} {v} {r}");
    }
}

#[test]
fn law_errors_chain_from_leg_to_leg() {
    let (vessel, pieces) = study();
    let grid = grid(8);
    let repertoire = repertoire(&vessel, &grid, &pieces);
    let legs = repertoire.informative(0).unwrap();
    let other: Vec<f64> = vessel.nominal.iter().map(|p| 1.3 * p).collect();
    let (sailed, end) = repertoire.rehearse_with(&legs[0], &other, None).unwrap();
    let astray = repertoire.astray(&legs[0], &sailed).unwrap();
    let [north, east] = grid.displacement(legs[0].di, legs[0].dj);
    assert_eq!((astray.pose.x, astray.pose.y), (end.x - north, end.y - east));
    assert!(astray.distance_m() > 1.0, "{astray:?}");
    // The next leg begins where this one ended, as fast as it ended.
    let next = basic_legs(&grid, &HANDLING).into_iter().find(|leg| leg.from == legs[0].to).unwrap();
    let (second, _) = repertoire.rehearse_with(&next, &other, Some(&astray)).unwrap();
    assert_eq!((second.samples[0].pose, second.samples[0].state), (astray.pose, astray.state));
    let (from_node, _) = repertoire.rehearse_with(&next, &other, None).unwrap();
    assert_ne!(second.samples[0].pose, from_node.samples[0].pose);
}

#[test]
fn informative_legs_have_a_mirror_image() {
    let all = legs(8, [0.0, 0.0]);
    let count = |side: Side| all.iter().filter(|(leg, ..)| leg.purpose.side() == Some(side)).count();
    assert_eq!((count(Side::AsDesigned), count(Side::Mirrored)), (24, 24));
}
