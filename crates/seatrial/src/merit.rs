use estimation::pooled::{Covariance, Uncertain};
use maneuver::Generator;
use refusal::Invalid;
use ship::engine::Run;
use ship::model::Vessel;
use study::documents::{MeritDocument, MeritTableRow, SlopesAt};
use validation::merit::{Merit, Unsimulated};

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
        let parameters = self.generator.map_or(Vec::new(), |own| own.parameters().to_vec());
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
