//! Times as they stand in logs.

use logs::{Backwards, NonMonotonic, Order, TimeUnit, order};

#[test]
fn dates_are_read_as_the_calendar_says() {
    for (text, expected) in [
        ("1970-01-01T00:00:00Z", 0.0),
        ("2020-07-31T13:04:24.5Z", 1_596_200_664.5),
        ("2020-07-31 13:04:24,5", 1_596_200_664.5),
        ("2020-07-31T22:04:24.5+09:00", 1_596_200_664.5),
        ("2020-07-31T09:34:24.5-0330", 1_596_200_664.5),
        ("2000-02-29T12:00", 951_825_600.0),
        ("1969-12-31T23:59:59Z", -1.0),
    ] {
        assert_eq!(TimeUnit::of_text(text), Some(expected), "{text}");
    }
    for text in ["", "2020-07-31", "2021-02-29T00:00Z", "2020-13-01T00:00Z", "31.07.2020 13:04", "12.5", "é"]
    {
        assert_eq!(TimeUnit::of_text(text), None, "{text}");
    }
}

#[test]
fn repeated_and_early_rows_are_counted() {
    let times = vec![0.0, 1.0, f64::NAN, 1.0, 3.0, 2.0, 3.0, 4.0].into();
    let error = order(&times, NonMonotonic::Refuse).unwrap_err();
    assert_eq!(error, Backwards { row: 5, time: 2.0, latest: 3.0 });
    let dropped = order(&times, NonMonotonic::Drop).unwrap();
    assert_eq!(dropped, Order { rows: vec![0, 1, 4, 7], repeated: 2, backwards: 1 });
    let sorted = order(&times, NonMonotonic::Sort).unwrap();
    assert_eq!(sorted, Order { rows: vec![0, 1, 5, 4, 7], repeated: 2, backwards: 1 });
}
