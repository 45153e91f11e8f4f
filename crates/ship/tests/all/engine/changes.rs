//! Currents and gusts that change while a ship sails.

use refusal::check_bounds;
use ship::engine::{Changes, Changing, ChangingCurrent, Pose, Ship, Streams, Wind};
use ship::model::{Source, Vessel};

const RATE_HZ: f64 = 2.0;

fn changes(gust_s: Option<f64>) -> Changes {
    let wind =
        Wind { std_surge_m_s2: 0.02, std_sway_m_s2: 0.05, std_yaw_rad_s2: 0.001, time_constant_s: gust_s };
    Changes { current: Some(ChangingCurrent { std_m_s: 0.1, time_constant_s: 20.0 }), wind: Some(wind) }
}

fn of_run(changes: Changes, run: u32) -> Changing {
    changes.of_run(Streams::new(3, "changes"), run, RATE_HZ).unwrap()
}

/// Mean square, and mean product with the value `lag` samples later.
fn moments(values: &[f64], lag: usize) -> [f64; 2] {
    let mean = |lag: usize| {
        let products = values.iter().zip(&values[lag..]).map(|(a, b)| a * b);
        products.sum::<f64>() / (values.len() - lag) as f64
    };
    [mean(0), mean(lag)]
}

#[test]
fn law_changes_have_their_deviations_and_fade_with_their_time_constants() {
    let all: Vec<_> = of_run(changes(Some(5.0)), 0).take(400_000).collect();
    let columns: [(Vec<f64>, f64, f64); 5] = [
        (all.iter().map(|own| own.0[0]).collect(), 0.1, 20.0),
        (all.iter().map(|own| own.0[1]).collect(), 0.1, 20.0),
        (all.iter().map(|own| own.1[0]).collect(), 0.02 / RATE_HZ, 5.0),
        (all.iter().map(|own| own.1[1]).collect(), 0.05 / RATE_HZ, 5.0),
        (all.iter().map(|own| own.1[2]).collect(), 0.001 / RATE_HZ, 5.0),
    ];
    for (values, std, time_s) in columns {
        // Over one time constant.
        let [square, product] = moments(&values, (time_s * RATE_HZ) as usize);
        assert!((square / (std * std) - 1.0).abs() < 0.05, "{square} {std}");
        assert!((product / square - (-1.0_f64).exp()).abs() < 0.05, "{product} {square}");
    }
    assert!(Changes::default().of_run(Streams::new(3, "changes"), 0, RATE_HZ).is_none());
}

#[test]
fn law_a_wind_without_a_time_constant_stays_as_a_run_drew_it_and_runs_differ() {
    let first: Vec<_> = of_run(changes(None), 0).take(300).collect();
    assert!(first.iter().all(|own| own.1 == first[0].1));
    assert_ne!(first[0].0, first[299].0);
    let drawn: Vec<f64> = (0..4000).map(|run| of_run(changes(None), run).next().unwrap().1[1]).collect();
    let [square, next] = moments(&drawn, 1);
    assert!((square.sqrt() / (0.05 / RATE_HZ) - 1.0).abs() < 0.05, "{square}");
    assert!((next / square).abs() < 0.06, "{next}");
}

#[test]
fn oracle_a_ship_in_changes_is_stepped_by_hand() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let parameters = vessel.parameters(Source::Value).unwrap();
    let pose = Pose { x: 0.0, y: 0.0, psi: 0.7 };
    let mut ship = Ship::new(&vessel, &parameters, pose, 0.8);
    ship.current_m_s = [0.1, -0.05];
    ship.changing = Some(of_run(changes(Some(5.0)), 7));
    // The same ship, put into every current anew, and pushed after every sample.
    let mut by_hand = Ship::new(&vessel, &parameters, pose, 0.8);
    let inputs = [4000.0, 0.0, 100.0];
    for (current, push) in of_run(changes(Some(5.0)), 7).take(40) {
        ship.step(&inputs[..vessel.model.inputs]);
        by_hand.current_m_s = [0.1 + current[0], -0.05 + current[1]];
        by_hand.step(&inputs[..vessel.model.inputs]);
        by_hand.state = [0, 1, 2].map(|d| by_hand.state[d] + push[d]);
        for (own, other) in ship.state.iter().zip(by_hand.state) {
            assert!((own - other).abs() < 1e-12, "{own} {other}");
        }
        assert!((ship.pose.x - by_hand.pose.x).hypot(ship.pose.y - by_hand.pose.y) < 1e-12);
    }
}

#[test]
fn changes_without_meaning_are_refused_by_their_key() {
    let current = |std_m_s: f64, time_constant_s: f64| {
        check_bounds(&ChangingCurrent { std_m_s, time_constant_s }).map_err(|e| e.to_string())
    };
    let wind = |gust_s| check_bounds(&changes(gust_s).wind.unwrap()).map_err(|e| e.to_string());
    for (refused, key) in [
        (current(20.0, 5.0), "`std_m_s`"),
        (current(f64::NAN, 5.0), "`std_m_s`"),
        (current(0.1, 0.0), "`time_constant_s`"),
        (wind(Some(-1.0)), "`time_constant_s`"),
    ] {
        let said = refused.unwrap_err();
        assert!(said.contains(key), "{said}");
    }
    assert_eq!((current(0.1, 20.0), wind(None)), (Ok(()), Ok(())));
}
