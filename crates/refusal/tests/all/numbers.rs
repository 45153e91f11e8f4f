//! Numbers within ranges.

use refusal::check_ranges;

#[test]
fn numbers_beyond_their_range_are_refused_with_it() {
    let check = |value| check_ranges([("window_s", value, 1e-6..=1e7, "s")]).map_err(|e| e.to_string());
    assert_eq!(check(3.0), Ok(()));
    let message = check(1.8446744073709552e19).unwrap_err();
    assert_eq!(message, "`window_s`: found 1.8446744073709552e19, expected 1e-6 to 1e7 s; correct it");
    assert!(check(f64::NAN).unwrap_err().contains("found NaN"));
    assert!(check(-1.0).unwrap_err().contains("found -1,"));
}
