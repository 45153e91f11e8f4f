use refusal::Invalid;
use regression::pooled::{
    AnyParts, COLLINEAR, CutRuns, DegreeFit, Faults, LostInstruments, NominalModel, Options, PartView, Parts,
    PooledRuns, PooledSums, Prior, Recorded, Regression, Unread, joined, unidentified,
};
use regression::{MeanRemoval, Sums};
use ship::model::{Degree, DegreeOfFreedom, Model, Vessel};

use super::windows::StateMeans;
use super::{Scales, Searched, Unfound};
use crate::Estimator;
use crate::criticism::Kinds;
use crate::estimator::AdditionalUnknowns;
use crate::predictor::{InitialState, Unknown};

/// The options of all estimates of a study.
#[derive(Clone)]
pub struct Pool<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Its model with intercepts.
    pub model: Model,
    /// The intercepts.
    pub removal: MeanRemoval,
    /// Strength of the prior.
    pub strength: f64,
    /// The source of the instruments.
    pub nominal: NominalModel,
    /// Maximum number of samples of a part; segments are not cut without it.
    pub part_samples: Option<usize>,
    /// Additional unknowns of searches.
    pub additional: AdditionalUnknowns,
    /// Logged channels that never vary, named in warnings about terms that hardly vary.
    pub constant: Vec<String>,
}

/// An estimate of pooled parts.
pub struct Estimated {
    /// Surge, sway, yaw.
    pub degrees: [DegreeFit; 3],
    /// The estimator of each.
    pub used: [Estimator; 3],
    /// Nominal parameters and intercepts, if there were any.
    pub nominal: Option<(Vec<f64>, [f64; 3])>,
    /// The result of a search and its scales, if one was requested and converged.
    pub searched: Option<(Searched, Scales)>,
    /// The kinds of noise that predictions found; empty without predictions.
    pub(super) noises: Kinds,
    /// Set if a requested search found no model: then no degree of freedom has an estimate.
    pub unfound: Option<Unfound>,
    /// Why instruments could not be simulated for `auto`, which then is least squares.
    pub diverged: Option<LostInstruments>,
    /// Parameters of the model with intercepts that the instruments were simulated with.
    pub instruments: Option<Vec<f64>>,
    /// Sums of the parts with the regressors as instruments.
    ls: PooledSums,
    /// Those with simulated instruments.
    iv: Option<PooledSums>,
    /// Of the measured states.
    means: StateMeans,
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum NoEstimate<E> {
    /// The simulation of the instruments diverges.
    Lost(LostInstruments),
    /// The parts cannot be read.
    Unread(E),
}

impl NoEstimate<Unread> {
    /// With the error that was kept in `faults`.
    fn restored<E>(self, faults: &Faults<E>) -> NoEstimate<E> {
        match self {
            Self::Lost(lost) => NoEstimate::Lost(lost),
            Self::Unread(unread) => NoEstimate::Unread(faults.take(unread)),
        }
    }
}

impl Estimated {
    /// The sums that degree of freedom `d` was estimated from.
    pub fn data(&self, d: usize) -> &PooledSums {
        self.iv.as_ref().filter(|_| self.by_instruments(d)).unwrap_or(&self.ls)
    }

    /// The model that the instruments of degree of freedom `d` were simulated with; `None` if they are the
    /// regressors.
    pub fn simulated(&self, d: usize) -> Option<&[f64]> {
        self.instruments.as_deref().filter(|_| self.iv.is_some() && self.by_instruments(d))
    }

    fn by_instruments(&self, d: usize) -> bool {
        self.used[d] == Estimator::Iv
    }

    /// The sums with the regressors as instruments.
    pub(super) fn least_squares_sums(&self) -> &PooledSums {
        &self.ls
    }

    pub(super) fn means(&self) -> &StateMeans {
        &self.means
    }

    /// θ̂ of all degrees of freedom, and their intercepts; none unless all have one.
    pub fn theta(&self) -> Option<(Vec<f64>, [f64; 3])> {
        whole(&self.degrees)
    }

    /// Whether instruments were simulated.
    pub fn instrumented(&self) -> bool {
        self.iv.is_some()
    }

    /// θ̂ and intercepts, in the order of `model`, which has them.
    pub fn parameters(&self, model: &Model) -> Option<Vec<f64>> {
        self.theta().map(|(theta, intercepts)| model.layout().woven(&theta, intercepts))
    }
}

/// θ̂ of all degrees of freedom, and their intercepts.
fn whole(degrees: &[DegreeFit; 3]) -> Option<(Vec<f64>, [f64; 3])> {
    joined(degrees.each_ref().map(|degree| degree.solution.as_ref()))
}

impl<'a> Pool<'a> {
    /// The default: an intercept everywhere, instruments by the nominal values of `vessel`.
    pub fn new(vessel: &'a Vessel) -> Self {
        Self {
            vessel,
            model: vessel.model.with_intercepts(),
            removal: MeanRemoval::Complete,
            strength: 0.0,
            nominal: NominalModel::Known(vessel.nominal.clone()),
            part_samples: None,
            additional: AdditionalUnknowns::default(),
            constant: Vec::new(),
        }
    }
}

impl Pool<'_> {
    /// The default estimator; `None` if the noise decides, see [`super::unstated`]. A prior only applies to
    /// regressions, and an unknown current only to simulations. `simulated`: the runs are those of simulated
    /// trials.
    pub fn usual(&self, simulated: bool) -> Option<Estimator> {
        match simulated || self.strength > 0.0 {
            true => Some(Estimator::Iv),
            false => (self.additional != AdditionalUnknowns::default()).then_some(Estimator::OutputError),
        }
    }

    /// Refuses contradictions: see [`MeanRemoval::check`]; a prior together with bounds.
    ///
    /// # Errors
    /// Names the parameter.
    pub fn check(&self) -> Result<(), Invalid> {
        self.removal.check(&self.vessel.model)?;
        let bounded = |degree: &'_ Degree| degree.bounds.keys().next().map(|i| degree.parameters[*i].clone());
        match self.vessel.model.degrees.iter().find_map(bounded).filter(|_| self.strength > 0.0) {
            None => Ok(()),
            Some(name) => Err(Invalid::new(
                format!("parameter `{name}`"),
                "`bounds` beside a prior",
                "one of them: either holds an estimate back",
                "remove the bounds, or leave out --prior",
            )),
        }
    }

    /// The same for another vessel, whose instruments are simulated with `nominal`.
    pub fn of<'v>(&self, vessel: &'v Vessel, nominal: NominalModel) -> Pool<'v> {
        let constant = self.constant.clone();
        Pool { vessel, model: vessel.model.with_intercepts(), nominal, constant, ..*self }
    }

    /// Cuts `runs` into segments, or takes whole runs if a current is unknown, which is the same throughout a
    /// run.
    pub fn cut<'r, R: Recorded>(&self, runs: &'r PooledRuns<R>) -> CutRuns<'r, R> {
        match self.unknown().current {
            None => runs.cut(self.part_samples),
            Some(_) => runs.whole(self.part_samples),
        }
    }

    /// The unknowns of free simulations with known starts.
    pub(super) fn unknown(&self) -> Unknown {
        Unknown::new(InitialState::Known, self.additional, 1.0 / self.vessel.sample_rate_hz)
    }

    /// Estimates from `parts`, with a pass over them for every kind of sums, and for every step of a search.
    ///
    /// # Errors
    /// The nominal simulation diverges; parts that cannot be read.
    pub fn estimate<P: Parts>(
        &self,
        parts: &P,
        estimator: Estimator,
    ) -> Result<Estimated, NoEstimate<P::Error>> {
        let faults = Faults::default();
        self.estimate_any(&faults.erased(parts), estimator).map_err(|e| e.restored(&faults))
    }

    /// See [`Pool::estimate`].
    pub(super) fn estimate_any(
        &self,
        parts: &AnyParts,
        estimator: Estimator,
    ) -> Result<Estimated, NoEstimate<Unread>> {
        let mut means = StateMeans::default();
        let ls = self.sums_any(parts, None, &mut |part, _| means.add(part.run.measured))?;
        let nominal = self.nominal.parameters(&ls);
        let fitted =
            ls.fit(&self.options(nominal.as_ref().map(|(theta, _)| theta.as_slice()), Estimator::Ls));
        let mut found = Estimated {
            degrees: fitted,
            used: [Estimator::Ls; 3],
            nominal,
            searched: None,
            noises: Vec::new(),
            unfound: None,
            diverged: None,
            instruments: None,
            ls,
            iv: None,
            means,
        };
        if estimator == Estimator::Ls {
            return Ok(found);
        }
        // If least squares found no model to simulate, nothing is identified in any case.
        if let Some(nominal) = found.nominal.clone() {
            match self.instrumented(parts, estimator, nominal, &mut found) {
                Err(NoEstimate::Lost(diverged)) if estimator == Estimator::Auto || estimator.searches() => {
                    found.diverged = Some(diverged);
                }
                result => result?,
            }
        }
        if estimator.searches() {
            self.searched(parts, estimator, &mut found).map_err(NoEstimate::Unread)?;
        }
        Ok(found)
    }

    /// The least-squares estimate of the data of `found`, and its intercepts.
    pub fn least_squares(&self, found: &Estimated) -> Option<(Vec<f64>, [f64; 3])> {
        let nominal = found.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        whole(&found.ls.fit(&self.options(nominal, Estimator::Ls)))
    }

    /// The regression of a part, and the states of its instruments: simulated from the measured state with these
    /// parameters of the model with intercepts; else the regressors are the instruments.
    ///
    /// # Errors
    /// The simulation diverges.
    pub fn regression(
        &self,
        part: &PartView,
        simulated: Option<&[f64]>,
    ) -> Result<(Regression, Vec<f64>), LostInstruments> {
        let Some(parameters) = simulated else {
            return Ok((Regression::of(&self.vessel.model, part), Vec::new()));
        };
        let states = part.simulated(&self.model, parameters)?;
        Ok((Regression::with(&self.vessel.model, part, &states).after_start(), states))
    }

    /// The sums of `parts` with instruments as in [`Pool::regression`]. `look` is called with every part and the sums of it.
    ///
    /// # Errors
    /// The first part whose simulation diverges; parts that cannot be read.
    pub fn sums<P: Parts>(
        &self,
        parts: &P,
        simulated: Option<&[f64]>,
        mut look: impl FnMut(PartView, &Sums),
    ) -> Result<PooledSums, NoEstimate<P::Error>> {
        let faults = Faults::default();
        self.sums_any(&faults.erased(parts), simulated, &mut look).map_err(|e| e.restored(&faults))
    }

    /// See [`Pool::sums`].
    pub(super) fn sums_any(
        &self,
        parts: &AnyParts,
        simulated: Option<&[f64]>,
        look: &mut dyn FnMut(PartView, &Sums),
    ) -> Result<PooledSums, NoEstimate<Unread>> {
        let (mut sums, mut lost) = (PooledSums::new(self.removal), None);
        let mut add = |part: PartView| {
            if lost.is_some() {
                return;
            }
            match self.regression(&part, simulated) {
                Ok((regression, _)) => {
                    let own = regression.sums();
                    sums.add(&own);
                    look(part, &own);
                }
                Err(diverged) => lost = Some(diverged),
            }
        };
        parts.each(&mut add).map_err(NoEstimate::Unread)?;
        lost.map_or(Ok(sums), |lost| Err(NoEstimate::Lost(lost)))
    }

    fn instrumented(
        &self,
        parts: &AnyParts,
        estimator: Estimator,
        (theta, intercepts): (Vec<f64>, [f64; 3]),
        found: &mut Estimated,
    ) -> Result<(), NoEstimate<Unread>> {
        let model = self.model.layout().woven(&theta, intercepts);
        let data = self.sums_any(parts, Some(&model), &mut |_, _| {})?;
        let degrees = data.fit(&self.options(Some(&theta), Estimator::Iv));
        for (d, degree) in degrees.into_iter().enumerate() {
            if degree.solution.is_some() || !(estimator == Estimator::Auto || estimator.searches()) {
                (found.degrees[d], found.used[d]) = (degree, Estimator::Iv);
            }
        }
        (found.iv, found.instruments) = (Some(data), Some(model));
        Ok(())
    }

    /// Why degrees of freedom have no estimate, in words.
    pub fn unidentified(&self, degrees: &[DegreeFit; 3]) -> Vec<String> {
        let why = |d: DegreeOfFreedom| {
            let (degree, fit) = (&self.vessel.model.degrees[d as usize], &degrees[d as usize]);
            unidentified(d, degree, &fit.status, &self.constant)
        };
        DegreeOfFreedom::ALL.into_iter().filter_map(why).collect()
    }

    /// The options of a fit. Least squares works with collinear columns; instruments must not be collinear.
    pub fn options<'b>(&self, nominal: Option<&'b [f64]>, used: Estimator) -> Options<'b> {
        let prior = nominal.filter(|_| self.strength > 0.0);
        Options {
            removal: self.removal,
            prior: prior.map(|nominal| Prior { strength: self.strength, nominal }),
            most: if used.by_instruments() { COLLINEAR } else { f64::INFINITY },
        }
    }
}
