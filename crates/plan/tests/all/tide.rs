//! The tide at its worst, against a search over every second.

use plan::voyage::{Tide, TideRow};

#[test]
fn law_no_second_of_the_slot_has_less_water_or_another_stream() {
    let row = |k: i32| TideRow {
        at_s: 600.0 * f64::from(k),
        level_m: 2.0 * libm::sin(0.7 * f64::from(k)),
        stream_m_s: [libm::cos(0.9 * f64::from(k)), 0.3 * libm::sin(1.3 * f64::from(k))],
    };
    let table: Vec<TideRow> = (0..30).map(row).collect();
    for (departure_s, slot_s) in [(0.0, 17_400.0), (700.0, 100.0), (1234.0, 5000.0), (600.0, 1200.0)] {
        let tide = Tide::worst(&table, departure_s, slot_s).unwrap();
        let (mut least, mut farthest) = (f64::INFINITY, 0.0_f64);
        for second in 0..=slot_s as i32 {
            let at = (departure_s + f64::from(second)) / 600.0;
            let (k, part) = ((at.floor() as usize).min(28), at - at.floor().min(28.0));
            let between =
                |of: &dyn Fn(&TideRow) -> f64| (1.0 - part) * of(&table[k]) + part * of(&table[k + 1]);
            least = least.min(between(&|row| row.level_m));
            let stream = [0, 1].map(|c: usize| between(&|row| row.stream_m_s[c]) - tide.stream_m_s[c]);
            farthest = farthest.max(libm::hypot(stream[0], stream[1]));
        }
        assert!((least - tide.level_m).abs() < 1e-2 && least >= tide.level_m - 1e-9, "{least} {tide:?}");
        assert!(farthest <= tide.spread_m_s + 1e-9, "{farthest} {tide:?}");
        assert!(farthest > tide.spread_m_s - 1e-2, "{farthest} {tide:?}");
    }
    // From the second row to the fourth: between 0.2 and 1 m/s north, −0.4 and 0.1 east, and the lower water of the ends.
    let rows =
        [(9.0, [5.0, 5.0]), (3.0, [1.0, 0.1]), (4.0, [0.2, -0.4]), (2.5, [0.6, 0.0]), (0.0, [9.0, 9.0])];
    let row = |(k, (level_m, stream_m_s)): (i32, (f64, [f64; 2]))| TideRow {
        at_s: f64::from(k),
        level_m,
        stream_m_s,
    };
    let rows: Vec<TideRow> = (0..).zip(rows).map(row).collect();
    let tide = Tide::worst(&rows, 1.0, 2.0).unwrap();
    assert!(
        (tide.stream_m_s[0] - 0.6).abs() < 1e-12 && (tide.stream_m_s[1] + 0.15).abs() < 1e-12,
        "{tide:?}"
    );
    assert!((tide.spread_m_s - libm::hypot(0.4, 0.25)).abs() < 1e-12 && tide.level_m == 2.5, "{tide:?}");
    assert_eq!(Tide::worst(&table, -1.0, 100.0), None);
    assert_eq!(Tide::worst(&table, 17_000.0, 401.0), None);
    assert_eq!(Tide::worst(&[], 0.0, 1.0), None);
}
