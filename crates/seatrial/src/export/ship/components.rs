//! Thrusters, wind and cross-flow drag: the force ahead and to starboard, and the moment.

use std::f64::consts::PI;

use ship::forces::{
    Coriolis, CrossflowSpec, Curve, Forces, Inflow, MOTION, PropellerSpec, RudderSpec, ThrusterSpec, WindSpec,
};

use super::expression::{Expression, Line, Lines, Numbers, Routine, motion};

/// Thruster `i` of a ship.
pub(crate) fn thruster(
    forces: &Forces,
    i: usize,
    spec: &ThrusterSpec,
    numbers: &Numbers,
    name: &str,
) -> Routine {
    let number = |key: &str| numbers.of(&spec.name, key);
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
    let astern = if spec.astern.is_some() { number("astern") } else { number("ahead") };
    let coefficient = input.clone().if_positive(number("ahead"), astern);
    let force = match (&spec.loss, spec.curve) {
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
        spec.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// Wind `i` on a ship.
pub(crate) fn wind(forces: &Forces, i: usize, spec: &WindSpec, numbers: &Numbers, name: &str) -> Routine {
    let number = |key: &str| numbers.of(&spec.name, key);
    let [speed, direction] = ["speed", "direction"].map(Expression::name);
    let [by_speed, by_direction] = forces.wind_inputs(i).map(|channel| numbers.driven(channel));
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
    let surge = harmonic("surge", spec.surge.len(), true);
    let sway = harmonic("sway", spec.sway.len(), false);
    let yaw = harmonic("yaw", spec.yaw.len(), false);
    let results =
        vec![frontal * surge, lateral.clone() * sway, lateral * (yaw * numbers.get("ship.length_m"))];
    let comment = format!(
        "Wind {}: force ahead and to starboard [N], moment [N m], by harmonics of the direction that it comes from [rad]; speed \
         in m/s.",
        spec.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// Cross-flow drag.
pub(crate) fn crossflow(spec: &CrossflowSpec, numbers: &Numbers, name: &str) -> Routine {
    let number = |key: &str| numbers.of(&spec.name, key);
    let [v, r, i, force, moment] = ["v", "r", "i", "force", "moment"].map(Expression::name);
    let strips = spec.strips.unwrap_or(21);
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
    lines.0.extend(["force", "moment"].map(|total| Line::Sum(total.to_owned())));
    lines.0.push(Line::Repeat(strips, each.0));
    let factor = numbers.get("density_kg_m3") * (strip * -0.5) * number("draught_m") * number("drag");
    let factor = lines.name("factor", factor, "drag of a strip over its speed squared [kg/m]");
    let results = vec![Expression::ZERO, factor.clone() * force, factor * moment];
    let comment = format!(
        "Cross-flow drag {}: force ahead and to starboard [N], moment [N m]. Faltinsen, Sea Loads on Ships and Offshore \
         Structures.",
        spec.name
    );
    Routine { name: name.to_owned(), comment, arguments: motion(), lines: lines.0, results }.without_unused()
}

// Terms of hull forces, and what accelerates the ship under all forces.

/// The terms of surge, sway and yaw.
pub(crate) fn hull(forces: &Forces, numbers: &Numbers, name: &str) -> Routine {
    let description = forces.description();
    let mut arguments = motion();
    let channels = numbers.channels.iter().enumerate().skip(3);
    arguments.extend(channels.map(|(i, channel)| (channel.clone(), Expression::Channel(i))));
    let variable = |i: usize| match MOTION.get(i) {
        Some(symbol) => Expression::name(symbol),
        None => Expression::name(&numbers.channels[3 + i - MOTION.len()]),
    };
    let mut lines = Lines::default();
    let mut results = Vec::new();
    for (d, (terms, (name, comment))) in description.terms().into_iter().zip(SUMS).enumerate() {
        let term = |(i, spec): (usize, &ship::forces::TermSpec)| {
            forces.factors(d, i).iter().fold(numbers.get(&spec.parameter), |product, factor| {
                let value = variable(factor.variable);
                let value = if factor.modulus { value.modulus() } else { value };
                if factor.divides { product / value } else { product * value }
            })
        };
        let sum = terms.iter().enumerate().map(term).fold(Expression::ZERO, |sum, product| sum + product);
        results.push(lines.name(name, sum, comment));
    }
    let comment =
        "Hydrodynamic derivatives of the hull: force ahead and to starboard [N], moment [N m].".to_owned();
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// The sums over terms.
const SUMS: [(&str, &str); 3] = [("surge", "[N]"), ("sway", "[N]"), ("yaw", "[N m]")];

/// Accelerations under a force ahead and to starboard and a moment.
pub(crate) fn rigid_body(forces: &Forces, numbers: &Numbers, name: &str, sums: [Expression; 3]) -> Routine {
    let ship = &forces.description().ship;
    let number = |key: &str| numbers.of("ship", key);
    let added = |key: &str| numbers.of("ship.added_mass", key);
    let [u, v, r] = ["u", "v", "r"].map(Expression::name);
    let mut lines = Lines::default();
    let (mass, x_g) = (number("mass_kg"), number("x_g_m"));
    let surge = lines.name("m_u", mass.clone() + added("surge"), "mass in surge [kg]");
    let sway = lines.name("m_v", mass.clone() + added("sway"), "mass in sway [kg]");
    let first = lines.name("m_x", mass.clone() * x_g.clone(), "mass times the place of its centre [kg m]");
    let inertia = match ship.inertia_kg_m2 {
        Some(_) => number("inertia_kg_m2"),
        None => mass * (number("gyration_m") * number("gyration_m") + x_g.clone() * x_g),
    };
    let yaw = lines.name("i_r", inertia + added("yaw"), "moment of inertia [kg m²]");
    let [a, b] = ["sway_yaw", "yaw_sway"].map(added);
    let by_yaw =
        lines.name("m_vr", first.clone() + a.clone(), "force to starboard by yaw acceleration [kg m]");
    let by_sway = lines.name("m_rv", first.clone() + b.clone(), "moment by sway acceleration [kg m]");
    let determinant = sway.clone() * yaw.clone() - by_yaw.clone() * by_sway.clone();
    let determinant = lines.name("determinant", determinant, "[kg² m²]");
    let coriolis = ship.coriolis.unwrap_or(Coriolis::WithoutMunk);
    let [mut ahead, mut starboard, mut moment] = FORCES.map(Expression::name);
    if coriolis != Coriolis::Absent {
        let turning = sway.clone() * v.clone() * r.clone() + first.clone() * r.clone() * r.clone();
        ahead = ahead + turning;
        starboard = starboard - surge.clone() * u.clone() * r.clone();
        moment = moment - first * u.clone() * r.clone();
    }
    if coriolis == Coriolis::Full {
        let coupling = lines.name("coupling", (a + b) * 0.5, "added mass of sway and yaw together [kg m]");
        let munk = (sway.clone() - surge.clone()) * u.clone() * v + coupling.clone() * u * r.clone();
        let munk = lines.name("munk", munk, "the Munk moment [N m]");
        ahead = ahead + coupling * r.clone() * r;
        moment = moment - munk;
    }
    let ahead = lines.name("surge", ahead, "with products of mass and yaw rate [N]");
    let starboard = lines.name("sway", starboard, "the same [N]");
    let moment = lines.name("yaw", moment, "the same [N m]");
    let over = |value: Expression| value / determinant.clone();
    let zero = || Expression::ZERO;
    let results = vec![
        ahead * (Expression::ONE / surge),
        over(yaw) * starboard.clone() + over(zero() - by_yaw) * moment.clone(),
        over(zero() - by_sway) * starboard + over(sway) * moment,
    ];
    let mut arguments = motion();
    arguments.extend(FORCES.into_iter().map(str::to_owned).zip(sums));
    let comment = "Changes per second of u, v [m/s²] and r [rad/s²] under a force ahead and to starboard [N] and a moment [N m]: \
                   mass, added mass, and the products of mass and yaw rate about the origin amidships."
        .to_owned();
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// The arguments with all forces.
const FORCES: [&str; 3] = ["force_x", "force_y", "moment_z"];

// Propellers and rudders: the force ahead and to starboard, and the moment.

/// What a propeller does to the water behind it, after its forces: inflow, jet, reversed.
const WASH: [&str; 3] = ["inflow", "jet", "reversed"];

/// u_P: the speed of the water that flows to a propeller.
fn inflow(spec: &PropellerSpec, numbers: &Numbers, lines: &mut Lines) -> Expression {
    let number = |key: &str| numbers.of(&spec.name, key);
    let [u, v, r, speed] = ["u", "v", "r", "U"].map(Expression::name);
    let one = || Expression::ONE;
    let drift = (Expression::ZERO - v).angle(u.clone().modulus()) - number("x_m") * r / speed;
    let drift = lines.name("drift", drift, "at the propeller [rad]");
    let [positive, negative] = numbers.both(&spec.name, "wake_ratio");
    let ratio = drift.clone().if_positive(positive, negative);
    let share = one() - (Expression::ZERO - number("wake_change") * drift.modulus()).exponential();
    let share = lines.name("share", share, "how far the wake has changed");
    let flow = (one() - number("wake")) * (one() + share * (ratio - one())) * u;
    lines.name("inflow", flow, "u_P, speed of the water that flows to it [m/s]")
}

/// Propeller `i` of a ship, with the first `wash` of what it does to the water.
pub(crate) fn propeller(
    forces: &Forces,
    i: usize,
    spec: &PropellerSpec,
    numbers: &Numbers,
    name: &str,
    wash: usize,
) -> Routine {
    let number = |key: &str| numbers.of(&spec.name, key);
    let n = Expression::name("n");
    let mut arguments = motion();
    arguments.push(("n".to_owned(), numbers.driven(forces.propeller_input(i))));
    let mut lines = Lines::default();
    let inflow = inflow(spec, numbers, &mut lines);
    let diameter = number("diameter_m");
    let tip = n.clone().if_positive(n.clone(), Expression::ZERO) * diameter.clone();
    let tip = lines.name("tip", tip, "n D ahead [m/s]");
    let [k_0, k_1, k_2] = [0, 1, 2].map(|k| number(&format!("thrust.{k}")));
    let thrust =
        k_0 * tip.clone() * tip.clone() + k_1 * tip * inflow.clone() + k_2 * inflow.clone() * inflow.clone();
    let thrust = lines.name("thrust", thrust, "over the density and D squared [m²/s²]");
    let jet = (inflow.clone() * inflow.clone() + thrust.clone() * (8.0 / PI)).root();
    let jet = lines.name("jet", jet, "speed of its jet far behind it [m/s]");
    let back = n.clone().if_positive(Expression::ZERO, n);
    let back = lines.name("back", back, "revolutions where it is reversed [1/s]");
    let reversed = lines.name("reversed", back.clone() * diameter.clone(), "n D where it is reversed [m/s]");
    let square = diameter.clone() * diameter.clone() * numbers.get("density_kg_m3");
    let square = lines.name("square", square, "density times D squared [kg/m]");
    let mut surge = (Expression::ONE - number("deduction")) * square.clone() * thrust;
    let (mut sway, mut yaw) = (Expression::ZERO, Expression::ZERO);
    if spec.astern.is_some() {
        let by_square = reversed.clone() * back.modulus() * diameter;
        let by_square = lines.name("by_square", by_square, "[m²/s²]");
        let by_inflow = lines.name("by_inflow", reversed.clone() * inflow.clone(), "[m²/s²]");
        let force = |key: &str| {
            let [a, b] = numbers.both(&spec.name, &format!("astern.{key}"));
            let sum = a * by_square.clone() + b * by_inflow.clone();
            square.clone() * sum
        };
        surge = surge + force("surge");
        sway = force("sway");
        yaw = force("yaw") * numbers.get("ship.length_m");
    }
    let surge = lines.name("surge", surge, "[N]");
    let mut results = vec![surge.clone(), sway, yaw - number("y_m") * surge];
    let mut comment = format!("Propeller {}: force ahead and to starboard [N], moment [N m]", spec.name);
    if wash > 0 {
        comment += ", speeds of its inflow and its jet [m/s]";
    }
    if wash > 2 {
        comment += ", n D where it is reversed [m/s]";
    }
    results.extend([inflow, jet, reversed].into_iter().take(wash));
    comment += "; n in 1/s. Yasukawa and Yoshimura, Introduction of MMG standard method for ship maneuvering predictions, \
                2015; without division by the advance ratio.";
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}

/// How much of the wash of the propeller in front of it a rudder takes.
pub(crate) fn taken(spec: &RudderSpec) -> usize {
    if spec.reversed_flow.is_some() { WASH.len() } else { WASH.len() - 1 }
}

/// u_R: the speed of the flow along a rudder, behind `propeller` if there is one.
fn along(spec: &RudderSpec, numbers: &Numbers, propeller: Option<&str>, lines: &mut Lines) -> Expression {
    let number = |key: &str| numbers.of(&spec.name, key);
    let comment = "u_R, speed of the flow along it [m/s]";
    let Some(propeller) = propeller else {
        return lines.name("along", number("epsilon") * Expression::name("u"), comment);
    };
    let [inflow, jet, reversed] = WASH.map(Expression::name);
    let here = inflow.clone() + number("kappa") * (jet - inflow.clone());
    let here = lines.name("here", here, "speed of the jet at the rudder [m/s]");
    let share = numbers.of(propeller, "diameter_m") / number("height_m");
    let share = lines.name("share", share, "of the rudder in the jet");
    let square = share.clone() * here.clone() * here.modulus()
        + (Expression::ONE - share) * inflow.clone() * inflow.modulus();
    let square = lines.name("square", square, "[m²/s²]");
    let flow = square.clone().sign() * square.modulus().square_root();
    let along = number("epsilon") * flow + number("reversed_flow") * reversed;
    lines.name("along", along, comment)
}

/// Rudder `i` of a ship, behind the propeller of that name whose results are named `wash`.
pub(crate) fn rudder(
    forces: &Forces,
    i: usize,
    spec: &RudderSpec,
    numbers: &Numbers,
    name: &str,
    wash: Option<(&str, &str)>,
) -> Routine {
    let number = |key: &str| numbers.of(&spec.name, key);
    let (one, zero) = (|| Expression::ONE, || Expression::ZERO);
    let mut arguments = motion();
    arguments.push(("angle".to_owned(), numbers.driven(forces.rudder_input(i).0)));
    if let Some((_, results)) = wash {
        let item = |(k, spec): (usize, &str)| (spec.to_owned(), Expression::Item(results.to_owned(), 3 + k));
        arguments.extend(WASH.into_iter().enumerate().map(item));
    }
    let mut lines = Lines::default();
    let along = along(spec, numbers, wash.map(|(propeller, _)| propeller), &mut lines);
    let [u, v, r, speed, angle] = ["u", "v", "r", "U", "angle"].map(Expression::name);
    let drift = match spec.inflow.unwrap_or(Inflow::Velocity) {
        Inflow::Velocity => zero() - v,
        Inflow::Angle => speed * (zero() - v).angle(u),
    };
    let drift = drift - number("ell") * (r * numbers.get("ship.length_m"));
    let drift = lines.name("drift", drift, "speed across it as of a rudder alone, to port [m/s]");
    let [positive, negative] = numbers.both(&spec.name, "gamma");
    let across = drift.clone().if_positive(positive, negative) * drift;
    let across = lines.name("across", across, "v_R, speed of the flow across it, to port [m/s]");
    let flow = across.clone().angle(along.clone().modulus());
    let flow = lines.name("flow", flow, "angle of the flow [rad]");
    let sign = (zero() - along.clone()).if_positive(Expression::Number(-1.0), one());
    let sign = lines.name("sense", sign, "-1 where it flows astern");
    let pressure = (along.clone() * along + across.clone() * across) * 0.5;
    let pressure = lines.name("pressure", pressure, "over the density [m²/s²]");
    let sine = (angle.clone() - sign.clone() * flow).sine();
    let normal = sign * pressure * number("area_m2") * number("lift_slope") * sine;
    let normal = lines.name("normal", normal * numbers.get("density_kg_m3"), "F_N, force normal to it [N]");
    let ahead = (one() - number("deduction")) * normal.clone() * angle.clone().sine();
    let ahead = lines.name("drag", ahead, "[N]");
    let starboard = lines.name("side", normal * angle.cosine(), "[N]");
    let arm = number("x_m") + number("interaction") * number("interaction_x_m");
    let results = vec![
        zero() - ahead.clone(),
        zero() - (one() + number("interaction")) * starboard.clone(),
        number("y_m") * ahead - arm * starboard,
    ];
    let comment = format!(
        "Rudder {}: force ahead and to starboard [N], moment [N m]; angle in rad. Yasukawa and Yoshimura, Introduction of MMG \
         standard method for ship maneuvering predictions, 2015.",
        spec.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}
