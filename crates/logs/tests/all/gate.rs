//! Numbers that are values, and numbers that are none.

use logs::{FileSpec, Log, Method, NonMonotonic, Plan, Reason, Setup, read_csv};

use crate::declared;

/// The log with one channel, in `unit`, that has these numbers a second apart; `keys` are more of its channel.
fn log(channel: &str, unit: &str, keys: &str, numbers: &[f64]) -> Log {
    let text = format!(
        "pattern = [\"*.csv\"]\ntime = {{ column = \"t\", unit = \"s\" }}\nchannel = [\n\
         {{ column = \"a\", channel = \"{channel}\", unit = \"{unit}\"{keys} }},\n\
         {{ column = \"u\", channel = \"y_u\", unit = \"m/s\" }},\n{{ column = \"u\", channel = \"y_v\", unit = \"m/s\" }},\n\
         {{ column = \"u\", channel = \"y_r\", unit = \"rad/s\" }},\n]\n"
    );
    let file: FileSpec = toml::from_str(&text).unwrap();
    let setup = Setup {
        written_in: "ingest.toml",
        files: vec![file],
        conventions: declared::conventions(Method::Smoother, 1.0),
        max_gap_s: 1.5,
        non_monotonic: NonMonotonic::Refuse,
        max_speed_m_s: 30.0,
    };
    let plan = Plan::new(setup, None).unwrap();
    let rows = numbers.iter().enumerate().map(|(t, number)| format!("{t},{number},1\n"));
    let csv = "t,a,u\n".to_owned() + &rows.collect::<String>();
    Log::new(read_csv(csv.as_bytes(), None, &plan, 0, None).unwrap(), 0, &plan).unwrap()
}

/// Reasons and counts of what was left out.
fn left_out(log: Log) -> Vec<(Reason, u64)> {
    log.omitted.into_vec().into_iter().map(|one| (one.reason, one.count)).collect()
}

#[test]
fn law_a_smooth_channel_passes_over_all_known_numbers() {
    // By hundredths from 320 to 330 deg: over 327.67; by hundredths over 9999.
    let angles: Vec<f64> = (0..1001).map(|k| (32_000.0 + f64::from(k)) / 100.0).collect();
    assert_eq!(left_out(log("psi", "deg", "", &angles)), []);
    let turns: Vec<f64> = (0..800).map(|k| 9_998.0 + 0.01 * f64::from(k)).collect();
    assert_eq!(left_out(log("power", "kW", "", &turns)), []);
}

#[test]
fn law_what_is_missing_and_valid_is_said_before_sign_and_scale() {
    let numbers: Vec<f64> = (0..100).map(f64::from).collect();
    let keys = ", sign = -1, scale = 0.5, missing = [3, 5], valid = [2, 90], max_omitted = 0.5";
    let found = log("power", "kW", keys, &numbers);
    assert_eq!(left_out(found.clone()), [(Reason::Missing, 2), (Reason::Range, 11)]);
    assert_eq!(found.channels[0].values.len(), 87);
    assert_eq!(found.channels[0].values.first(), Some(-1000.0));
}

#[test]
fn law_a_fault_is_left_out_wherever_it_stands_and_however_long() {
    for place in [0, 1, 50, 97, 99] {
        for count in [1, 3] {
            let mut numbers: Vec<f64> = (0..100).map(|k| 40.0 + (0.1 * f64::from(k)).sin()).collect();
            numbers.iter_mut().skip(place).take(count).for_each(|number| *number = 327.67);
            let rows = numbers.iter().filter(|number| **number == 327.67).count() as u64;
            for (channel, unit) in [("psi", "deg"), ("power", "kW"), ("wind", "m/s")] {
                let reason = if channel == "wind" { Reason::Range } else { Reason::Missing };
                assert_eq!(
                    left_out(log(channel, unit, "", &numbers)),
                    [(reason, rows)],
                    "{channel} {place} {count}"
                );
            }
        }
    }
}
