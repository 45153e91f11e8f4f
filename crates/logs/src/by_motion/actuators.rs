//! Which columns steer and drive: what predicts the motion in recordings that it was not fitted to.

use super::clocks::goes_with_time;
use super::table::{LoggedTable, Sums, correlation, increments};

/// Correlation from which on a column is a copy of another.
const COPY: f64 = 0.999;
/// How near 1, g or degrees in a radian the slope of an acceleration is, and the share that it explains.
const ACCELERATION: [f64; 3] = [1.0, 9.81, 57.296];
const SLOPE_OFF: f64 = 0.15;
const EXPLAINED: f64 = 0.5;
/// A difference of two columns counts if it is better than either by this.
const BETTER: f64 = 0.05;
/// What is sure: the gain; that beside any rival, and over the rival's beside it.
const GAIN: f64 = 0.15;
const BESIDE: f64 = 0.05;
const OVER: f64 = 4.0;
/// Columns that go together so at some lag are an order and its answer.
const TOGETHER: f64 = 0.75;
/// Lags that are tried, in rows.
const LAGS: usize = 24;
/// Gains below this tell nothing.
pub(super) const LITTLE: f64 = 0.02;
/// Most candidates that are compared with each other.
const COMPARED: usize = 8;

/// Columns that may steer or drive: one, or two against or with each other.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorChoice {
    /// The columns.
    pub columns: Vec<usize>,
    /// The share of the error in recordings left out that they take away.
    pub gain: f64,
    /// Whether more of it turns the ship the way the angle counts, or drives it ahead.
    pub sign: f64,
    /// Whether it stands out.
    pub is_sure: bool,
}

/// Speeds and yaw rate on the rows of a table.
pub(super) struct Response<'a> {
    pub(super) table: &'a LoggedTable,
    pub(super) time: &'a [f64],
    pub(super) surge: &'a [f64],
    pub(super) rate: &'a [f64],
}

/// Effects that a signal has.
const EFFECTS: usize = 2;

/// What is predicted.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Of {
    Rate,
    Surge,
}

/// Steps over which changes are predicted.
const STEPS: [usize; 3] = [4, 12, 36];

impl Response<'_> {
    /// Columns among `free` that are none of the `used` ones or copies of these, no times, no accelerations.
    pub(super) fn candidates(&self, free: &[usize], used: &[usize]) -> Vec<usize> {
        let columns = &self.table.columns;
        let is_copy =
            |at: usize| used.iter().any(|entry| correlation(&columns[*entry], &columns[at]).abs() > COPY);
        let fits = |at: &usize| {
            !used.contains(at)
                && !is_copy(*at)
                && !goes_with_time(self.table, *at)
                && !self.is_acceleration(*at)
        };
        free.iter().copied().filter(fits).collect()
    }

    fn is_acceleration(&self, at: usize) -> bool {
        let entry = &self.table.columns[at];
        let integral = self.table.integral(|row| entry[row], self.time);
        [self.surge, self.rate].into_iter().any(|of| {
            [4, 36].into_iter().all(|step| {
                let spans = self.table.spans(step);
                let [x, y] = [&integral[..], of].map(|all| increments(all, &spans));
                let lengths = increments(self.time, &spans);
                let sums = Sums::of(&[&x, &lengths], &y);
                let Some(solution) = sums.solution() else { return false };
                let share = 1.0 - sums.residual(&solution) / super::table::scatter(&y);
                let is = |size: &f64| (solution[0].abs() * size - 1.0).abs() < SLOPE_OFF;
                share > EXPLAINED && ACCELERATION.iter().any(is)
            })
        })
    }

    /// The candidates, the best first: what each takes away of the error.
    pub(super) fn ranked(&self, candidates: &[usize], of: Of) -> Vec<ActuatorChoice> {
        let single = |at: &usize| self.choice(&[*at], of);
        let singles: Vec<ActuatorChoice> = candidates.iter().map(single).collect();
        let best =
            |at: usize| singles.iter().find(|entry| entry.columns == [at]).map_or(0.0, |entry| entry.gain);
        let pairs = candidates.iter().flat_map(|a| candidates.iter().map(move |b| [*a, *b]));
        let pairs = pairs.filter(|[a, b]| a < b && best(*a).max(best(*b)) > LITTLE && self.are_alike(*a, *b));
        let pairs = pairs.map(|pair| self.choice(&pair, of));
        let pairs = pairs.filter(|entry| entry.columns.iter().all(|at| entry.gain > best(*at) + BETTER));
        let mut all: Vec<ActuatorChoice> = pairs.collect();
        all.extend(singles.iter().cloned());
        all.retain(|entry| entry.gain > LITTLE);
        all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let is_sure = all.first().is_some_and(|first| self.is_sure(first, &all[1..], candidates, of));
        if let Some(first) = all.first_mut() {
            first.is_sure = is_sure;
        }
        all
    }

    fn is_sure(
        &self,
        first: &ActuatorChoice,
        rivals: &[ActuatorChoice],
        candidates: &[usize],
        of: Of,
    ) -> bool {
        let entry = self.signal(&first.columns, of);
        let others = candidates.iter().filter(|at| !first.columns.contains(at));
        let is_apart = |other: &[f64]| self.together(&entry, other) < TOGETHER;
        first.gain > GAIN
            && self.table.recordings.len() > 1
            && others.clone().all(|at| is_apart(&self.table.columns[*at]))
            && rivals
                .iter()
                .filter(|rival| rival.columns.iter().all(|at| !first.columns.contains(at)))
                .take(COMPARED)
                .all(|rival| {
                    let other = self.signal(&rival.columns, of);
                    let [beside, back] = [[&entry, &other], [&other, &entry]]
                        .map(|[tried, known]| self.gain(&[known], &[known, tried], of).0);
                    beside > BESIDE && beside > OVER * back
                })
    }

    /// The strongest correlation of changes of two signals at any lag.
    fn together(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut most: f64 = 0.0;
        for lag in 0..=LAGS {
            for (early, late) in [(a, b), (b, a)] {
                let (mut x, mut y) = (Vec::new(), Vec::new());
                for rows in self.table.recordings.iter().filter(|rows| rows.len() > lag) {
                    x.extend_from_slice(&early[rows.start..rows.end - lag]);
                    y.extend_from_slice(&late[rows.start + lag..rows.end]);
                }
                most = most.max(correlation(&x, &y).abs());
            }
        }
        most
    }

    /// Whether two columns are of one kind: of about one size.
    fn are_alike(&self, a: usize, b: usize) -> bool {
        let about = |at: usize| {
            let entry = &self.table.columns[at];
            let mean = entry.iter().sum::<f64>() / entry.len() as f64;
            (mean, (super::table::scatter(entry) / entry.len() as f64).sqrt())
        };
        let ((mean_a, std_a), (mean_b, std_b)) = (about(a), about(b));
        (0.5..=2.0).contains(&(std_a / std_b)) && (mean_a - mean_b).abs() < std_a + std_b
    }

    fn signal(&self, columns: &[usize], of: Of) -> Vec<f64> {
        let all = &self.table.columns;
        let sign = if of == Of::Rate { -1.0 } else { 1.0 };
        match columns {
            [one] => all[*one].clone(),
            [one, two] => all[*one].iter().zip(&all[*two]).map(|(a, b)| a + sign * b).collect(),
            _ => Vec::new(),
        }
    }

    fn choice(&self, columns: &[usize], of: Of) -> ActuatorChoice {
        let (gain, sign) = self.gain(&[], &[&self.signal(columns, of)], of);
        ActuatorChoice { columns: columns.to_vec(), gain, sign, is_sure: false }
    }

    /// The share of the squared error of left-out recordings that `signals` take away where `known` ones are there; and the
    /// sign of the last one's effect. The best over steps.
    fn gain(&self, known: &[&[f64]], signals: &[&[f64]], of: Of) -> (f64, f64) {
        let one = |step: &usize| {
            let spans = self.table.spans(*step);
            let (mut sums, mut at): (Vec<Sums>, usize) = (Vec::new(), 0);
            let basis = self.basis(of);
            let of_signals = signals.iter().flat_map(|signal| self.effects(signal, of));
            let integrals: Vec<Vec<f64>> = basis.into_iter().chain(of_signals).collect();
            let count = integrals.len() - EFFECTS * signals.len();
            let base: Vec<usize> = (0..count + EFFECTS * known.len()).collect();
            let target = if of == Of::Rate { self.rate } else { self.surge };
            for rows in &self.table.recordings {
                let end = at + spans[at..].iter().take_while(|[_, to]| *to < rows.end).count();
                let entry = &spans[at..end];
                at = end;
                let parts: Vec<Vec<f64>> = integrals.iter().map(|all| increments(all, entry)).collect();
                let parts: Vec<&[f64]> = parts.iter().map(Vec::as_slice).collect();
                sums.push(Sums::of(&parts, &increments(target, entry)));
            }
            let whole = sums[1..].iter().fold(sums[0].clone(), |all, entry| all.plus(entry, 1.0));
            let every: Vec<usize> = (0..integrals.len()).collect();
            let error = |which: &[usize]| {
                let of = |entry: &Sums| {
                    let rest = if sums.len() > 1 { whole.plus(entry, -1.0) } else { whole.clone() };
                    Some(entry.some(which).residual(&rest.some(which).solution()?))
                };
                sums.iter().map(of).sum::<Option<f64>>()
            };
            let (without, with) = (error(&base)?, error(&every)?);
            let slope = whole.solution()?[integrals.len() - EFFECTS];
            (without > 0.0).then_some((1.0 - with / without, slope.signum()))
        };
        let best = STEPS.iter().filter_map(one).max_by(|a, b| a.0.total_cmp(&b.0));
        best.unwrap_or((0.0, 1.0))
    }

    fn basis(&self, of: Of) -> Vec<Vec<f64>> {
        let (u, r) = (self.surge, self.rate);
        let of_rows = |value: &dyn Fn(usize) -> f64| self.table.integral(value, self.time);
        match of {
            Of::Rate => vec![
                of_rows(&|row| r[row]),
                of_rows(&|row| r[row] * r[row].abs()),
                of_rows(&|row| r[row] * r[row]),
                of_rows(&|_| 1.0),
            ],
            Of::Surge => vec![
                of_rows(&|row| u[row]),
                of_rows(&|row| u[row] * u[row].abs()),
                of_rows(&|row| r[row] * r[row]),
                of_rows(&|_| 1.0),
            ],
        }
    }

    fn effects(&self, signal: &[f64], of: Of) -> [Vec<f64>; 2] {
        let of_rows = |value: &dyn Fn(usize) -> f64| self.table.integral(value, self.time);
        let u = self.surge;
        match of {
            Of::Rate => [of_rows(&|row| signal[row]), of_rows(&|row| signal[row] * u[row])],
            Of::Surge => [of_rows(&|row| signal[row]), of_rows(&|row| signal[row] * signal[row].abs())],
        }
    }
}
