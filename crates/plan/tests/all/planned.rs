//! Trials of the vessel of the Helsinki study around an island, planned in memory.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use chart::{Layer, LayerKind, PolygonLayer, Uncharted};
use maneuver::Generator;
use plan::voyage::{
    AbortRule, Area, Brief, CostRule, Failing, Goal, Hull, ManeuverUse, Place, Prepared, Primary, Safety,
    SailedPlan, Sailing, Search, Secondary, Shares, Solved, SpeedLimit, Task, Tide, Times,
};
use plan::{Approach, DerivedHandling, Deviations, Handling, Mode, Sensors, Tolerance};
use ship::engine::{Changes, Run};
use ship::model::{Source, Vessel};
use trial::campaign::Maneuvers;

use crate::legs::generator;

const HANDLING: Handling = Handling {
    turn_rate_rad_s: 0.05,
    crawl_m_s: 0.5,
    acceleration_m_s2: 0.05,
    response_s: 30.0,
    lookahead_m: 60.0,
};

/// West, south, east, north of the island in degrees.
pub const ISLAND_DEG: [f64; 4] = [24.998, 59.999, 25.002, 60.001];

/// A planned trial.
pub struct Planned {
    pub prepared: Prepared,
    pub solved: Solved,
    pub sailing: Sailing,
}

impl Planned {
    fn of(brief: Brief) -> Self {
        let search = Search::unlimited();
        let mut prepared = Prepared::new(brief, &search).unwrap();
        let (solved, sailing) = prepared.plan(&search, false).unwrap();
        assert!(sailing.check.safe, "{:?}", sailing.check.faults);
        Self { prepared, solved, sailing }
    }

    pub fn plan(&self) -> SailedPlan<'_> {
        SailedPlan { prepared: &self.prepared, solved: &self.solved, sailing: &self.sailing }
    }

    pub fn rate_hz(&self) -> f64 {
        self.prepared.brief.vessel.sample_rate_hz
    }
}

/// The trial in still water, with little to keep in mind: home again with as few moves as possible.
pub fn small() -> &'static Planned {
    static PLANNED: LazyLock<Planned> = LazyLock::new(|| Planned::of(small_brief()));
    &PLANNED
}

/// The trial among depths, in a tide, with other vessels, noisy sensors, a speed limit and a part of the box.
pub fn rich() -> &'static Planned {
    static PLANNED: LazyLock<Planned> = LazyLock::new(|| Planned::of(rich_brief()));
    &PLANNED
}

/// A run of every maneuver of the study, by the nominal vessel.
pub fn dictionary(vessel: &Vessel, generator: &Generator) -> Vec<Run> {
    let maneuvers = Maneuvers::new(vessel, generator, Source::Nominal, "dictionary").unwrap();
    let (runs, _) = maneuvers.simulate(0..maneuvers.count()).unwrap();
    runs.into_iter().map(|simulated| simulated.run).collect()
}

/// A rectangle as a polygon of GeoJSON with `properties`.
fn feature([west, south, east, north]: [f64; 4], properties: &str) -> String {
    format!(
        "{{\"type\": \"Feature\", \"properties\": {{{properties}}}, \"geometry\": {{\"type\": \"Polygon\", \
         \"coordinates\": [[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], \
         [{west}, {south}]]]}}}}"
    )
}

fn layer(features: &[String], kind: &LayerKind) -> Layer {
    let text = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(", "));
    Layer::Polygons(PolygonLayer::from_geojson(&text, kind, None).unwrap())
}

fn used(name: &str, count: Option<u32>, piece_s: Option<f64>) -> ManeuverUse {
    ManeuverUse { name: name.to_owned(), count, piece_s }
}

pub fn mode(name: &str, speed_m_s: f64) -> Mode {
    Mode { name: name.to_owned(), speed_m_s }
}

/// The small trial before it is planned.
pub fn small_brief() -> Brief {
    let (vessel, generator) = generator();
    let modes = vec![mode("half", 1.5)];
    let hull = Hull {
        length_m: 30.0,
        beam_m: 8.0,
        reference_m: 0.0,
        air_draught_m: None,
        draught_m: None,
        block_coefficient: None,
    };
    let tolerance = Tolerance {
        distance_m: 12.0,
        heading_rad: 6.0_f64.to_radians(),
        surge_m_s: 0.1,
        sway_m_s: 0.15,
        yaw_rate_rad_s: 0.0075,
    };
    let task = Task {
        area: Area {
            west_deg: 24.98,
            south_deg: 59.99,
            east_deg: 25.02,
            north_deg: 60.01,
            corners: Vec::new(),
        },
        cell_m: 120.0,
        headings: 4,
        raster_per_cell: 4,
        uncharted: Some(Uncharted::Water),
        hull,
        safety: Safety {
            transit_depth_m: 0.0,
            trial_depth_m: 0.0,
            margin_m: 20.0,
            under_keel_m: None,
            unknown_current_m_s: 0.05,
            parameter_error: 0.0,
            standard_errors: None,
            runs: Some(4),
            vessels: None,
            aground_probability: None,
        },
        deviations: Deviations::Box(0.0),
        measurement: None,
        errors_from: None,
        sensors: Sensors::default(),
        changes: Changes::default(),
        known_current_m_s: [0.0; 2],
        handling: HANDLING,
        derived: DerivedHandling::of(&vessel, &modes, hull.length_m).unwrap(),
        approach: Approach { run_in_s: 30.0, tolerance },
        modes,
        speed_limits: Vec::new(),
        maneuvers: vec![used("zig-zag-steep", Some(1), None), used("sway-zig-zag", Some(1), None)],
        informative_s: None,
        departure: None,
        start: Place { longitude_deg: 24.985, latitude_deg: 60.0, heading_deg: 0.0, mode: None },
        goal: Goal::Home {},
        cost: CostRule::default(),
        tide: None,
        slot: None,
        times: Times::default(),
        on_node: false,
        failing: Failing { abort: AbortRule::Told, drift_s: 600.0, room_m: None },
        crossing_rad: 0.35,
    };
    let dictionary = dictionary(&vessel, &generator);
    let layers = vec![layer(&[feature(ISLAND_DEG, "\"name\": \"Holm\"")], &LayerKind::Land)];
    let programs = BTreeMap::new();
    Brief { vessel, task, layers, chart_bytes: 0, dictionary, programs, design: None, seed: 1 }
}

/// The rich trial before it is planned.
pub fn rich_brief() -> Brief {
    let small = small_brief();
    let depth = |bounds, least: f64| feature(bounds, &format!("\"least\": {least}"));
    let kind = LayerKind::Depth { least: "least".to_owned() };
    let depths = [
        depth([24.9, 59.95, 25.1, 60.05], 20.0),
        depth([24.984, 59.992, 24.99, 59.995], 5.0),
        depth([25.008, 60.003, 25.012, 60.006], 2.0),
    ];
    let rock = LayerKind::Danger { least: "least".to_owned() };
    let rocks = [depth([25.006, 59.9945, 25.0062, 59.9946], 1.0)];
    let layers = small.layers.iter().cloned().chain([layer(&depths, &kind), layer(&rocks, &rock)]).collect();
    let modes = vec![mode("slow", 0.8), mode("half", 1.5)];
    let corners = [[24.98, 59.99], [25.02, 59.99], [25.02, 60.008], [25.015, 60.01], [24.98, 60.01]];
    let limited = [[24.98, 60.004], [24.992, 60.004], [24.992, 60.01], [24.98, 60.01]];
    let order = ["zig-zag-steep", "sway-zig-zag"].map(str::to_owned);
    let share = order.iter().cloned().zip([0.45, 0.55]).collect();
    let sensors = Sensors { position_m: 1.0, heading_rad: 0.005, speed_m_s: 0.02, yaw_rate_rad_s: 0.0005 };
    let task = Task {
        area: Area { corners: corners.to_vec(), ..small.task.area },
        uncharted: None,
        hull: Hull { reference_m: 4.0, draught_m: Some(3.0), ..small.task.hull },
        safety: Safety {
            transit_depth_m: 4.0,
            trial_depth_m: 8.0,
            margin_m: 25.0,
            parameter_error: 0.05,
            runs: Some(12),
            ..small.task.safety
        },
        deviations: Deviations::Box(0.05),
        sensors,
        known_current_m_s: [0.06, -0.04],
        derived: DerivedHandling::of(&small.vessel, &modes, small.task.hull.length_m).unwrap(),
        approach: Approach {
            tolerance: Tolerance { sway_m_s: 0.25, ..small.task.approach.tolerance },
            ..small.task.approach
        },
        modes,
        speed_limits: vec![SpeedLimit {
            name: Some("harbour".to_owned()),
            corners: limited.to_vec(),
            max_speed_m_s: 1.0,
        }],
        maneuvers: vec![used("zig-zag-steep", None, Some(110.0)), used("sway-zig-zag", None, None)],
        informative_s: Some(430.0),
        departure: Some(1_780_300_800),
        goal: Goal::Any {},
        cost: CostRule { primary: Primary::Seconds, secondary: Secondary::Clearance },
        on_node: true,
        ..small.task
    };
    let tide = Tide { slot_s: 7200.0, level_m: 0.5, stream_m_s: [0.02, 0.03], spread_m_s: 0.02 };
    let design = Some(Shares { order: order.to_vec(), share });
    Brief { task: task.with_tide(tide), layers, design, seed: 3, ..small }
}
