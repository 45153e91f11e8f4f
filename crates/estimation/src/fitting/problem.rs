use numerics::statistics;
use ship::forces::Forces;

use crate::fitting::window::{Group, windows};
use crate::fitting::{Inputs, Prior, Recording, Settings, Unfit};

/// How long inputs before a window may act in it, where thrusters follow theirs late \[s\].
const HISTORY_S: f64 = 20.0;

/// As how many samples the first one of a window counts at most.
const MOST: f64 = 1e6;

/// Recordings that a force model is fitted to.
pub struct Problem<'a> {
    pub(crate) forces: &'a Forces,
    pub(crate) recordings: Vec<Recording<'a>>,
    pub(crate) settings: Settings,
    pub(crate) groups: Vec<Group>,
    pub(crate) priors: Vec<Option<Prior>>,
    /// Of u, v \[m/s\], r \[rad/s\].
    pub(crate) deviations: [f64; 3],
    /// Samples of all windows.
    pub(crate) samples: usize,
    pub(crate) width: usize,
    pub(crate) late: bool,
}

impl<'a> Problem<'a> {
    /// `forces` on `recordings`, whose rows have `width` inputs and measured disturbances. Priors are those of the model.
    ///
    /// # Errors
    /// No free number, no sample, or a state that does not vary.
    pub fn new(
        forces: &'a Forces,
        recordings: Vec<Recording<'a>>,
        width: usize,
        settings: Settings,
    ) -> Result<Self, Unfit> {
        if forces.parameters().is_empty() {
            return Err(Unfit::NoParameter);
        }
        let deviations = deviations(&recordings)?;
        let thrusters = &forces.description().thruster;
        let late = settings.inputs == Inputs::Linear
            && thrusters.iter().any(|own| own.lag_s.is_some() || own.dead_time_s.is_some());
        let before = if late { settings.samples(HISTORY_S) } else { 0 };
        let windows = windows(&recordings, &settings);
        let groups = Group::all(&windows, &recordings, width, before);
        let prior =
            |own: &ship::forces::Parameter| own.prior.map(|deviation| Prior { mean: own.nominal, deviation });
        let priors = forces.parameters().iter().map(prior).collect();
        let samples = windows.iter().map(|own| own.samples).sum();
        Ok(Self { forces, recordings, settings, groups, priors, deviations, samples, width, late })
    }

    /// The same with these priors, one for each free parameter.
    #[must_use]
    pub fn with_priors(self, priors: Vec<Option<Prior>>) -> Self {
        Self { priors, ..self }
    }

    /// Standard deviations of measured u, v \[m/s\] and r \[rad/s\], which errors are counted in.
    pub fn deviations(&self) -> [f64; 3] {
        self.deviations
    }

    /// Whether each row of inputs acts during its whole sample.
    pub fn are_inputs_held(&self) -> bool {
        self.settings.inputs == Inputs::Held
    }

    /// Number of windows.
    pub fn windows(&self) -> usize {
        self.groups.iter().map(|own| own.windows.len()).sum()
    }

    /// How many samples the first one of u, v and r counts as, where errors of the simulation are `rms` of the standard
    /// deviations: as often as noise is smaller than they are. Noise is what changes of the third order tell of it.
    pub(crate) fn first(&self, rms: [f64; 3]) -> [f64; 3] {
        let third = |own: &[[f64; 3]], d: usize| own[3][d] - own[0][d] - 3.0 * (own[2][d] - own[1][d]);
        [0, 1, 2].map(|d: usize| {
            let all = self.recordings.iter().flat_map(|own| own.measured.as_chunks::<3>().0.windows(4));
            let squares: Vec<f64> = all.map(|own| third(own, d).powi(2)).collect();
            let noise = statistics::mean(&squares).unwrap_or(0.0) / 20.0;
            let error = (rms[d] * self.deviations[d]).powi(2);
            (error / noise.max(f64::MIN_POSITIVE)).clamp(1.0, MOST)
        })
    }

    /// What the square of a prior's standardised distance costs: the weight over half the numbers at 1 Hz.
    pub(crate) fn prior_cost(&self) -> f64 {
        let numbers = 3.0 * self.samples as f64 * self.settings.sample_s;
        self.settings.prior_weight / (0.5 * numbers).max(1.0)
    }
}

/// Standard deviations of u, v, r after the first sample of each recording.
fn deviations(recordings: &[Recording]) -> Result<[f64; 3], Unfit> {
    if recordings.iter().all(|own| own.samples() == 0) {
        return Err(Unfit::NoSample);
    }
    let mut found = [0.0; 3];
    for (d, name) in ["u", "v", "r"].into_iter().enumerate() {
        let rows = recordings.iter().flat_map(|own| own.measured.as_chunks::<3>().0.iter().skip(1));
        let all: Vec<f64> = rows.map(|row| row[d]).collect();
        let mean = statistics::mean(&all).unwrap_or(0.0);
        let square = all.iter().map(|own| (own - mean) * (own - mean)).sum::<f64>() / all.len() as f64;
        found[d] = square.sqrt();
        if !(found[d] > 0.0 && found[d].is_finite()) {
            return Err(Unfit::Constant(name));
        }
    }
    Ok(found)
}
