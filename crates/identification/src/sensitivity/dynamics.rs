use engine::{Ambient, Compiled, Stepping};
use model::Model;
use numerics::Lane;

use super::levels::{Flow, Levels};
use super::unknowns::Unknowns;

/// The state transition of the N states: u, v, r, then the current's two components (N = 5, 8, 9), then three forces
/// (N = 6, 8); or, for free simulations only, the change of the current's components and the wind's effect per
/// sample, both over ground (N = 9). With drifting sensors (N = 7) the first three states are the measured ones,
/// including drift; the last three are the drift itself, and the one between them stays zero.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics<'m, X: Stepping, const N: usize> {
    model: Compiled<'m, X>,
    motion: Motion<X, N>,
}

/// The linear part of [`Dynamics`]: the transition of deviations of the states, and of the disturbances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<X, const N: usize> {
    current: X,
    turning: X,
    force: [X; 3],
    drift: X,
}

/// The dynamics at one sample, for their derivative.
#[derive(Clone, Copy)]
pub(crate) struct Local<X> {
    pub slopes: [[X; 3]; 3],
    turn: Turn<X>,
}

/// Vectors with a fixed direction over ground rotate relative to the vessel by the change of its heading: cosine and
/// sine, and the derivatives by r of the components of the current, of its change and of the wind.
#[derive(Clone, Copy)]
struct Turn<X> {
    cos: X,
    sin: X,
    by_r: [[X; 2]; 3],
}

const fn current(n: usize) -> bool {
    n == 5 || n == 8 || n == 9
}

const fn has_ambient(n: usize) -> bool {
    n == 9
}

const fn force(n: usize) -> bool {
    n == 6 || n == 8
}

const fn drift(n: usize) -> bool {
    n == 7
}

impl<'m, X: Unknowns, const N: usize> Dynamics<'m, X, N> {
    /// Of `model` with `theta`, one number per parameter.
    pub(crate) fn new(model: &'m Model, theta: &[X], levels: Option<&Levels<X>>) -> Self {
        Self { model: Compiled::new(model, theta), motion: Motion::new(levels) }
    }

    /// Transposed products at the last point of [`Self::at`]: see [`Compiled::pull_back`].
    #[inline(always)]
    pub(crate) fn pull_back(&mut self, terms: &[X], slopes: &[[X; 3]; 3], out: &mut [X]) {
        self.model.pull_back(terms, slopes, out);
    }

    /// The transition of deviations.
    #[inline(always)]
    pub(crate) fn motion(&self) -> &Motion<X, N> {
        &self.motion
    }

    /// φ of parameter `i`.
    #[inline(always)]
    pub(crate) fn term(&self, i: usize) -> X {
        self.model.term(i)
    }

    /// Evaluates the dynamics at the states `z`.
    #[inline(always)]
    pub(crate) fn at(&mut self, z: &[X; N], exogenous: &[X]) -> Local<X> {
        let water = if current(N) { Some([z[3], z[4]]) } else { None };
        self.model.look(vessel_state(z), exogenous, water);
        Local { slopes: self.model.slopes(), turn: self.motion.turn(z) }
    }

    /// The next u, v, r, without derivatives.
    #[inline(always)]
    pub(crate) fn step(&mut self, state: [X; 3], exogenous: &[X]) -> [X; 3] {
        self.model.step(state, exogenous, Ambient::default())
    }

    /// The next states, after [`Self::at`] of `z`.
    #[inline(always)]
    pub(crate) fn next(&self, z: &[X; N], local: &Local<X>) -> [X; N] {
        let forces = force(N).then(|| [z[N - 3], z[N - 2], z[N - 1]]);
        self.motion.next(z, self.model.next(vessel_state(z), forces), local)
    }

    /// A s, A being the derivative of the next states, for a column of s.
    #[inline(always)]
    pub(crate) fn forward(&self, local: &Local<X>, s: &[Lane; N]) -> [Lane; N] {
        self.motion.forward(local, s)
    }

    /// Aᵀ λ for a column of λ; not for the ambient unknowns of a free simulation (N = 9).
    #[inline(always)]
    pub(crate) fn backward(&self, local: &Local<X>, adjoint: &[Lane; N]) -> [Lane; N] {
        self.motion.backward(local, adjoint)
    }
}

/// u, v, r of the vessel itself, without the drift of its sensors.
#[inline(always)]
pub(crate) fn vessel_state<X: Unknowns, const N: usize>(z: &[X; N]) -> [X; 3] {
    match drift(N) {
        true => [z[0] - z[N - 3], z[1] - z[N - 2], z[2] - z[N - 1]],
        false => [z[0], z[1], z[2]],
    }
}

/// The components of the current among the states; `None` in still water.
#[inline(always)]
pub(crate) fn current_of<X: Unknowns, const N: usize>(z: &[X; N]) -> Option<[X; 2]> {
    current(N).then(|| [z[3], z[4]])
}

impl<X: Unknowns, const N: usize> Motion<X, N> {
    pub(crate) fn new(levels: Option<&Levels<X>>) -> Self {
        let (current, turning) = match levels.map(|l| l.current) {
            Some(Flow::Markov { factor, turning, .. }) => (factor, turning),
            _ => (X::ZERO, X::ZERO),
        };
        let force = levels.and_then(|l| l.force).map_or([X::ZERO; 3], |gusts| gusts.factor);
        let drift = levels.and_then(|l| l.drift).map_or(X::ZERO, |drift| drift.factor);
        Self { current, turning, force, drift }
    }

    /// The dynamics at the states `z`, where the model's derivatives by its states are `slopes`.
    #[inline(always)]
    pub(crate) fn local(&self, z: &[X; N], slopes: [[X; 3]; 3]) -> Local<X> {
        Local { slopes, turn: self.turn(z) }
    }

    #[inline(always)]
    fn turn(&self, z: &[X; N]) -> Turn<X> {
        let still = [[X::ZERO; 2]; 3];
        if !current(N) {
            return Turn { cos: X::ONE, sin: X::ZERO, by_r: still };
        }
        // Polynomials: to 1e-9 for turns of up to 0.15 rad per sample.
        let angle = self.turning * z[2];
        let square = angle * angle;
        let cos = X::ONE + square * (X::from(-0.5) + square * X::from(1.0 / 24.0));
        let sin = angle * (X::ONE + square * (X::from(-1.0 / 6.0) + square * X::from(1.0 / 120.0)));
        let by_r = |[along, across]: [X; 2]| {
            let by = [cos * across - sin * along, X::ZERO - (cos * along + sin * across)];
            by.map(|by| self.turning * by)
        };
        let turned = match has_ambient(N) {
            true => [by_r([z[3] + z[5], z[4] + z[6]]), by_r([z[5], z[6]]), by_r([z[7], z[8]])],
            false => [by_r([z[3], z[4]]), still[1], still[2]],
        };
        Turn { cos, sin, by_r: turned }
    }

    /// The states after `z`, where `vessel` is u, v, r.
    #[inline(always)]
    pub(crate) fn next(&self, z: &[X; N], vessel: [X; 3], local: &Local<X>) -> [X; N] {
        let mut next = *z;
        next[..3].copy_from_slice(&vessel);
        if current(N) {
            let changed = if has_ambient(N) { [z[3] + z[5], z[4] + z[6]] } else { [z[3], z[4]] };
            [next[3], next[4]] = local.turn.of(changed).map(|c| self.current * c);
        }
        if has_ambient(N) {
            (next[0], next[1]) = (next[0] + z[7], next[1] + z[8]);
            [next[5], next[6]] = local.turn.of([z[5], z[6]]);
            [next[7], next[8]] = local.turn.of([z[7], z[8]]);
        }
        for d in 0..3 {
            if force(N) {
                next[N - 3 + d] = self.force[d] * z[N - 3 + d];
            }
            if drift(N) {
                next[N - 3 + d] = self.drift * z[N - 3 + d];
                next[d] += next[N - 3 + d];
            }
        }
        next
    }

    /// See [`Dynamics::forward`].
    #[inline(always)]
    pub(crate) fn forward(&self, local: &Local<X>, s: &[Lane; N]) -> [Lane; N] {
        let mut out = *s;
        let mut own = [s[0], s[1], s[2]];
        if drift(N) {
            (0..3).for_each(|d| own[d] = s[d] - s[N - 3 + d]);
        }
        let (x, y) = if current(N) { (s[0] - s[3], s[1] - s[4]) } else { (own[0], own[1]) };
        for (d, slope) in local.slopes.iter().enumerate() {
            let by_r = slope[2].lane().fused(own[2], own[d]);
            out[d] = slope[0].lane().fused(x, slope[1].lane().fused(y, by_r));
            if force(N) {
                out[d] += s[N - 3 + d];
            }
        }
        if current(N) {
            let changed = if has_ambient(N) { [s[3] + s[5], s[4] + s[6]] } else { [s[3], s[4]] };
            [out[3], out[4]] = local.turn.forward(0, changed, s[2]).map(|c| self.current.lane() * c);
        }
        if has_ambient(N) {
            (out[0], out[1]) = (out[0] + s[7], out[1] + s[8]);
            [out[5], out[6]] = local.turn.forward(1, [s[5], s[6]], s[2]);
            [out[7], out[8]] = local.turn.forward(2, [s[7], s[8]], s[2]);
        }
        for d in 0..3 {
            if force(N) {
                out[N - 3 + d] = self.force[d].lane() * s[N - 3 + d];
            }
            if drift(N) {
                out[N - 3 + d] = self.drift.lane() * s[N - 3 + d];
                out[d] += out[N - 3 + d];
            }
        }
        out
    }

    /// See [`Dynamics::backward`].
    #[inline(always)]
    fn backward(&self, local: &Local<X>, adjoint: &[Lane; N]) -> [Lane; N] {
        let mut out = *adjoint;
        let [surge, sway, yaw] = &local.slopes;
        let through = |i: usize, start: Lane| {
            let by_yaw = yaw[i].lane().fused(adjoint[2], start);
            surge[i].lane().fused(adjoint[0], sway[i].lane().fused(adjoint[1], by_yaw))
        };
        for i in 0..3 {
            out[i] = through(i, adjoint[i]);
        }
        if current(N) {
            let (kept, [cos, sin, along, across]) = (self.current.lane(), local.turn.lanes());
            out[2] += kept * (along * adjoint[3] + across * adjoint[4]);
            out[3] = kept * (cos * adjoint[3] - sin * adjoint[4]) - through(0, Lane::ZERO);
            out[4] = kept * (sin * adjoint[3] + cos * adjoint[4]) - through(1, Lane::ZERO);
        }
        for d in 0..3 {
            if force(N) {
                out[N - 3 + d] = adjoint[d] + self.force[d].lane() * adjoint[N - 3 + d];
            }
            if drift(N) {
                out[N - 3 + d] = self.drift.lane() * (adjoint[d] + adjoint[N - 3 + d]) - out[d];
            }
        }
        out
    }
}

impl<X: Unknowns> Turn<X> {
    /// Components one sample later.
    #[inline(always)]
    fn of(&self, [along, across]: [X; 2]) -> [X; 2] {
        [self.cos * along + self.sin * across, self.cos * across - self.sin * along]
    }

    /// The same for columns of sensitivities: of vector `i` of [`Turn::by_r`] and of r.
    #[inline(always)]
    fn forward(&self, i: usize, [along, across]: [Lane; 2], r: Lane) -> [Lane; 2] {
        let (cos, sin, by_r) = (self.cos.lane(), self.sin.lane(), &self.by_r[i]);
        [cos * along + sin * across + by_r[0].lane() * r, cos * across - sin * along + by_r[1].lane() * r]
    }

    #[inline(always)]
    fn lanes(&self) -> [Lane; 4] {
        [self.cos.lane(), self.sin.lane(), self.by_r[0][0].lane(), self.by_r[0][1].lane()]
    }
}
