//! The problem of `design`, read and checked.

use artifact::Provenance;
use design::{
    Accuracy, Bounds, Candidates, Criterion, CriterionName, Design, Dictionary, Errors, NoDesign, Norm,
    Options, Question, Restricted, Restriction, Stock,
};
use refusal::Invalid;
use regression::MeanRemoval;
use study::design_files::read_stock;
use study::documents::Few;
use study::files::{read_dictionary, read_vessel};
use trial::arranging::{Arranged, Arranging};
use trial::moments::{Estimated, Moments};

use super::Arguments;
use super::refusal::no_design;
use crate::cli::given;
use crate::failure::Failure;

/// Maneuvers and a criterion.
pub(super) struct Problem<'a> {
    pub a: &'a Arguments,
    /// Of random starts and random designs.
    pub seed: u64,
    pub moments: &'a Moments,
    pub dictionary: Dictionary,
    pub name: CriterionName,
    pub estimated: Estimated,
    pub criterion: Criterion,
    /// The available amount of every maneuver.
    pub stock: Option<Stock>,
    /// Of a criterion of the covariance.
    meat: Option<Candidates>,
}

impl<'a> Problem<'a> {
    pub fn read(
        a: &'a Arguments,
        seed: u64,
        moments: &'a Moments,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let (name, estimated) = (a.criterion_name()?, a.estimated());
        let invalid = |e: Invalid| Failure::invalid(&a.moments, &e);
        let dictionary = moments.dictionary(estimated).map_err(invalid)?;
        let weights = weights(a, name, moments, &dictionary)?;
        let (criterion, meat) = match name {
            CriterionName::DHessian => (Ok(Criterion::Information(dictionary.information.clone())), None),
            _ => {
                let meat = moments.middle(estimated).map_err(invalid)?;
                let criterion = match name {
                    CriterionName::V => {
                        let g = moments.free_run_weights().map_err(invalid)?;
                        Criterion::of_free_runs(&dictionary, &meat, g)
                    }
                    CriterionName::D => Criterion::of_covariance(&dictionary, &meat, weights, Norm::LogDet),
                    _ => Criterion::of_covariance(&dictionary, &meat, weights, Norm::Trace),
                };
                (criterion, Some(meat))
            }
        };
        let criterion = criterion.map_err(|e| no_design(&a.moments, None, e))?;
        let stock = a.available.as_ref().map(|path| read_stock(path, &dictionary.maneuvers, provenance));
        let stock = stock.transpose()?;
        Ok(Self { a, seed, moments, dictionary, name, estimated, criterion, stock, meat })
    }

    pub fn refuse(&self, why: NoDesign) -> Failure {
        no_design(&self.a.moments, self.a.available.as_deref(), why)
    }

    /// A design of the shortest experiment for the requested accuracy.
    pub fn shortest(&self, options: &Options) -> Result<Option<(Design, Accuracy)>, Failure> {
        let a = self.a;
        let (Some(accuracy), Criterion::Covariance(own), Some(meat)) =
            (a.accuracy, &self.criterion, &self.meat)
        else {
            return Ok(None);
        };
        let squares = self.moments.squares(a.relative_to).map_err(|e| Failure::invalid(&a.moments, &e))?;
        let wanted = a.wanted(accuracy);
        let lengths: Vec<f64> = self.moments.maneuvers.iter().map(|m| m.samples as f64).collect();
        let question = Question {
            dictionary: &self.dictionary,
            lengths: &lengths,
            criterion: &self.criterion,
            errors: Errors::new(&self.dictionary, meat, own, &squares, wanted.of),
            wanted,
            least_largest: a.per_parameter && a.criterion.is_none(),
            stock: self.stock.as_ref(),
        };
        let shortest = question.shortest(options).map_err(|e| self.refuse(e))?;
        let rivals = self.moments.rivals(a.mean_removal, self.seed);
        let accuracy = question.compare(&shortest, &rivals);
        Ok(Some((shortest.design, accuracy)))
    }

    /// A design with few maneuvers, or long ones, if requested. `duration_s`: of the experiment, if known.
    pub fn few(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        duration_s: Option<f64>,
        options: &Options,
    ) -> Result<Option<(Few, Restricted)>, Failure> {
        let few = Few { most_maneuvers: self.a.most_maneuvers, minimal_s: self.a.minimal_s };
        if few == Few::default() {
            return Ok(None);
        }
        let least = few.minimal_s.zip(duration_s).map_or(0.0, |(minimal, duration)| minimal / duration);
        let most = few.most_maneuvers.map_or(usize::MAX, |k| k as usize).min(relaxed.shares.len());
        let (restriction, parameters) = (Restriction { most, least }, self.dictionary.parameters());
        let found = self.criterion.restricted(relaxed, bounds, &restriction, options, parameters);
        found.map(|found| Some((few, found))).map_err(|e| {
            let asked = [
                few.most_maneuvers.map(|k| format!("--most-maneuvers {k}")),
                few.minimal_s.map(|s| format!("--minimal-s {s}")),
            ];
            Failure::NoAnswer(format!(
                "{}: {}: found no such choice that excites every parameter ({e}), expected one; allow more or shorter maneuvers",
                self.a.moments.display(),
                asked.into_iter().flatten().collect::<Vec<_>>().join(" ")
            ))
        })
    }

    /// Order and lengths of the maneuvers of `design`, if requested.
    pub fn arranged(
        &self,
        design: &Design,
        samples: Option<f64>,
        provenance: &mut Provenance,
    ) -> Result<Option<Arranged>, Failure> {
        let a = self.a;
        if !a.arrange {
            return Ok(None);
        }
        let usage = |found: &str, expected: &str| {
            Err(Failure::Usage(format!("--arrange: found {found}, expected {expected}")))
        };
        let Some(samples) = samples else {
            return usage(
                "no length of the experiment",
                "one to fill; add --duration-s, --accuracy, or --segments and --segment-samples",
            );
        };
        let unkept = [a.available.is_some(), a.most_maneuvers.is_some(), a.minimal_s.is_some()];
        if unkept.contains(&true) || a.mean_removal == MeanRemoval::Batch {
            return usage(
                "--available, --most-maneuvers, --minimal-s or --mean-removal batch, which the search does not keep",
                "none of them; leave them out",
            );
        }
        let (vessel, dictionary) = (given(&a.vessel, "vessel")?, given(&a.dictionary, "dictionary")?);
        let vessel = read_vessel(vessel, provenance)?.with_disturbances_held();
        let generator = read_dictionary(dictionary, &vessel, provenance)?;
        let arranging = Arranging {
            vessel: &vessel,
            generator: &generator,
            moments: self.moments,
            dictionary: &self.dictionary,
            criterion: &self.criterion,
            estimated: self.estimated,
            seed: self.seed,
        };
        let found = arranging.search(&design.shares, &design.sensitivities, samples.round() as usize);
        found.map(Some).map_err(|e| Failure::invalid(dictionary, &e))
    }
}

/// The weight of every parameter's variance: 1 or 1/θ².
fn weights(
    a: &Arguments,
    name: CriterionName,
    moments: &Moments,
    dictionary: &Dictionary,
) -> Result<Vec<f64>, Failure> {
    if name != CriterionName::ARelative {
        return Ok(vec![1.0; dictionary.parameters()]);
    }
    let squares = moments.squares(a.relative_to).map_err(|e| Failure::invalid(&a.moments, &e))?;
    Ok(squares.iter().map(|s| 1.0 / s).collect())
}
