//! The command line of `design`.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use design::{AccuracyOf, CriterionName, Dictionary, Length, Wanted};
use estimation::Estimator;
use files::Provenance;
use regression::MeanRemoval;
use serde_json::json;
use ship::model::Source;
use study::figure_goals::{FigureWeight, StatedAccuracy};
use trial::moments::{Estimated, Moments};

use crate::choice::choice;
use crate::cli::{check_positive, name_of};
use crate::failure::Failure;

/// The longest experiment for --accuracy \[s\]: a day.
const LONGEST_S: f64 = 86_400.0;

/// Finds how long to run which maneuver, so that the logs say most about the model: D-optimal shares of the time, or the
/// best by another criterion, with a certificate
#[derive(Parser)]
#[command(
    name = "design",
    after_help = "Example:\n  design --moments moments.json --out design.json\n  \
    design --moments moments.json --segments 5 --segment-samples 200 --out design.json\n  \
    design --moments moments.json --criterion a-relative --relative-to value --out design.json"
)]
pub struct Arguments {
    /// The maneuvers' moments
    #[arg(long, value_name = "moments.json")]
    pub(super) moments: PathBuf,
    /// How the estimator will remove the instruments' mean
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    pub(super) mean_removal: MeanRemoval,
    /// What the shares are best for; all but d-hessian need moments made with --campaign (default: d-hessian; d for
    /// output-error; a-relative with --accuracy)
    #[arg(long, value_parser = choice(&CriterionName::ALL, CriterionName::name, CriterionName::description))]
    pub(super) criterion: Option<CriterionName>,
    /// The estimator whose covariance the criterion is of; output-error needs moments made with --estimator output-error
    #[arg(long = "for", value_parser = choice(&Estimator::PREDICTED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    pub(super) estimator: Estimator,
    /// What disturbs an output-error estimate: measurement errors and the current, or measurement errors alone (then the problem
    /// is convex, and the certificate one of the global optimum)
    #[arg(long, value_enum, default_value_t = OutputNoise::All)]
    noise: OutputNoise,
    /// Use at most so many maneuvers
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) most_maneuvers: Option<u64>,
    /// Use a maneuver for at least so long or not at all; with --arrange of each piece, which is at least 15 % of its maneuver [s]
    #[arg(long, value_name = "S")]
    pub(super) minimal_s: Option<f64>,
    /// Find the shortest experiment of this standard error, relative to the parameters (--relative-to), and from which length on
    /// that holds; or of one of a figure of merit in its unit, repeatable
    #[arg(long, value_name = "SHARE|FIGURE=ERROR UNIT", conflicts_with_all = ["segments", "duration_s"])]
    pub(super) accuracy: Vec<StatedAccuracy>,
    /// Figures of merit with their slopes, as `validate merit --slopes` writes them: says how well each will be known
    #[arg(long, value_name = "merit.json")]
    pub(super) figures: Option<PathBuf>,
    /// Weight of a figure in the criterion `figures`, repeatable; without any it is 1, of those in --accuracy if there are such.
    /// Names as in merit.json: `advance`, `overshoot` for all its numbers, `circle/advance` of one maneuver, `all`
    #[arg(long, value_name = "FIGURE=NUMBER", requires = "figures")]
    pub(super) weight: Vec<FigureWeight>,
    /// The accuracy is that of every parameter, not of all together (the root of the sum of squares)
    #[arg(long, requires = "accuracy")]
    pub(super) per_parameter: bool,
    /// Which parameters the errors of a-relative are relative to
    #[arg(long, value_parser = choice(&Source::ALL, Source::name, relative_to), default_value = "nominal")]
    pub(super) relative_to: Source,
    /// How much of each maneuver exists: tables `seconds` and `segments` by maneuver, or what `ingest` cut
    #[arg(long, value_name = "available.toml|ingest.json")]
    pub(super) available: Option<PathBuf>,
    /// Length of the experiment, where --segments does not tell it [s]
    #[arg(long, value_name = "S", conflicts_with = "segments")]
    pub(super) duration_s: Option<f64>,
    /// Find order and lengths of the maneuvers with the state carried over from one to the next; needs --vessel, --dictionary
    /// and the length of the experiment
    #[arg(long, requires = "vessel", requires = "dictionary")]
    pub(super) arrange: bool,
    /// The vessel, for --arrange
    #[arg(long, visible_alias = "model", value_name = "vessel.toml", requires = "arrange")]
    pub(super) vessel: Option<PathBuf>,
    /// The maneuvers, for --arrange
    #[arg(long, value_name = "dictionary.toml", requires = "arrange")]
    pub(super) dictionary: Option<PathBuf>,
    /// Random starts besides equal shares
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub(super) starts: u32,
    /// Stop at this gap, relative to the dimension
    #[arg(long, value_name = "GAP", default_value_t = 1e-10)]
    pub(super) tolerance: f64,
    /// Find the best counts of this many whole segments
    #[arg(long, value_name = "N", requires = "segment_samples", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(super) segments: Option<u64>,
    /// Samples per segment
    #[arg(long, value_name = "N", requires = "segments", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(super) segment_samples: Option<u64>,
}

/// The disturbances of an output-error estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutputNoise {
    /// Measurement errors and the current
    All,
    /// Measurement errors alone
    Measurement,
}

/// The parameters that errors are relative to, in one line.
fn relative_to(source: Source) -> &'static str {
    match source {
        Source::Nominal => "The nominal ones",
        Source::Value => {
            "Those that the disturbances were linearised with: the true ones where they are known"
        }
    }
}

impl Arguments {
    /// Refuses invalid numbers.
    pub(super) fn check(&self) -> Result<(), Failure> {
        check_positive("--tolerance", Some(self.tolerance))?;
        check_positive("--duration-s", self.duration_s)?;
        check_positive("--minimal-s", self.minimal_s)?;
        let usage =
            |found: &str, expected: &str| Err(Failure::Usage(format!("{found}, expected {expected}")));
        match (self.accuracy.as_slice(), self.share(), &self.figures) {
            ([_, _, ..], Some(_), _) => {
                usage("--accuracy: found several, one a share", "one share, or figures")
            }
            ([_, ..], None, None) => {
                usage("--accuracy: found a figure without --figures", "its merit.json; add it")
            }
            ([_, ..], None, _) if self.per_parameter => {
                usage("--per-parameter: found an --accuracy of figures", "a share; leave one of them out")
            }
            _ if self.criterion == Some(CriterionName::Figures) && self.figures.is_none() => usage(
                "--criterion: found figures without --figures",
                "a file of them; add --figures merit.json",
            ),
            (_, share, _) => check_positive("--accuracy", share),
        }
    }

    /// The standard error that is wanted, relative to the parameters.
    fn share(&self) -> Option<f64> {
        self.accuracy.iter().find_map(StatedAccuracy::share)
    }

    /// The name of the requested criterion or the default.
    pub(super) fn criterion_name(&self) -> Result<CriterionName, Failure> {
        let usage = |found: &str, expected: &str| {
            Err(Failure::Usage(format!("--criterion: found {found}, expected {expected}; take another")))
        };
        let output_error = self.estimator == Estimator::OutputError;
        match self.criterion {
            Some(CriterionName::DHessian) if output_error => {
                usage("d-hessian for output-error, which has no instruments", "d, a, a-relative, v or figures")
            }
            Some(CriterionName::V) if !output_error => usage("v for iv", "v with --for output-error"),
            Some(CriterionName::DHessian) if !self.accuracy.is_empty() => Err(Failure::Usage(
                "--accuracy: found --criterion d-hessian, which predicts no standard errors, expected a criterion of the \
                 covariance; leave --criterion out or take a-relative"
                    .into(),
            )),
            Some(name) => Ok(name),
            None if self.share().is_some() => Ok(CriterionName::ARelative),
            None if !self.accuracy.is_empty() => Ok(CriterionName::Figures),
            None => Ok(self.estimated().d_optimal()),
        }
    }

    /// The estimator whose covariance the criterion uses.
    pub(super) fn estimated(&self) -> Estimated {
        match self.estimator {
            Estimator::OutputError => Estimated::OutputError { current: self.noise == OutputNoise::All },
            _ => Estimated::Iv(self.mean_removal),
        }
    }

    /// The experiment's duration, which --minimal-s needs.
    pub(super) fn few_duration(
        &self,
        dictionary: &Dictionary,
        length: &Length,
    ) -> Result<Option<f64>, Failure> {
        let duration = length.samples.map(|samples| samples / dictionary.sample_rate_hz);
        match (self.minimal_s, duration) {
            (Some(_), None) => Err(Failure::Usage(
                "--minimal-s: found no length of the experiment, expected one to relate it to; add --duration-s, or --segments and \
                 --segment-samples"
                    .into(),
            )),
            (Some(minimal), Some(duration)) if minimal > duration => Err(Failure::Usage(format!(
                "--minimal-s: found {minimal}, expected no more than the experiment's {duration} s; lower it"
            ))),
            _ => Ok(duration),
        }
    }

    /// The accuracy of --accuracy, if it is given.
    pub(super) fn wanted(&self) -> Option<Wanted> {
        let (accuracy, of) = match (self.share(), self.per_parameter) {
            (None, _) if self.accuracy.is_empty() => return None,
            (None, _) => (1.0, AccuracyOf::Figures),
            (Some(share), true) => (share, AccuracyOf::PerParameter),
            (Some(share), false) => (share, AccuracyOf::Overall),
        };
        Some(Wanted { accuracy, of, longest_s: LONGEST_S })
    }

    /// The experiment's length, as far as it is given or needed: then that of the campaign's trials.
    pub(super) fn length(&self, moments: &Moments) -> Length {
        let segments = self.segments.zip(self.segment_samples);
        let counted = segments.map(|(n, samples)| n as f64 * samples as f64);
        let duration_s = self.trial_s(moments);
        Length { samples: duration_s.map(|s| s * moments.sample_rate_hz).or(counted), segments }
    }

    /// The length of the trial \[s\]: --duration-s, or that of the campaign where only the campaign says one and one is needed.
    fn trial_s(&self, moments: &Moments) -> Option<f64> {
        let is_told = self.segments.is_some() || !self.accuracy.is_empty();
        let predicts = self.estimator == Estimator::OutputError && self.criterion == Some(CriterionName::D);
        let is_needed = self.arrange || self.minimal_s.is_some() || self.counts_priors(moments) || predicts;
        let usual = || moments.disturbances.as_ref()?.trial_s.filter(|_| is_needed && !is_told);
        self.duration_s.or_else(usual)
    }

    /// Whether what is known of a ship before the trial counts, once.
    fn counts_priors(&self, moments: &Moments) -> bool {
        moments.prior.is_some() && self.estimator == Estimator::OutputError
    }

    /// `moments` with what the ship's priors add in a trial of the given length.
    pub(super) fn with_prior(&self, moments: Moments) -> Result<Moments, Failure> {
        if !self.counts_priors(&moments) {
            return Ok(moments);
        }
        match self.length(&moments).samples {
            Some(samples) => Ok(moments.with_prior(samples)),
            None => Err(Failure::Usage(format!(
                "--duration-s: found no length of the trial, expected one, as the priors of {} count once for the whole trial; add \
                 --duration-s, or --segments and --segment-samples, in place of --accuracy",
                moments.vessel
            ))),
        }
    }

    /// The settings that the result depends on besides the inputs; a criterion only if it is not the default.
    pub(super) fn settings(&self, seed: u64, moments: &Moments, provenance: &mut Provenance) {
        let settings = &mut provenance.settings;
        settings.insert("seed".into(), json!(seed));
        settings.insert("starts".into(), json!(self.starts));
        settings.insert("tolerance".into(), json!(self.tolerance));
        let name = self.criterion_name().unwrap_or(CriterionName::DHessian);
        if name != CriterionName::DHessian {
            settings.insert("criterion".into(), json!(name));
        }
        if name == CriterionName::ARelative || self.share().is_some() {
            settings.insert("relative_to".into(), json!(self.relative_to));
        }
        if self.estimator == Estimator::OutputError {
            settings.insert("estimator".into(), json!(self.estimator));
            settings.insert("noise".into(), json!(name_of(self.noise)));
        }
        for FigureWeight { name, weight } in &self.weight {
            settings.entry("weights".into()).or_insert_with(|| json!({}))[name.text()] = json!(weight);
        }
        if let Some(duration) = self.trial_s(moments) {
            settings.insert("duration_s".into(), json!(duration));
        }
    }
}
