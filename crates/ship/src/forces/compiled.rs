use refusal::{Invalid, check_numbers, check_ranges};

use crate::forces::crossflow::Crossflow;
use crate::forces::mass::{Mass, Prime};
use crate::forces::numbers::{Builder, Numbers};
use crate::forces::propeller::Propeller;
use crate::forces::rudder::Rudder;
use crate::forces::term::Term;
use crate::forces::thruster::Thruster;
use crate::forces::wind::Wind;
use crate::forces::{Channel, Description, Driven, Factor, Parameter, Quantity, QuantitySource};

/// Most parts of a kind, such as terms of an equation or thrusters.
const MOST: f64 = 2000.0;

/// The forces on a ship, checked and compiled: structure, and one flat vector θ of free parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    pub(crate) prime: Prime,
    pub(crate) step_s: Option<f64>,
    pub(crate) mass: Mass,
    pub(crate) terms: [Vec<Term>; 3],
    pub(crate) propellers: Vec<Propeller>,
    pub(crate) rudders: Vec<Rudder>,
    pub(crate) thrusters: Vec<Thruster>,
    pub(crate) winds: Vec<Wind>,
    pub(crate) crossflows: Vec<Crossflow>,
    /// Channels whose values go around, and half a turn in their units.
    pub(crate) turning: Vec<(usize, f64)>,
    pub(crate) numbers: Numbers,
    description: Description,
}

impl Forces {
    /// Checks `description`, whose inputs and measured disturbances are `channels`, in the order of a row.
    ///
    /// # Errors
    /// The first name that is unknown or duplicate, number that is missing, not finite or contradicts another, unit that
    /// does not fit, division by what can be 0; a free mass without a prior; a ship that her nominal masses cannot be.
    pub fn new(description: &Description, channels: &[Channel]) -> Result<Self, Invalid> {
        check_counts(description)?;
        let step = description.step_s.map(|own| ("step_s", own));
        check_numbers(step, "a step above 0 s", |own| own > 0.0)?;
        let prime = Prime::new(description.density_kg_m3, &description.ship)?;
        let mut builder = Builder::default();
        let own = &mut builder;
        let mut terms = [Vec::new(), Vec::new(), Vec::new()];
        for (d, specs) in description.terms().into_iter().enumerate() {
            for spec in specs {
                terms[d].push(Term::new(spec, d, channels, &prime, own)?);
            }
        }
        let mass = Mass::new(&description.ship, &prime, own)?;
        let mut propellers: Vec<Propeller> = Vec::new();
        for spec in &description.propeller {
            propellers.push(Propeller::new(spec, channels, &prime, own)?);
        }
        let rudder = |spec| Rudder::new(spec, &propellers, channels, &prime, own);
        let rudders = description.rudder.iter().map(rudder).collect::<Result<Vec<_>, _>>()?;
        let thruster = |spec| Thruster::new(spec, channels, &prime, own);
        let thrusters = description.thruster.iter().map(thruster).collect::<Result<Vec<_>, _>>()?;
        let wind = |spec| Wind::new(spec, channels, &prime, own);
        let winds = description.wind.iter().map(wind).collect::<Result<Vec<_>, _>>()?;
        let crossflow = |spec| Crossflow::new(spec, &prime, own);
        let crossflows = description.crossflow.iter().map(crossflow).collect::<Result<Vec<_>, _>>()?;
        let turning =
            thrusters.iter().filter_map(Thruster::turning).chain(winds.iter().map(Wind::turning)).collect();
        let (numbers, step_s, description) = (builder.finish()?, description.step_s, description.clone());
        let forces = Self {
            prime,
            step_s,
            mass,
            terms,
            propellers,
            rudders,
            thrusters,
            winds,
            crossflows,
            turning,
            numbers,
            description,
        };
        forces.check(&forces.nominal())?;
        Ok(forces)
    }

    /// The free parameters, in the order of θ: those of terms of surge, sway and yaw, of the ship, then of components.
    pub fn parameters(&self) -> &[Parameter] {
        &self.numbers.parameters
    }

    /// All numbers with parameters `theta`, in SI units: those of terms, of the ship and of components, then the density of
    /// the water, the length and the speed that the prime system is made of.
    pub fn quantities(&self, theta: &[f64]) -> Vec<Quantity> {
        let Prime { density, length, speed, .. } = self.prime;
        let known = |(name, unit, value): (&str, &str, f64)| Quantity {
            name: name.to_owned(),
            unit: unit.to_owned(),
            value,
            stated: true,
            source: QuantitySource::Known,
        };
        let prime = [
            ("density_kg_m3", "kg/m³", density),
            ("ship.length_m", "m", length),
            ("ship.speed_m_s", "m/s", speed),
        ];
        self.numbers.quantities(theta).into_iter().chain(prime.map(known)).collect()
    }

    /// The factors of term `i` of degree of freedom `d`, in order.
    pub fn factors(&self, d: usize, i: usize) -> &[Factor] {
        self.terms[d][i].factors()
    }

    /// The channel of propeller `i`, in revolutions per second.
    pub fn propeller_input(&self, i: usize) -> Driven {
        self.propellers[i].revolutions
    }

    /// The channel of rudder `i`, in rad, and the propeller in front of it.
    pub fn rudder_input(&self, i: usize) -> (Driven, Option<usize>) {
        (self.rudders[i].angle, self.rudders[i].behind)
    }

    /// The channel of thruster `i`, in N where that is its force, and that of its angle in rad, if it has one.
    pub fn thruster_inputs(&self, i: usize) -> (Driven, Option<Driven>) {
        self.thrusters[i].inputs()
    }

    /// The channels of wind `i`: speed in m/s, direction in rad.
    pub fn wind_inputs(&self, i: usize) -> [Driven; 2] {
        self.winds[i].inputs()
    }

    /// θ before any estimate.
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters().iter().map(|own| own.nominal).collect()
    }

    /// The channels that thrusters follow with a lag, and these lags \[s\] with parameters `theta`.
    pub fn lags(&self, theta: &[f64]) -> Vec<(usize, f64)> {
        let numbers = self.numbers.with(theta);
        let lag = |own: &Thruster| own.delay.map(|[lag, _]| (own.input(), lag.of(&numbers)));
        self.thrusters.iter().filter_map(lag).filter(|(_, lag)| *lag > 0.0).collect()
    }

    /// Whether, with parameters `theta`, a thruster begins to follow its input only after some time.
    pub fn has_dead_time(&self, theta: &[f64]) -> bool {
        let numbers = self.numbers.with(theta);
        let late = |own: &Thruster| own.delay.is_some_and(|[_, dead]| dead.of(&numbers) > 0.0);
        self.thrusters.iter().any(late)
    }

    /// Whether a channel drives a propeller whose thrust law holds ahead only.
    pub fn is_ahead_only(&self, channel: usize) -> bool {
        let mut driven = self.propellers.iter().filter(|own| own.revolutions.channel == channel);
        driven.any(|own| !own.is_reversed())
    }

    /// As written.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Refuses parameters `theta` with whose masses forces accelerate the ship backwards.
    ///
    /// # Errors
    /// Names the ship.
    pub fn check(&self, theta: &[f64]) -> Result<(), Invalid> {
        let numbers = self.numbers.with(theta);
        if self.mass.with(&numbers).is_sound(()) {
            return Ok(());
        }
        let expected = "masses with added masses above 0, and coupling that does not outweigh them";
        Err(Invalid::new(
            "[ship]",
            "masses with which forces accelerate her backwards",
            expected,
            "correct them",
        ))
    }
}

/// Refuses more parts than any ship has.
fn check_counts(description: &Description) -> Result<(), Invalid> {
    let Description { surge, sway, yaw, propeller, rudder, thruster, wind, crossflow, .. } = description;
    let counts = [
        ("surge", surge.len()),
        ("sway", sway.len()),
        ("yaw", yaw.len()),
        ("propeller", propeller.len()),
        ("rudder", rudder.len()),
        ("thruster", thruster.len()),
        ("wind", wind.len()),
        ("crossflow", crossflow.len()),
    ];
    check_ranges(counts.map(|(key, count)| (key, count as f64, 0.0..=MOST, "parts")))
}
