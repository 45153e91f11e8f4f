//! Times of the rows of tables of inputs.

use maneuver::{InputTable, Resampling};
use refusal::Invalid;
use ship::model::Vessel;

/// A table of the preset's three inputs, which change evenly with the time.
fn table(t: impl IntoIterator<Item = f64>) -> Result<InputTable, Invalid> {
    let model = Vessel::preset("ljungberg-model-ship").unwrap().model;
    let header = format!("t,{}\n", model.input_names().join(","));
    let row = |t: f64| format!("{t},{},{},0\n", 2.0 * (t - 5.0), 6.0 - t);
    InputTable::parse(&(header + &t.into_iter().map(row).collect::<String>()), &model)
}

#[test]
fn law_resampling_follows_straight_lines_at_any_rates() {
    for (step, rate_hz) in [(1.0, 10.0), (0.1, 10.0), (0.1, 1.0), (0.25, 7.0), (1.0 / 3.0, 3.0)] {
        let table = table((0..40).map(|k| 5.0 + f64::from(k) * step)).unwrap();
        let (played, pace) = table.played(3, rate_hz, true).unwrap();
        let Resampling::Resampled(found_hz) = pace else { panic!("{pace:?}") };
        assert!((found_hz * step - 1.0).abs() < 1e-9, "{found_hz} {step}");
        assert_eq!(played.len() / 3, (39.0 * step * rate_hz + 1e-6) as usize + 1);
        for (k, row) in played.chunks(3).enumerate() {
            let t = k as f64 / rate_hz;
            assert!(
                (row[0] - 2.0 * t).abs() < 1e-9 && (row[1] - 1.0 + t).abs() < 1e-9,
                "{step} {rate_hz} {k}"
            );
        }
    }
}

#[test]
fn law_stamps_at_the_vessels_rate_change_nothing() {
    for rate_hz in [1.0, 3.0, 8.0, 10.0, 30.0] {
        let rounded = (0..900).map(|k| (f64::from(k) / rate_hz * 1000.0).round() / 1000.0);
        let own = table(rounded).unwrap();
        assert_eq!(own.clone().played(3, rate_hz, false), Ok((own.inputs, Resampling::Stamps)));
    }
    let refused = table([0.0, 1.0, 2.0]).unwrap().played(3, 10.0, false).unwrap_err();
    assert!(refused.to_string().contains("resample"), "{refused}");
}

#[test]
fn stamps_that_are_not_even_are_refused_by_line() {
    let refused = |t: [f64; 5]| table(t).unwrap_err().to_string();
    assert!(
        refused([0.0, 1.0, 2.0, 2.0, 3.0])
            .starts_with("line 5, column `t`: found the time of the row before")
    );
    assert!(refused([0.0, 1.0, 2.0, 1.5, 3.0]).starts_with("line 5, column `t`: found 0.5 s before"));
    assert!(refused([0.0, 1.0, 3.0, 4.0, 5.0]).starts_with("line 4, column `t`: found 2 s after"));
}
