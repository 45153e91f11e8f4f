//! Accelerations of `scripts/independent/force_models.py`.

use serde_json::Value;

use crate::forces::ships::{ESSO_OSAKA, KVLCC2, MARINER, OTTER, forces};

#[test]
fn oracle_accelerations_of_published_ships_are_those_of_their_sources() {
    let all: Value =
        serde_json::from_str(include_str!("../../../../../fixtures/oracle/force_models.json")).unwrap();
    for ship in all["ships"].as_array().unwrap() {
        let name = ship["ship"].as_str().unwrap();
        let text = match name {
            "mariner" => MARINER,
            "kvlcc2-l7" => KVLCC2,
            _ => OTTER,
        };
        let forces = forces(text).unwrap();
        let body = forces.body(&forces.nominal());
        let rows: Vec<Vec<f64>> = serde_json::from_value(ship["rows"].clone()).unwrap();
        assert_eq!(rows.len(), 200, "{name}");
        let changes: Vec<&[f64]> = rows.iter().map(|row| &row[row.len() - 3..]).collect();
        // Of the size of each acceleration over all states: single ones may be 0 by chance.
        let size = |d: usize| changes.iter().map(|own| own[d].abs()).fold(0.0, f64::max);
        let sizes = [size(0), size(1), size(2)];
        for (row, expected) in rows.iter().zip(&changes) {
            let found = body.accelerations([row[0], row[1], row[2]], &row[3..row.len() - 3]);
            for d in 0..3 {
                let off = (found[d] - expected[d]).abs() / expected[d].abs().max(1e-3 * sizes[d]);
                assert!(off <= 1e-12, "{name}: {found:?} {expected:?} off by {off:e} at {row:?}");
            }
        }
    }
}

/// In the prime system of ½ρLd, of the same 3 m model: Y. Miyauchi and others, J. Marine Science and Technology 27, 2022, as their
/// group's public simulator of a ship with one propeller and one rudder has them.
const LINEAR: [(&str, f64); 4] = [("Y_v", -0.3728), ("Y_r", 0.116), ("N_v", -0.1458), ("N_r", -0.04849)];

#[test]
fn published_linear_derivatives_of_the_esso_osaka_lie_within_the_priors_of_her_preset() {
    let forces = forces(ESSO_OSAKA).unwrap();
    for (name, published) in LINEAR {
        let own = forces.parameters().iter().find(|own| own.name == name).unwrap();
        let off = (own.nominal - published) / own.prior.unwrap();
        assert!(off.abs() < 1.0, "{name}: {off} prior deviations");
    }
}
