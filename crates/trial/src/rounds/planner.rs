use design::{Candidates, Covariance, Norm, Options, solve_covariance_among, solve_covariance_from};
use estimation::{OutputInformation, Simulated, output_informations};
use maneuver::Generator;
use refusal::Invalid;
use regression::Noise;
use ship::engine::{Helm, Run, Segment, Streams};
use ship::model::{ParameterLayout, Vessel};

use crate::campaign::{Judged, OwnLoop, Parts, judge};

/// Designs for output-error estimates, from a model and from the run so far.
pub struct Planner<'a> {
    vessel: &'a Vessel,
    noise: Noise,
    maneuvers: Vec<Maneuver>,
}

/// The trial before its next round.
pub struct SoFar<'a> {
    /// Number of samples so far.
    pub samples: usize,
    /// Their information, by the planning model.
    pub information: &'a OutputInformation,
    /// Shares of the previous round, which start the search for the next.
    pub shares: &'a [f64],
}

/// A maneuver at its own length.
struct Maneuver {
    /// Its index in the dictionary.
    index: usize,
    initial: [f64; 3],
    exogenous: Vec<f64>,
}

impl<'a> Planner<'a> {
    /// For the maneuvers of `generator`, except generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver that is too long or that the model cannot hold; limits that leave none.
    pub fn new(vessel: &'a Vessel, generator: &Generator, noise: Noise) -> Result<Self, Invalid> {
        let mut maneuvers = Vec::new();
        for index in 0..generator.maneuvers().len() {
            if let Judged::Within { initial, exogenous, .. } = judge(vessel, generator, index)? {
                maneuvers.push(Maneuver { index, initial, exogenous });
            }
        }
        if maneuvers.is_empty() {
            let remedy = "see the messages of `simulate dictionary` about its limits";
            return Err(Invalid::new("maneuvers", "none within the limits", "at least one", remedy));
        }
        Ok(Self { vessel, noise, maneuvers })
    }

    /// Indices in the dictionary of the maneuvers with shares.
    pub fn maneuvers(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.maneuvers.iter().map(|maneuver| maneuver.index)
    }

    /// Shares of the next `n` samples that minimize Σ var/size² of the parameters' estimates at their end, for the model with
    /// parameters `theta`, in addition to the information of the run so far: every candidate's matrix is that of the whole,
    /// (N_past M_past + N_coming M_q)/N. `None` where the model diverges in every maneuver or they do not excite it.
    pub fn shares(&self, theta: &[f64], sizes: &[f64], so_far: Option<SoFar>, n: usize) -> Option<Vec<f64>> {
        let before = so_far.as_ref().map_or(0, |so_far| so_far.samples);
        let past = so_far.as_ref().map(|so_far| so_far.information);
        let share = n as f64 / (before + n) as f64;
        let each = self.maneuvers.iter();
        let each = each.map(|m| Simulated { theta, initial: m.initial, exogenous: &m.exogenous });
        let informations = self.informations(&each.collect::<Vec<_>>());
        let whole = informations.iter().flatten().map(|sums| match past {
            None => (sums.information.clone(), sums.middle()),
            Some(past) => (
                mixed(&past.information, &sums.information, share),
                mixed(&past.middle(), &sums.middle(), share),
            ),
        });
        let criterion = self.criterion(whole, sizes)?;
        let latest = so_far.map(|so_far| {
            let kept = so_far.shares.iter().zip(&informations).filter(|(_, sum)| sum.is_some());
            kept.map(|(share, _)| *share).collect::<Vec<f64>>()
        });
        let mut designed = self.solved(&criterion, latest)?.into_iter();
        let share = |of: &Option<OutputInformation>| of.as_ref().and_then(|_| designed.next()).unwrap_or(0.0);
        Some(informations.iter().map(share).collect())
    }

    /// The best shares, searched from the `latest` if there are any.
    fn solved(&self, criterion: &Covariance, latest: Option<Vec<f64>>) -> Option<Vec<f64>> {
        let options = Options { random_starts: 0, tolerance: 1e-4, ..Options::default() };
        let from = latest.filter(|shares| shares.iter().any(|share| *share > 0.0));
        let designed = match from.map(|shares| solve_covariance_from(criterion, &shares, &options)) {
            Some(Ok(designed)) => designed,
            _ => solve_covariance_among(criterion, 2 * self.layout().parameters(), &options).ok()?,
        };
        Some(designed.shares)
    }

    /// Standard errors of an output-error estimate from a run of `samples` with this `information`. `None`
    /// where a direction is not excited.
    pub fn standard_errors(
        &self,
        information: &OutputInformation,
        sizes: &[f64],
        samples: usize,
    ) -> Option<Vec<f64>> {
        let sums = (information.information.clone(), information.middle());
        let criterion = self.criterion(std::iter::once(sums), sizes)?;
        let variances = criterion.variances(&[1.0])?;
        let kept = self.weights(sizes);
        let errors = variances.iter().zip(kept).filter(|(_, weight)| *weight > 0.0);
        Some(errors.map(|(variance, _)| (variance.max(0.0) / samples as f64).sqrt()).collect())
    }

    /// The information of runs. `None` for those that diverge.
    pub fn informations(&self, runs: &[Simulated]) -> Vec<Option<OutputInformation>> {
        output_informations(&self.vessel.model, runs, &self.noise)
    }

    /// The sum of var/size² over candidates' information and middle matrices.
    fn criterion(
        &self,
        candidates: impl Iterator<Item = (Vec<f64>, Vec<f64>)>,
        sizes: &[f64],
    ) -> Option<Covariance> {
        let dimensions = vec![self.layout().parameters()];
        let (mut information, mut meat) = (Candidates::new(dimensions.clone()), Candidates::new(dimensions));
        for (sums, noise) in candidates {
            information.push(&sums).ok()?;
            meat.push(&noise).ok()?;
        }
        Covariance::new(&information, &meat, &self.weights(sizes), Norm::Trace).ok()
    }

    /// 1/size² of the lifted parameters, zero for intercepts.
    fn weights(&self, sizes: &[f64]) -> Vec<f64> {
        let weights: Vec<f64> = sizes.iter().map(|size| size.powi(-2)).collect();
        self.layout().woven(&weights, [0.0; 3])
    }

    /// The order of information matrices' rows.
    fn layout(&self) -> ParameterLayout {
        self.vessel.model.layout().with_intercepts()
    }
}

/// (1 − share) past + share × new.
fn mixed(past: &[f64], new: &[f64], share: f64) -> Vec<f64> {
    past.iter().zip(new).map(|(past, new)| (1.0 - share) * past + share * new).collect()
}

/// One realization's run so far: it grows, the ship does not restart.
#[derive(Clone, Debug, Default)]
pub struct GrowingRun {
    /// State at its first sample: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs and measured disturbances, N × exogenous, row-major; before a reacting part is run, those of an undisturbed ship.
    pub exogenous: Vec<f64>,
    /// Maneuver and first sample of every segment.
    segments: Vec<(usize, usize)>,
    /// The helm of every segment, with its samples.
    helms: Vec<(Helm, usize)>,
}

impl GrowingRun {
    /// Number of samples N.
    pub fn samples(&self, vessel: &Vessel) -> usize {
        self.exogenous.len() / vessel.model.exogenous().max(1)
    }

    /// Continues with `plan`, from the vessel's current state; a new run starts with the initial state of its
    /// first maneuver. `parts` has the realized maneuvers of other runs.
    ///
    /// # Errors
    /// A motion that the model cannot hold.
    pub fn extend(
        &mut self,
        vessel: &Vessel,
        generator: &Generator,
        parts: &mut Parts,
        plan: &[(usize, usize)],
    ) -> Result<(), Invalid> {
        parts.make(generator, plan)?;
        let (initial, inputs) = parts.joined(plan);
        if self.segments.is_empty() {
            self.initial = initial;
        }
        let mut start = self.samples(vessel);
        for (maneuver, samples) in plan {
            self.segments.push((*maneuver, start));
            start += samples;
        }
        self.exogenous.extend(vessel.model.undisturbed(&inputs));
        self.helms.extend(parts.helms(plan));
        Ok(())
    }

    /// Its commands.
    pub fn helm(&self) -> Helm {
        Helm::sequence(self.helms.clone())
    }

    /// As a run of `design` with its measured states, (N+1) × 3.
    pub fn recorded(
        &self,
        vessel: &Vessel,
        generator: &Generator,
        design: &str,
        run: u32,
        measured: Vec<f64>,
    ) -> Run {
        let own_loop = OwnLoop::new(vessel, self.initial, &self.helms);
        let instruments = own_loop.map(|own_loop| own_loop.instruments(&vessel.model, &self.exogenous));
        let segment = |(maneuver, start): &(usize, usize)| Segment {
            maneuver: generator.maneuvers()[*maneuver].name.clone(),
            start: *start,
        };
        Run {
            design: design.to_owned(),
            run: run as i32,
            segments: self.segments.iter().map(segment).collect(),
            exogenous: self.exogenous.clone(),
            instrument_exogenous: instruments.unwrap_or_default(),
            measured,
            initial: self.initial,
        }
    }
}

/// The knowledge of the parameters before a trial, and its update by estimates.
pub struct Knowledge {
    /// Parameters that crude models are drawn around.
    pub about: Vec<f64>,
    /// Standard deviation of the logarithm of crude over these.
    pub spread: f64,
    /// Least moduli that errors are relative to; 0 for none.
    pub floor: Vec<f64>,
    /// Seed of the draws.
    pub seed: u64,
}

impl Knowledge {
    /// The crude model of a realization.
    pub fn crude(&self, realization: u32) -> Vec<f64> {
        let mut normals = vec![0.0; self.about.len()];
        Streams::new(self.seed, "crude model").normals(realization, 0, &mut normals);
        self.about.iter().zip(normals).map(|(theta, z)| theta * libm::exp(self.spread * z)).collect()
    }

    /// The variance-weighted mean of the crude and the estimated parameters: the crude one's variance is
    /// (spread × parameter)², at least that of the floor.
    pub fn learnt(&self, crude: &[f64], estimate: &[f64], standard_errors: &[f64]) -> Vec<f64> {
        let between = |(i, error): (usize, &f64)| {
            let before = (self.spread * crude[i]).abs().max(self.floor[i]).powi(2);
            let sum = before + error * error;
            if sum > 0.0 { crude[i] + before / sum * (estimate[i] - crude[i]) } else { estimate[i] }
        };
        standard_errors.iter().enumerate().map(between).collect()
    }

    /// The sizes that errors of the parameters are relative to.
    pub fn sizes(&self, theta: &[f64]) -> Vec<f64> {
        theta.iter().zip(&self.floor).map(|(theta, floor)| theta.abs().max(*floor)).collect()
    }

    /// 2-norm over the parameters of `standard_errors` over the sizes of `theta`.
    pub fn relative(&self, standard_errors: &[f64], theta: &[f64]) -> f64 {
        let relative = standard_errors.iter().zip(self.sizes(theta)).map(|(error, size)| error / size);
        relative.map(|x| x * x).sum::<f64>().sqrt()
    }
}
