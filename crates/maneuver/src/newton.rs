//! Newton's method for a few equations, plain and damped.

/// Most steps; damped ones may be short.
const STEPS: usize = 50;
const DAMPED_STEPS: usize = 200;

/// Relative change of the unknowns at which they count as solved.
const SOLVED: f64 = 1e-13;

/// Solves the equations from `unknowns` by full steps; returns whether they converge. `linearised` fills in
/// rows \[Jacobian | −residual\].
pub(crate) fn plain(
    unknowns: &mut [f64],
    Workspace { rows, solver }: &mut Workspace,
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

/// Buffers that searches reuse.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
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
    /// Prepares for the rows of `unknowns`, without any yet.
    pub(crate) fn clear(&mut self, unknowns: usize) {
        self.entries.clear();
        self.width = unknowns + 1;
    }

    /// Appends a row of zeros.
    pub(crate) fn push(&mut self) -> &mut [f64] {
        let before = self.entries.len();
        self.entries.resize(before + self.width, 0.0);
        &mut self.entries[before..]
    }

    fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.entries.chunks_exact(self.width.max(1))
    }
}

/// [`plain`] with steps that are halved until the next one, with the same Jacobian, is shorter, so that the
/// units of the equations do not matter. `scales`: magnitudes of the unknowns.
///
/// The test is the natural one of Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3.
pub(crate) fn damped(
    unknowns: &mut [f64],
    scales: &[f64],
    mut linearised: impl FnMut(&[f64], &mut Rows),
) -> bool {
    let (mut rows, mut solver) = (Rows::default(), Solver::default());
    linearised(unknowns, &mut rows);
    // At rest the equations hold, and the step is undetermined.
    if rows.iter().all(|row| row.last() == Some(&0.0)) {
        return true;
    }
    let mut before = f64::INFINITY;
    for _ in 0..DAMPED_STEPS {
        let Some(step) = solver.solve(&rows).map(<[f64]>::to_vec) else { return false };
        let length = length(&step, unknowns, scales);
        // Only rounding remains: the equations cannot be solved more accurately.
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

/// Advances along `step`, whose length is given, as far as the next step with the same Jacobian becomes
/// shorter: returns the unknowns there, with their rows.
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

/// The largest relative change by `step`.
fn length(step: &[f64], unknowns: &[f64], scales: &[f64]) -> f64 {
    let all = step.iter().zip(unknowns).zip(scales);
    all.fold(0.0, |most: f64, ((dx, x), scale)| most.max(dx.abs() / (x.abs() + 1e-3 * scale)))
}

/// Buffers of the linear solver.
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
