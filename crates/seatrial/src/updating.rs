use std::ops::Range;

use design::{AccuracyOf, CriterionName, Norm, error_of, promised_error};
use estimation::Estimator;
use numerics::quadratic;
use refusal::Invalid;
use ship::model::Source;
use study::design_files::Promised;
use study::documents::{
    CovarianceCriterion, DesignDocument, DesignFigure, ModelDocument, PromiseUpdate, UpdatedAccuracy,
    UpdatedCriterion, UpdatedError, UpdatedFigure, UpdatedParameter,
};
use study::figure_goals::FigureGoals;
use thiserror::Error;
use trial::moments::Moments;

/// Why a promise cannot be updated, by the file at fault.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UpdateError {
    /// A design that promises nothing, or is of other moments.
    #[error("design: {0}")]
    Design(Invalid),
    /// An estimate of another vessel, or one that does not say how uncertain it is.
    #[error("model: {0}")]
    Model(Invalid),
}

/// A design whose trial has been run.
pub struct Updating<'a> {
    /// The design.
    pub design: &'a DesignDocument,
    /// The moments that it was made from.
    pub moments: &'a Moments,
    /// The parameters that its errors are relative to.
    pub relative_to: Source,
    /// Figures of merit, if any.
    pub figures: Option<&'a FigureGoals>,
}

/// The estimate of a trial, its parameters in the order of the moments.
struct Estimate {
    values: Vec<f64>,
    variances: Vec<f64>,
    /// n × n, if it is known.
    covariance: Option<Vec<f64>>,
    samples: f64,
}

impl<'a> Updating<'a> {
    /// With what was read of it.
    pub fn new(of: &'a Promised) -> Self {
        let Promised { design, moments, relative_to, figures } = of;
        Self { design, moments, relative_to: *relative_to, figures: figures.as_ref() }
    }

    /// The promise of the design beside what `model`, the estimate of its trial, leaves uncertain.
    ///
    /// # Errors
    /// [`UpdateError`].
    pub fn after(&self, model: &ModelDocument) -> Result<PromiseUpdate, UpdateError> {
        let promised = self.promised().map_err(UpdateError::Design)?;
        let names = self.names();
        let estimate = Estimate::read(model, self.moments, &names).map_err(UpdateError::Model)?;
        let scales = self.moments.squares(self.relative_to).ok();
        let longer = (promised.samples as f64 / estimate.samples).sqrt();
        let before: Vec<f64> = names.iter().map(|name| promised.standard_errors[*name] * longer).collect();
        let now: Vec<f64> = estimate.variances.iter().map(|variance| variance.sqrt()).collect();
        let parameter = |i: usize| UpdatedParameter {
            name: names[i].to_owned(),
            estimate: estimate.values[i],
            scale: scales.as_ref().map(|squares| squares[i].sqrt()),
            standard_error: UpdatedError::of(before[i], now[i]),
        };
        let norm = |errors: &[f64]| {
            let relative = errors.iter().zip(scales.as_ref()?).map(|(error, square)| error / square.sqrt());
            Some(relative.map(|e| e * e).sum::<f64>().sqrt())
        };
        let parameter_error = norm(&before).zip(norm(&now)).map(|(before, n)| UpdatedError::of(before, n));
        let figures = self.figures(&estimate);
        let duration_s = estimate.samples / self.moments.sample_rate_hz;
        let reached = match self.design.accuracy.as_ref().map(|accuracy| accuracy.of) {
            Some(AccuracyOf::Overall) => parameter_error.map(|error| error.now),
            Some(AccuracyOf::Figures) => self.over_wanted(&figures),
            None => None,
        };
        let mut document = PromiseUpdate {
            statement: String::new(),
            estimator: model.estimator,
            samples: estimate.samples as u64,
            duration_s,
            parameters: (0..names.len()).map(parameter).collect(),
            parameter_error,
            criterion: self.criterion(promised, &estimate).map_err(UpdateError::Model)?,
            figures,
            after_another: parameter_error.map(|error| error.now / 2.0_f64.sqrt()),
            accuracy: reached.and_then(|reached| self.accuracy(reached, duration_s)),
            statements: self.statements(promised, model),
        };
        document.statement = said(&document);
        Ok(document)
    }

    fn names(&self) -> Vec<&str> {
        self.moments.degrees.iter().flat_map(|degree| &degree.parameters).map(String::as_str).collect()
    }

    /// What the design predicts, of just the parameters of the moments.
    fn promised(&self) -> Result<&CovarianceCriterion, Invalid> {
        let Some(promised) = &self.design.covariance else {
            let expected = "predicted standard errors";
            let remedy = "make it from moments with --campaign, and by another criterion than d-hessian";
            return Err(Invalid::new("`data.covariance`", "no promise", expected, remedy));
        };
        let names = self.names();
        match names.iter().find(|name| !promised.standard_errors.contains_key(**name)) {
            None if promised.standard_errors.len() == names.len() => Ok(promised),
            missing => {
                let found =
                    missing.map_or("other parameters".to_owned(), |name| format!("no error of `{name}`"));
                let remedy = "name the moments that the design was made from";
                Err(Invalid::new("`data.covariance`", found, "the parameters of the moments", remedy))
            }
        }
    }

    /// The criterion as an error; none where it depends on more than the parameters.
    fn criterion(
        &self,
        promised: &CovarianceCriterion,
        estimate: &Estimate,
    ) -> Result<Option<UpdatedCriterion>, Invalid> {
        let norm = match promised.name {
            CriterionName::D => Norm::LogDet,
            CriterionName::A | CriterionName::ARelative => Norm::Trace,
            CriterionName::DHessian | CriterionName::V | CriterionName::Figures => return Ok(None),
        };
        let weights: Vec<f64> =
            self.names().iter().map(|name| promised.weights.get(*name).copied().unwrap_or(0.0)).collect();
        let covariance = match (&estimate.covariance, norm) {
            (Some(known), _) => known.clone(),
            (None, Norm::Trace) => diagonal(&estimate.variances),
            (None, Norm::LogDet) => {
                let expected = "one, for the criterion d of the design";
                let remedy = "estimate the trial by `estimate --fit together`";
                return Err(Invalid::new("`data.covariance`", "none", expected, remedy));
            }
        };
        let samples = promised.samples as f64;
        let before = promised_error(norm, promised.value, weights.len(), samples, estimate.samples);
        let now = error_of(norm, &weights, &covariance, &self.blocks());
        Ok(now.map(|now| UpdatedCriterion { name: promised.name, error: UpdatedError::of(before, now) }))
    }

    /// The parameters that the design counted as estimated together.
    fn blocks(&self) -> Vec<Range<usize>> {
        let all = self.names().len();
        if self.design.estimator == Some(Estimator::OutputError) {
            return std::iter::once(0..all).collect();
        }
        let mut first = 0;
        let next = |degree: &design::Degree| {
            first += degree.parameters.len();
            first - degree.parameters.len()..first
        };
        self.moments.degrees.iter().map(next).filter(|block| !block.is_empty()).collect()
    }

    /// The figures that both the design and the given file have.
    fn figures(&self, estimate: &Estimate) -> Vec<UpdatedFigure> {
        let (Some(goals), Some(of_design)) = (self.figures, &self.design.figures) else { return Vec::new() };
        let covariance = estimate.covariance.clone().unwrap_or_else(|| diagonal(&estimate.variances));
        let longer = (of_design.samples as f64 / estimate.samples).sqrt();
        let one = |figure: &DesignFigure| {
            let is_it = |goal: &&study::figure_goals::FigureGoal| {
                goal.maneuver == figure.maneuver && goal.name == figure.name
            };
            let slopes = &goals.goals.iter().find(is_it)?.figure.slopes;
            let now = quadratic(slopes, &covariance).max(0.0).sqrt();
            Some(UpdatedFigure {
                maneuver: figure.maneuver.clone(),
                name: figure.name.clone(),
                unit: figure.unit.clone(),
                standard_error: UpdatedError::of(figure.standard_error * longer, now),
            })
        };
        of_design.figures.iter().filter_map(one).collect()
    }

    /// The largest error of a figure over the wanted one; `None` where one that is wanted is not given.
    fn over_wanted(&self, figures: &[UpdatedFigure]) -> Option<f64> {
        let wanted = self.design.figures.iter().flat_map(|all| &all.figures);
        let one = |(figure, wanted): (&DesignFigure, f64)| {
            let updated = figures
                .iter()
                .find(|updated| updated.maneuver == figure.maneuver && updated.name == figure.name)?;
            Some(updated.standard_error.now / wanted)
        };
        let all: Option<Vec<f64>> = wanted.filter_map(|f| Some((f, f.wanted?))).map(one).collect();
        all.map(|all| all.into_iter().fold(0.0, f64::max))
    }

    /// The time for the accuracy that the design was asked for: information grows in proportion to time.
    fn accuracy(&self, reached: f64, duration_s: f64) -> Option<UpdatedAccuracy> {
        let asked = self.design.accuracy.as_ref()?;
        let needed_s = duration_s * (reached / asked.wanted).powi(2);
        let remaining_s = (needed_s - duration_s).max(0.0);
        Some(UpdatedAccuracy { wanted: asked.wanted, of: asked.of, reached, needed_s, remaining_s })
    }

    fn statements(&self, promised: &CovarianceCriterion, model: &ModelDocument) -> Vec<String> {
        let mut said = Vec::new();
        let designed = self.design.estimator.unwrap_or(Estimator::Iv);
        if designed != model.estimator {
            said.push(format!("The promise is one for {designed}, the estimate is by {}.", model.estimator));
        }
        if model.rejected == Some(true) {
            said.push("The data reject the model's structure: its standard errors are too small.".to_owned());
        }
        if matches!(promised.name, CriterionName::V | CriterionName::Figures) {
            let name = promised.name.name();
            said.push(format!(
                "The criterion {name} depends on more than the parameters, and is not updated."
            ));
        }
        let is_asked = self.design.figures.is_some() && self.figures.is_none();
        if is_asked {
            said.push("Figures of merit are not updated without --figures.".to_owned());
        }
        said
    }
}

impl Estimate {
    /// That of `model`.
    fn read(model: &ModelDocument, moments: &Moments, names: &[&str]) -> Result<Self, Invalid> {
        let remedy = "name the model.json that the trial of this design was estimated to";
        let refuse =
            |thing: &str, found: String, expected: String| Err(Invalid::new(thing, found, expected, remedy));
        if model.vessel != moments.vessel {
            let expected = format!("`{}`, as in the design's moments", moments.vessel);
            return refuse("`data.vessel`", format!("`{}`", model.vessel), expected);
        }
        if model.sample_rate_hz != moments.sample_rate_hz {
            let expected = format!("{} Hz, as in the design's moments", moments.sample_rate_hz);
            return refuse("`data.sample_rate_hz`", format!("{} Hz", model.sample_rate_hz), expected);
        }
        let parameters: Vec<_> = model.degrees.iter().flat_map(|degree| &degree.parameters).collect();
        let mut values = Vec::new();
        for name in names {
            match parameters.iter().find(|parameter| parameter.name == *name) {
                Some(parameter) if !parameter.fixed && parameter.tied_to.is_none() => values.push(*parameter),
                other => {
                    let state = if other.is_some() { "one that was not estimated" } else { "none" };
                    let expected = "an estimate, as in the design's moments".to_owned();
                    return refuse(&format!("parameter `{name}`"), state.to_owned(), expected);
                }
            }
        }
        let covariance =
            model.covariance.as_ref().map(|known| covariance(&known.names, &known.entries, names));
        let covariance = covariance.transpose()?;
        let variance = |(i, parameter): (usize, &&study::documents::ModelParameter)| match &covariance {
            Some(known) => Ok(known[i * names.len() + i]),
            None if parameter.at_bound => Ok(0.0),
            None => parameter.standard_error.map(|error| error * error).ok_or_else(|| {
                let expected = "how uncertain the estimate is: a covariance or standard errors";
                let remedy =
                    "estimate the trial by `estimate --fit together`, without a search for its structure";
                Invalid::new(format!("parameter `{}`", parameter.name), "no standard error", expected, remedy)
            }),
        };
        let variances = values.iter().enumerate().map(variance).collect::<Result<_, _>>()?;
        let samples = model.samples as f64;
        if samples < 1.0 {
            return refuse("`data.samples`", "0".to_owned(), "those of a trial".to_owned());
        }
        Ok(Self { values: values.iter().map(|p| p.value).collect(), variances, covariance, samples })
    }
}

/// The part of a covariance by `rows` that `names` have, in their order.
fn covariance(rows: &[String], entries: &[f64], names: &[&str]) -> Result<Vec<f64>, Invalid> {
    let refuse = |found: String| {
        let expected = "a covariance of the parameters of the design's moments";
        Err(Invalid::new("`data.covariance`", found, expected, "estimate the model again"))
    };
    let mut places = Vec::new();
    for name in names {
        match rows.iter().position(|row| row == name) {
            Some(place) => places.push(place),
            None => return refuse(format!("no `{name}`")),
        }
    }
    let n = names.len();
    let part: Vec<f64> = (0..n * n).map(|k| entries[places[k / n] * rows.len() + places[k % n]]).collect();
    if let Some(i) = (0..n).find(|i| !(part[i * n + i] >= 0.0 && part[i * n + i].is_finite())) {
        return refuse(format!("a variance of {} of `{}`", part[i * n + i], names[i]));
    }
    let is_one = |k: usize| {
        let most = (part[k / n * (n + 1)] * part[k % n * (n + 1)]).sqrt();
        part[k].abs() <= most * (1.0 + 1e-6) && (part[k] - part[k % n * n + k / n]).abs() <= 1e-6 * most
    };
    match (0..n * n).find(|k| !is_one(*k)) {
        None => Ok(part),
        Some(k) => {
            let (one, other) = (names[k / n], names[k % n]);
            refuse(format!(
                "{} between `{one}` and `{other}`, more than they vary or not the same both ways",
                part[k]
            ))
        }
    }
}

fn diagonal(variances: &[f64]) -> Vec<f64> {
    let n = variances.len();
    (0..n * n).map(|k| if k % (n + 1) == 0 { variances[k / n] } else { 0.0 }).collect()
}

/// The update in words.
fn said(found: &PromiseUpdate) -> String {
    let error = found.parameter_error.map(|error| ("parameter error", error));
    let by_criterion = found.criterion.as_ref().map(|criterion| ("criterion", criterion.error));
    let errors = match error.or(by_criterion) {
        Some((what, UpdatedError { promised, now, ratio })) => {
            let over = ratio.map_or(String::new(), |ratio| format!(", {ratio:.2} of it"));
            format!("the {what} is {now:.3}, relative to fixed scales; {promised:.3} was promised{over}")
        }
        None => "no error of all parameters together, as one of them is zero".to_owned(),
    };
    let left = found.accuracy.as_ref().map(|accuracy| match accuracy.remaining_s > 0.0 {
        true => format!(
            "; {} is wanted ({}), which takes {:.1} s more of the same design",
            accuracy.wanted, accuracy.of, accuracy.remaining_s
        ),
        false => format!("; {} was wanted ({}), and is reached", accuracy.wanted, accuracy.of),
    });
    let another = found.after_another.map(|e| format!("; another trial of this length leaves {e:.3}"));
    let left = left.or(another).unwrap_or_default();
    format!("After {:.1} s {errors}{left}.", found.duration_s)
}
