//! Every number of a ship as written, with its name and what it is made of.

use refusal::Invalid;

use crate::forces::term::factors;
use crate::forces::{
    AddedMass, Channel, CrossflowSpec, Curve, Description, Number, PropellerSpec, Reversed, RudderSpec,
    ShipSpec, TermSpec, ThrusterSpec, WindSpec,
};

/// Where a number is written.
pub(crate) enum Place<'a> {
    /// In a term.
    Term(&'a mut TermSpec),
    /// In a component.
    Component(&'a mut Number),
}

/// A number as written.
pub(crate) struct Slot<'a> {
    /// As its parameter is called.
    pub name: String,
    /// Where it is written.
    pub place: Place<'a>,
    /// What it is made of, in SI units; else the unit of a channel that no rule scales.
    pub dimension: Result<Dimension, String>,
    /// Whether a plain number is in the prime system.
    pub plain_prime: bool,
}

/// What is known about a number that is no plain one.
pub(crate) struct NumberParts<'a> {
    /// In SI units, in the prime system.
    pub numbers: [&'a mut Option<f64>; 2],
    /// The truth.
    pub value: &'a mut Option<f64>,
    /// Standard deviation of the prior.
    pub prior: &'a mut Option<f64>,
    /// Bounds.
    pub bounds: &'a mut Option<[f64; 2]>,
    /// Another number that it is tied to.
    pub tied_to: &'a Option<String>,
    /// By which factor.
    pub factor: &'a mut Option<f64>,
}

impl Place<'_> {
    /// Its parts; none for a plain number.
    pub fn parts(&mut self) -> Option<NumberParts<'_>> {
        Some(match self {
            Self::Term(TermSpec { nominal, prime, value, prior, bounds, tied_to, factor, .. }) => {
                NumberParts { numbers: [nominal, prime], value, prior, bounds, tied_to, factor }
            }
            Self::Component(Number::Table(table)) => NumberParts {
                numbers: [&mut table.nominal, &mut table.prime],
                value: &mut table.value,
                prior: &mut table.prior,
                bounds: &mut table.bounds,
                tied_to: &table.tied_to,
                factor: &mut table.factor,
            },
            Self::Component(Number::Plain(_)) => return None,
        })
    }
}

/// All numbers of `description`, each once.
pub(crate) fn slots<'a>(
    description: &'a mut Description,
    channels: &[Channel],
) -> Result<Vec<Slot<'a>>, Invalid> {
    let Description {
        density_kg_m3: _,
        step_s: _,
        ship,
        surge,
        sway,
        yaw,
        propeller: propellers,
        rudder: rudders,
        thruster: thrusters,
        wind: winds,
        crossflow: crossflows,
    } = description;
    let mut walk = Walk { slots: Vec::new(), channels };
    for (d, terms) in [surge, sway, yaw].into_iter().enumerate() {
        for term in terms {
            let dimension = of_term(term, d, channels)?;
            walk.slots.push(Slot {
                name: term.parameter.clone(),
                place: Place::Term(term),
                dimension,
                plain_prime: false,
            });
        }
    }
    walk.ship(ship);
    propellers.iter_mut().for_each(|propeller| walk.propeller(propeller));
    rudders.iter_mut().for_each(|rudder| walk.rudder(rudder));
    thrusters.iter_mut().for_each(|thruster| walk.thruster(thruster));
    winds.iter_mut().for_each(|wind| walk.wind(wind));
    crossflows.iter_mut().for_each(|crossflow| walk.crossflow(crossflow));
    Ok(walk.slots)
}

/// What the number of a term of the equation of degree of freedom `d` is made of.
fn of_term(spec: &TermSpec, d: usize, channels: &[Channel]) -> Result<Result<Dimension, String>, Invalid> {
    let mut sum = Dimension::FORCE.times(Dimension::length(1), i32::from(d == 2));
    for factor in factors(spec, channels)? {
        let dimension = match factor.channel() {
            None if factor.is_yaw_rate() => Dimension::RATE,
            None => Dimension::SPEED,
            Some(channel) => match Dimension::of_unit(&channels[channel].unit) {
                Some(dimension) => dimension,
                None => return Ok(Err(channels[channel].unit.clone())),
            },
        };
        sum = sum.times(dimension, -factor.power());
    }
    Ok(Ok(sum))
}

struct Walk<'a, 'c> {
    slots: Vec<Slot<'a>>,
    channels: &'c [Channel],
}

impl<'a> Walk<'a, '_> {
    fn add(&mut self, owner: &str, key: &str, number: &'a mut Number, dimension: Dimension) {
        self.put(owner, key, number, Ok(dimension));
    }

    fn put(&mut self, owner: &str, key: &str, number: &'a mut Number, dimension: Result<Dimension, String>) {
        let place = Place::Component(number);
        let plain_prime = owner == "ship.added_mass";
        self.slots.push(Slot { name: format!("{owner}.{key}"), place, dimension, plain_prime });
    }

    fn maybe(&mut self, owner: &str, key: &str, number: &'a mut Option<Number>, dimension: Dimension) {
        if let Some(number) = number {
            self.add(owner, key, number, dimension);
        }
    }

    /// Several numbers, counted from `first`.
    fn all(&mut self, owner: &str, key: &str, numbers: &'a mut [Number], first: usize) {
        for (i, number) in numbers.iter_mut().enumerate() {
            self.add(owner, &format!("{key}.{}", i + first), number, Dimension::NONE);
        }
    }

    fn ship(&mut self, spec: &'a mut ShipSpec) {
        let ShipSpec {
            length_m: _,
            draught_m: _,
            speed_m_s: _,
            area: _,
            mass_kg,
            x_g_m,
            gyration_m,
            inertia_kg_m2,
            added_mass,
            coriolis: _,
        } = spec;
        let AddedMass { surge, sway, yaw, sway_yaw, yaw_sway } = added_mass;
        self.add("ship", "mass_kg", mass_kg, Dimension::mass(0));
        self.maybe("ship", "x_g_m", x_g_m, Dimension::length(1));
        self.maybe("ship", "gyration_m", gyration_m, Dimension::length(1));
        self.maybe("ship", "inertia_kg_m2", inertia_kg_m2, Dimension::mass(2));
        self.add("ship.added_mass", "surge", surge, Dimension::mass(0));
        self.add("ship.added_mass", "sway", sway, Dimension::mass(0));
        self.add("ship.added_mass", "yaw", yaw, Dimension::mass(2));
        self.maybe("ship.added_mass", "sway_yaw", sway_yaw, Dimension::mass(1));
        self.maybe("ship.added_mass", "yaw_sway", yaw_sway, Dimension::mass(1));
    }

    fn propeller(&mut self, spec: &'a mut PropellerSpec) {
        let PropellerSpec {
            name,
            input: _,
            diameter_m,
            thrust,
            deduction,
            wake,
            wake_change,
            wake_ratio,
            x_m,
            y_m,
            astern,
        } = spec;
        self.all(name, "thrust", thrust, 0);
        self.maybe(name, "deduction", deduction, Dimension::NONE);
        self.maybe(name, "wake", wake, Dimension::NONE);
        self.maybe(name, "wake_change", wake_change, Dimension::NONE);
        self.all(name, "wake_ratio", wake_ratio.as_mut_slice().as_flattened_mut(), 0);
        self.add(name, "diameter_m", diameter_m, Dimension::length(1));
        self.maybe(name, "x_m", x_m, Dimension::length(1));
        self.maybe(name, "y_m", y_m, Dimension::length(1));
        if let Some(Reversed { surge, sway, yaw }) = astern {
            self.all(name, "astern.surge", surge, 0);
            self.all(name, "astern.sway", sway.as_mut_slice().as_flattened_mut(), 0);
            self.all(name, "astern.yaw", yaw.as_mut_slice().as_flattened_mut(), 0);
        }
    }

    fn rudder(&mut self, spec: &'a mut RudderSpec) {
        let RudderSpec {
            name,
            input: _,
            behind: _,
            area_m2,
            height_m,
            lift_slope,
            epsilon,
            kappa,
            gamma,
            ell,
            deduction,
            interaction,
            interaction_x_m,
            x_m,
            y_m,
            reversed_flow,
            inflow: _,
        } = spec;
        self.add(name, "area_m2", area_m2, Dimension::length(2));
        self.maybe(name, "height_m", height_m, Dimension::length(1));
        self.add(name, "lift_slope", lift_slope, Dimension::NONE);
        self.maybe(name, "epsilon", epsilon, Dimension::NONE);
        self.maybe(name, "kappa", kappa, Dimension::NONE);
        self.all(name, "gamma", gamma.as_mut_slice().as_flattened_mut(), 0);
        self.maybe(name, "ell", ell, Dimension::NONE);
        self.maybe(name, "deduction", deduction, Dimension::NONE);
        self.maybe(name, "interaction", interaction, Dimension::NONE);
        self.maybe(name, "interaction_x_m", interaction_x_m, Dimension::length(1));
        self.add(name, "x_m", x_m, Dimension::length(1));
        self.maybe(name, "y_m", y_m, Dimension::length(1));
        self.maybe(name, "reversed_flow", reversed_flow, Dimension::NONE);
    }

    fn thruster(&mut self, spec: &'a mut ThrusterSpec) {
        let ThrusterSpec {
            name,
            input,
            x_m,
            y_m,
            angle: _,
            angle_deg,
            curve,
            ahead,
            astern,
            loss,
            lag_s,
            dead_time_s,
        } = spec;
        let unit = self
            .channels
            .iter()
            .find(|channel| channel.name == *input)
            .map_or("", |channel| channel.unit.as_str());
        let unit = Dimension::of_unit(unit).ok_or_else(|| unit.to_owned());
        let over = |power: i32, speeds: i32| {
            unit.clone().map(|unit| Dimension::FORCE.times(unit, -power).times(Dimension::SPEED, -speeds))
        };
        let coefficient = match curve {
            Curve::Square => over(2, 0),
            Curve::Force => Ok(Dimension::NONE),
        };
        self.add(name, "x_m", x_m, Dimension::length(1));
        self.maybe(name, "y_m", y_m, Dimension::length(1));
        self.maybe(name, "angle_deg", angle_deg, Dimension::NONE);
        if let Some(number) = ahead {
            self.put(name, "ahead", number, coefficient.clone());
        }
        if let Some(number) = astern {
            self.put(name, "astern", number, coefficient);
        }
        if let Some(number) = loss {
            self.put(name, "loss", number, over(1, 1));
        }
        self.maybe(name, "lag_s", lag_s, Dimension::TIME);
        self.maybe(name, "dead_time_s", dead_time_s, Dimension::TIME);
    }

    fn wind(&mut self, spec: &'a mut WindSpec) {
        let WindSpec {
            name,
            speed: _,
            direction: _,
            air_density_kg_m3,
            frontal_area_m2,
            lateral_area_m2,
            surge,
            sway,
            yaw,
        } = spec;
        self.all(name, "surge", surge, 1);
        self.all(name, "sway", sway, 1);
        self.all(name, "yaw", yaw, 1);
        self.add(name, "frontal_area_m2", frontal_area_m2, Dimension::length(2));
        self.add(name, "lateral_area_m2", lateral_area_m2, Dimension::length(2));
        // The air stays as it is.
        self.maybe(name, "air_density_kg_m3", air_density_kg_m3, Dimension::NONE);
    }

    fn crossflow(&mut self, spec: &'a mut CrossflowSpec) {
        let CrossflowSpec { name, draught_m, drag, strips: _ } = spec;
        self.add(name, "draught_m", draught_m, Dimension::length(1));
        self.add(name, "drag", drag, Dimension::NONE);
    }
}

/// Powers of the water's density and of half lengths: a speed counts as the root of a length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dimension {
    /// Power of the density.
    density: i32,
    /// Twice the power of the length.
    halves: i32,
}

/// Those of units.
const UNITS: [(&[&str], Dimension); 14] = [
    (&["", "1", "%", "rad", "deg", "°", "m/s²", "m/s^2"], Dimension::NONE),
    (&["s"], Dimension::of(0, 1)),
    (&["1/s", "rps", "Hz", "rpm", "1/min", "rad/s", "deg/s", "°/s"], Dimension::of(0, -1)),
    (&["1/s²", "1/s^2", "rad/s²", "rad/s^2"], Dimension::of(0, -2)),
    (&["m/s", "kn"], Dimension::SPEED),
    (&["m²/s²", "m^2/s^2"], Dimension::of(0, 2)),
    (&["m", "cm", "mm"], Dimension::of(0, 2)),
    (&["m²", "m^2"], Dimension::of(0, 4)),
    (&["m³", "m^3"], Dimension::of(0, 6)),
    (&["kg", "t"], Dimension::of(1, 6)),
    (&["N", "kN", "MN"], Dimension::FORCE),
    (&["N m", "kN m", "Nm", "kNm"], Dimension::of(1, 8)),
    (&["W", "kW", "MW"], Dimension::of(1, 7)),
    (&["Pa", "kPa", "bar"], Dimension::of(1, 2)),
];

impl Dimension {
    /// A pure number, an angle, an acceleration.
    pub const NONE: Self = Self::of(0, 0);
    /// A speed.
    pub const SPEED: Self = Self::of(0, 1);
    /// A turning rate.
    pub const RATE: Self = Self::of(0, -1);
    /// A time.
    pub const TIME: Self = Self::of(0, 1);
    /// A force.
    pub const FORCE: Self = Self::of(1, 6);

    const fn of(density: i32, halves: i32) -> Self {
        Self { density, halves }
    }

    /// The `power`th power of a length.
    pub const fn length(power: i32) -> Self {
        Self::of(0, 2 * power)
    }

    /// A mass times the `power`th power of a length.
    pub const fn mass(power: i32) -> Self {
        Self::of(1, 6 + 2 * power)
    }

    /// That of a unit, if it is known.
    pub fn of_unit(unit: &str) -> Option<Self> {
        UNITS.iter().find(|(units, _)| units.contains(&unit)).map(|(_, dimension)| *dimension)
    }

    /// This, times the `power`th power of another.
    pub fn times(self, other: Self, power: i32) -> Self {
        Self::of(self.density + power * other.density, self.halves + power * other.halves)
    }

    /// What one of a ship is of another, with `length` times the length in water of `density` times the density.
    pub fn factor(self, length: f64, density: f64) -> f64 {
        let whole = density.powi(self.density) * length.powi(self.halves.div_euclid(2));
        if self.halves.rem_euclid(2) == 1 { whole * length.sqrt() } else { whole }
    }
}
