use crate::solve::Normal;
use crate::{MeanRemoval, Sums};

/// Condition index above which columns count as collinear: Belsley, Kuh & Welsch, *Regression Diagnostics*, 1980. A
/// just identified instrumental-variable estimate has no moments: in such a direction it is noise.
pub const COLLINEAR: f64 = 30.0;

/// How well pooled parts determine one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Condition number of the matrix of correlations between centred instruments and regressors, as in
    /// [`crate::Excitation`]; infinite where a direction is not excited.
    pub condition: f64,
    /// Condition index: square root of the condition number of the normal matrix with the intercept's row and column,
    /// each divided by the root sum of squares of its instrument and regressor, means left in. Above
    /// [`COLLINEAR`] the columns are collinear (with each other or with the intercept).
    pub index: f64,
    /// The weakest direction in these scaled parameters, unit length: p entries, and one for the intercept over all
    /// parts, if any.
    pub direction: Vec<f64>,
    /// Index of the parameter that dominates it.
    pub weakest: usize,
    /// Per regressor the root mean square after removing the mean over all parts, relative to that before: 0 for a
    /// constant.
    pub variation: Vec<f64>,
}

/// Diagnoses degree of freedom `d` with sums over the `whole` of the parts and their `normal` equations.
pub(super) fn diagnosed(whole: &Sums, normal: &Normal, removal: MeanRemoval, d: usize) -> Diagnosis {
    let degree = &whole.degrees[d];
    let p = degree.parameters();
    let size = |i: usize| {
        let of = |squares: &[f64]| if i < p { squares[i].sqrt() } else { (whole.samples as f64).sqrt() };
        [of(&degree.instrument_squares), of(&degree.regressor_squares)]
    };
    let lifted = removal == MeanRemoval::Complete && !degree.known.constant;
    let width = p + usize::from(lifted);
    let entry = |k: usize| {
        let (i, j) = (k / width, k % width);
        let plain = if lifted { degree.a[i * (p + 1) + j] } else { normal.a[i * p + j] };
        plain / (size(i)[0] * size(j)[1])
    };
    let scaled: Vec<f64> = (0..width * width).map(entry).collect();
    let mut diagnosis = unknown(p);
    diagnosis.condition = normal.excitation().condition;
    diagnosis.variation = variation(whole, d);
    match numerics::weakest(width, &scaled) {
        Some(found) => {
            diagnosis.index = (1.0 / found.ratio).sqrt();
            diagnosis.weakest = found.dominant(p);
            diagnosis.direction = found.direction;
        }
        None => diagnosis.weakest = normal.excitation().weakest,
    }
    diagnosis
}

pub(super) fn unknown(p: usize) -> Diagnosis {
    Diagnosis {
        condition: f64::INFINITY,
        index: f64::INFINITY,
        direction: vec![0.0; p],
        weakest: 0,
        variation: vec![0.0; p],
    }
}

fn variation(whole: &Sums, d: usize) -> Vec<f64> {
    let degree = &whole.degrees[d];
    let (p, n) = (degree.parameters(), whole.samples.max(1) as f64);
    let share = |i: usize| {
        let (mean, square) = (degree.a[p * (p + 1) + i] / n, degree.regressor_squares[i] / n);
        if square > 0.0 { (1.0 - mean * mean / square).max(0.0).sqrt() } else { 0.0 }
    };
    (0..p).map(share).collect()
}
