//! A made-up trial: two maneuvers with moves between them, one of them mirrored.

use std::collections::BTreeMap;

use crate::mock;
use report::{PlannedTrial, Study, Trajectory};
use study::documents::{
    Ability, AbortMove, AbortTrack, Check, CostUnit, DerivedHandling, FrontPoint, Handling, Information,
    LegDrift, NearestDanger, Passage, PassageLeg, PlanDocument, PlanHandling, PlanLattice, PlanPose,
    PlanStatus, PlanStep, Primitive, ScoredEstimates, Secondary, SecondaryCost, Side, Tide, Voyage,
    VoyageLeg, WaitingPlace, WorstVessel, WorstVessels,
};

pub const MAP: &str = "<svg role=\"img\" aria-label=\"Planned trial\" viewBox=\"0 0 5600 8370\" \
    xmlns=\"http://www.w3.org/2000/svg\">\n<title>Planned trial</title>\n<path d=\"M1 2l3 4\" fill=\"none\" \
    stroke=\"currentColor\"/>\n</svg>\n";

/// The study of [`mock::study`] with a plan, one variant and simulated trials.
pub fn study() -> Study {
    let mut study = mock::study();
    let designs = |name: &str| name == "optimized";
    let validation = study.validation.clone().map(|mut planned| {
        planned.designs.retain(|d| designs(&d.design));
        planned.designs.iter_mut().for_each(|d| {
            d.design = "planned".to_owned();
            d.runs = 200;
            d.parameter_error_share = 0.875;
            d.parameter_error.median = Some(0.777);
            d.not_identifiable = 3;
        });
        planned
    });
    let estimate = study.estimate.clone().map(|mut planned| {
        planned.designs.retain(|d| designs(&d.design));
        planned.designs.iter_mut().for_each(|d| d.design = "planned".to_owned());
        planned
    });
    study.trajectory = Some(Trajectory {
        main: Some(trial("")),
        variants: vec![trial("plan-4-headings")],
        estimate,
        validation,
    });
    study
}

/// Validation of the planned trial with other bounds than the study's.
pub fn otherwise_bounded(study: &mut Study) {
    let planned = study.trajectory.as_mut().and_then(|own| own.validation.as_mut());
    planned.into_iter().for_each(|v: &mut ScoredEstimates| v.bounds.parameter_error = 4.0);
}

fn trial(name: &str) -> PlannedTrial {
    PlannedTrial {
        name: name.to_owned(),
        plan: plan(),
        map: Some(MAP.to_owned()),
        document: None,
        stale: Vec::new(),
    }
}

fn counts(steep: u64, sway: u64) -> BTreeMap<String, u64> {
    BTreeMap::from([("steep".to_owned(), steep), ("sway".to_owned(), sway)])
}

pub fn plan() -> PlanDocument {
    PlanDocument {
        status: PlanStatus::Optimal,
        statement: "Proved: no plan over the 1234 states of the lattice costs less.".to_owned(),
        cost_unit: CostUnit::BasicMoves,
        cost: 4.0,
        lower_bound: 4.0,
        gap: 0.0,
        secondary: Some(SecondaryCost { name: Secondary::Seconds, value: 701.0 }),
        counts: counts(1, 1),
        steps: vec![
            step("faster", (0, "at rest"), (0, "half")),
            step("steep", (0, "half"), (1, "half")),
            step("turn-port", (1, "half"), (2, "half")),
            step("slower", (2, "half"), (2, "at rest")),
            step("sway", (2, "at rest"), (2, "at rest")),
            step("turn-starboard", (2, "at rest"), (1, "at rest")),
        ],
        voyage: Some(voyage()),
        charts: Vec::new(),
        beyond: Vec::new(),
        begun: None,
    }
}

fn step(action: &str, from: (u64, &str), to: (u64, &str)) -> PlanStep {
    let pose = |(h, mode): (u64, &str)| PlanPose { i: 3, j: 4, h, mode: Some(mode.to_owned()) };
    PlanStep { action: action.to_owned(), variant: 0, from: pose(from), to: pose(to), cost: 1.0 }
}

fn passage_leg(what: &str, end_s: f64, turn_radius_m: Option<f64>, then: &[&str]) -> PassageLeg {
    PassageLeg {
        what: what.to_owned(),
        informative: turn_radius_m.is_none(),
        longitude_deg: 24.953,
        latitude_deg: 60.15,
        course_deg: 36.4,
        distance_m: 463.0,
        speed_m_s: 1.5,
        end_s,
        leave_s: end_s,
        turn_radius_m,
        xtd_port_m: 12.2,
        xtd_starboard_m: 40.6,
        least_depth_m: Some(9.26),
        squat_m: None,
        under_keel_m: None,
        passes: Vec::new(),
        nearest: Some(NearestDanger {
            what: "WRECKS Träholm".to_owned(),
            distance_m: 90.7,
            bearing_deg: 271.4,
        }),
        then: then.iter().map(|what| (*what).to_owned()).collect(),
    }
}

fn voyage() -> Voyage {
    Voyage {
        lattice: PlanLattice {
            nx: 60,
            ny: 50,
            headings: 8,
            cell_m: 120.0,
            longitude_deg: 24.9,
            latitude_deg: 60.1,
            modes: BTreeMap::from([("at rest".to_owned(), 0.0), ("half".to_owned(), 1.5)]),
        },
        legs: vec![
            leg("faster", None, 0.0, 90.0, 0.0),
            leg("steep", Some(Side::Mirrored), 90.0, 200.0, 1.5),
            leg("turn-port", None, 290.0, 60.0, 1.5),
            leg("slower", None, 350.0, 70.0, 1.5),
            leg("sway", Some(Side::AsDesigned), 420.0, 280.0, 0.0),
            leg("turn-starboard", None, 700.0, 22.0, 0.0),
        ],
        primitives: vec![primitive("steep", 1513), primitive("sway", 0)],
        duration_s: 722.0,
        informative_s: 400.0,
        check: Check {
            safe: false,
            faults: vec!["2 of 64 runs aground (3.1 %, 0.9 to 10.7 %)".to_owned()],
            clearance_m: 61.5,
            clear: true,
            margin_m: 50.0,
            shortfall_m: 0.0,
            sight_m: 550.0,
            unknown_current_m_s: 0.15,
            parameter_error: 0.35,
            standard_errors: None,
            errors_from: None,
            seed: 1,
            runs: 64,
            aground: 2,
            aground_interval: [0.009, 0.107],
            aground_bound: None,
            below_margin: 2,
            ends: 384,
            ends_astray: 1,
            tolerance_used: 0.4,
            proved_s: 720.0,
            sailed_s: 722.0,
            sailed_quantiles_s: [700.0, 723.0, 741.0],
            rounds: 2,
            left_area: 0,
            clearance_quantiles_m: [0.0, 12.5, 60.0],
            aground_open_loop: 17,
            worst: Some(WorstVessels {
                searched: 375,
                aground: 1,
                below_margin: 3,
                ends: 2250,
                ends_astray: 0,
                clearance_m: 0.0,
                nearest: worst_vessel(2, "steep"),
                tolerance_used: 0.92,
                farthest: worst_vessel(5, "sway"),
            }),
        },
        uncharted_share: 0.034,
        uncharted_is_water: false,
        passage: Passage {
            departure: Some("2026-06-01T08:00:00Z".to_owned()),
            tide: Some(Tide { slot_s: 3600.0, level_m: -0.4, stream_m_s: [0.1, 0.0], spread_m_s: 0.05 }),
            departures: None,
            longitude_deg: 24.95,
            latitude_deg: 60.148,
            before: Vec::new(),
            leave_s: 0.0,
            legs: vec![
                passage_leg("straight", 90.0, Some(212.4), &[]),
                passage_leg("steep (mirrored)", 290.0, None, &["turn-starboard"]),
            ],
        },
        information: Information {
            predicted_log_det: Some(62.9),
            realised_log_det: Some(61.6),
            whole_log_det: Some(75.9),
            efficiency: Some((-0.1_f64).exp()),
            design_efficiency: Some(0.913),
            dimension: 13,
        },
        dropped: Vec::new(),
        handling: handling(),
        front: vec![point(1, 0, 2.0, 55.0), point(1, 1, 4.0, 62.9)],
    }
}

fn handling() -> PlanHandling {
    let used = Handling {
        turn_rate_rad_s: 0.05,
        crawl_m_s: 0.5,
        acceleration_m_s2: 0.05,
        response_s: 30.0,
        lookahead_m: 60.0,
    };
    let ability = Ability {
        turn_rate_rad_s: Some(0.12),
        turn_acceleration_rad_s2: Some(0.01),
        acceleration_m_s2: Some(0.3),
        braking_m_s2: Some(0.4),
        coasting_m_s2: 0.06,
        lag_s: 1.5,
    };
    let handling = Handling { turn_rate_rad_s: 0.06, lookahead_m: 90.0, ..used };
    PlanHandling { used, derived: DerivedHandling { handling, ability } }
}

fn leg(name: &str, side: Option<Side>, start_s: f64, duration_s: f64, speed_m_s: f64) -> VoyageLeg {
    let inputs = [("tau1", 19.66), ("tau2", 1.2e-13), ("tau3", if side.is_some() { 212.12 } else { 3e-12 })];
    VoyageLeg {
        name: name.to_owned(),
        informative: side.is_some(),
        side,
        start_s,
        duration_s,
        maneuver_start_s: side.map(|_| start_s + 31.0),
        maneuver_s: side.map(|_| duration_s - 80.0),
        longitude_deg: 24.953_519_2,
        latitude_deg: 60.148_635_85,
        heading_deg: 45.0,
        speed_m_s,
        end_error_m: 0.4,
        largest_inputs: inputs.into_iter().map(|(name, most)| (name.to_owned(), most)).collect(),
        order: None,
        wheel_over: Vec::new(),
        abort: Some(abort(speed_m_s)),
        no_abort: None,
        drift: Some(LegDrift {
            lasts_s: 600.0,
            drifted: 264,
            aground: u64::from(speed_m_s == 0.0),
            clearance_m: if speed_m_s == 0.0 { 0.0 } else { 61.2 },
            nearest_s: 540.0,
            stopped_s: start_s,
        }),
    }
}

/// A ship at rest waits where she is.
fn abort(speed_m_s: f64) -> AbortTrack {
    let under_way = speed_m_s > 0.0;
    let to = AbortMove { action: "slower".to_owned(), i: 3, j: 2, h: 1, mode: "at rest".to_owned() };
    AbortTrack {
        kind: if under_way { WaitingPlace::Anchorage } else { WaitingPlace::OpenWater },
        longitude_deg: 24.95,
        latitude_deg: 60.14,
        depth_m: None,
        room_m: 30.0,
        towards_deg: under_way.then_some(44.6),
        distance_m: if under_way { 240.0 } else { 0.0 },
        duration_s: if under_way { 250.0 } else { 0.0 },
        moves: if under_way { vec![to] } else { Vec::new() },
        vessels: 400,
        aground: 0,
        clearance_m: under_way.then_some(85.0),
    }
}

fn primitive(maneuver: &str, fits: u64) -> Primitive {
    Primitive {
        maneuver: maneuver.to_owned(),
        side: Side::AsDesigned,
        h: 7,
        di: 3,
        dj: -1,
        to_h: 0,
        maneuver_s: 180.0,
        leg_s: 266.0,
        residual_m: 1.21,
        residual_deg: 0.252,
        spread_m: 27.0,
        fits,
    }
}

fn point(steep: u64, sway: u64, cost: f64, log_det: f64) -> FrontPoint {
    FrontPoint { counts: counts(steep, sway), cost, informative_s: 200.0 * (steep + sway) as f64, log_det }
}

fn worst_vessel(step: u64, leg: &str) -> WorstVessel {
    WorstVessel {
        step,
        leg: leg.to_owned(),
        informative: true,
        parameters_percent: BTreeMap::from([("X_tau".to_owned(), 35.0), ("X_u".to_owned(), -35.0)]),
        numbers: BTreeMap::new(),
        current_m_s: 0.15,
        towards_deg: 90.0,
    }
}
