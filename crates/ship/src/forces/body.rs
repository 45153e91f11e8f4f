use refusal::{Invalid, check_bounds};

use super::actuators::{Propeller, Rudder, Thruster, Wash};
use crate::forces::mass::{Inertia, Mass, Prime};
use crate::forces::numbers::{Builder, Numbers};
use crate::forces::term::{Crossflow, Surroundings, Term, Wind, motion};
use crate::forces::{Channel, Description, Driven, Factor, Parameter, Quantity, QuantitySource, Real};

/// A ship with her parameters: what accelerates her, and how she moves on.
#[derive(Clone, Debug)]
pub struct Body<'f, X> {
    pub(crate) forces: &'f Forces,
    pub(crate) numbers: Vec<X>,
    inertia: Inertia<X>,
}

impl Forces {
    /// The ship with these parameters.
    ///
    /// # Panics
    /// With fewer numbers than [`Self::parameters`].
    pub fn body<X: Real>(&self, theta: &[X]) -> Body<'_, X> {
        let numbers = self.numbers.with(theta);
        let inertia = self.mass.with(&numbers);
        Body { forces: self, numbers, inertia }
    }
}

/// Adds one force to another.
#[inline(always)]
fn add<X: Real>(sum: &mut [X; 3], more: [X; 3]) {
    for (total, more) in sum.iter_mut().zip(more) {
        *total += more;
    }
}

impl<X: Real> Body<'_, X> {
    /// The force ahead and to starboard \[N\] and the moment \[N m\] without products of mass and yaw rate, in `state`:
    /// u, v \[m/s\] relative to the water, r \[rad/s\].
    #[inline(always)]
    pub fn force(&self, state: [X; 3], channel: &impl Fn(usize) -> X) -> [X; 3] {
        let Self { forces, numbers, .. } = self;
        let around = Surroundings {
            motion: motion(state, forces.prime.speed),
            channel,
            density: X::from(forces.prime.density),
            length: forces.prime.length,
        };
        let mut sum = [X::ZERO; 3];
        for (total, terms) in sum.iter_mut().zip(&forces.terms) {
            for term in terms {
                *total += term.value(numbers, &around.motion, channel);
            }
        }
        // Of the few propellers of a ship; a rudder further back than the fourth is rare, and computes its wash again.
        let mut washes: [Option<Wash<X>>; 4] = [None; 4];
        for (i, propeller) in forces.propellers.iter().enumerate() {
            let (thrust, wash) = propeller.forces(numbers, &around);
            add(&mut sum, thrust);
            if let Some(to) = washes.get_mut(i) {
                *to = Some(wash);
            }
        }
        for rudder in &forces.rudders {
            let known = rudder.behind.and_then(|i| washes.get(i).copied().flatten());
            let again = || rudder.behind.map(|i| forces.propellers[i].forces(numbers, &around).1);
            let wash = known.or_else(again);
            add(&mut sum, rudder.forces(numbers, &around, wash.as_ref()));
        }
        forces.thrusters.iter().for_each(|thruster| add(&mut sum, thruster.forces(numbers, &around)));
        forces.winds.iter().for_each(|wind| add(&mut sum, wind.forces(numbers, &around)));
        forces.crossflows.iter().for_each(|crossflow| add(&mut sum, crossflow.forces(numbers, &around)));
        sum
    }

    /// Changes per second of u, v \[m/s²\] and r \[rad/s²\] in `state`: u, v \[m/s\] relative to the water, r \[rad/s\];
    /// `channels`: one number per input and measured disturbance.
    pub fn accelerations<E: Copy + Into<X>>(&self, state: [X; 3], channels: &[E]) -> [X; 3] {
        self.changes(state, &|i: usize| channels[i].into())
    }

    #[inline(always)]
    fn changes(&self, state: [X; 3], channel: &impl Fn(usize) -> X) -> [X; 3] {
        self.inertia.accelerations(state, self.force(state, channel))
    }

    /// The state after `seconds`, with channels linear between those at its beginning and its end, by steps of order 4.
    pub fn step<E: Copy + Into<X>>(&self, state: [X; 3], begin: &[E], end: &[E], seconds: f64) -> [X; 3] {
        self.steps(state, |i| [begin[i].into(), end[i].into()], seconds)
    }

    /// The state after `seconds`, with channels held.
    pub fn step_held<E: Copy + Into<X>>(&self, state: [X; 3], channels: &[E], seconds: f64) -> [X; 3] {
        self.steps(state, |i| [channels[i].into(); 2], seconds)
    }

    /// By how much u, v \[m/s\] over the ground and r \[rad/s\] change in a sample of `seconds` with channels held, from the
    /// state `relative` to the water. Each change has the axes of its end. Water that flows with `current`, ahead and to starboard
    /// \[m/s\], keeps its course over the earth while the ship turns.
    #[inline(always)]
    pub fn changes_in_current<E: Copy + Into<X>>(
        &self,
        relative: [X; 3],
        channels: &[E],
        [along, across]: [X; 2],
        seconds: f64,
    ) -> [X; 3] {
        let next = self.step_held(relative, channels, seconds);
        let (sine, cosine) = (relative[2] + next[2]).times(0.5 * seconds).sine_and_cosine();
        let turned = [cosine * along + sine * across, cosine * across - sine * along];
        [
            next[0] - relative[0] + (turned[0] - along),
            next[1] - relative[1] + (turned[1] - across),
            next[2] - relative[2],
        ]
    }

    /// The state after `seconds`, where `ends` has a channel at the beginning and at the end.
    #[inline(always)]
    pub fn steps(&self, mut state: [X; 3], ends: impl Fn(usize) -> [X; 2], seconds: f64) -> [X; 3] {
        let count = self.forces.step_s.map_or(1.0, |most| (seconds / most - 1e-9).ceil().max(1.0));
        let step = seconds / count;
        for i in 0..count as usize {
            let at =
                |share: f64, channel: usize| self.between(channel, ends(channel), (i as f64 + share) / count);
            state = self.runge_kutta(state, at, step);
        }
        state
    }

    /// A channel between its `ends`; one that goes around takes the shorter way.
    #[inline(always)]
    fn between(&self, channel: usize, [begin, end]: [X; 2], share: f64) -> X {
        let mut change = end - begin;
        if let Some((_, half)) = self.forces.turning.iter().find(|(input, _)| *input == channel) {
            let half = X::from(*half);
            change = (change - half).if_positive(change - half - half, change);
            change = (change + half).if_positive(change, change + half + half);
        }
        begin + change.times(share)
    }

    /// One loop over the four stages, so that the forces are compiled once.
    #[inline(always)]
    fn runge_kutta(&self, state: [X; 3], at: impl Fn(f64, usize) -> X, step: f64) -> [X; 3] {
        // Where each stage is within the step, and its weight.
        const STAGES: [(f64, f64); 4] = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)];
        let (mut change, mut sum) = ([X::ZERO; 3], [X::ZERO; 3]);
        for (share, weight) in STAGES {
            let here = std::array::from_fn(|d| state[d] + change[d].times(share * step));
            change = self.changes(here, &|channel| at(share, channel));
            (0..3).for_each(|d| sum[d] += change[d].times(weight));
        }
        std::array::from_fn(|d| state[d] + sum[d].times(step / 6.0))
    }
}

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
        check_bounds(description)?;
        let prime = Prime::new(description.density_kg_m3, &description.ship)?;
        let mut builder = Builder::default();
        let reading = &mut builder;
        let mut terms = [Vec::new(), Vec::new(), Vec::new()];
        for (d, specs) in description.terms().into_iter().enumerate() {
            for spec in specs {
                terms[d].push(Term::new(spec, d, channels, &prime, reading)?);
            }
        }
        let mass = Mass::new(&description.ship, &prime, reading)?;
        let mut propellers: Vec<Propeller> = Vec::new();
        for spec in &description.propeller {
            propellers.push(Propeller::new(spec, channels, &prime, reading)?);
        }
        let rudder = |spec| Rudder::new(spec, &propellers, channels, &prime, reading);
        let rudders = description.rudder.iter().map(rudder).collect::<Result<Vec<_>, _>>()?;
        let thruster = |spec| Thruster::new(spec, channels, &prime, reading);
        let thrusters = description.thruster.iter().map(thruster).collect::<Result<Vec<_>, _>>()?;
        let wind = |spec| Wind::new(spec, channels, &prime, reading);
        let winds = description.wind.iter().map(wind).collect::<Result<Vec<_>, _>>()?;
        let crossflow = |spec| Crossflow::new(spec, &prime, reading);
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
        self.parameters().iter().map(|parameter| parameter.nominal).collect()
    }

    /// The channels that thrusters follow with a lag, and these lags \[s\] with parameters `theta`.
    pub fn lags(&self, theta: &[f64]) -> Vec<(usize, f64)> {
        let numbers = self.numbers.with(theta);
        let lag = |thruster: &Thruster| thruster.delay.map(|[lag, _]| (thruster.input(), lag.of(&numbers)));
        self.thrusters.iter().filter_map(lag).filter(|(_, lag)| *lag > 0.0).collect()
    }

    /// Whether, with parameters `theta`, a thruster begins to follow its input only after some time.
    pub fn has_dead_time(&self, theta: &[f64]) -> bool {
        let numbers = self.numbers.with(theta);
        let late = |thruster: &Thruster| thruster.delay.is_some_and(|[_, dead]| dead.of(&numbers) > 0.0);
        self.thrusters.iter().any(late)
    }

    /// Whether a channel drives a propeller whose thrust law holds ahead only.
    pub fn is_ahead_only(&self, channel: usize) -> bool {
        let mut driven = self.propellers.iter().filter(|propeller| propeller.revolutions.channel == channel);
        driven.any(|propeller| !propeller.is_reversed())
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

/// The shortest time constant \[s\]: a shorter one is none.
const SHORTEST_S: f64 = 1e-9;

impl<X: Real> Body<'_, X> {
    /// What acts in every sample where thrusters follow their inputs with dead time and lag: rows as `inputs`, which have
    /// `width` entries each, `sample_s` apart and linear between. Before the first row the inputs were as in it. Tangents of the inputs themselves are not followed.
    pub fn acting<E: Copy + Into<X>>(&self, inputs: &[E], width: usize, sample_s: f64) -> Vec<X> {
        let mut rows: Vec<X> = inputs.iter().map(|input| (*input).into()).collect();
        for thruster in &self.forces.thrusters {
            let Some([lag, dead]) = thruster.delay else { continue };
            let (lag, dead) = (lag.of(&self.numbers), dead.of(&self.numbers));
            let channel = thruster.input();
            let commanded: Vec<X> = inputs.chunks_exact(width).map(|row| row[channel].into()).collect();
            let followed = late(&commanded, dead, lag, sample_s);
            rows.chunks_exact_mut(width).zip(followed).for_each(|(row, value)| row[channel] = value);
        }
        rows
    }
}

/// What follows `commanded`, linear between samples `sample_s` apart, after `dead` seconds and with a time constant of `lag`
/// seconds. Before the first sample it was as in that.
pub fn late<X: Real>(commanded: &[X], dead: X, lag: X, sample_s: f64) -> Vec<X> {
    let begun: Vec<X> = (0..commanded.len()).map(|k| before(commanded, k, dead, sample_s)).collect();
    lagging(&begun, lag, sample_s)
}

/// The input `dead` seconds before sample `k`, linear between samples.
fn before<X: Real>(all: &[X], k: usize, dead: X, sample_s: f64) -> X {
    let samples = dead.times(1.0 / sample_s);
    let whole = X::of(|place| samples.at(place).max(0.0).floor());
    let at = |more: f64| X::of(|place| all[k - (whole.at(place) + more).min(k as f64) as usize].at(place));
    let (near, far) = (at(0.0), at(1.0));
    near + (samples - whole) * (far - near)
}

/// What follows `all`, linear between samples, with a time constant of `lag` seconds: the exact solution.
fn lagging<X: Real>(all: &[X], lag: X, sample_s: f64) -> Vec<X> {
    let lag = (lag - X::from(SHORTEST_S)).if_positive(lag, X::from(SHORTEST_S));
    let left = X::from(-sample_s).over(lag).exponential();
    let mut out: Vec<X> = all.iter().take(1).copied().collect();
    for ends in all.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        // Behind an input that changes steadily by as much as it changes in a time constant.
        let behind = (to - from).times(1.0 / sample_s) * lag;
        let start = out.last().copied().unwrap_or(X::ZERO);
        out.push(to - behind + left * (start - from + behind));
    }
    out
}

/// A sum of terms of one order in sway or yaw, where v is the same multiple of r L throughout. It is linear in θ.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralSum {
    /// 1 for sway, 2 for yaw.
    pub degree: usize,
    /// 1 for linear terms, 3 for cubic ones.
    pub order: u32,
    /// By what each of θ counts in it, in the prime system.
    pub weights: Vec<f64>,
    /// What known numbers add.
    pub known: f64,
}

impl LateralSum {
    /// The sum with parameters `theta`.
    pub fn of(&self, theta: &[f64]) -> f64 {
        self.known + numerics::dot(&self.weights, theta)
    }
}

impl Forces {
    /// The sums of linear, quadratic and cubic terms in sway and yaw where v is `drift` r L, with a yaw rate of 1 in the prime
    /// system. Those of fewer than two free numbers are left out.
    pub fn lateral_sums(&self, drift: f64) -> Vec<LateralSum> {
        let orders = [1, 2].into_iter().flat_map(|degree| (1..=3).map(move |order| (degree, order)));
        let all = orders.map(|(degree, order)| self.lateral_sum(degree, order, drift));
        all.filter(|sum| sum.weights.iter().filter(|weight| **weight != 0.0).count() > 1).collect()
    }

    fn lateral_sum(&self, degree: usize, order: u32, drift: f64) -> LateralSum {
        let of = |theta: &[f64]| -> f64 {
            let numbers = self.numbers.with(theta);
            let terms = self.terms[degree].iter().filter_map(|term| term.lateral(&numbers, drift));
            terms.filter(|pair| pair.0 == order).map(|pair| pair.1).sum()
        };
        let count = self.parameters().len();
        let known = of(&vec![0.0; count]);
        let weight = |i: usize| {
            let unit: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k == i))).collect();
            of(&unit) - known
        };
        LateralSum { degree, order, weights: (0..count).map(weight).collect(), known }
    }
}
