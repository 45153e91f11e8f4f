//! Sensors with rate and resolution.

use logs::chain::{Gnss, quantised};

#[test]
fn fixes_come_every_so_many_samples() {
    let gnss = |rate_hz| Gnss {
        rate_hz,
        white_std_m: 0.0,
        wander_std_m: 0.0,
        wander_time_s: None,
        resolution_m: 0.0,
    };
    assert_eq!(gnss(8.0).every(8.0), Some(1));
    assert_eq!(gnss(2.0).every(8.0), Some(4));
    assert_eq!(gnss(3.0).every(8.0), None);
    assert_eq!(gnss(16.0).every(8.0), None);
}

#[test]
fn resolution_rounds() {
    assert_eq!(quantised(0.37, 0.25), 0.25);
    assert_eq!(quantised(-0.38, 0.25), -0.5);
    assert_eq!(quantised(0.37, 0.0), 0.37);
}
