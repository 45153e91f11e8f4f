//! Times, places and moves as the crew reads them.

use study::documents::{
    Check, CostUnit, PlanDocument, PlanLattice, PlanPose, PlanStatus, PlanStep, Side, VoyageLeg, WaitingPlace,
};

use crate::number::{exact, or_dash, percent, three};

/// One knot \[m/s\].
const KNOT: f64 = 1852.0 / 3600.0;
/// Below this a speed counts as rest \[m/s\].
const REST: f64 = 5e-3;

/// A time since the start: `01:04:52`.
pub(crate) fn clock(seconds: f64) -> String {
    or_dash(whole(seconds).map(|whole| {
        let (hours, minutes) = ((whole / 3600.0).floor(), (whole / 60.0).floor() % 60.0);
        format!("{hours:02.0}:{minutes:02.0}:{:02.0}", whole % 60.0)
    }))
}

/// A duration: `64 min 52 s`.
pub(crate) fn minutes(seconds: f64) -> String {
    let minutes = |whole: f64| format!("{:.0}\u{a0}min {:02.0}\u{a0}s", (whole / 60.0).floor(), whole % 60.0);
    or_dash(whole(seconds).map(minutes))
}

/// Whole seconds of a time that can be printed.
fn whole(seconds: f64) -> Option<f64> {
    (seconds.is_finite() && seconds >= 0.0).then(|| seconds.round())
}

/// Degrees and decimal minutes, to a thousandth of a minute: `60° 08.918′ N`.
pub(crate) fn latitude(degrees: f64) -> String {
    place(degrees, 2, ["N", "S"])
}

/// As [`latitude`]: `024° 57.211′ E`.
pub(crate) fn longitude(degrees: f64) -> String {
    place(degrees, 3, ["E", "W"])
}

fn place(degrees: f64, digits: usize, sides: [&str; 2]) -> String {
    if !degrees.is_finite() {
        return "–".to_owned();
    }
    let thousandths = (degrees.abs() * 60_000.0).round();
    let side = sides[usize::from(degrees < 0.0 && thousandths > 0.0)];
    let (whole, rest) = ((thousandths / 60_000.0).floor(), thousandths % 60_000.0 / 1000.0);
    format!("{whole:0digits$.0}°\u{a0}{rest:06.3}′\u{a0}{side}")
}

/// A compass heading of three digits: `045°`.
pub(crate) fn heading(degrees: f64) -> String {
    let finite = degrees.is_finite().then(|| degrees.rem_euclid(360.0).round() % 360.0);
    or_dash(finite.map(|degrees| format!("{degrees:03.0}°")))
}

/// Compass heading of level `h` of the lattice, which counts counter-clockwise from east.
pub(crate) fn level(lattice: &PlanLattice, h: u64) -> String {
    heading((90.0 - h as f64 * 360.0 / lattice.headings as f64).rem_euclid(360.0))
}

/// A speed in knots: `2.9`.
pub(crate) fn knots(speed_m_s: f64) -> String {
    if speed_m_s.is_finite() { format!("{:.1}", speed_m_s / KNOT) } else { "–".to_owned() }
}

/// A distance in nautical miles: `0.43`.
pub(crate) fn miles(distance_m: f64) -> String {
    if distance_m.is_finite() { format!("{:.2}", distance_m / 1852.0) } else { "–".to_owned() }
}

/// A cost with its unit: `10 basic moves`, `3629 s`.
pub(crate) fn cost(value: f64, unit: CostUnit) -> String {
    let number = exact((value * 1e3).round() / 1e3);
    match unit {
        CostUnit::BasicMoves if value == 1.0 => "1 basic move".to_owned(),
        CostUnit::BasicMoves => format!("{number} basic moves"),
        CostUnit::Seconds => format!("{number}\u{a0}s"),
        CostUnit::Cost => number,
    }
}

/// The optimality gap of a plan that is not proved optimal.
pub(crate) fn gap(plan: &PlanDocument) -> Option<String> {
    (plan.status == PlanStatus::Feasible)
        .then(|| format!("at most {} dearer than the best", cost(plan.gap, plan.cost_unit)))
}

/// The clearance of the hull from obstacles; `None` if it touches one. The distance is measured on a raster that
/// never overstates it.
pub(crate) fn clearance(check: &Check) -> Option<String> {
    let (how, metres) = match check.clearance_m >= check.sight_m {
        true => ("more than", check.sight_m),
        false => ("at least", check.clearance_m),
    };
    check.clear.then(|| format!("{how} {}\u{a0}m", three(metres)))
}

/// The title of the cost, for a column or an axis.
pub(crate) fn cost_title(unit: CostUnit) -> &'static str {
    match unit {
        CostUnit::BasicMoves => "basic moves",
        CostUnit::Seconds => "cost [s]",
        CostUnit::Cost => "cost",
    }
}

/// A count of a total: `17 of 64 (26.6 %)`.
pub(crate) fn part(count: u64, of: u64) -> String {
    if of == 0 {
        return "none simulated".to_owned();
    }
    format!("{count} of {of} ({})", percent(count as f64 / of as f64))
}

/// What becomes of the ship if it fails on a leg: `wait at 045°, 0.13 NM, 4 min 10 s; drifts to 60 m off`.
pub(crate) fn failing(leg: &VoyageLeg) -> String {
    let way = match &leg.abort {
        None => {
            leg.no_abort.as_ref().map_or_else(|| "–".to_owned(), |why| format!("no place to wait: {why}"))
        }
        Some(abort) => {
            let place = if abort.kind == WaitingPlace::Anchorage { "anchorage" } else { "wait" };
            match abort.towards_deg {
                None => format!("{place} here"),
                Some(bearing) => format!(
                    "{place} at {}, {}\u{a0}NM, {}",
                    heading(bearing),
                    miles(abort.distance_m),
                    minutes(abort.duration_s)
                ),
            }
        }
    };
    let Some(drift) = &leg.drift else { return way };
    match drift.aground {
        0 => format!("{way}; drifts to {}\u{a0}m off", three(drift.clearance_m)),
        _ => format!("{way}; drifts aground in {}", minutes(drift.nearest_s)),
    }
}

/// The action of a leg, in plain words.
pub(crate) fn action(step: &PlanStep, leg: &VoyageLeg, lattice: &PlanLattice) -> String {
    if let Some(order) = &leg.order {
        return order.clone();
    }
    if leg.informative {
        return match leg.side {
            Some(Side::Mirrored) => format!("{}, mirrored (starts to the other side)", leg.name),
            Some(side) => format!("{}, {}", leg.name, side.name()),
            None => leg.name.clone(),
        };
    }
    match leg.name.as_str() {
        "straight" => "straight ahead".to_owned(),
        "turn-port" => format!("turn to port {}", turn(step, leg, lattice)),
        "turn-starboard" => format!("turn to starboard {}", turn(step, leg, lattice)),
        "faster" => format!("faster{}", new_speed(&step.to, lattice)),
        "slower" => format!("slower{}", new_speed(&step.to, lattice)),
        other => other.to_owned(),
    }
}

fn turn(step: &PlanStep, leg: &VoyageLeg, lattice: &PlanLattice) -> String {
    let how = if leg.speed_m_s.abs() < REST { "on the spot" } else { "under way" };
    format!("{how}, to\u{a0}{}", level(lattice, step.to.h))
}

fn new_speed(to: &PlanPose, lattice: &PlanLattice) -> String {
    match to.mode.as_ref().and_then(|mode| lattice.modes.get(mode)) {
        Some(speed) if speed.abs() < REST => ", to a stop".to_owned(),
        Some(speed) => format!(", to {}\u{a0}m/s ({}\u{a0}kn)", three(*speed), knots(*speed)),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_carry_into_minutes_and_hours() {
        assert_eq!(
            [0.0, 59.6, 3892.0, 360_000.0].map(clock),
            ["00:00:00", "00:01:00", "01:04:52", "100:00:00"]
        );
        assert_eq!(minutes(3892.4), "64\u{a0}min 52\u{a0}s");
        assert_eq!(minutes(59.7), "1\u{a0}min 00\u{a0}s");
        assert_eq!([f64::NAN, -1.0].map(clock), ["–", "–"]);
    }

    #[test]
    fn places_carry_into_degrees_and_name_their_side() {
        assert_eq!(latitude(60.148_635_853), "60°\u{a0}08.918′\u{a0}N");
        assert_eq!(longitude(24.953_519_201), "024°\u{a0}57.211′\u{a0}E");
        assert_eq!(longitude(-0.999_999_99), "001°\u{a0}00.000′\u{a0}W");
        assert_eq!(latitude(-1e-9), "00°\u{a0}00.000′\u{a0}N");
        assert_eq!(latitude(f64::NAN), "–");
    }

    #[test]
    fn headings_have_three_digits_and_no_360() {
        assert_eq!([45.0, 359.7, -90.0, 360.0, f64::NAN].map(heading), ["045°", "000°", "270°", "000°", "–"]);
    }

    #[test]
    fn miles_are_nautical() {
        assert_eq!([0.0, 1852.0, 463.0, f64::NAN].map(miles), ["0.00", "1.00", "0.25", "–"]);
    }

    #[test]
    fn knots_are_nautical_miles_per_hour() {
        assert_eq!([0.0, 1.5, 3.0].map(knots), ["0.0", "2.9", "5.8"]);
    }
}
