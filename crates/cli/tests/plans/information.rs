//! The information of the planned track, summed again from its rows.

use approx::assert_relative_eq;

use crate::fleet::{Ship, Sums, Three};
use crate::planned::*;
use crate::support::craft;

fn all() -> [&'static Planned; 3] {
    let [eight, four] = helsinki_planned();
    [eight, four, small_planned()]
}

#[test]
fn oracle_realised_information_is_that_of_the_maneuvers_in_the_track() {
    for planned in all() {
        let (track, ship) = (&planned.track, Ship::new(planned.text("vessel.toml"), "nominal"));
        let mut sums = Sums::new();
        for stretch in track.stretches() {
            sums.add(&ship, &track.state[stretch.clone()], &track.inputs[stretch], 1.0);
        }
        let told = planned.number("/voyage/information/realised_log_det");
        assert_relative_eq!(told, sums.log_det(), max_relative = 1e-6);
        assert_eq!(planned.number("/voyage/information/dimension"), sums.dimension() as f64);
    }
}

#[test]
fn oracle_the_whole_tracks_information() {
    for planned in all() {
        let (track, ship) = (&planned.track, Ship::new(planned.text("vessel.toml"), "nominal"));
        let mut sums = Sums::new();
        sums.add(&ship, &track.state, &track.inputs, 1.0);
        let told = planned.number("/voyage/information/whole_log_det");
        assert_relative_eq!(told, sums.log_det(), max_relative = 1e-6);
    }
}

/// Speed and inputs of a maneuver of the dictionary.
fn maneuver(name: &str) -> (f64, Vec<Three>) {
    let folder = small();
    let dictionary = craft::read(&folder.path().join("dictionary.parquet"), "trajectories");
    let place = |name: &str| dictionary.schema.columns.iter().position(|c| c.name == name).unwrap();
    let mut found = (f64::NAN, Vec::new());
    for block in &dictionary.blocks {
        for row in 0..block.columns[0].len() {
            let value = |name: &str| block.columns[place(name)].value_at(row);
            if block.columns[place("maneuver")].text_at(row) != Some(name) {
                continue;
            }
            if found.1.is_empty() {
                found.0 = value("u").unwrap();
            }
            if let Some(tau1) = value("tau1") {
                found.1.push([tau1, value("tau2").unwrap(), value("tau3").unwrap()]);
            }
        }
    }
    found
}

#[test]
fn oracle_predicted_information_adds_up_pieces_of_the_dictionary() {
    let planned = small_planned();
    let ship = Ship::new(planned.text("vessel.toml"), "nominal");
    let mut sums = Sums::new();
    for (name, count) in planned.plan["counts"].as_object().unwrap() {
        let (speed, inputs) = maneuver(name);
        let states = ship.simulate([speed, 0.0, 0.0], &inputs);
        sums.add(&ship, &states, &inputs, count.as_f64().unwrap());
    }
    let told = |key: &str| planned.number(&format!("/voyage/information/{key}"));
    // The segments alone hardly excite surge: the determinant loses digits.
    assert_relative_eq!(told("predicted_log_det"), sums.log_det(), max_relative = 1e-5);
    let efficiency = ((told("realised_log_det") - sums.log_det()) / 13.0).exp();
    assert_relative_eq!(told("efficiency"), efficiency, max_relative = 1e-5);
    let front = planned.voyage()["front"].as_array().unwrap().last().unwrap();
    assert_relative_eq!(front["log_det"].as_f64().unwrap(), sums.log_det(), max_relative = 1e-5);
}

#[test]
fn law_maneuvers_are_run_as_in_the_dictionary_or_to_the_other_side() {
    let planned = small_planned();
    let informative = planned.legs().iter().filter(|leg| leg["informative"] == true);
    for (stretch, leg) in planned.track.stretches().into_iter().zip(informative) {
        let sign = if leg["side"] == "mirrored" { -1.0 } else { 1.0 };
        let (_, inputs) = maneuver(&planned.track.maneuver[stretch.start]);
        let own = inputs.iter().map(|[a, b, c]| [*a, sign * b, sign * c]);
        assert!(own.eq(planned.track.inputs[stretch.clone()].iter().copied()), "{leg}");
    }
}
