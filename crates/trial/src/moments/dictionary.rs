//! From moments to the candidates of designs.

use std::collections::BTreeSet;

use design::{
    Bounds, Candidates, Criterion, CriterionName, Degree, Dictionary, NoDesign, Norm, Options, Rivals,
    WeightedFigure, solve_within,
};
use refusal::Invalid;
use regression::MeanRemoval;
use ship::engine::Streams;
use ship::model::Source;

use super::{DegreeMoments, Moments, OutputErrorMoments};

/// The estimate that a design is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimated {
    /// By instrumental variables, with this removal of the mean.
    Iv(MeanRemoval),
    /// By output error.
    OutputError,
}

impl Estimated {
    /// The criterion of a D-optimal design for it.
    pub fn d_optimal(self) -> CriterionName {
        if matches!(self, Self::Iv(_)) { CriterionName::DHessian } else { CriterionName::D }
    }

    /// Whether intercepts are among the unknowns.
    fn has_intercepts(self) -> bool {
        matches!(self, Self::Iv(MeanRemoval::Complete) | Self::OutputError)
    }
}

impl Moments {
    /// One candidate per maneuver: its additive matrices for the estimate.
    ///
    /// # Errors
    /// Moments that are not complete, finite and of one shape, duplicate maneuvers, no moments for the estimator.
    pub fn dictionary(&self, estimated: Estimated) -> Result<Dictionary, Invalid> {
        self.check_structure()?;
        let information = match estimated {
            Estimated::Iv(removal) => self.blocks(removal, |one, _, n| Ok(reduced(&one.m, n, removal)))?,
            Estimated::OutputError => self.whole(|o| Ok(o.f.clone()))?,
        };
        Ok(Dictionary {
            degrees: self.degrees.clone(),
            maneuvers: self.maneuvers.iter().map(|m| m.name.clone()).collect(),
            sample_rate_hz: self.sample_rate_hz,
            intercepts: estimated.has_intercepts() && self.have_regressors(),
            information,
        })
    }

    /// The middle matrices of the candidates of [`Moments::dictionary`], the meat of their sandwich covariances.
    ///
    /// # Errors
    /// Moments without middle matrices, or with some that are not covariances.
    pub fn middle(&self, estimated: Estimated) -> Result<Candidates, Invalid> {
        if self.disturbances.is_none() {
            return Err(Invalid::new(
                "`data.disturbances`",
                "no expected disturbances",
                "those that the covariance of the estimate is predicted from",
                "run `moments` with --campaign campaign.toml, or take --criterion d-hessian without --figures",
            ));
        }
        match estimated {
            Estimated::Iv(removal) => self.blocks(removal, |degree, name, n| match &degree.b {
                None => Err("no middle matrix `B`".to_owned()),
                Some(b) if b.len() != n * n => Err(format!("{} entries of `B` in {name}", b.len())),
                Some(b) if !is_covariance(b, n) => Err(format!("a `B` in {name} that is no covariance")),
                Some(b) => Ok(centred(b, &degree.m, n, removal)),
            }),
            Estimated::OutputError => self.whole(|o| {
                let measurement = o.e.as_ref().unwrap_or(&o.f);
                match &o.p {
                    Some(p) if p.len() == measurement.len() => {
                        Ok(measurement.iter().zip(p).map(|(e, p)| e + p).collect())
                    }
                    Some(_) => Err("a `P` of another size than `F`".into()),
                    None => Ok(measurement.clone()),
                }
            }),
        }
    }

    /// G of the mean square of a free run's error.
    ///
    /// # Errors
    /// Moments without it.
    pub fn free_run_weights(&self) -> Result<Vec<f64>, Invalid> {
        self.output_error.as_ref().and_then(|o| o.g.clone()).ok_or_else(|| {
            Invalid::new(
                "`data.output_error.G`",
                "none",
                "what free runs over the validation maneuvers depend on",
                "run `moments` again with --campaign and --estimator output-error",
            )
        })
    }

    /// The squares of the parameters that errors are relative to: the nominal ones, or those that the
    /// disturbances were linearised with.
    ///
    /// # Errors
    /// A parameter of zero.
    pub fn squares(&self, relative_to: Source) -> Result<Vec<f64>, Invalid> {
        let parameters = self.degrees.iter().flat_map(|d| &d.parameters);
        // Without disturbances the criterion itself is refused.
        let Some(expected) = &self.disturbances else { return Ok(parameters.map(|_| 1.0).collect()) };
        let (values, remedy) = match relative_to {
            Source::Nominal => {
                (&expected.nominal, "take --relative-to value, or --criterion d without --accuracy")
            }
            Source::Value => (&expected.parameters, "take --criterion d without --accuracy"),
        };
        let square = |name: &String| match values.get(name) {
            Some(theta) if *theta != 0.0 && theta.is_finite() => Ok(theta * theta),
            value => Err(Invalid::new(
                format!("parameter `{name}`"),
                value.map_or("no value".into(), |v| format!("{v}")),
                "a value other than 0 that its error can be relative to",
                remedy,
            )),
        };
        parameters.map(square).collect()
    }

    /// One block per maneuver: all lifted parameters together.
    fn whole(
        &self,
        of: impl Fn(&OutputErrorMoments) -> Result<Vec<f64>, String>,
    ) -> Result<Candidates, Invalid> {
        let n: usize = self.degrees.iter().map(|d| d.regressors.len()).sum();
        let mut candidates = Candidates::new(vec![n]);
        for maneuver in &self.maneuvers {
            let Some(error_moments) = &maneuver.output_error else {
                return Err(Invalid::new(
                    format!("moments of `{}`", maneuver.name),
                    "no `output_error`",
                    "what an output-error estimate learns from it",
                    "run `moments` again with --campaign and --estimator output-error",
                ));
            };
            let entries = of(error_moments).map_err(|what| malformed(&maneuver.name, &what))?;
            if !is_covariance(&entries, n) {
                return Err(malformed(&maneuver.name, "an `F`, `E` or `P` that is no covariance"));
            }
            candidates.push(&entries).map_err(|e| malformed(&maneuver.name, &e.to_string()))?;
        }
        Ok(candidates)
    }

    /// A block per degree of freedom and maneuver: `entries_of` its moments, its name and its lifted parameters.
    fn blocks(
        &self,
        removal: MeanRemoval,
        entries_of: impl Fn(&DegreeMoments, &str, usize) -> Result<Vec<f64>, String>,
    ) -> Result<Candidates, Invalid> {
        self.check_terms()?;
        let lifted: Vec<usize> = self.degrees.iter().map(|d| d.regressors.len()).collect();
        let kept = |n: &usize| if removal == MeanRemoval::Complete { *n } else { n - 1 };
        let mut candidates = Candidates::new(lifted.iter().map(kept).collect());
        for maneuver in &self.maneuvers {
            if maneuver.degrees.len() != lifted.len() {
                let degrees = format!("{} degrees of freedom", maneuver.degrees.len());
                return Err(malformed(&maneuver.name, &degrees));
            }
            let mut entries = Vec::with_capacity(candidates.size());
            for ((moments, degree), n) in maneuver.degrees.iter().zip(&self.degrees).zip(&lifted) {
                if moments.m.len() != n * n {
                    let value = format!("{} entries in {}", moments.m.len(), degree.name);
                    return Err(malformed(&maneuver.name, &value));
                }
                let of_degree = entries_of(moments, &degree.name, *n);
                entries.extend(of_degree.map_err(|what| malformed(&maneuver.name, &what))?);
            }
            candidates.push(&entries).map_err(|e| malformed(&maneuver.name, &e.to_string()))?;
        }
        Ok(candidates)
    }

    /// Whether they have regressors, and intercepts beside the parameters.
    pub fn have_regressors(&self) -> bool {
        let bare = |degree: &Degree| degree.regressors.len() == degree.parameters.len();
        self.degrees.is_empty() || !self.degrees.iter().all(bare)
    }

    /// Refuses moments without regressors for instrumental variables.
    fn check_terms(&self) -> Result<(), Invalid> {
        if self.have_regressors() {
            return Ok(());
        }
        Err(Invalid::new(
            "`data.degrees`",
            "a ship with forces, which has no terms per sample",
            "terms per sample, which instruments of `iv` are made of",
            "take --for output-error",
        ))
    }

    /// Refuses degrees of freedom without one parameter per regressor, and duplicate maneuvers.
    fn check_structure(&self) -> Result<(), Invalid> {
        let refuse = |thing: String, found: &str, expected: &str| {
            Err(Invalid::new(thing, found, expected, "run `moments` again"))
        };
        for degree in &self.degrees {
            let (regressors, parameters) = (degree.regressors.len(), degree.parameters.len());
            let intercepts = usize::from(self.have_regressors());
            if parameters == 0 || regressors != parameters + intercepts {
                let value = format!("{regressors} regressors and {parameters} parameters");
                let thing = format!("`data.degrees` {}", degree.name);
                return refuse(thing, &value, "one regressor more than parameters");
            }
        }
        if self.maneuvers.is_empty() {
            return refuse("`data.maneuvers`".into(), "none", "at least one maneuver");
        }
        let mut names = BTreeSet::new();
        match self.maneuvers.iter().find(|maneuver| !names.insert(&maneuver.name)) {
            Some(twice) => {
                refuse(format!("maneuver `{}`", twice.name), "its moments twice", "every maneuver once")
            }
            None => Ok(()),
        }
    }
}

/// The refusal of moments of `maneuver` that are not those of its model.
pub fn malformed(maneuver: &str, found: &str) -> Invalid {
    Invalid::new(
        format!("moments of `{maneuver}`"),
        found,
        "a finite p̃ × p̃ matrix per degree of freedom",
        "run `moments` again",
    )
}

/// From M = \[\[X̄, Ȳ\], \[Z̄ᵀ, 1\]\]: M itself, X̄ − Ȳ Z̄ᵀ or X̄.
fn reduced(m: &[f64], lifted: usize, removal: MeanRemoval) -> Vec<f64> {
    let p = lifted - 1;
    let entry = |i: usize, j: usize| m[i * lifted + j];
    match removal {
        MeanRemoval::Complete => m.to_vec(),
        MeanRemoval::Batch => {
            (0..p * p).map(|k| entry(k / p, k % p) - entry(k / p, p) * entry(p, k % p)).collect()
        }
        MeanRemoval::None => leading(m, lifted, p),
    }
}

/// The first `kept` rows and columns of the `n` that a matrix has.
pub fn leading(matrix: &[f64], n: usize, kept: usize) -> Vec<f64> {
    (0..kept * kept).map(|e| matrix[e / kept * n + e % kept]).collect()
}

/// From B of ζ̃ = \[ζ; 1\]: B itself, that of ζ − Z̄, or that of ζ.
fn centred(b: &[f64], m: &[f64], lifted: usize, removal: MeanRemoval) -> Vec<f64> {
    let p = lifted - 1;
    let entry = |i: usize, j: usize| b[i * lifted + j];
    let mean = |i: usize| m[p * lifted + i];
    match removal {
        MeanRemoval::Complete => b.to_vec(),
        MeanRemoval::Batch => {
            let of = |(i, j): (usize, usize)| {
                entry(i, j) - mean(i) * entry(p, j) - entry(i, p) * mean(j) + mean(i) * entry(p, p) * mean(j)
            };
            (0..p * p).map(|k| of((k / p, k % p))).collect()
        }
        MeanRemoval::None => leading(b, lifted, p),
    }
}

/// Finite and symmetric, no pair of instruments more than fully correlated.
fn is_covariance(b: &[f64], n: usize) -> bool {
    if b.len() != n * n {
        return false;
    }
    let size = |i: usize, j: usize| (b[i * n + i].max(0.0) * b[j * n + j].max(0.0)).sqrt();
    let is_valid = |k: usize| {
        let (i, j) = (k / n, k % n);
        let (one, other, size) = (b[k], b[j * n + i], size(i, j));
        b[i * n + i] >= 0.0 && one.abs() <= size * (1.0 + 1e-9) && (one - other).abs() <= 1e-9 * size
    };
    b.iter().all(|x| x.is_finite()) && (0..n * n).all(is_valid)
}

/// A criterion and what it is of.
#[derive(Clone, Debug)]
pub struct CriterionOf<'a> {
    /// Its name.
    pub name: CriterionName,
    /// The estimate.
    pub estimated: Estimated,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// The figures of [`CriterionName::Figures`], and the parameters, not 0, that these were differentiated at.
    pub figures: (&'a [WeightedFigure], &'a [f64]),
}

/// Why moments have no criterion.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum NoCriterion {
    /// What the moments lack.
    #[error("{0}")]
    Moments(Invalid),
    /// A covariance that is not defined.
    #[error(transparent)]
    Design(#[from] NoDesign),
}

impl From<Invalid> for NoCriterion {
    fn from(invalid: Invalid) -> Self {
        Self::Moments(invalid)
    }
}

impl Moments {
    /// The criterion over the maneuvers of `dictionary`, and B_q of these where it is one of the covariance.
    ///
    /// # Errors
    /// Moments without what the criterion is computed from; a singular covariance.
    pub fn criterion(
        &self,
        dictionary: &Dictionary,
        of: &CriterionOf,
    ) -> Result<(Criterion, Option<Candidates>), NoCriterion> {
        if of.name == CriterionName::DHessian {
            return Ok((Criterion::Information(dictionary.information.clone()), None));
        }
        // Checked before the meat: its refusals name the parameter.
        let weights = match of.name {
            CriterionName::ARelative => self.squares(of.relative_to)?.iter().map(|s| 1.0 / s).collect(),
            _ => vec![1.0; dictionary.parameters()],
        };
        let meat = self.middle(of.estimated)?;
        let criterion = match of.name {
            CriterionName::V => Criterion::of_free_runs(dictionary, &meat, self.free_run_weights()?),
            CriterionName::Figures => Criterion::of_figures(dictionary, &meat, of.figures.0, of.figures.1),
            CriterionName::D => Criterion::of_covariance(dictionary, &meat, weights, Norm::LogDet),
            _ => Criterion::of_covariance(dictionary, &meat, weights, Norm::Trace),
        };
        Ok((criterion?, Some(meat)))
    }
}

/// Random designs for the median.
const RANDOM: u32 = 400;
/// Segments of a random design, as in the paper.
const SEGMENTS: u32 = 5;

impl Moments {
    /// The designs for comparison: the shares of the paper's criterion, and random designs of equally long
    /// segments, each any maneuver.
    pub fn rivals(&self, removal: MeanRemoval, seed: u64) -> Rivals {
        let streams = Streams::new(seed, "random designs");
        let count = self.maneuvers.len();
        let random = |run: u32| {
            let mut shares = vec![0.0; count];
            for q in streams.choices(run, 0, count as u32, SEGMENTS as usize) {
                shares[q as usize] += 1.0 / f64::from(SEGMENTS);
            }
            shares
        };
        let options = Options { random_starts: 0, tolerance: 1e-8, ..Options::default() };
        let known = self.dictionary(Estimated::Iv(removal)).ok();
        let design = known.and_then(|all| solve_within(&all.information, &Bounds::default(), &options).ok());
        Rivals {
            paper: design.map(|design| design.shares),
            random: (0..RANDOM).map(random).collect(),
            random_segments: SEGMENTS,
        }
    }
}
