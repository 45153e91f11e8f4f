//! What cannot be planned, and the memory that planning needs.

use plan::voyage::{Brief, Footing, Goal, Place, Prepared, Search, VoyageError};
use plan::{Ability, Deviations, Handling};

use crate::golden::Table;
use crate::planned::{rich, rich_brief, small, small_brief};

fn prepared(brief: Brief) -> Result<Prepared, VoyageError> {
    Prepared::new(brief, &Search::unlimited())
}

/// Why the small trial with a change has no plan.
#[track_caller]
fn refused(change: impl Fn(&mut Brief)) -> String {
    let mut brief = small_brief();
    change(&mut brief);
    let outcome = prepared(brief).and_then(|mut own| own.plan(&Search::unlimited(), false).map(|_| ()));
    outcome.unwrap_err().to_string()
}

#[test]
fn areas_that_are_too_small_too_long_or_empty_are_refused_with_their_size() {
    let said = refused(|brief| brief.task.area.east_deg = 24.9805);
    assert!(
        said.contains("`area`: found 0.0 × 2.2 km, expected at most 200 km on a side, within 20 to 1"),
        "{said}"
    );
    let said = refused(|brief| brief.task.area.east_deg = 29.0);
    assert!(said.contains("× 2.2 km"), "{said}");
    let said = refused(|brief| brief.task.cell_m = 1200.0);
    assert!(said.contains("found 1 × 1 nodes, expected from 2 × 2"), "{said}");
    let said = refused(|brief| brief.task.cell_m = 0.5);
    assert!(said.contains("found 4465 × 4456 nodes"), "{said}");
    let said = refused(|brief| (brief.task.area.south_deg, brief.task.area.north_deg) = (10.0, 10.02));
    assert!(said.starts_with("[[chart]]: found nothing within `area`"), "{said}");
    // As long as 20 to 1 is allowed: 0.4° of longitude at 60° is 22.3 km, and 1.2 km are 0.0108°.
    let mut brief = small_brief();
    (brief.task.area.west_deg, brief.task.area.east_deg) = (24.8, 25.2);
    (brief.task.area.south_deg, brief.task.area.north_deg) = (59.995, 60.0055);
    assert!(brief.sight().is_ok());
}

#[test]
fn places_off_the_lattice_or_in_no_mode_are_refused() {
    let start = |change: fn(&mut Place)| refused(|brief| change(&mut brief.task.start));
    assert!(start(|own| own.longitude_deg = 25.03).contains("`start`: found longitude 25.03, latitude 60"));
    assert!(start(|own| own.latitude_deg = 59.98).contains("expected a place inside `area`"));
    assert!(start(|own| own.heading_deg = f64::NAN).contains("heading NaN"));
    let said = start(|own| own.mode = Some("full".to_owned()));
    assert!(said.contains("`start.mode`: found `full`, expected at rest, half"), "{said}");
    let said = refused(|brief| brief.task.goal = Goal::Places { places: Vec::new() });
    assert!(said.starts_with("`goal.places`: found none"), "{said}");
}

#[test]
fn a_start_too_near_to_the_island_is_refused_with_its_distance_and_the_nearest_clear_node() {
    let said = refused(|brief| brief.task.start.longitude_deg = 24.9982);
    // The node is 96 m west of the plane's centre, 15 m inside the island; the next one is clear.
    assert!(
        said.contains("0 m from an obstacle (land Holm), expected the hull in `area`, at least 20 m clear"),
        "{said}"
    );
    assert!(said.contains("the nearest clear node is 120 m away, 60.0002 N 24.9961 E heading 0°"), "{said}");
    let said = refused(|brief| {
        brief.task.area.corners =
            vec![[24.98, 59.99], [25.02, 59.99], [25.02, 60.01], [24.986, 60.01], [24.986, 60.0]];
        brief.task.start.longitude_deg = 24.983;
    });
    assert!(said.contains("where the hull reaches out of `area`"), "{said}");
}

#[test]
fn maneuvers_that_are_unknown_twice_or_without_a_count_are_refused() {
    let first =
        |change: fn(&mut plan::voyage::ManeuverUse)| refused(|brief| change(&mut brief.task.maneuvers[0]));
    let said = first(|own| own.name = "spiral".to_owned());
    assert!(said.contains("expected one of zig-zag-steep, zig-zag-wide, sway-zig-zag"), "{said}");
    assert!(first(|own| own.name = "sway-zig-zag".to_owned()).contains("found it twice"));
    assert!(first(|own| own.name = "straight".to_owned()).contains("the name of a basic move"));
    assert!(first(|own| own.count = None).contains("no `count` and no design"));
    assert!(first(|own| own.piece_s = Some(1e4)).contains("1 to 180"));
    assert!(refused(|brief| brief.task.maneuvers.clear()).contains("none, and no design"));
    let said = refused(|brief| brief.task.maneuvers.iter_mut().for_each(|own| own.count = Some(0)));
    assert!(said.contains("no maneuver that is used at least once"), "{said}");
}

#[test]
fn all_maneuvers_without_a_leg_and_all_tolerances_that_fail_are_named_at_once() {
    let said = refused(|brief| {
        let tolerance = &mut brief.task.approach.tolerance;
        (tolerance.heading_rad, tolerance.sway_m_s, tolerance.yaw_rate_rad_s) = (1e-9, 1e-9, 1e-9);
    });
    assert!(said.starts_with("maneuver `zig-zag-steep`: found no leg on which"), "{said}");
    assert!(said.contains("; nor of `sway-zig-zag`"), "{said}");
    for quantity in ["heading ", " and sway ", " and yaw rate "] {
        assert!(said.contains(quantity), "{quantity}: {said}");
    }
    assert!(said.contains("times their tolerances"), "{said}");
}

#[test]
fn law_counts_are_shares_of_the_time_over_the_pieces() {
    let counts = |informative_s: f64| {
        let mut brief = rich_brief();
        brief.task.informative_s = Some(informative_s);
        let prepared = prepared(brief).unwrap();
        prepared.wanted.iter().map(|own| own.count).collect::<Vec<_>>()
    };
    // Pieces of 120 s and 240 s, with shares of 0.45 and 0.55.
    assert_eq!(counts(430.0), [2, 1]);
    assert_eq!(counts(1200.0), [5, 3]);
}

#[test]
fn law_a_trial_fits_in_the_memory_that_it_is_said_to_need_and_in_no_less() {
    let with = |memory_bytes: u64| {
        let mut search = Search::unlimited();
        search.options.memory_bytes = memory_bytes;
        search
    };
    let footing = |outcome: Result<(), VoyageError>| match outcome {
        Err(VoyageError::TooLarge(footing)) => footing,
        other => panic!("{other:?}"),
    };
    let mut table = Table::default();
    let numbers = |own: &Footing| {
        let Footing { lattice, cells, clearance_cells, other, check } = *own;
        [lattice.poses, lattice.moves, cells, clearance_cells, other, check, own.bytes()].map(|n| n as f64)
    };
    for (name, brief) in [("small", small_brief as fn() -> Brief), ("rich", rich_brief)] {
        let layout = footing(Prepared::new(brief(), &with(0)).map(|_| ()));
        table.row(format!("{name} layout"), numbers(&layout));
        let least = layout.bytes() as u64;
        assert_eq!(footing(Prepared::new(brief(), &with(least - 1)).map(|_| ())), layout);
        let prepared = Prepared::new(brief(), &with(least)).unwrap();
        let legs = footing(prepared.solve(&with(0)).map(|_| ()));
        table.row(format!("{name} legs"), numbers(&legs));
        let needed = legs.bytes() as u64;
        assert_eq!(footing(prepared.solve(&with(needed - 1)).map(|_| ())), legs);
        // More than that is only needed by the states of the search.
        let after = prepared.solve(&with(needed)).map(|_| ());
        assert!(!matches!(after, Err(VoyageError::TooLarge(_))), "{after:?}");
        let words = legs.to_string();
        let cells = legs.cells + legs.clearance_cells;
        assert!(words.ends_with(&format!(" moves and {cells} raster cells")), "{words}");
    }
    table.assert(
        "
        small_layout 2592 0 5776 1261129 29360576 12583584 53352081
        small_legs 2592 59004 5776 1261129 39546696 12717984 63679976
        rich_layout 3468 0 19616 2389298 29369920 12584928 63654690
        rich_legs 3468 231584 24800 2389298 39545284 13036448 74362362
        ",
    );
}

#[test]
fn oracle_cells_and_moves_of_a_footing_are_counted() {
    let layout = |change: fn(&mut Brief)| {
        let mut brief = small_brief();
        change(&mut brief);
        let mut search = Search::unlimited();
        search.options.memory_bytes = 0;
        match Prepared::new(brief, &search) {
            Err(VoyageError::TooLarge(footing)) => footing,
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    let small = layout(|_| ());
    // 18 × 18 nodes with 4 headings at rest and at half speed; 72 × 72 cells of 30 m, and two more on each side for the margin.
    assert_eq!((small.lattice.poses, small.lattice.moves), (18 * 18 * 8, 0));
    assert_eq!(small.cells, 76 * 76);
    assert_eq!(layout(|brief| brief.task.safety.margin_m = 80.0).cells, 80 * 80);
    // An area and a speed limit have a mask each.
    let corners = [[24.98, 59.99], [25.02, 59.99], [25.02, 60.01], [24.98, 60.01]];
    let masked = layout(|brief| {
        brief.task.area.corners = vec![[24.98, 59.99], [25.02, 59.99], [25.02, 60.01], [24.98, 60.01]]
    });
    assert_eq!((masked.cells - small.cells, corners.len()), (72 * 72, 4));
    // Runs are kept, at most 200 of their tracks.
    let runs = |runs: fn(&mut Brief)| layout(runs).check;
    let [four, eight, many, more] = [
        runs(|_| ()),
        runs(|brief| brief.task.safety.runs = Some(8)),
        runs(|brief| brief.task.safety.runs = Some(1000)),
        runs(|brief| brief.task.safety.runs = Some(1100)),
    ];
    assert!(four < eight && eight < many, "{four} {eight} {many}");
    assert!((more - many) * 996 == (many - four) * 100, "without legs there are no samples yet");
    // By default as many runs as exclude a probability of 1 % with the first round's half of 5 %.
    let usual = layout(|brief| brief.task.safety.runs = None).check;
    assert_eq!((usual - four) * 4, (eight - four) * 364);
    let asked =
        layout(|brief| (brief.task.safety.runs, brief.task.safety.aground_probability) = (None, Some(0.1)));
    assert_eq!((asked.check - four) * 4, (eight - four) * 32);
}

#[test]
fn vessels_that_cannot_be_steered_are_refused_by_name() {
    let said = refused(|brief| {
        brief.task.deviations = Deviations::Box(1.5);
        brief.task.safety.parameter_error = 1.5;
    });
    assert!(said.starts_with("`safety.parameter_error`: found a vessel with"), "{said}");
    assert!(said.contains("that cannot be steered: in mode `"), "{said}");
    assert!(said.contains("after 300 s"), "{said}");
}

#[test]
fn a_maneuver_without_room_is_named_and_the_one_that_needs_most() {
    // Four nodes by four: the zig-zag needs three or four cells, and room for what it sweeps.
    let said = refused(|brief| {
        let area = &mut brief.task.area;
        (area.west_deg, area.east_deg, area.south_deg, area.north_deg) = (24.983, 24.9925, 59.9965, 60.0012);
        brief.task.safety.margin_m = 60.0;
    });
    let why = "`zig-zag-steep` fits nowhere that can be reached, though it would at 59.9970 N 24.9841 E heading 90°";
    assert!(said.starts_with(&format!("no feasible plan (proved): {why}")), "{said}");
    assert!(
        said.contains("`sway-zig-zag` has room for vessels that end it 27 m from the nominal one"),
        "{said}"
    );
}

#[test]
fn golden_handling() {
    let mut table = Table::default();
    for planned in [small(), rich()] {
        let own = &planned.prepared.brief.task.derived;
        let Handling { turn_rate_rad_s, crawl_m_s, acceleration_m_s2, response_s, lookahead_m } =
            own.handling;
        table.row("handling", [turn_rate_rad_s, crawl_m_s, acceleration_m_s2, response_s, lookahead_m]);
        let Ability { coasting_m_s2, lag_s, acceleration_m_s2, braking_m_s2, .. } = own.ability;
        let known = [acceleration_m_s2, braking_m_s2].into_iter().flatten();
        table.row("ability", [coasting_m_s2, lag_s].into_iter().chain(known));
    }
    table.assert(
        "
        handling 0.0125 0.3 0.05925 30 46.1880215
        ability 0.05925 0
        handling 0.00666666667 0.16 0.02992 56.25 86.6025404
        ability 0.02992 0
        ",
    );
}
