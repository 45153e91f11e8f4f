//! Designs by any criterion, the ships and the figures of merit that they are for.

use std::path::Path;

use design::{
    Accuracy, AccuracyOf, Bounds, Candidates, Criterion, CriterionName, Design, Dictionary, Errors,
    FigureErrors, Options, Question, Restricted, Stock, Wanted,
};
use estimation::pooled::{Covariance, Uncertain};
use maneuver::Generator;
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::Run;
use ship::model::{Source, Vessel};
use study::documents::{MeritDocument, MeritTableRow, SlopesAt, SolvedFigures};
use study::figure_goals::FigureGoals;
use study::files::read_model;
use study::trajectories::{Reacting, TrajectoryReader};
use trial::moments::{CriterionOf, Estimated, Moments, NoCriterion, PlayedMotion, SampledShips, ShipSampler};
use validation::merit::{Merit, Unsimulated};

/// What the shares of a design are best for.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// The criterion.
    pub name: CriterionName,
    /// The estimate.
    pub estimated: Estimated,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// At most so many maneuvers.
    pub most_maneuvers: Option<u64>,
}

/// Maneuvers and a criterion of their shares.
pub struct Designing<'a> {
    /// The maneuvers' moments.
    pub moments: &'a Moments,
    /// What the shares are best for.
    pub wish: Wish,
    /// The moments as candidates.
    pub dictionary: Dictionary,
    /// The criterion.
    pub criterion: Criterion,
    /// The available amount of every maneuver.
    pub stock: Option<Stock>,
    figures: Option<(FigureGoals, FigureErrors)>,
}

impl<'a> Designing<'a> {
    /// The problem without limits of what is available. `goals`: figures of merit, if any.
    ///
    /// # Errors
    /// Moments without what the criterion is computed from; a singular covariance.
    pub fn new(moments: &'a Moments, wish: Wish, goals: Option<FigureGoals>) -> Result<Self, NoCriterion> {
        let dictionary = moments.dictionary(wish.estimated)?;
        let (criterion, meat) = criterion(moments, &dictionary, wish, goals.as_ref())?;
        let predicted = |goals: FigureGoals| {
            let meat = meat.map_or_else(|| moments.middle(wish.estimated), Ok)?;
            let errors = FigureErrors::new(&dictionary, &meat, &goals.slopes())?;
            Ok::<_, NoCriterion>((goals, errors))
        };
        let figures = goals.map(predicted).transpose()?;
        Ok(Self { moments, wish, dictionary, criterion, stock: None, figures })
    }

    /// A design of the shortest experiment for the `wanted` accuracy, beside the paper's and random ones of this `seed`;
    /// `None` without a criterion of the covariance.
    ///
    /// # Errors
    /// A parameter of zero, that no error is relative to; an accuracy out of reach; those of the solvers.
    pub fn shortest(
        &self,
        wanted: Wanted,
        (removal, seed): (regression::MeanRemoval, u64),
        options: &Options,
    ) -> Result<Option<(Design, Accuracy)>, NoCriterion> {
        let Criterion::Covariance(covariance) = &self.criterion else { return Ok(None) };
        let lengths: Vec<f64> = self.moments.maneuvers.iter().map(|m| m.samples as f64).collect();
        let squares = match wanted.of {
            AccuracyOf::Figures => Vec::new(),
            _ => self.moments.squares(self.wish.relative_to)?,
        };
        let errors = match &self.figures {
            Some((goals, _)) if wanted.of == AccuracyOf::Figures => {
                Errors::of_figures(&self.dictionary, covariance, &goals.wanted())
            }
            _ => Errors::new(&self.dictionary, covariance, &squares),
        };
        let question = Question {
            dictionary: &self.dictionary,
            lengths: &lengths,
            criterion: &self.criterion,
            errors,
            wanted,
            stock: self.stock.as_ref(),
        };
        let shortest = question.shortest(options)?;
        let accuracy = question.compare(&shortest, &self.moments.rivals(removal, seed));
        Ok(Some((shortest.design, accuracy)))
    }

    /// A design with few maneuvers, if that is wished.
    ///
    /// # Errors
    /// No such choice that excites every parameter.
    pub fn few(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        options: &Options,
    ) -> Result<Option<Restricted>, design::Error> {
        self.few_by(&self.criterion, relaxed, bounds, options)
    }

    fn few_by(
        &self,
        criterion: &Criterion,
        relaxed: &Design,
        bounds: &Bounds,
        options: &Options,
    ) -> Result<Option<Restricted>, design::Error> {
        let parameters = self.dictionary.parameters();
        let few = |most: u64| criterion.restricted(relaxed, bounds, most as usize, options, parameters);
        self.wish.most_maneuvers.map(few).transpose()
    }

    /// The figures' standard errors after an experiment of `samples` (1 if not known) by `design`, and by the D-optimal
    /// design under the same limits; `None` without figures.
    ///
    /// # Errors
    /// Those of the solvers.
    pub fn figures(
        &self,
        design: &Design,
        bounds: &Bounds,
        samples: Option<f64>,
        options: &Options,
    ) -> Result<Option<SolvedFigures<'_>>, NoCriterion> {
        let Some((goals, errors)) = &self.figures else { return Ok(None) };
        let at = |shares: &[f64]| errors.at(shares, samples.unwrap_or(1.0));
        let Some(designed) = at(&design.shares) else { return Ok(None) };
        let d_optimal = self.d_optimal(design, bounds, options)?;
        Ok(Some(SolvedFigures { goals, errors: designed, d_optimal: at(&d_optimal) }))
    }

    /// The D-optimal shares under the same limits: those of `design` where that is D-optimal.
    fn d_optimal(
        &self,
        design: &Design,
        bounds: &Bounds,
        options: &Options,
    ) -> Result<Vec<f64>, NoCriterion> {
        let name = self.wish.estimated.d_optimal();
        if name == self.wish.name {
            return Ok(design.shares.clone());
        }
        let explained = |e| NoCriterion::from(self.dictionary.explain(e));
        let (criterion, _) = criterion(self.moments, &self.dictionary, Wish { name, ..self.wish }, None)?;
        let relaxed = criterion.solve(bounds, options).map_err(explained)?;
        let few = self.few_by(&criterion, &relaxed, bounds, options).map_err(explained)?;
        Ok(few.map_or(relaxed.shares, |restricted| restricted.design.shares))
    }
}

fn criterion(
    moments: &Moments,
    dictionary: &Dictionary,
    wish: Wish,
    goals: Option<&FigureGoals>,
) -> Result<(Criterion, Option<Candidates>), NoCriterion> {
    let weighted = goals.map(FigureGoals::weighted).unwrap_or_default();
    let parameters = goals.map_or(&[][..], |goals| &goals.parameters);
    let Wish { name, estimated, relative_to, .. } = wish;
    moments.criterion(
        dictionary,
        &CriterionOf { name, estimated, relative_to, figures: (&weighted, parameters) },
    )
}

/// What ships with other parameters than `vessel` do with the inputs of a dictionary's simulated maneuvers. `None` where the
/// true parameters are known, the maneuvers were not simulated, or the vessel is a model in `file` without covariance.
///
/// # Errors
/// Files that cannot be read.
pub fn sampled_ships(
    file: &Path,
    vessel: &Vessel,
    reader: &TrajectoryReader,
) -> Result<Option<SampledShips>, files::Error> {
    let model = read_model(file)?;
    let is_known = vessel.best_known() == Source::Value || !reader.true_states();
    let covariance = model.as_ref().and_then(|model| model.covariance.as_ref());
    if is_known || covariance.is_some() != model.is_some() {
        return Ok(None);
    }
    let Some(sampler) = ShipSampler::new(vessel, covariance) else { return Ok(None) };
    let (reacting, mut all) = (Reacting::noted(reader.provenance()), Vec::new());
    let name = |run: &Run| run.segments.first().map_or(String::new(), |segment| segment.maneuver.clone());
    for block in 0..reader.blocks() {
        let mut runs = reader.runs(block)?;
        runs.retain(|run| !reacting.has(&name(run), run.run));
        let motions: Vec<PlayedMotion> = runs.par_iter().map(|run| sampler.play(run)).collect();
        all.extend(motions);
    }
    Ok(Some(sampler.found(all)))
}

/// Step of the differences that figures' slopes are computed by, as a part of the parameter: large against what the sampling of
/// a figure leaves, small against what the model's terms bend.
const STEP: f64 = 0.02;

/// Figures of merit of the standard maneuvers of a dictionary, or of those that logs show.
pub struct Merits<'a> {
    vessel: &'a Vessel,
    generator: Option<&'a Generator>,
    length_m: f64,
    merit: Merit<'a>,
    /// Whether runs are draws of a model's parameters.
    is_drawn: bool,
    slopes_at: Option<SlopesAt>,
}

impl<'a> Merits<'a> {
    /// None so far, for a ship of this length \[m\].
    ///
    /// # Errors
    /// A dictionary without standard maneuvers.
    pub fn new(vessel: &'a Vessel, generator: Option<&'a Generator>, length_m: f64) -> Result<Self, Invalid> {
        vessel.check_length(length_m, "the length", None)?;
        let merit = Merit::new(vessel, generator, length_m)?;
        Ok(Self { vessel, generator, length_m, merit, is_drawn: false, slopes_at: None })
    }

    /// Adds recorded runs, with north, east \[m\] and heading \[rad\] of all of their rows where they were recorded. Logs show
    /// themselves which orders were given.
    pub fn add(&mut self, runs: &[Run], poses: Option<&[[f64; 3]]>, are_logged: bool) {
        let mut first = 0;
        for run in runs {
            let rows = first..first + run.samples() + 1;
            first = rows.end;
            self.merit.add(run, poses.map(|poses| &poses[rows]), are_logged);
        }
    }

    /// Adds the undisturbed ship.
    ///
    /// # Errors
    /// A vessel without parameters; a maneuver that it cannot hold.
    pub fn simulate(&mut self) -> Result<(), Unsimulated> {
        let known = self.vessel.parameters(self.vessel.best_known());
        self.merit.simulate(&known.map_err(Unsimulated::Unheld)?, 0)
    }

    /// Adds undisturbed ships whose parameters are drawn from a covariance.
    ///
    /// # Errors
    /// What is no covariance.
    pub fn simulate_drawn(&mut self, covariance: &Covariance, draws: u32, seed: u64) -> Result<(), Invalid> {
        let parameters = self.generator.map_or(Vec::new(), |generator| generator.parameters().to_vec());
        let uncertain = Uncertain::new(self.vessel, parameters, covariance).ok_or_else(|| {
            Invalid::new("`covariance`", "numbers that are none", "a covariance", "estimate the model again")
        })?;
        self.is_drawn = true;
        self.merit.simulate_drawn(&uncertain, draws, seed);
        Ok(())
    }

    /// Computes the derivatives of every figure by every parameter of the undisturbed ship.
    ///
    /// # Errors
    /// A vessel without parameters, or with one of 0; a maneuver that it cannot hold.
    pub fn differentiate(&mut self) -> Result<(), Invalid> {
        let values = self.vessel.parameters(self.vessel.best_known())?;
        self.merit.differentiate(&values, STEP)?;
        let names = self.vessel.model.parameter_names().map(str::to_owned);
        self.slopes_at = Some(SlopesAt { parameters: names.zip(values).collect(), step: STEP });
        Ok(())
    }

    /// The document, and every figure of every run.
    ///
    /// # Errors
    /// Maneuvers that have no figures in any run; no maneuver that was run.
    pub fn found(&self) -> Result<(MeritDocument, Vec<MeritTableRow>), Invalid> {
        let summary = self.merit.summary(self.is_drawn)?;
        let document = MeritDocument::new(&self.vessel.name, self.length_m, self.is_drawn, summary);
        let document = document.with_slopes_at(self.slopes_at.clone());
        Ok((document, self.merit.rows().iter().map(MeritTableRow::from).collect()))
    }
}
