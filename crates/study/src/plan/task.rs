//! The task in `plan.toml`, as the planner takes it.

use chart::route::Timestamp;
use plan::voyage::{Task, current_m_s};
use plan::{Approach, DerivedHandling, Deviations, Handling, Tolerance};
use refusal::Invalid;
use ship::model::Vessel;

use super::file::PlanFile;

/// By how much of it the length over all may differ from that between perpendiculars.
const OVER_ALL: f64 = 0.2;

impl PlanFile {
    /// Refuses speeds outside the range of a model's logs.
    fn check_speeds(&self, vessel: &Vessel) -> Result<(), Invalid> {
        let Some([[low, high], ..]) = vessel.motion else { return Ok(()) };
        match self.speed_mode.iter().find(|mode| !(low..=high).contains(&mode.speed_m_s)) {
            None => Ok(()),
            Some(mode) => Err(Invalid::new(
                format!("speed mode `{}`", mode.name),
                format!("{} m/s", mode.speed_m_s),
                format!("{low:.4} to {high:.4} m/s, about what the logs of the model cover"),
                "choose such a speed, or allow it with --beyond-range",
            )),
        }
    }

    /// The task for `vessel`.
    ///
    /// # Errors
    /// Invalid numbers, or ones beyond the vessel's limits: names the key.
    pub fn task(&self, vessel: &Vessel) -> Result<Task, Invalid> {
        self.check()?;
        self.check_speeds(vessel)?;
        vessel.check_length(self.hull.length_m, "`hull.length_m`", Some(OVER_ALL))?;
        let derived = DerivedHandling::of(vessel, &self.speed_mode, self.hull.length_m)?;
        let handling = self.handling.completed(&derived)?;
        let approach = self.approach(&handling);
        self.check_sensors(&approach.tolerance)?;
        let area = self.area.area()?;
        let departure = self.departure.as_deref().map(|at| second("departure", at)).transpose()?;
        Ok(Task {
            slot: self.slot(&area, departure)?,
            area,
            cell_m: self.cell_m,
            headings: self.headings,
            raster_per_cell: self.raster_per_cell,
            uncharted: self.uncharted,
            hull: self.hull,
            safety: self.safety,
            deviations: kept(vessel, Deviations::Box(self.safety.parameter_error)),
            sensors: self.sensors.into(),
            measurement: self.measurement,
            errors_from: None,
            changes: self.changes(),
            known_current_m_s: self.known_current.map_or([0.0; 2], |known_current| {
                current_m_s(known_current.speed_m_s, known_current.towards_deg)
            }),
            handling,
            derived,
            approach,
            modes: self.speed_mode.clone(),
            speed_limits: self.speed_limit.clone(),
            maneuvers: self.maneuver.clone(),
            informative_s: self.informative_s,
            departure,
            start: self.start.clone(),
            goal: self.goal.clone(),
            cost: self.cost,
            tide: None,
            on_node: false,
        })
    }
}

/// `deviations` of `vessel`: numbers of a ship with forces stay within their bounds.
pub(super) fn kept(vessel: &Vessel, deviations: Deviations) -> Deviations {
    let bounds = vessel.model.forces.is_some().then(|| vessel.model.bounds()).flatten();
    deviations.within(bounds)
}

/// A time of day with its offset, the value of `key`, as seconds since 1970 in UTC.
pub fn second(key: &str, text: &str) -> Result<i64, Invalid> {
    let refused = |_| {
        let expected = "date, time and offset, such as 2026-06-01T08:00:00Z or 2026-06-01T11:00:00+03:00";
        Invalid::new(format!("`{key}`"), format!("`{text}`"), expected, "write it so")
    };
    text.parse::<Timestamp>().map(Timestamp::as_second).map_err(refused)
}

/// Default tolerances of a settled vessel: fraction of the allowed yaw rate, and speed \[m/s\].
const YAW_RATE: f64 = 0.15;
const SPEED_M_S: f64 = 0.1;

impl PlanFile {
    /// The approach to a maneuver, with tolerances in metres and radians.
    fn approach(&self, handling: &Handling) -> Approach {
        let approach = self.approach;
        let known = self.known_current.map_or(0.0, |current| current.speed_m_s);
        let crabbing_m_s = known + self.safety.unknown_current_m_s;
        let speed_m_s = approach.tolerance_m_s.unwrap_or(SPEED_M_S);
        Approach {
            run_in_s: approach.run_in_s,
            tolerance: Tolerance {
                distance_m: approach.tolerance_cells * self.cell_m,
                heading_rad: approach.tolerance_deg.to_radians(),
                surge_m_s: speed_m_s,
                sway_m_s: speed_m_s + crabbing_m_s,
                yaw_rate_rad_s: approach.tolerance_rad_s.unwrap_or(YAW_RATE * handling.turn_rate_rad_s),
            },
        }
    }
}
