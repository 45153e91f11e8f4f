use vessel::{Invalid, Model};

/// What the channels of a model are to the library: indices of its variables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    /// Rudders, or what steers like one.
    pub rudders: Vec<usize>,
    /// Propeller speed with its sign.
    pub propeller: Option<usize>,
    /// Propeller speed where it goes ahead, else 0.
    pub ahead: Option<usize>,
    /// Propeller speed where it goes astern, else 0.
    pub astern: Option<usize>,
    /// Thrust, where no propeller speed is known.
    pub thrust: Option<usize>,
    /// Disturbances that a reflection leaves as they are.
    pub even: Vec<usize>,
    /// Disturbances whose sign a reflection changes.
    pub odd: Vec<usize>,
}

/// Roles as they are named by the user: names of channels. Empty ones are found by unit and name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NamedRoles {
    /// See [`Roles::rudders`].
    pub rudders: Vec<String>,
    /// See [`Roles::propeller`].
    pub propeller: Option<String>,
    /// See [`Roles::ahead`].
    pub ahead: Option<String>,
    /// See [`Roles::astern`].
    pub astern: Option<String>,
    /// See [`Roles::thrust`].
    pub thrust: Option<String>,
    /// See [`Roles::even`].
    pub even: Vec<String>,
    /// See [`Roles::odd`].
    pub odd: Vec<String>,
}

impl Roles {
    /// Those that are `named`; others by the units and names of the channels: radians steer, 1/s and rpm are propellers, the
    /// first in N is thrust; of measured disturbances `…_x` is even, others are odd; other inputs may act on everything.
    ///
    /// # Errors
    /// A name that no channel has.
    pub fn new(model: &Model, named: &NamedRoles) -> Result<Self, Invalid> {
        let names = || model.variables.iter().skip(3).map(|v| v.name.as_str());
        let place = |name: &String| {
            let unknown = || Invalid::unknown(format!("channel `{name}`"), name, names());
            names().position(|own| own == name).map(|i| i + 3).ok_or_else(unknown)
        };
        let all = |list: &[String]| list.iter().map(place).collect::<Result<Vec<_>, _>>();
        let one = |name: &Option<String>| name.as_ref().map(place).transpose();
        let mut roles = Self {
            rudders: all(&named.rudders)?,
            propeller: one(&named.propeller)?,
            ahead: one(&named.ahead)?,
            astern: one(&named.astern)?,
            thrust: one(&named.thrust)?,
            even: all(&named.even)?,
            odd: all(&named.odd)?,
        };
        for variable in 3..model.variables.len() {
            if !roles.all().contains(&variable) {
                roles.guess(model, variable);
            }
        }
        // Without a channel for either direction the speed itself stands for both.
        if roles.ahead.is_none() && roles.astern.is_none() {
            roles.ahead = roles.propeller;
        }
        Ok(roles)
    }

    fn all(&self) -> Vec<usize> {
        let single = [self.propeller, self.ahead, self.astern, self.thrust].into_iter().flatten();
        single.chain([&self.rudders, &self.even, &self.odd].into_iter().flatten().copied()).collect()
    }

    fn guess(&mut self, model: &Model, variable: usize) {
        let channel = &model.variables[variable];
        let (name, unit) = (channel.name.to_lowercase(), channel.unit.as_str());
        let speed = ["1/s", "rpm", "1/min", "rad/s", "Hz"].contains(&unit);
        let steers = unit == "rad" || unit == "deg";
        let force = (unit == "N" || unit == "kN") && self.thrust.is_none();
        match (speed, name) {
            (true, name) if name.contains("ahead") => self.ahead = self.ahead.or(Some(variable)),
            (true, name) if name.contains("astern") || name.contains("reverse") => {
                self.astern = self.astern.or(Some(variable));
            }
            (true, _) => self.propeller = self.propeller.or(Some(variable)),
            _ if force => self.thrust = Some(variable),
            _ if steers => self.rudders.push(variable),
            (_, name) if variable >= 3 + model.inputs && name.ends_with("_x") => self.even.push(variable),
            // Whatever an unknown input does, it may do to every degree of freedom.
            _ if variable < 3 + model.inputs => self.even.push(variable),
            _ => self.odd.push(variable),
        }
    }
}
