//! Thrusters, wind and cross-flow drag: the force ahead and to starboard, and the moment.

use std::f64::consts::PI;

use ship::forces::{CrossflowSpec, Curve, Forces, ThrusterSpec, WindSpec};

use super::expression::Expression;
use super::numbers::{Numbers, motion};
use super::routine::{Line, Lines, Routine};

/// Thruster `i` of a ship.
pub(crate) fn thruster(
    forces: &Forces,
    i: usize,
    thruster_spec: &ThrusterSpec,
    numbers: &Numbers,
    name: &str,
) -> Routine {
    let number = |key: &str| numbers.of(&thruster_spec.name, key);
    let (driven, turned) = forces.thruster_inputs(i);
    let [input, u, v, r] = ["setting", "u", "v", "r"].map(Expression::name);
    let mut arguments = motion();
    arguments.push(("setting".to_owned(), numbers.driven(driven)));
    let mut lines = Lines::default();
    let angle = match turned {
        Some(channel) => {
            arguments.push(("angle".to_owned(), numbers.driven(channel)));
            Expression::name("angle")
        }
        None => number("angle_deg") * (PI / 180.0),
    };
    let angle = lines.name("direction", angle, "in which it pushes, from ahead to starboard [rad]");
    let cosine = lines.name("ahead", angle.clone().cosine(), "share of its force ahead");
    let sine = lines.name("starboard", angle.sine(), "share of its force to starboard");
    let [x, y] = ["x_m", "y_m"].map(number);
    let astern = if thruster_spec.astern.is_some() { number("astern") } else { number("ahead") };
    let coefficient = input.clone().if_positive(number("ahead"), astern);
    let force = match (&thruster_spec.loss, thruster_spec.curve) {
        (None, Curve::Force) => coefficient * input,
        (None, Curve::Square) => coefficient * input.clone() * input.modulus(),
        (Some(_), _) => {
            let along = (u - y.clone() * r.clone()) * cosine.clone() + (v + x.clone() * r) * sine.clone();
            let along = lines.name("along", along, "speed of the ship along it [m/s]");
            input.clone().modulus() * (coefficient * input - number("loss") * along)
        }
    };
    let force = lines.name("force", force, "[N]");
    let results =
        vec![force.clone() * cosine.clone(), force.clone() * sine.clone(), force * (x * sine - y * cosine)];
    let comment = format!(
        "Thruster {}: force ahead and to starboard [N], moment [N m]. Fossen, Handbook of Marine Craft Hydrodynamics and \
         Motion Control.",
        thruster_spec.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// Wind `i` on a ship.
pub(crate) fn wind(forces: &Forces, i: usize, own: &WindSpec, numbers: &Numbers, name: &str) -> Routine {
    let number = |key: &str| numbers.of(&own.name, key);
    let [speed, direction] = ["speed", "direction"].map(Expression::name);
    let [by_speed, by_direction] = forces.wind_inputs(i).map(|own| numbers.driven(own));
    let arguments = vec![("speed".to_owned(), by_speed), ("direction".to_owned(), by_direction)];
    let mut lines = Lines::default();
    let pressure = number("air_density_kg_m3") * speed.clone() * speed * -0.5;
    let pressure = lines.name("pressure", pressure, "of the wind, against it [N/m²]");
    let frontal = number("frontal_area_m2") * pressure.clone();
    let lateral = number("lateral_area_m2") * pressure;
    let harmonic = |key: &str, count: usize, cosine: bool| {
        (1..=count).fold(Expression::ZERO, |sum, k| {
            let turns = direction.clone() * k as f64;
            let part = if cosine { turns.cosine() } else { turns.sine() };
            sum + number(&format!("{key}.{k}")) * part
        })
    };
    let surge = harmonic("surge", own.surge.len(), true);
    let sway = harmonic("sway", own.sway.len(), false);
    let yaw = harmonic("yaw", own.yaw.len(), false);
    let results =
        vec![frontal * surge, lateral.clone() * sway, lateral * (yaw * numbers.get("ship.length_m"))];
    let comment = format!(
        "Wind {}: force ahead and to starboard [N], moment [N m], by harmonics of the direction that it comes from [rad]; speed \
         in m/s.",
        own.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// Cross-flow drag.
pub(crate) fn crossflow(own: &CrossflowSpec, numbers: &Numbers, name: &str) -> Routine {
    let number = |key: &str| numbers.of(&own.name, key);
    let [v, r, i, force, moment] = ["v", "r", "i", "force", "moment"].map(Expression::name);
    let strips = own.strips.unwrap_or(21);
    let length = numbers.get("ship.length_m");
    let mut lines = Lines::default();
    let strip = length.clone() / Expression::Number(f64::from(strips - 1));
    let strip = lines.name("strip", strip, "length of a strip [m]");
    let mut each = Lines::default();
    let x = each.name("x", i * strip.clone() - Expression::Number(0.5) * length, "ahead of the origin [m]");
    let across = each.name("across", v + r * x.clone(), "speed to starboard there [m/s]");
    let drag = each.name("drag", across.clone() * across.modulus(), "[m²/s²]");
    each.0.push(Line::Grow("force".to_owned(), drag.clone()));
    each.0.push(Line::Grow("moment".to_owned(), drag * x));
    lines.0.extend(["force", "moment"].map(|own| Line::Sum(own.to_owned())));
    lines.0.push(Line::Repeat(strips, each.0));
    let factor = numbers.get("density_kg_m3") * (strip * -0.5) * number("draught_m") * number("drag");
    let factor = lines.name("factor", factor, "drag of a strip over its speed squared [kg/m]");
    let results = vec![Expression::ZERO, factor.clone() * force, factor * moment];
    let comment = format!(
        "Cross-flow drag {}: force ahead and to starboard [N], moment [N m]. Faltinsen, Sea Loads on Ships and Offshore \
         Structures.",
        own.name
    );
    Routine { name: name.to_owned(), comment, arguments: motion(), lines: lines.0, results }.without_unused()
}
