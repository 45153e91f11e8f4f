//! Newton's method for a few equations, plain and damped.

/// Most steps; damped ones may be short.
const STEPS: usize = 50;
const DAMPED_STEPS: usize = 200;

/// Relative change of the unknowns at which they count as solved.
const SOLVED: f64 = 1e-13;

/// The unknowns that solve the equations from `unknowns` on, by full steps. `linearised` fills in rows \[Jacobian | −residual\].
/// Whether they do.
pub(crate) fn plain(
    unknowns: &mut [f64],
    Room { rows, solver }: &mut Room,
    mut linearised: impl FnMut(&[f64], &mut Rows),
) -> bool {
    for _ in 0..STEPS {
        linearised(unknowns, rows);
        let Some(step) = solver.solve(rows) else {
            return false;
        };
        let mut change: f64 = 0.0;
        for (x, dx) in unknowns.iter_mut().zip(step) {
            change = change.max(dx.abs() / (x.abs() + 1e-9));
            *x += dx;
        }
        if !unknowns.iter().all(|x| x.is_finite()) {
            return false;
        }
        if change < SOLVED {
            return true;
        }
    }
    false
}

/// What searches leave to those after them, so that memory is asked for once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    rows: Rows,
    solver: Solver,
}

/// Rows \[Jacobian | −residual\] of as many equations as unknowns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    entries: Vec<f64>,
    width: usize,
}

impl Rows {
    /// Makes room for the rows of `unknowns`, none of which is there.
    pub(crate) fn clear(&mut self, unknowns: usize) {
        self.entries.clear();
        self.width = unknowns + 1;
    }

    /// One row more, of zeros.
    pub(crate) fn push(&mut self) -> &mut [f64] {
        let before = self.entries.len();
        self.entries.resize(before + self.width, 0.0);
        &mut self.entries[before..]
    }

    fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.entries.chunks_exact(self.width.max(1))
    }
}

/// The same with steps that are halved until the next one, of the same Jacobian, is shorter: it then does not matter in which
/// units the equations are. `scales`: magnitudes of the unknowns.
///
/// The test is the natural one of Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3.
pub(crate) fn damped(
    unknowns: &mut [f64],
    scales: &[f64],
    mut linearised: impl FnMut(&[f64], &mut Rows),
) -> bool {
    let (mut rows, mut solver) = (Rows::default(), Solver::default());
    linearised(unknowns, &mut rows);
    // Nothing is to be done at rest, where no step is determined either.
    if rows.iter().all(|row| row.last() == Some(&0.0)) {
        return true;
    }
    let mut before = f64::INFINITY;
    for _ in 0..DAMPED_STEPS {
        let Some(step) = solver.solve(&rows).map(<[f64]>::to_vec) else { return false };
        let length = length(&step, unknowns, scales);
        // What is left is rounding: the equations cannot be solved better.
        let rounding = length < 1e-8 && length >= 0.5 * before;
        if length < SOLVED || rounding {
            unknowns.iter_mut().zip(&step).for_each(|(x, dx)| *x += dx);
            return true;
        }
        let Some((next, after)) = shortened(unknowns, scales, (&step, length), &rows, &mut linearised) else {
            return false;
        };
        unknowns.copy_from_slice(&next);
        (rows, before) = (after, length);
    }
    false
}

/// As far along `step`, of such a length, as the next step of the same Jacobian gets shorter: the unknowns there, with their
/// rows.
fn shortened(
    unknowns: &[f64],
    scales: &[f64],
    (step, whole): (&[f64], f64),
    rows: &Rows,
    linearised: &mut impl FnMut(&[f64], &mut Rows),
) -> Option<(Vec<f64>, Rows)> {
    let (mut share, mut solver) = (1.0, Solver::default());
    while share > 1e-6 {
        let next: Vec<f64> = unknowns.iter().zip(step).map(|(x, dx)| x + share * dx).collect();
        let mut after = Rows::default();
        linearised(&next, &mut after);
        let mut mixed = rows.clone();
        for (row, after) in mixed.entries.chunks_exact_mut(rows.width).zip(after.iter()) {
            row[rows.width - 1] = after[rows.width - 1];
        }
        let left = solver.solve(&mixed);
        let shorter = left.is_some_and(|left| length(left, unknowns, scales) <= (1.0 - share / 4.0) * whole);
        if shorter || whole < 1e-8 {
            return Some((next, after));
        }
        share *= 0.5;
    }
    None
}

/// The largest relative change that `step` makes.
fn length(step: &[f64], unknowns: &[f64], scales: &[f64]) -> f64 {
    let all = step.iter().zip(unknowns).zip(scales);
    all.fold(0.0, |most: f64, ((dx, x), scale)| most.max(dx.abs() / (x.abs() + 1e-3 * scale)))
}

/// Room for what is solved.
#[derive(Clone, Debug, Default)]
struct Solver {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Solver {
    /// Solves rows \[a | b\], each scaled to a largest coefficient of 1; `None` where they are singular.
    fn solve(&mut self, rows: &Rows) -> Option<&[f64]> {
        let n = rows.iter().len();
        self.a.clear();
        self.b.clear();
        for row in rows.iter() {
            let scale = row[..n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            self.a.extend(row[..n].iter().map(|x| x / scale));
            self.b.push(row[n] / scale);
        }
        numerics::solve(n, &mut self.a, &mut self.b)?;
        self.b.iter().all(|x| x.is_finite()).then_some(&self.b)
    }
}
