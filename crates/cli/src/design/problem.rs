//! The problem of `design`, read and checked.

use design::{Accuracy, Bounds, Design, NoDesign, Options, Restricted};
use files::Provenance;
use regression::MeanRemoval;
use seatrial::{Designing, Wish};
use study::design_files::read_stock;
use study::documents::{Few, SolvedFigures};
use study::figure_goals::FigureGoals;
use study::files::{read_dictionary, read_planned};
use trial::arranging::{Arranged, Arranging};
use trial::moments::{Moments, NoCriterion};

use super::Arguments;
use super::refusal::no_design;
use crate::cli::given;
use crate::failure::Failure;

/// Maneuvers and a criterion.
pub(super) struct Problem<'a> {
    pub a: &'a Arguments,
    /// Of random starts and random designs.
    pub seed: u64,
    pub of: Designing<'a>,
}

impl<'a> Problem<'a> {
    pub fn read(
        a: &'a Arguments,
        seed: u64,
        moments: &'a Moments,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        // Of an arranged experiment the search keeps the length of pieces.
        let few = Few { most_maneuvers: a.most_maneuvers, minimal_s: a.minimal_s.filter(|_| !a.arrange) };
        let (name, estimated) = (a.criterion_name()?, a.estimated());
        let wish = Wish { name, estimated, relative_to: a.relative_to, few };
        let goals = a.figures.as_ref().map(|path| {
            let mut goals = FigureGoals::read(path, moments, provenance)?;
            let stated = goals.want(&a.accuracy).and_then(|()| goals.weigh(&a.weight));
            stated.map(|()| goals).map_err(|e| Failure::invalid(path, &e))
        });
        let mut of = Designing::new(moments, wish, goals.transpose()?).map_err(|e| no_criterion(a, e))?;
        let stock = a.available.as_ref().map(|path| read_stock(path, &of.dictionary.maneuvers, provenance));
        of.stock = stock.transpose()?;
        Ok(Self { a, seed, of })
    }

    pub fn refuse(&self, why: NoDesign) -> Failure {
        no_criterion(self.a, why.into())
    }

    /// A design of the shortest experiment for the requested accuracy.
    pub fn shortest(&self, options: &Options) -> Result<Option<(Design, Accuracy)>, Failure> {
        let a = self.a;
        let Some(wanted) = a.wanted() else { return Ok(None) };
        let how = (wanted, a.per_parameter && a.criterion.is_none());
        let found = self.of.shortest(how, (a.mean_removal, self.seed), options);
        found.map_err(|e| no_criterion(a, e))
    }

    /// A design with few maneuvers, or long ones, if requested. `duration_s`: of the experiment, if known.
    pub fn few(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        duration_s: Option<f64>,
        options: &Options,
    ) -> Result<Option<(Few, Restricted)>, Failure> {
        let Few { most_maneuvers, minimal_s } = self.of.wish.few;
        self.of.few(relaxed, bounds, duration_s, options).map_err(|e| {
            let asked = [
                most_maneuvers.map(|k| format!("--most-maneuvers {k}")),
                minimal_s.map(|s| format!("--minimal-s {s}")),
            ];
            Failure::NoAnswer(format!(
                "{}: {}: found no such choice that excites every parameter ({e}), expected one; allow more or shorter maneuvers",
                self.a.moments.display(),
                asked.into_iter().flatten().collect::<Vec<_>>().join(" ")
            ))
        })
    }

    /// The figures' standard errors after the experiment, if figures were given.
    pub fn figures(
        &self,
        design: &Design,
        bounds: &Bounds,
        samples: Option<f64>,
        options: &Options,
    ) -> Result<Option<SolvedFigures<'_>>, Failure> {
        self.of.figures(design, bounds, samples, options).map_err(|e| no_criterion(self.a, e))
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
                "one to fill; make the moments with --campaign, or add --duration-s, --accuracy, or --segments and --segment-samples",
            );
        };
        if a.available.is_some() || a.most_maneuvers.is_some() || a.mean_removal == MeanRemoval::Batch {
            return usage(
                "--available, --most-maneuvers or --mean-removal batch, which the search does not keep",
                "none of them; leave them out",
            );
        }
        let (vessel, dictionary) = (given(&a.vessel, "vessel")?, given(&a.dictionary, "dictionary")?);
        let vessel = read_planned(vessel, provenance)?;
        let generator = read_dictionary(dictionary, &vessel, provenance)?;
        let arranging = Arranging {
            vessel: &vessel,
            generator: &generator,
            moments: self.of.moments,
            dictionary: &self.of.dictionary,
            criterion: &self.of.criterion,
            estimated: self.of.wish.estimated,
            minimal_s: a.minimal_s,
            seed: self.seed,
        };
        let found = arranging.search(&design.shares, &design.sensitivities, samples.round() as usize);
        found.map(Some).map_err(|e| Failure::invalid(dictionary, &e))
    }
}

/// Why there is no criterion, or no design of it.
fn no_criterion(a: &Arguments, why: NoCriterion) -> Failure {
    match why {
        NoCriterion::Moments(e) => Failure::invalid(&a.moments, &e),
        NoCriterion::Design(e) => no_design(&a.moments, a.available.as_deref(), e),
    }
}
