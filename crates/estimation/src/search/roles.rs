use refusal::Invalid;
use ship::model::{ChannelRole, Model};

/// The channels of a model by their roles in the library, as indices of its variables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    pub(super) channels: [Vec<usize>; ChannelRole::ALL.len()],
    /// Differences of thrusters: port less starboard.
    pub differences: Vec<usize>,
}

/// The parts of names that distinguish channels of port and starboard.
const SIDES: [[&str; 2]; 5] =
    [["port", "starboard"], ["port", "stbd"], ["left", "right"], ["_p", "_s"], ["_l", "_r"]];
const SPEEDS: [&str; 5] = ["1/s", "rpm", "1/min", "rad/s", "Hz"];
const FORCES: [&str; 2] = ["N", "kN"];

impl Roles {
    /// Takes the roles that the vessel's file states and infers the others from the units and names of the channels. Radians are
    /// rudders, 1/s and rpm propellers, N and kN thrusts. Thrusters of one unit whose names differ only in the side, or that
    /// `model` ties to each other, are pairs. Measured disturbances called wind are its speed and angle by their
    /// units; of others `…_x` is even, the rest odd. Other inputs may act on all degrees of freedom.
    ///
    /// # Errors
    /// A wind with only its speed or only its angle stated, if the other is not found.
    pub fn new(model: &Model) -> Result<Self, Invalid> {
        let mut roles = Self::default();
        model.roles.iter().for_each(|(variable, role)| roles.add(*role, *variable));
        roles.pair(model);
        for variable in 3..model.variables.len() {
            if !roles.has(variable) {
                roles.guess(model, variable);
            }
        }
        roles.take_speeds_ahead();
        for (role, other, lacking, alone) in [
            (ChannelRole::Wind, ChannelRole::WindFrom, "direction", ChannelRole::Even),
            (ChannelRole::WindFrom, ChannelRole::Wind, "speed", ChannelRole::Odd),
        ] {
            let Some(&half) = roles.of(role).first().filter(|_| roles.of(other).is_empty()) else { continue };
            if model.roles.contains_key(&half) {
                let without = format!("`{role}` without a channel of its {lacking}");
                let remedy = format!("add `role = \"{other}\"` to that, or declare it as [[measured]]");
                let both = "both speed and direction of the relative wind";
                return Err(model.refused_role(half, without, both, &remedy));
            }
            // If found by its name alone, it is a disturbance like any other: a reflection keeps a speed and changes
            // the sign of an angle.
            roles.add(alone, half);
        }
        Ok(roles)
    }

    /// The channels of `role`; those of port and starboard are pairs.
    pub fn of(&self, role: ChannelRole) -> &[usize] {
        &self.channels[role as usize]
    }

    pub(super) fn add(&mut self, role: ChannelRole, variable: usize) {
        self.channels[role as usize].push(variable);
    }

    fn has(&self, variable: usize) -> bool {
        self.channels.iter().flatten().any(|taken| *taken == variable)
    }

    /// Without channels for ahead and astern the speeds themselves stand for both.
    pub(super) fn take_speeds_ahead(&mut self) {
        if self.of(ChannelRole::Ahead).is_empty() && self.of(ChannelRole::Astern).is_empty() {
            self.channels[ChannelRole::Ahead as usize] = self.of(ChannelRole::Propeller).to_vec();
        }
    }

    fn pair(&mut self, model: &Model) {
        let thruster =
            |i: &usize| [&SPEEDS[..], &FORCES].concat().contains(&model.variables[*i].unit.as_str());
        let free: Vec<usize> = (3..3 + model.inputs).filter(|i| thruster(i) && !self.has(*i)).collect();
        for (i, port) in free.iter().enumerate() {
            let other = |starboard: &usize| {
                let alike = model.variables[*port].unit == model.variables[*starboard].unit;
                alike && !self.has(*port) && !self.has(*starboard)
            };
            let of_name = |starboard: &&usize| other(starboard) && sides(model, *port, **starboard).is_some();
            let tied = |starboard: &&usize| other(starboard) && mirrored(model, *port, **starboard);
            let pair = match free.iter().find(of_name) {
                Some(starboard) => sides(model, *port, *starboard),
                None => free[i + 1..].iter().find(tied).map(|starboard| [*port, *starboard]),
            };
            if let Some([port, starboard]) = pair {
                self.add(ChannelRole::Port, port);
                self.add(ChannelRole::Starboard, starboard);
            }
        }
    }

    fn guess(&mut self, model: &Model, variable: usize) {
        let channel = &model.variables[variable];
        let (name, unit) = (channel.name.to_lowercase(), channel.unit.as_str());
        let measured = variable >= 3 + model.inputs;
        if measured && self.blows(&name, unit, variable) {
            return;
        }
        let speed = SPEEDS.contains(&unit);
        let role = if speed && name.contains("ahead") {
            ChannelRole::Ahead
        } else if speed && (name.contains("astern") || name.contains("reverse")) {
            ChannelRole::Astern
        } else if speed {
            ChannelRole::Propeller
        } else if FORCES.contains(&unit) {
            ChannelRole::Thrust
        } else if unit == "rad" || unit == "deg" {
            ChannelRole::Rudder
        } else if !measured || name.ends_with("_x") {
            // An unknown input may act on every degree of freedom.
            ChannelRole::Even
        } else {
            ChannelRole::Odd
        };
        self.add(role, variable);
    }

    /// Takes a measured disturbance as the wind's speed or angle; returns whether it is one.
    fn blows(&mut self, name: &str, unit: &str, variable: usize) -> bool {
        let component = name.ends_with("_x") || name.ends_with("_y");
        let role = match unit {
            "rad" => ChannelRole::WindFrom,
            "m/s" if !component => ChannelRole::Wind,
            _ => return false,
        };
        let blows = name.contains("wind") && self.of(role).is_empty();
        if blows {
            self.add(role, variable);
        }
        blows
    }
}

fn sides(model: &Model, one: usize, other: usize) -> Option<[usize; 2]> {
    let [one_name, other_name] = [one, other].map(|i| model.variables[i].name.to_lowercase());
    let named = |port: &str, starboard: &str| {
        SIDES.iter().any(|[p, s]| port.contains(p) && port.replacen(p, s, 1) == starboard)
    };
    if named(&one_name, &other_name) {
        Some([one, other])
    } else if named(&other_name, &one_name) {
        Some([other, one])
    } else {
        None
    }
}

/// Whether the model ties the effects of `starboard` to those of `port`: equal ahead, and opposite in yaw.
fn mirrored(model: &Model, port: usize, starboard: usize) -> bool {
    let tied = |d: usize, sign: f64| {
        model.degrees[d].terms.iter().any(|term| {
            let of = |factors: &[ship::model::Factor], channel| factors.iter().any(|f| f.variable == channel);
            let other = |product: &ship::model::Product| {
                of(&product.factors, starboard) && product.coefficient == sign
            };
            of(&term.factors, port) && term.tied.iter().any(other)
        })
    };
    tied(0, 1.0) && tied(2, -1.0)
}
