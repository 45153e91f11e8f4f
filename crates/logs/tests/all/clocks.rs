//! Times as they stand in logs.

use logs::{Backwards, NoStamp, NonMonotonic, Order, Stamps, TimeSpec, order};

/// Stamps of a time that is declared so beside its column.
fn stamps(keys: &str) -> Stamps {
    let spec: TimeSpec = toml::from_str(&format!("column = \"t\"\n{keys}")).unwrap();
    Stamps::new(&spec).unwrap()
}

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
        assert_eq!(stamps("unit = \"iso8601\"").seconds(text), Ok(expected), "{text}");
    }
    for text in ["2020-07-31", "2021-02-29T00:00Z", "2020-13-01T00:00Z", "31.07.2020 13:04", "12.5", "é"] {
        assert_eq!(stamps("unit = \"iso8601\"").seconds(text), Err(NoStamp::Unread), "{text}");
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

#[test]
fn times_are_read_as_their_format_says_or_not_at_all() {
    let slashes = "format = \"%Y/%m/%d %H:%M:%S%.f\"";
    let day = 1_744_329_600.0;
    for (keys, text, expected) in [
        (slashes, "2025/04/11 12:08:20.3", day + 43_700.3),
        (slashes, "2025/04/11 12:08:20", day + 43_700.0),
        ("format = \"%d.%m.%y %I:%M:%S %p\"", "11.04.25 01:00:01 PM", day + 46_801.0),
        ("format = \"%Y-%m-%d %H:%M:%S %:z\"", "2025-04-11 12:08:20 +03:00", day + 32_900.0),
        ("format = \"%H:%M:%S%.f\"", "12:08:20.25", 43_700.25),
        ("format = \"%Y%m%d%H%M\"\nzone = \"+03:00\"", "202504111208", day + 32_880.0),
        ("unit = \"iso8601\"\nzone = \"Europe/Helsinki\"", "2025-04-11T12:08:20", day + 32_900.0),
        ("unit = \"iso8601\"\nzone = \"Europe/Helsinki\"", "2025-04-11T12:08:20Z", day + 43_700.0),
    ] {
        assert_eq!(stamps(keys).seconds(text), Ok(expected), "{keys} {text}");
    }
    for text in
        ["2025/04/11 12:08", "2025/04/11 12:08:20.3 UTC", "2025-04-11 12:08:20", "2025/02/29 12:08:20"]
    {
        assert_eq!(stamps(slashes).seconds(text), Err(NoStamp::Unread), "{text}");
    }
    assert!(stamps(slashes).seconds(" ").unwrap().is_nan());
}

#[test]
fn times_that_clocks_showed_twice_or_never_are_ambiguous() {
    let helsinki = stamps("unit = \"iso8601\"\nzone = \"Europe/Helsinki\"");
    for (text, expected) in [
        ("2025-03-30T02:59:59", Ok(1_743_296_399.0)),
        ("2025-03-30T03:30:00", Err(NoStamp::Never)),
        ("2025-03-30T04:00:00", Ok(1_743_296_400.0)),
        ("2025-10-26T03:30:00", Err(NoStamp::Twice)),
        ("2025-10-26T03:30:00+03:00", Ok(1_761_438_600.0)),
        ("2025-10-26T04:00:00", Ok(1_761_444_000.0)),
    ] {
        assert_eq!(helsinki.seconds(text), expected, "{text}");
    }
}
