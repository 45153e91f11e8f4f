//! Signs of a ship's geometry that logs and drawings often have the wrong way round.

use std::fmt;

use ship::forces::{Channel, Description, Forces, Number, NumberSpec};

/// Something that is turned over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Turn {
    /// A thruster or propeller stands on the other side of the middle line.
    Side(String),
    /// A thruster pushes the other way.
    Push(String),
    /// The angle of this rudder or thruster, logged as that input, has the other sign.
    Angle(String, String),
    /// The wind that this component feels comes from the other side.
    Wind(String, String),
    /// The inputs of two thrusters or propellers on different sides are exchanged.
    Exchanged([String; 2], [String; 2]),
}

impl fmt::Display for Turn {
    /// As in "fit better with …".
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Side(of) => write!(f, "`{of}` on the other side of the ship"),
            Self::Push(of) => write!(f, "`{of}` pushing the other way"),
            Self::Angle(of, input) => write!(f, "the sign of `{input}` turned, the angle of `{of}`"),
            Self::Wind(of, input) => write!(f, "the sign of `{input}` turned, the direction of `{of}`"),
            Self::Exchanged([one, other], [first, second]) => {
                write!(f, "`{first}` and `{second}` exchanged, the inputs of `{one}` and `{other}`")
            }
        }
    }
}

/// A ship with something turned over.
pub(crate) struct Alternative {
    pub turn: Turn,
    pub forces: Forces,
    /// A column of the inputs that is negated.
    pub negated: Option<usize>,
    /// The number that changes with it, and how.
    changed: Option<(String, Change)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Negated,
    HalfTurn,
}

impl Change {
    fn of(self, value: f64) -> f64 {
        match self {
            Self::Negated => -value,
            Self::HalfTurn => value + 180.0,
        }
    }

    /// The number after the change; `None` where it is tied or 0 and stays.
    fn number(self, own: &Number) -> Option<Number> {
        match own {
            Number::Plain(value) => Some(Number::Plain(self.of(*value))),
            Number::Table(spec) if spec.tied_to.is_some() => None,
            Number::Table(spec) => {
                let ends = spec.bounds.map(|[low, high]| match self {
                    Self::Negated => [-high, -low],
                    Self::HalfTurn => [low + 180.0, high + 180.0],
                });
                let of = |own: Option<f64>| own.map(|own| self.of(own));
                let (nominal, prime, value) = (of(spec.nominal), of(spec.prime), of(spec.value));
                Some(Number::Table(NumberSpec { nominal, prime, value, bounds: ends, ..spec.clone() }))
            }
        }
    }
}

impl Alternative {
    /// All of `forces`, whose rows of inputs have these `channels`.
    pub fn all(forces: &Forces, channels: &[Channel]) -> Vec<Self> {
        let turns = Turns { forces, channels };
        let pairs = turns.exchanged();
        turns.sides().chain(turns.pushes()).chain(turns.angles()).chain(turns.winds()).chain(pairs).collect()
    }

    /// A value of the parameter `name` of the ship as written, for this one.
    pub fn value(&self, name: &str, value: f64) -> f64 {
        match &self.changed {
            Some((changed, how)) if changed == name => how.of(value),
            _ => value,
        }
    }
}

struct Turns<'a> {
    forces: &'a Forces,
    channels: &'a [Channel],
}

impl Turns<'_> {
    fn written(&self) -> &Description {
        self.forces.description()
    }

    /// The ship of `description`; `None` where she is none, so that nothing can be said of her.
    fn with(&self, turn: Turn, description: &Description, changed: (String, Change)) -> Option<Alternative> {
        let forces = Forces::new(description, self.channels).ok()?;
        Some(Alternative { turn, forces, negated: None, changed: Some(changed) })
    }

    /// The ship as written, with this column negated.
    fn negated(&self, turn: Turn, channel: usize) -> Alternative {
        Alternative { turn, forces: self.forces.clone(), negated: Some(channel), changed: None }
    }

    fn sides(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        let thrusters = (0..written.thruster.len()).filter_map(move |i| {
            let mut all = written.clone();
            let own = &mut all.thruster[i];
            let (name, y) = (own.name.clone(), other_side(own.y_m.as_ref())?);
            own.y_m = Some(y);
            self.with(Turn::Side(name.clone()), &all, (format!("{name}.y_m"), Change::Negated))
        });
        let propellers = (0..written.propeller.len()).filter_map(move |i| {
            let mut all = written.clone();
            let own = &mut all.propeller[i];
            let (name, y) = (own.name.clone(), other_side(own.y_m.as_ref())?);
            own.y_m = Some(y);
            self.with(Turn::Side(name.clone()), &all, (format!("{name}.y_m"), Change::Negated))
        });
        thrusters.chain(propellers)
    }

    fn pushes(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        (0..written.thruster.len()).filter_map(move |i| {
            let mut all = written.clone();
            let own = &mut all.thruster[i];
            if own.angle.is_some() {
                return None;
            }
            let (name, angle) = (own.name.clone(), own.angle_deg.clone().unwrap_or(Number::Plain(0.0)));
            own.angle_deg = Some(Change::HalfTurn.number(&angle)?);
            self.with(Turn::Push(name.clone()), &all, (format!("{name}.angle_deg"), Change::HalfTurn))
        })
    }

    /// Rudders and azimuth thrusters; several that follow one input are turned together.
    fn angles(&self) -> impl Iterator<Item = Alternative> {
        let written = self.written();
        let rudders = written.rudder.iter().enumerate();
        let rudders = rudders.map(|(i, own)| (own.name.clone(), self.forces.rudder_input(i).0.channel));
        let azimuths = written.thruster.iter().enumerate();
        let azimuths = azimuths
            .filter_map(|(i, own)| Some((own.name.clone(), self.forces.thruster_inputs(i).1?.channel)));
        let all: Vec<(String, usize)> = rudders.chain(azimuths).collect();
        let first = |i: usize| all[..i].iter().all(|(_, channel)| *channel != all[i].1);
        let firsts: Vec<(String, usize)> =
            (0..all.len()).filter(|i| first(*i)).map(|i| all[i].clone()).collect();
        firsts.into_iter().map(|(name, channel)| {
            self.negated(Turn::Angle(name, self.channels[channel].name.clone()), channel)
        })
    }

    fn winds(&self) -> impl Iterator<Item = Alternative> {
        self.written().wind.iter().enumerate().map(|(i, own)| {
            let [_, direction] = self.forces.wind_inputs(i);
            let turn = Turn::Wind(own.name.clone(), self.channels[direction.channel].name.clone());
            self.negated(turn, direction.channel)
        })
    }

    /// Pairs of thrusters, and of propellers, on different sides.
    fn exchanged(&self) -> Vec<Alternative> {
        let written = self.written();
        let thrusters = written.thruster.iter().map(|own| (&own.name, &own.input, own.y_m.as_ref()));
        let propellers = written.propeller.iter().map(|own| (&own.name, &own.input, own.y_m.as_ref()));
        let exchange = |(i, j): (usize, usize), all: &mut Description, of: &Swapped| match of {
            Swapped::Thrusters => {
                let input = std::mem::take(&mut all.thruster[i].input);
                let other = std::mem::replace(&mut all.thruster[j].input, input);
                all.thruster[i].input = other;
            }
            Swapped::Propellers => {
                let input = std::mem::take(&mut all.propeller[i].input);
                let other = std::mem::replace(&mut all.propeller[j].input, input);
                all.propeller[i].input = other;
            }
        };
        let kinds: [(Swapped, Vec<Placed>); 2] =
            [(Swapped::Thrusters, thrusters.collect()), (Swapped::Propellers, propellers.collect())];
        let mut found = Vec::new();
        for (kind, own) in &kinds {
            for (i, j) in opposite(own) {
                let mut all = written.clone();
                exchange((i, j), &mut all, kind);
                let [names, inputs] =
                    [[own[i].0, own[j].0], [own[i].1, own[j].1]].map(|own| own.map(Clone::clone));
                let turn = Turn::Exchanged(names, inputs);
                let forces = Forces::new(&all, self.channels).ok();
                found.extend(forces.map(|forces| Alternative { turn, forces, negated: None, changed: None }));
            }
        }
        found
    }
}

/// Whose inputs are exchanged.
enum Swapped {
    Thrusters,
    Propellers,
}

/// Name, input and place to starboard of a thruster or propeller.
type Placed<'a> = (&'a String, &'a String, Option<&'a Number>);

/// Pairs on different sides, with inputs of their own.
fn opposite(all: &[Placed]) -> Vec<(usize, usize)> {
    let side = |i: usize| all[i].2.and_then(value).filter(|own| *own != 0.0).map(|own| own > 0.0);
    let apart = |(i, j): &(usize, usize)| {
        side(*i).zip(side(*j)).is_some_and(|(one, other)| one != other) && all[*i].1 != all[*j].1
    };
    (0..all.len()).flat_map(|i| (i + 1..all.len()).map(move |j| (i, j))).filter(apart).collect()
}

/// A number as written.
fn value(number: &Number) -> Option<f64> {
    match number {
        Number::Plain(number) => Some(*number),
        Number::Table(number) => number.nominal.or(number.prime),
    }
}

/// The place on the other side; `None` for one on the middle line.
fn other_side(own: Option<&Number>) -> Option<Number> {
    let own = own.filter(|own| value(own).is_some_and(|own| own != 0.0))?;
    Change::Negated.number(own)
}
