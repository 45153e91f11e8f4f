use vessel::{Lane, Number, Tangent};

use super::levels::{Flow, Levels};

/// How the N states move on: u, v, r, then the current's two components (N = 5, 8), then three forces (N = 6, 8).
#[derive(Clone, Debug)]
pub(crate) struct Dynamics<const N: usize> {
    tangent: Tangent,
    current: Lane,
    turning: Lane,
    force: Lane,
}

/// The dynamics at one sample: what their derivative is made of.
pub(crate) struct Local {
    pub slopes: [[Lane; 3]; 3],
    turn: Turn,
}

/// A current that turns against the vessel by its heading's change: cosine and sine, and what r changes in its components.
struct Turn {
    cos: Lane,
    sin: Lane,
    by_r: [Lane; 2],
}

const fn current(n: usize) -> bool {
    n == 5 || n == 8
}

const fn force(n: usize) -> bool {
    n == 6 || n == 8
}

impl<const N: usize> Dynamics<N> {
    pub(crate) fn new(tangent: Tangent, levels: Option<&Levels>) -> Self {
        let (factor, turning) = match levels.map(|l| l.current) {
            Some(Flow::Markov { factor, turning, .. }) => (factor, turning),
            _ => (0.0, 0.0),
        };
        let gusts = levels.and_then(Levels::gusts).map_or(0.0, |g| g.factor);
        Self {
            tangent,
            current: Lane::splat(factor),
            turning: Lane::splat(turning),
            force: Lane::splat(gusts),
        }
    }

    pub(crate) fn tangent(&self) -> &Tangent {
        &self.tangent
    }

    /// Looks at the states `z`.
    #[inline(always)]
    pub(crate) fn at(&mut self, z: &[Lane; N], exogenous: &[impl Number], theta: &[Lane]) -> Local {
        let mut relative = [z[0], z[1], z[2]];
        if current(N) {
            relative[0] = z[0] - z[3];
            relative[1] = z[1] - z[4];
        }
        self.tangent.set(relative, exogenous);
        Local { slopes: self.tangent.slopes(theta), turn: self.turn(z) }
    }

    #[inline(always)]
    fn turn(&self, z: &[Lane; N]) -> Turn {
        if !current(N) {
            return Turn { cos: Lane::ONE, sin: Lane::ZERO, by_r: [Lane::ZERO; 2] };
        }
        // Polynomials: to 1e-9 for turns of up to 0.15 rad per sample.
        let angle = self.turning * z[2];
        let square = angle * angle;
        let cos = Lane::ONE + square * (Lane::splat(-0.5) + square * Lane::splat(1.0 / 24.0));
        let sin = angle
            * (Lane::ONE + square * (Lane::splat(-1.0 / 6.0) + square * Lane::splat(1.0 / 120.0)));
        let (along, across) = (cos * z[4] - sin * z[3], Lane::ZERO - (cos * z[3] + sin * z[4]));
        Turn { cos, sin, by_r: [self.turning * along, self.turning * across] }
    }

    /// The next states, after [`Self::at`] looked at `z`.
    #[inline(always)]
    pub(crate) fn next(&self, z: &[Lane; N], local: &Local, theta: &[Lane], intercepts: &[Lane]) -> [Lane; N] {
        let mut next = *z;
        for (d, increment) in self.tangent.increments(theta).into_iter().enumerate() {
            next[d] = z[d] + (increment + intercepts[d]);
            if force(N) {
                next[d] += z[N - 3 + d];
            }
        }
        if current(N) {
            next[3] = self.current * (local.turn.cos * z[3] + local.turn.sin * z[4]);
            next[4] = self.current * (local.turn.cos * z[4] - local.turn.sin * z[3]);
        }
        if force(N) {
            (N - 3..N).for_each(|i| next[i] = self.force * z[i]);
        }
        next
    }

    /// A s, A being the derivative of the next states.
    #[inline(always)]
    pub(crate) fn forward(&self, local: &Local, s: &[Lane; N]) -> [Lane; N] {
        let mut out = *s;
        let (x, y) = if current(N) { (s[0] - s[3], s[1] - s[4]) } else { (s[0], s[1]) };
        for (d, slope) in local.slopes.iter().enumerate() {
            out[d] = s[d] + (slope[0] * x + slope[1] * y + slope[2] * s[2]);
            if force(N) {
                out[d] += s[N - 3 + d];
            }
        }
        if current(N) {
            let Turn { cos, sin, by_r } = &local.turn;
            out[3] = self.current * (*cos * s[3] + *sin * s[4] + by_r[0] * s[2]);
            out[4] = self.current * (*cos * s[4] - *sin * s[3] + by_r[1] * s[2]);
        }
        if force(N) {
            (N - 3..N).for_each(|i| out[i] = self.force * s[i]);
        }
        out
    }

    /// Aᵀ λ.
    #[inline(always)]
    pub(crate) fn backward(&self, local: &Local, adjoint: &[Lane; N]) -> [Lane; N] {
        let mut out = *adjoint;
        let through: [Lane; 3] = std::array::from_fn(|i| {
            let column = local.slopes.each_ref().map(|row| row[i]);
            column[0] * adjoint[0] + column[1] * adjoint[1] + column[2] * adjoint[2]
        });
        (0..3).for_each(|i| out[i] = adjoint[i] + through[i]);
        if current(N) {
            let Turn { cos, sin, by_r } = &local.turn;
            out[2] += self.current * (by_r[0] * adjoint[3] + by_r[1] * adjoint[4]);
            out[3] = self.current * (*cos * adjoint[3] - *sin * adjoint[4]) - through[0];
            out[4] = self.current * (*sin * adjoint[3] + *cos * adjoint[4]) - through[1];
        }
        if force(N) {
            (0..3).for_each(|d| out[N - 3 + d] = adjoint[d] + self.force * adjoint[N - 3 + d]);
        }
        out
    }
}
