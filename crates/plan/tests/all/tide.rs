//! The tide at its worst, against a search over every second.

use chart::route::Timestamp;
use plan::voyage::{Departures, Tide, TideRow, Times};

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

#[test]
fn law_a_plan_holds_for_its_departures_and_not_a_minute_before_or_after() {
    let row = |k: i32| TideRow {
        at_s: 600.0 * f64::from(k),
        level_m: 2.0 + libm::sin(0.11 * f64::from(k)),
        stream_m_s: [libm::cos(0.09 * f64::from(k)), 0.3 * libm::sin(0.13 * f64::from(k))],
    };
    let table: Vec<TideRow> = (0..144).map(row).collect();
    let second = |text: &str| text.parse::<Timestamp>().unwrap().as_second() as f64;
    let lasts_s = 1500.0;
    let mut closed_by_tide = 0;
    for (departure_s, slot_s) in [(9000.0, 7200.0), (30_000.0, 5400.0), (52_000.0, 9000.0)] {
        let tide = Tide::worst(&table, departure_s, slot_s).unwrap();
        // By the second, over the whole of a trial.
        let holds = |begin_s: f64| {
            (0..=lasts_s as i32).all(|second| {
                let at = (begin_s + f64::from(second)) / 600.0;
                if !(0.0..=143.0).contains(&at) {
                    return false;
                }
                let (k, part) = ((at.floor() as usize).min(142), at - at.floor().min(142.0));
                let between =
                    |of: &dyn Fn(&TideRow) -> f64| (1.0 - part) * of(&table[k]) + part * of(&table[k + 1]);
                let off = [0, 1].map(|c: usize| between(&|row| row.stream_m_s[c]) - tide.stream_m_s[c]);
                between(&|row| row.level_m) >= tide.level_m - 1e-6
                    && libm::hypot(off[0], off[1]) <= tide.spread_m_s + 1e-6
            })
        };
        let times = Times { table: table.clone(), bounds: [None, None] };
        let found = Departures::around(&times, Some(&tide), departure_s, lasts_s).unwrap();
        let (earliest, latest) = (second(&found.earliest), second(&found.latest));
        assert!(earliest <= departure_s && latest >= departure_s + slot_s - lasts_s - 60.0, "{found:?}");
        assert!(
            (0..).map(|k| earliest + 60.0 * f64::from(k)).take_while(|at| *at <= latest).all(holds),
            "{found:?}"
        );
        assert!(!holds(earliest - 60.0) && !holds(latest + 60.0), "{found:?}");
        closed_by_tide += u32::from(found.after.starts_with("level") || found.after.starts_with("stream"));
        let best = Tide::worst(&table, second(found.best.as_ref().unwrap()), lasts_s).unwrap().level_m;
        assert!(best >= Tide::worst(&table, departure_s, lasts_s).unwrap().level_m);
        // The slot closes it earlier.
        let bounds =
            [Some(("slot.from", departure_s - 120.0)), Some(("slot.until", departure_s + lasts_s + 300.0))];
        let found =
            Departures::around(&Times { table: table.clone(), bounds }, Some(&tide), departure_s, lasts_s)
                .unwrap();
        assert!(
            second(&found.earliest) >= departure_s - 120.0 && second(&found.latest) == departure_s + 300.0
        );
        assert_eq!(found.after, "`slot.until`");
    }
    assert!(closed_by_tide > 0);
    assert_eq!(Departures::around(&Times::default(), None, 0.0, 60.0), None);
}
