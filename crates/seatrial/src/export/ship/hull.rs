//! Terms of hull forces, and what accelerates the ship under all forces.

use ship::forces::{Coriolis, Forces, MOTION};

use super::expression::Expression;
use super::numbers::{Numbers, motion};
use super::routine::{Lines, Routine};

/// The terms of surge, sway and yaw.
pub(crate) fn hull(forces: &Forces, numbers: &Numbers, name: &str) -> Routine {
    let description = forces.description();
    let mut arguments = motion();
    let channels = numbers.channels.iter().enumerate().skip(3);
    arguments.extend(channels.map(|(i, own)| (own.clone(), Expression::Channel(i))));
    let variable = |i: usize| match MOTION.get(i) {
        Some(own) => Expression::name(own),
        None => Expression::name(&numbers.channels[3 + i - MOTION.len()]),
    };
    let mut lines = Lines::default();
    let mut results = Vec::new();
    for (d, (terms, (name, comment))) in description.terms().into_iter().zip(SUMS).enumerate() {
        let term = |(i, own): (usize, &ship::forces::TermSpec)| {
            forces.factors(d, i).iter().fold(numbers.get(&own.parameter), |product, factor| {
                let own = variable(factor.variable);
                let own = if factor.modulus { own.modulus() } else { own };
                if factor.divides { product / own } else { product * own }
            })
        };
        let sum = terms.iter().enumerate().map(term).fold(Expression::ZERO, |sum, own| sum + own);
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
    let over = |own: Expression| own / determinant.clone();
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
