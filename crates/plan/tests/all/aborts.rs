//! What becomes of a ship if it fails on a leg.

use plan::voyage::{
    AbortRule, Failing, LegFailure, Prepared, SailedPlan, Sailing, Search, Solved, Task, VoyageError,
    WaitingPlace,
};
use ship::engine::Ship;

use crate::plan_laws::{from_box, hull, island};
use crate::planned::{Planned, rich, small, small_brief};

/// The small trial with other settings, in still water.
fn planned(failing: Failing) -> Result<Planned, VoyageError> {
    let mut brief = small_brief();
    brief.task.safety.unknown_current_m_s = 0.0;
    brief.task = Task { failing, ..brief.task };
    let search = Search::unlimited();
    let mut prepared = Prepared::new(brief, &search)?;
    let (solved, sailing): (Solved, Sailing) = prepared.plan(&search, false)?;
    Ok(Planned { prepared, solved, sailing })
}

fn failures(planned: &Planned) -> impl Iterator<Item = (&plan::lattice::Step, &LegFailure)> {
    let failures = &planned.sailing.failures;
    assert_eq!(failures.len(), planned.solved.solution.steps.len());
    planned.solved.solution.steps.iter().zip(failures)
}

#[test]
fn law_an_abort_track_leads_from_the_end_of_its_leg_to_water_with_room() {
    let mut moves = 0;
    for planned in [small(), rich()] {
        let Prepared { grid, brief, .. } = &planned.prepared;
        for (step, failure) in failures(planned) {
            let Ok((abort, places)) = &failure.abort else { continue };
            assert_eq!((abort.aground, abort.kind), (0, WaitingPlace::OpenWater));
            let Some(last) = abort.moves.last() else {
                assert_eq!((abort.towards_deg, abort.distance_m, abort.duration_s), (None, 0.0, 0.0));
                continue;
            };
            moves += abort.moves.len();
            assert_eq!(last.mode, grid.modes[0].name);
            // It begins and ends at its nodes, to the tolerance of legs.
            let within = brief.task.approach.tolerance.distance_m;
            let [from, to] =
                [step.to, plan::lattice::Pose { i: last.i as usize, j: last.j as usize, layer: 0 }];
            for (place, node) in [(places[0], from), (places[places.len() - 1], to)] {
                let [north, east] = planned.prepared.node(node);
                let off = (place[0] - east).hypot(place[1] - north);
                assert!(off <= within, "{off}");
            }
            assert_eq!(abort.duration_s, (places.len() - 1) as f64 / planned.rate_hz());
            assert!(abort.clearance_m.unwrap() >= brief.task.safety.margin_m);
        }
    }
    assert!(moves > 0);
    // Around where she waits there is no island.
    let (margin_m, island) = (small().prepared.brief.task.safety.margin_m, island(small()));
    for (_, failure) in failures(small()) {
        let (abort, _) = failure.abort.as_ref().unwrap();
        let at = small().prepared.chart.plane().to_plane(abort.longitude_deg, abort.latitude_deg);
        assert_eq!(abort.room_m, 30.0);
        assert!(from_box(island, at) >= abort.room_m + 15.0 + margin_m);
    }
}

#[test]
fn law_a_ship_whose_engine_stops_in_still_water_glides_as_far_as_her_drag_allows() {
    let failing = Failing { abort: AbortRule::Required, drift_s: 240.0, room_m: None };
    let planned = planned(failing).unwrap();
    let (vessel, island) = (&planned.prepared.brief.vessel, island(&planned));
    let samples = &planned.sailing.sailed.samples;
    let mut nearer = 0;
    for (leg, (_, failure)) in failures(&planned).enumerate() {
        assert!(failure.abort.is_ok());
        let glide = |sample: &plan::Sample| {
            let mut ship = Ship::new(vessel, &vessel.nominal, sample.pose, 0.0);
            ship.state = sample.state;
            let drift = |_| {
                let pose = ship.pose;
                ship.step(&[0.0; 3]);
                hull(&planned, pose)
                    .into_iter()
                    .map(|place| from_box(island, place))
                    .fold(f64::INFINITY, f64::min)
            };
            (0..=240).map(drift).fold(f64::INFINITY, f64::min)
        };
        let of_leg = samples.iter().filter(|sample| sample.leg == leg).step_by(5);
        let least = of_leg.map(glide).fold(f64::INFINITY, f64::min);
        let drift = &failure.drift;
        assert_eq!((drift.lasts_s, drift.aground > 0), (240.0, drift.clearance_m <= 0.0));
        assert!(drift.clearance_m > least - 5.0 || least > 500.0, "leg {leg}: {drift:?} {least}");
        let from_every_eighth = least + 40.0;
        assert!(drift.clearance_m < from_every_eighth, "leg {leg}: {drift:?} {least}");
        nearer += u32::from(least < 500.0);
    }
    assert!(nearer > 0);
    let plan = SailedPlan { prepared: &planned.prepared, solved: &planned.solved, sailing: &planned.sailing };
    for (step, places, corners) in plan.aborts() {
        assert!(step < planned.sailing.failures.len());
        assert_eq!((corners[0], *corners.last().unwrap()), (0, places.len() - 1));
    }
}

#[test]
fn law_legs_without_room_to_wait_are_named_or_refused() {
    let failing = |abort| Failing { abort, drift_s: 1.0, room_m: Some(5000.0) };
    let told = planned(failing(AbortRule::Told)).unwrap();
    assert!(told.sailing.check.safe);
    for (_, failure) in failures(&told) {
        assert!(failure.abort.as_ref().unwrap_err().contains("5000 m of room (`abort_room_m`)"));
    }
    let refused = planned(failing(AbortRule::Required)).err().unwrap();
    let VoyageError::Infeasible(why) = refused else { panic!("{refused:?}") };
    assert!(why.contains("without an abort track") && why.contains("`abort`"), "{why}");
}
