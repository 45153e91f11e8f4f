use refusal::Invalid;
use ship::model::Model;

/// The roles of a model's channels in the library: indices of its variables, or as a user names them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles<C = usize> {
    /// Rudders, or channels that steer like one.
    pub rudders: Vec<C>,
    /// Propeller speeds with their signs.
    pub propellers: Vec<C>,
    /// Propeller speeds when ahead, else 0.
    pub ahead: Vec<C>,
    /// Propeller speeds when astern, else 0.
    pub astern: Vec<C>,
    /// Thrusts, if no propeller speed is known.
    pub thrusts: Vec<C>,
    /// Thrusters on either side, port and starboard: propeller speeds or thrusts.
    pub pairs: Vec<[C; 2]>,
    /// Differences of thrusters: port less starboard.
    pub differences: Vec<C>,
    /// Speed of the relative wind.
    pub wind: Option<C>,
    /// Direction that the relative wind comes from, from the bow to starboard.
    pub wind_from: Option<C>,
    /// Disturbances that a reflection does not change.
    pub even: Vec<C>,
    /// Disturbances whose sign a reflection changes.
    pub odd: Vec<C>,
}

/// The parts of names that distinguish channels of port and starboard.
const SIDES: [[&str; 2]; 5] =
    [["port", "starboard"], ["port", "stbd"], ["left", "right"], ["_p", "_s"], ["_l", "_r"]];
const SPEEDS: [&str; 5] = ["1/s", "rpm", "1/min", "rad/s", "Hz"];
const FORCES: [&str; 2] = ["N", "kN"];

impl Roles {
    /// Takes the `named` roles and infers the others from the units and names of the channels. Radians are rudders,
    /// 1/s and rpm propellers, N and kN thrusts. Thrusters of one unit whose names differ only in the side, or that
    /// `model` ties to each other, are pairs. Measured disturbances called wind are its speed and angle by their
    /// units; of others `…_x` is even, the rest odd. Other inputs may act on all degrees of freedom.
    ///
    /// # Errors
    /// A name that no channel has; a wind with only its speed or only its angle named, if the other is not found.
    pub fn new(model: &Model, named: &Roles<String>) -> Result<Self, Invalid> {
        let names = || model.variables.iter().skip(3).map(|v| v.name.as_str());
        let place = |name: &String| {
            let unknown = || Invalid::unknown(format!("channel `{name}`"), name, names());
            names().position(|known| known == name).map(|i| i + 3).ok_or_else(unknown)
        };
        let all = |list: &[String]| list.iter().map(place).collect::<Result<Vec<_>, _>>();
        let one = |name: &Option<String>| name.as_ref().map(place).transpose();
        let pair = |[port, starboard]: &[String; 2]| Ok([place(port)?, place(starboard)?]);
        let mut roles = Self {
            rudders: all(&named.rudders)?,
            propellers: all(&named.propellers)?,
            ahead: all(&named.ahead)?,
            astern: all(&named.astern)?,
            thrusts: all(&named.thrusts)?,
            pairs: named.pairs.iter().map(pair).collect::<Result<_, _>>()?,
            differences: Vec::new(),
            wind: one(&named.wind)?,
            wind_from: one(&named.wind_from)?,
            even: all(&named.even)?,
            odd: all(&named.odd)?,
        };
        roles.pair(model);
        for variable in 3..model.variables.len() {
            if !roles.all().contains(&variable) {
                roles.guess(model, variable);
            }
        }
        // Without channels for ahead and astern the speeds themselves stand for both.
        if roles.ahead.is_empty() && roles.astern.is_empty() {
            roles.ahead.clone_from(&roles.propellers);
        }
        match (roles.wind, roles.wind_from, &named.wind, &named.wind_from) {
            (Some(_), None, Some(name), _) => return Err(half_a_wind(name, "--wind-from", "direction")),
            (None, Some(_), _, Some(name)) => return Err(half_a_wind(name, "--wind", "speed")),
            // If found by its name alone, it is a disturbance like any other: a reflection keeps a speed and changes
            // the sign of an angle.
            (speed, None, ..) => roles.even.extend(speed),
            (None, angle, ..) => roles.odd.extend(angle),
            _ => {}
        }
        Ok(roles)
    }

    fn all(&self) -> Vec<usize> {
        let inputs = [&self.rudders, &self.propellers, &self.ahead, &self.astern, &self.thrusts];
        let lists = inputs.into_iter().chain([&self.even, &self.odd]);
        let single = [self.wind, self.wind_from].into_iter().flatten();
        single.chain(self.pairs.iter().flatten().copied()).chain(lists.flatten().copied()).collect()
    }

    fn pair(&mut self, model: &Model) {
        let thruster =
            |i: &usize| [&SPEEDS[..], &FORCES].concat().contains(&model.variables[*i].unit.as_str());
        let free: Vec<usize> =
            (3..3 + model.inputs).filter(|i| thruster(i) && !self.all().contains(i)).collect();
        for (i, port) in free.iter().enumerate() {
            let other = |starboard: &usize| {
                let taken = |variable: &usize| self.pairs.iter().flatten().any(|paired| paired == variable);
                model.variables[*port].unit == model.variables[*starboard].unit
                    && !taken(port)
                    && !taken(starboard)
            };
            let of_name = |starboard: &&usize| other(starboard) && sides(model, *port, **starboard).is_some();
            let tied = |starboard: &&usize| other(starboard) && mirrored(model, *port, **starboard);
            if let Some(starboard) = free.iter().find(of_name) {
                self.pairs.extend(sides(model, *port, *starboard));
            } else if let Some(starboard) = free[i + 1..].iter().find(tied) {
                self.pairs.push([*port, *starboard]);
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
        if speed && name.contains("ahead") {
            self.ahead.push(variable);
        } else if speed && (name.contains("astern") || name.contains("reverse")) {
            self.astern.push(variable);
        } else if speed {
            self.propellers.push(variable);
        } else if FORCES.contains(&unit) {
            self.thrusts.push(variable);
        } else if unit == "rad" || unit == "deg" {
            self.rudders.push(variable);
        } else if !measured || name.ends_with("_x") {
            // An unknown input may act on every degree of freedom.
            self.even.push(variable);
        } else {
            self.odd.push(variable);
        }
    }

    /// Takes a measured disturbance as the wind's speed or angle; returns whether it is one.
    fn blows(&mut self, name: &str, unit: &str, variable: usize) -> bool {
        let component = name.ends_with("_x") || name.ends_with("_y");
        let role = match unit {
            "rad" => &mut self.wind_from,
            "m/s" if !component => &mut self.wind,
            _ => return false,
        };
        let blows = name.contains("wind") && role.is_none();
        if blows {
            *role = Some(variable);
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

fn half_a_wind(name: &str, flag: &str, other: &str) -> Invalid {
    Invalid::new(
        format!("wind `{name}`"),
        format!("no channel of its {other}"),
        "both speed and direction of the relative wind",
        format!("name the {other} with {flag}, or declare it as [[measured]]"),
    )
}
