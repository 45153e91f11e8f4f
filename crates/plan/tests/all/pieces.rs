//! Pieces of maneuvers, and their mirror images.

use plan::mirror;
use ship::model::Vessel;
use trial::{Piece, period};

fn swing(samples: usize, period: f64) -> Vec<f64> {
    (0..samples).map(|k| (std::f64::consts::TAU * k as f64 / period).sin()).collect()
}

fn piece(inputs: &[f64]) -> Piece {
    Piece {
        maneuver: "turn".into(),
        speed_m_s: 1.0,
        inputs: inputs.to_vec(),
        samples: inputs.len(),
        longest: inputs.len(),
        helm: None,
    }
}

#[test]
fn swings_are_cut_at_whole_periods() {
    assert_eq!(period(&swing(300, 80.0), 1), Some(80));
    assert_eq!(piece(&swing(300, 80.0)).cut(Some(130)).unwrap().samples, 160);
    assert_eq!(piece(&swing(300, 80.0)).cut(None).unwrap().samples, 300);
}

#[test]
fn sweeps_and_steps_are_cut_at_the_target() {
    let sweep: Vec<f64> = (0..300).map(f64::from).collect();
    assert_eq!(piece(&sweep).cut(Some(130)).unwrap().samples, 130);
    assert_eq!(piece(&[2.0; 300]).cut(Some(70)).unwrap().samples, 70);
    let error = piece(&sweep).cut(Some(301)).unwrap_err();
    assert!(error.to_string().contains("1 to 300"), "{error}");
}

#[test]
fn the_papers_ship_is_mirrored_by_turning_sway_force_and_yaw_moment_round() {
    let file = "preset = \"ljungberg-model-ship\"".parse().unwrap();
    let vessel = Vessel::from_file(file).unwrap();
    assert_eq!(mirror(&vessel), Some(vec![1.0, -1.0, -1.0]));
}

#[test]
fn law_the_mirror_image_of_a_piece_may_be_beyond_a_one_sided_range() {
    let mut vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let turn = Piece { samples: 2, ..piece(&[500.0, 20.0, 300.0, 500.0, -10.0, 250.0]) };
    let is_within = |vessel: &Vessel| turn.is_mirrored_within(vessel, &[1.0, -1.0, -1.0]);
    assert!(is_within(&vessel));
    vessel.actuators[0].range = Some([0.0, 5978.1]);
    assert!(is_within(&vessel));
    vessel.actuators[2].range = Some([-260.0, 600.0]);
    assert!(!is_within(&vessel));
}
