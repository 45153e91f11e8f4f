//! Propellers and rudders: the force ahead and to starboard, and the moment.

use std::f64::consts::PI;

use ship::forces::{Forces, Inflow, PropellerSpec, RudderSpec};

use super::expression::Expression;
use super::numbers::{Numbers, motion};
use super::routine::{Lines, Routine};

/// What a propeller does to the water behind it, after its forces: inflow, jet, reversed.
const WASH: [&str; 3] = ["inflow", "jet", "reversed"];

/// u_P: the speed of the water that flows to a propeller.
fn inflow(propeller_spec: &PropellerSpec, numbers: &Numbers, lines: &mut Lines) -> Expression {
    let number = |key: &str| numbers.of(&propeller_spec.name, key);
    let [u, v, r, speed] = ["u", "v", "r", "U"].map(Expression::name);
    let one = || Expression::ONE;
    let drift = (Expression::ZERO - v).angle(u.clone().modulus()) - number("x_m") * r / speed;
    let drift = lines.name("drift", drift, "at the propeller [rad]");
    let [positive, negative] = numbers.both(&propeller_spec.name, "wake_ratio");
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
    propeller_spec: &PropellerSpec,
    numbers: &Numbers,
    name: &str,
    wash: usize,
) -> Routine {
    let number = |key: &str| numbers.of(&propeller_spec.name, key);
    let n = Expression::name("n");
    let mut arguments = motion();
    arguments.push(("n".to_owned(), numbers.driven(forces.propeller_input(i))));
    let mut lines = Lines::default();
    let inflow = inflow(propeller_spec, numbers, &mut lines);
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
    if propeller_spec.astern.is_some() {
        let by_square = reversed.clone() * back.modulus() * diameter;
        let by_square = lines.name("by_square", by_square, "[m²/s²]");
        let by_inflow = lines.name("by_inflow", reversed.clone() * inflow.clone(), "[m²/s²]");
        let force = |key: &str| {
            let [a, b] = numbers.both(&propeller_spec.name, &format!("astern.{key}"));
            let sum = a * by_square.clone() + b * by_inflow.clone();
            square.clone() * sum
        };
        surge = surge + force("surge");
        sway = force("sway");
        yaw = force("yaw") * numbers.get("ship.length_m");
    }
    let surge = lines.name("surge", surge, "[N]");
    let mut results = vec![surge.clone(), sway, yaw - number("y_m") * surge];
    let mut comment =
        format!("Propeller {}: force ahead and to starboard [N], moment [N m]", propeller_spec.name);
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
pub(crate) fn taken(rudder_spec: &RudderSpec) -> usize {
    if rudder_spec.reversed_flow.is_some() { WASH.len() } else { WASH.len() - 1 }
}

/// u_R: the speed of the flow along a rudder, behind `propeller` if there is one.
fn along(
    rudder_spec: &RudderSpec,
    numbers: &Numbers,
    propeller: Option<&str>,
    lines: &mut Lines,
) -> Expression {
    let number = |key: &str| numbers.of(&rudder_spec.name, key);
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
    rudder_spec: &RudderSpec,
    numbers: &Numbers,
    name: &str,
    wash: Option<(&str, &str)>,
) -> Routine {
    let number = |key: &str| numbers.of(&rudder_spec.name, key);
    let (one, zero) = (|| Expression::ONE, || Expression::ZERO);
    let mut arguments = motion();
    arguments.push(("angle".to_owned(), numbers.driven(forces.rudder_input(i).0)));
    if let Some((_, results)) = wash {
        let item = |(k, rudder_spec): (usize, &str)| {
            (rudder_spec.to_owned(), Expression::Item(results.to_owned(), 3 + k))
        };
        arguments.extend(WASH.into_iter().enumerate().map(item));
    }
    let mut lines = Lines::default();
    let along = along(rudder_spec, numbers, wash.map(|(propeller, _)| propeller), &mut lines);
    let [u, v, r, speed, angle] = ["u", "v", "r", "U", "angle"].map(Expression::name);
    let drift = match rudder_spec.inflow.unwrap_or(Inflow::Velocity) {
        Inflow::Velocity => zero() - v,
        Inflow::Angle => speed * (zero() - v).angle(u),
    };
    let drift = drift - number("ell") * (r * numbers.get("ship.length_m"));
    let drift = lines.name("drift", drift, "speed across it as of a rudder alone, to port [m/s]");
    let [positive, negative] = numbers.both(&rudder_spec.name, "gamma");
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
        rudder_spec.name
    );
    Routine { name: name.to_owned(), comment, arguments, lines: lines.0, results }.without_unused()
}
