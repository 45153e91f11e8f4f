//! Candidates from `moments.json`.

use std::collections::BTreeSet;
use std::path::Path;

use design::Candidates;

use super::criterion::intercepts;
use crate::failure::Failure;
use crate::instruments::Removal;
use study::documents::{DegreeMoments, ManeuverMoments, MomentsDocument, OutputErrorMoments};

/// The estimate that a design is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimated {
    /// By instrumental variables, their mean removed like this.
    Iv(Removal),
    /// By output error; the covariance of measurement errors alone, or of the current too.
    OutputError {
        /// Whether the current counts.
        current: bool,
    },
}

impl Estimated {
    /// Whether intercepts are among the unknowns.
    pub fn has_intercepts(self) -> bool {
        match self {
            Self::Iv(removal) => intercepts(removal),
            Self::OutputError { .. } => true,
        }
    }
}

/// One candidate per maneuver: the matrices that add up for the estimate.
///
/// # Errors
/// Moments that are not complete, finite and of one shape, maneuvers of the same name, none for the estimator.
pub fn information(
    file: &Path,
    moments: &MomentsDocument,
    estimated: Estimated,
) -> Result<Candidates, Failure> {
    check_structure(file, moments)?;
    match estimated {
        Estimated::Iv(removal) => {
            candidates(file, moments, removal, |degree, n| Ok(reduced(&degree.m, n, removal)))
        }
        Estimated::OutputError { .. } => output_error(file, moments, |o| Ok(o.f.clone())),
    }
}

/// The middle matrices of [`information`]'s candidates for the same estimate.
///
/// # Errors
/// Moments without middle matrices, or with some that are no covariances.
pub fn middle(file: &Path, moments: &MomentsDocument, estimated: Estimated) -> Result<Candidates, Failure> {
    let of = |degree: &DegreeMoments, n: usize, removal: Removal| match &degree.b {
        None => Err("no middle matrix `B`".to_owned()),
        Some(b) if b.len() != n * n => Err(format!("{} entries of `B` in {}", b.len(), degree.name)),
        Some(b) if !is_covariance(b, n) => Err(format!("a `B` in {} that is no covariance", degree.name)),
        Some(b) => Ok(centred(b, &degree.m, n, removal)),
    };
    if moments.disturbances.is_none() {
        return Err(Failure::refuse(
            file,
            "`data.disturbances`",
            "no expected disturbances",
            "those that the covariance of the estimate is predicted from",
            "run `moments` with --campaign campaign.toml, or take --criterion d-hessian",
        ));
    }
    match estimated {
        Estimated::Iv(removal) => candidates(file, moments, removal, |degree, n| of(degree, n, removal)),
        Estimated::OutputError { current } => output_error(file, moments, |o| {
            let own = o.e.as_ref().unwrap_or(&o.f);
            match (&o.p, current) {
                (Some(p), true) if p.len() == own.len() => {
                    Ok(own.iter().zip(p).map(|(e, p)| e + p).collect())
                }
                (Some(_), true) => Err("a `P` of another size than `F`".into()),
                _ => Ok(own.clone()),
            }
        }),
    }
}

/// One block per maneuver: all lifted parameters together.
fn output_error(
    file: &Path,
    moments: &MomentsDocument,
    of: impl Fn(&OutputErrorMoments) -> Result<Vec<f64>, String>,
) -> Result<Candidates, Failure> {
    let n: usize = moments.degrees.iter().map(|d| d.regressors.len()).sum();
    let mut candidates = Candidates::new(vec![n]);
    for maneuver in &moments.maneuvers {
        let Some(own) = &maneuver.output_error else {
            return Err(Failure::refuse(
                file,
                &format!("moments of `{}`", maneuver.name),
                "no `output_error`",
                "what an output-error estimate learns from it",
                "run `moments` again with --campaign and --estimator output-error",
            ));
        };
        let entries = of(own).map_err(|found| malformed(file, maneuver, &found))?;
        if !is_covariance(&entries, n) {
            return Err(malformed(file, maneuver, "an `F`, `E` or `P` that is no covariance"));
        }
        candidates.push(&entries).map_err(|e| malformed(file, maneuver, &e.to_string()))?;
    }
    Ok(candidates)
}

fn candidates(
    file: &Path,
    moments: &MomentsDocument,
    removal: Removal,
    entries_of: impl Fn(&DegreeMoments, usize) -> Result<Vec<f64>, String>,
) -> Result<Candidates, Failure> {
    let lifted: Vec<usize> = moments.degrees.iter().map(|d| d.regressors.len()).collect();
    let kept = lifted.iter().map(|n| if removal == Removal::Complete { *n } else { n - 1 }).collect();
    let mut candidates = Candidates::new(kept);
    for maneuver in &moments.maneuvers {
        if maneuver.degrees.len() != lifted.len() {
            let found = format!("{} degrees of freedom", maneuver.degrees.len());
            return Err(malformed(file, maneuver, &found));
        }
        let mut entries = Vec::with_capacity(candidates.size());
        for (degree, n) in maneuver.degrees.iter().zip(&lifted) {
            if degree.m.len() != n * n || degree.shape != [*n as u64; 2] {
                let found = format!("{} entries in {}", degree.m.len(), degree.name);
                return Err(malformed(file, maneuver, &found));
            }
            entries.extend(entries_of(degree, *n).map_err(|found| malformed(file, maneuver, &found))?);
        }
        candidates.push(&entries).map_err(|e| malformed(file, maneuver, &e.to_string()))?;
    }
    Ok(candidates)
}

fn malformed(file: &Path, maneuver: &ManeuverMoments, found: &str) -> Failure {
    Failure::refuse(
        file,
        &format!("moments of `{}`", maneuver.name),
        found,
        "a finite p̃ × p̃ matrix per degree of freedom",
        "run `moments` again",
    )
}

/// Refuses degrees of freedom without one parameter per regressor, and maneuvers of the same name.
fn check_structure(file: &Path, moments: &MomentsDocument) -> Result<(), Failure> {
    let refuse = |thing: String, found: &str, expected: &str| {
        Err(Failure::refuse(file, &thing, found, expected, "run `moments` again"))
    };
    for degree in &moments.degrees {
        let (regressors, parameters) = (degree.regressors.len(), degree.parameters.len());
        if parameters == 0 || regressors != parameters + 1 {
            let found = format!("{regressors} regressors and {parameters} parameters");
            return refuse(
                format!("`data.degrees` {}", degree.name),
                &found,
                "one regressor more than parameters",
            );
        }
    }
    let mut names = BTreeSet::new();
    match moments.maneuvers.iter().find(|maneuver| !names.insert(&maneuver.name)) {
        Some(twice) => {
            refuse(format!("maneuver `{}`", twice.name), "its moments twice", "every maneuver once")
        }
        None => Ok(()),
    }
}

/// From M = \[\[X̄, Ȳ\], \[Z̄ᵀ, 1\]\]: M itself, X̄ − Ȳ Z̄ᵀ or X̄.
fn reduced(m: &[f64], lifted: usize, removal: Removal) -> Vec<f64> {
    let p = lifted - 1;
    let entry = |i: usize, j: usize| m[i * lifted + j];
    match removal {
        Removal::Complete => m.to_vec(),
        Removal::Batch => {
            (0..p * p).map(|k| entry(k / p, k % p) - entry(k / p, p) * entry(p, k % p)).collect()
        }
        Removal::None => (0..p * p).map(|k| entry(k / p, k % p)).collect(),
    }
}

/// From B of ζ̃ = \[ζ; 1\]: B itself, that of ζ − Z̄, or that of ζ.
fn centred(b: &[f64], m: &[f64], lifted: usize, removal: Removal) -> Vec<f64> {
    let p = lifted - 1;
    let entry = |i: usize, j: usize| b[i * lifted + j];
    let mean = |i: usize| m[p * lifted + i];
    match removal {
        Removal::Complete => b.to_vec(),
        Removal::Batch => (0..p * p)
            .map(|k| (k / p, k % p))
            .map(|(i, j)| {
                entry(i, j) - mean(i) * entry(p, j) - entry(i, p) * mean(j) + mean(i) * entry(p, p) * mean(j)
            })
            .collect(),
        Removal::None => (0..p * p).map(|k| entry(k / p, k % p)).collect(),
    }
}

/// Finite and symmetric, no pair of instruments more than fully correlated.
fn is_covariance(b: &[f64], n: usize) -> bool {
    if b.len() != n * n {
        return false;
    }
    let size = |i: usize, j: usize| (b[i * n + i].max(0.0) * b[j * n + j].max(0.0)).sqrt();
    let pairs = (0..n * n).map(|k| (k / n, k % n));
    b.iter().all(|x| x.is_finite())
        && pairs.into_iter().all(|(i, j)| {
            let (one, other) = (b[i * n + j], b[j * n + i]);
            b[i * n + i] >= 0.0
                && one.abs() <= size(i, j) * (1.0 + 1e-9)
                && (one - other).abs() <= 1e-9 * size(i, j)
        })
}
