use vessel::{Compiled, Lane, Look, Model};

use super::levels::{Flow, Levels};
use super::unknowns::Unknowns;

/// How the N states move on: u, v, r, then the current's two components (N = 5, 8), then three forces (N = 6, 8).
#[derive(Clone, Debug)]
pub(crate) struct Dynamics<M, X, const N: usize> {
    model: M,
    current: X,
    turning: X,
    force: X,
}

/// The dynamics at one sample: what their derivative is made of.
pub(crate) struct Local<X> {
    pub slopes: [[X; 3]; 3],
    turn: Turn<X>,
}

/// A current that turns against the vessel by its heading's change: cosine and sine, and what r changes in its components.
struct Turn<X> {
    cos: X,
    sin: X,
    by_r: [X; 2],
}

const fn current(n: usize) -> bool {
    n == 5 || n == 8
}

const fn force(n: usize) -> bool {
    n == 6 || n == 8
}

impl<'m, X: Unknowns, const N: usize> Dynamics<Compiled<'m, X>, X, N> {
    /// Of `model` with `theta`, one number per parameter.
    pub(crate) fn new(model: &'m Model, theta: &[X], levels: Option<&Levels<X>>) -> Self {
        Self::of(Compiled::new(model, theta), levels)
    }

    /// Transposed products where [`Self::at`] looked last: see [`Compiled::pull_back`].
    #[inline(always)]
    pub(crate) fn pull_back(&mut self, terms: &[X], slopes: &[[X; 3]; 3], out: &mut [X]) {
        self.model.pull_back(terms, slopes, out);
    }
}

impl<M: Look<X>, X: Unknowns, const N: usize> Dynamics<M, X, N> {
    /// Of `model` with its parameters.
    pub(crate) fn of(model: M, levels: Option<&Levels<X>>) -> Self {
        let (current, turning) = match levels.map(|l| l.current) {
            Some(Flow::Markov { factor, turning, .. }) => (factor, turning),
            _ => (X::ZERO, X::ZERO),
        };
        let force = levels.and_then(|l| l.force).map_or(X::ZERO, |gusts| gusts.factor);
        Self { model, current, turning, force }
    }

    /// φ of parameter `i`.
    #[inline(always)]
    pub(crate) fn term(&self, i: usize) -> X {
        self.model.term(i)
    }

    /// Looks at the states `z`.
    #[inline(always)]
    pub(crate) fn at(&mut self, z: &[X; N], exogenous: &[X]) -> Local<X> {
        let water = if current(N) { Some([z[3], z[4]]) } else { None };
        self.model.look([z[0], z[1], z[2]], exogenous, water);
        Local { slopes: self.model.slopes(), turn: self.turn(z) }
    }

    #[inline(always)]
    fn turn(&self, z: &[X; N]) -> Turn<X> {
        if !current(N) {
            return Turn { cos: X::ONE, sin: X::ZERO, by_r: [X::ZERO; 2] };
        }
        // Polynomials: to 1e-9 for turns of up to 0.15 rad per sample.
        let angle = self.turning * z[2];
        let square = angle * angle;
        let cos = X::ONE + square * (X::from(-0.5) + square * X::from(1.0 / 24.0));
        let sin = angle * (X::ONE + square * (X::from(-1.0 / 6.0) + square * X::from(1.0 / 120.0)));
        let (along, across) = (cos * z[4] - sin * z[3], X::ZERO - (cos * z[3] + sin * z[4]));
        Turn { cos, sin, by_r: [self.turning * along, self.turning * across] }
    }

    /// The next states, after [`Self::at`] looked at `z`.
    #[inline(always)]
    pub(crate) fn next(&self, z: &[X; N], local: &Local<X>) -> [X; N] {
        let forces = force(N).then(|| [z[N - 3], z[N - 2], z[N - 1]]);
        let mut next = *z;
        next[..3].copy_from_slice(&self.model.next([z[0], z[1], z[2]], forces));
        if current(N) {
            next[3] = self.current * (local.turn.cos * z[3] + local.turn.sin * z[4]);
            next[4] = self.current * (local.turn.cos * z[4] - local.turn.sin * z[3]);
        }
        if force(N) {
            for i in N - 3..N {
                next[i] = self.force * z[i];
            }
        }
        next
    }

    /// A s, A being the derivative of the next states, for a column of s.
    #[inline(always)]
    pub(crate) fn forward(&self, local: &Local<X>, s: &[Lane; N]) -> [Lane; N] {
        let mut out = *s;
        let (x, y) = if current(N) { (s[0] - s[3], s[1] - s[4]) } else { (s[0], s[1]) };
        for (d, slope) in local.slopes.iter().enumerate() {
            out[d] = s[d] + (slope[0].lane() * x + slope[1].lane() * y + slope[2].lane() * s[2]);
            if force(N) {
                out[d] += s[N - 3 + d];
            }
        }
        if current(N) {
            let (kept, [cos, sin, along, across]) = (self.current.lane(), local.turn.lanes());
            out[3] = kept * (cos * s[3] + sin * s[4] + along * s[2]);
            out[4] = kept * (cos * s[4] - sin * s[3] + across * s[2]);
        }
        if force(N) {
            for i in N - 3..N {
                out[i] = self.force.lane() * s[i];
            }
        }
        out
    }

    /// Aᵀ λ for a column of λ.
    #[inline(always)]
    pub(crate) fn backward(&self, local: &Local<X>, adjoint: &[Lane; N]) -> [Lane; N] {
        let mut out = *adjoint;
        let [surge, sway, yaw] = &local.slopes;
        let mut through = [Lane::ZERO; 3];
        for i in 0..3 {
            through[i] =
                surge[i].lane() * adjoint[0] + sway[i].lane() * adjoint[1] + yaw[i].lane() * adjoint[2];
            out[i] = adjoint[i] + through[i];
        }
        if current(N) {
            let (kept, [cos, sin, along, across]) = (self.current.lane(), local.turn.lanes());
            out[2] += kept * (along * adjoint[3] + across * adjoint[4]);
            out[3] = kept * (cos * adjoint[3] - sin * adjoint[4]) - through[0];
            out[4] = kept * (sin * adjoint[3] + cos * adjoint[4]) - through[1];
        }
        if force(N) {
            for d in 0..3 {
                out[N - 3 + d] = adjoint[d] + self.force.lane() * adjoint[N - 3 + d];
            }
        }
        out
    }
}

impl<X: Unknowns> Turn<X> {
    #[inline(always)]
    fn lanes(&self) -> [Lane; 4] {
        [self.cos.lane(), self.sin.lane(), self.by_r[0].lane(), self.by_r[1].lane()]
    }
}
