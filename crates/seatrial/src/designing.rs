use design::{
    Accuracy, AccuracyOf, Bounds, Candidates, Criterion, CriterionName, Design, Dictionary, Errors,
    FigureErrors, Options, Question, Restricted, Restriction, Stock, Wanted,
};
use ship::model::Source;
use study::documents::{Few, SolvedFigures};
use study::figure_goals::FigureGoals;
use trial::moments::{CriterionOf, Estimated, Moments, NoCriterion};

/// What the shares of a design are best for.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// The criterion.
    pub name: CriterionName,
    /// The estimate.
    pub estimated: Estimated,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// Few or long maneuvers.
    pub few: Few,
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
    /// B_q of the candidates, for a criterion of the covariance.
    meat: Option<Candidates>,
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
            let meat = meat.clone().map_or_else(|| moments.middle(wish.estimated), Ok)?;
            let errors = FigureErrors::new(&dictionary, &meat, &goals.slopes())?;
            Ok::<_, NoCriterion>((goals, errors))
        };
        let figures = goals.map(predicted).transpose()?;
        Ok(Self { moments, wish, dictionary, criterion, stock: None, meat, figures })
    }

    /// A design of the shortest experiment for the `wanted` accuracy, beside the paper's and random ones of this `seed`;
    /// `None` without a criterion of the covariance. `least_largest`: minimise the largest error instead of the criterion.
    ///
    /// # Errors
    /// A parameter of zero, that no error is relative to; an accuracy out of reach; those of the solvers.
    pub fn shortest(
        &self,
        (wanted, least_largest): (Wanted, bool),
        (removal, seed): (regression::MeanRemoval, u64),
        options: &Options,
    ) -> Result<Option<(Design, Accuracy)>, NoCriterion> {
        let (Criterion::Covariance(own), Some(meat)) = (&self.criterion, &self.meat) else { return Ok(None) };
        let lengths: Vec<f64> = self.moments.maneuvers.iter().map(|m| m.samples as f64).collect();
        let squares = match wanted.of {
            AccuracyOf::Figures => Vec::new(),
            _ => self.moments.squares(self.wish.relative_to)?,
        };
        let errors = match &self.figures {
            Some((goals, _)) if wanted.of == AccuracyOf::Figures => {
                Errors::of_figures(&self.dictionary, meat, own, &goals.wanted())
            }
            _ => Errors::new(&self.dictionary, meat, own, &squares, wanted.of),
        };
        let question = Question {
            dictionary: &self.dictionary,
            lengths: &lengths,
            criterion: &self.criterion,
            errors,
            wanted,
            least_largest,
            stock: self.stock.as_ref(),
        };
        let shortest = question.shortest(options)?;
        let accuracy = question.compare(&shortest, &self.moments.rivals(removal, seed));
        Ok(Some((shortest.design, accuracy)))
    }

    /// A design with few maneuvers, or long ones, if that is wished. `duration_s`: of the experiment, if known.
    ///
    /// # Errors
    /// No such choice that excites every parameter.
    pub fn few(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        duration_s: Option<f64>,
        options: &Options,
    ) -> Result<Option<(Few, Restricted)>, design::Error> {
        self.few_by(&self.criterion, relaxed, bounds, duration_s, options)
    }

    fn few_by(
        &self,
        criterion: &Criterion,
        relaxed: &Design,
        bounds: &Bounds,
        duration_s: Option<f64>,
        options: &Options,
    ) -> Result<Option<(Few, Restricted)>, design::Error> {
        let few = self.wish.few;
        if few == Few::default() {
            return Ok(None);
        }
        let least = few.minimal_s.zip(duration_s).map_or(0.0, |(minimal, duration)| minimal / duration);
        let most = few.most_maneuvers.map_or(usize::MAX, |k| k as usize).min(relaxed.shares.len());
        let (restriction, parameters) = (Restriction { most, least }, self.dictionary.parameters());
        let found = criterion.restricted(relaxed, bounds, &restriction, options, parameters)?;
        Ok(Some((few, found)))
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
        let Some(own) = at(&design.shares) else { return Ok(None) };
        let duration_s = samples.map(|samples| samples / self.dictionary.sample_rate_hz);
        let d_optimal = self.d_optimal(design, bounds, duration_s, options)?;
        Ok(Some(SolvedFigures { goals, errors: own, d_optimal: at(&d_optimal) }))
    }

    /// The D-optimal shares under the same limits: those of `design` where that is D-optimal.
    fn d_optimal(
        &self,
        design: &Design,
        bounds: &Bounds,
        duration_s: Option<f64>,
        options: &Options,
    ) -> Result<Vec<f64>, NoCriterion> {
        let name = self.wish.estimated.d_optimal();
        if name == self.wish.name {
            return Ok(design.shares.clone());
        }
        let explained = |e| NoCriterion::from(self.dictionary.explain(e));
        let (criterion, _) = criterion(self.moments, &self.dictionary, Wish { name, ..self.wish }, None)?;
        let relaxed = criterion.solve(bounds, options).map_err(explained)?;
        let few = self.few_by(&criterion, &relaxed, bounds, duration_s, options).map_err(explained)?;
        Ok(few.map_or(relaxed.shares, |(_, found)| found.design.shares))
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
