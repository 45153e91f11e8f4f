use crate::forces::components::Surroundings;
use crate::forces::mass::Inertia;
use crate::forces::propeller::Wash;
use crate::forces::term::motion;
use crate::forces::{Forces, Real};

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
        Body::new(self, theta)
    }
}

/// Adds one force to another.
#[inline(always)]
fn add<X: Real>(sum: &mut [X; 3], more: [X; 3]) {
    for (own, more) in sum.iter_mut().zip(more) {
        *own += more;
    }
}

impl<'f, X: Real> Body<'f, X> {
    fn new(forces: &'f Forces, theta: &[X]) -> Self {
        let numbers = forces.numbers.with(theta);
        let inertia = forces.mass.with(&numbers);
        Self { forces, numbers, inertia }
    }

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
        for (own, terms) in sum.iter_mut().zip(&forces.terms) {
            for term in terms {
                *own += term.value(numbers, &around.motion, channel);
            }
        }
        // Of the few propellers of a ship; a rudder further back than the fourth is rare, and computes its wash again.
        let mut washes: [Option<Wash<X>>; 4] = [None; 4];
        for (i, propeller) in forces.propellers.iter().enumerate() {
            let (own, wash) = propeller.forces(numbers, &around);
            add(&mut sum, own);
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
        if let Some((_, half)) = self.forces.turning.iter().find(|(own, _)| *own == channel) {
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
