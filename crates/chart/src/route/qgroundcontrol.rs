use serde_json::{Value, json};

use super::{Route, Waypoint};
use crate::Invalid;

/// MAVLink's number for a waypoint.
const WAYPOINT: u32 = 16;
/// MAVLink's number for a change of speed.
const CHANGE_SPEED: u32 = 178;
/// The frame of waypoints: heights above home.
const ABOVE_HOME: u32 = 3;
/// The frame of commands without a position.
const NO_FRAME: u32 = 2;

/// The route as a mission of a surface vessel for QGroundControl (plan file, version 1): every waypoint with
/// the speed on the leg that ends there. Maneuvers are not included: the mission leads from one to the next.
///
/// # Errors
/// As [`super::rtz`], but for the limit of 10 NM.
pub fn qgroundcontrol(route: &Route) -> Result<String, Invalid> {
    route.check()?;
    let mut items = Vec::new();
    let mut speed = None;
    for waypoint in &route.waypoints {
        if let Some(wanted) = waypoint.speed_m_s.filter(|wanted| speed != Some(*wanted)) {
            let params = [json!(1), json!(wanted), json!(-1), json!(0), json!(0), json!(0), json!(0)];
            items.push(item(items.len(), CHANGE_SPEED, NO_FRAME, &params));
            speed = Some(wanted);
        }
        items.push(go_to(items.len(), waypoint));
    }
    let cruise = route.waypoints.iter().filter_map(|w| w.speed_m_s).fold(0.0, f64::max);
    let home = &route.waypoints[0];
    let plan = json!({
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        // Not a key of the format: ground stations ignore it, users can read it.
        "description": route.name,
        "mission": {
            "version": 2,
            // ArduPilot, a surface boat.
            "firmwareType": 3,
            "vehicleType": 11,
            "cruiseSpeed": cruise,
            "hoverSpeed": cruise,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [home.lat_deg, home.lon_deg, 0],
            "items": items,
        },
        "geoFence": {"version": 2, "circles": [], "polygons": []},
        "rallyPoints": {"version": 2, "points": []},
    });
    Ok(format!("{plan:#}\n"))
}

fn go_to(place: usize, waypoint: &Waypoint) -> Value {
    let radius = json!(waypoint.turn_radius_m.unwrap_or(0.0));
    let (lat, lon) = (json!(waypoint.lat_deg), json!(waypoint.lon_deg));
    item(place, WAYPOINT, ABOVE_HOME, &[json!(0), radius, json!(0), Value::Null, lat, lon, json!(0)])
}

fn item(place: usize, command: u32, frame: u32, params: &[Value; 7]) -> Value {
    json!({"type": "SimpleItem", "autoContinue": true, "doJumpId": place + 1, "command": command, "frame": frame,
        "params": params})
}
