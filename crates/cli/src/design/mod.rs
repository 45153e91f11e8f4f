//! `design`: the time of each maneuver, or the input signals themselves.

mod stage;

use std::path::{Path, PathBuf};

use clap::Parser;
use design::{
    Accuracy, AccuracyOf, Bounds, CriterionName, Design, Length, NoDesign, Options, Restricted, Scarce,
    Wanted,
};
use estimation::Estimator;
use files::Provenance;
use regression::MeanRemoval;
use seatrial::{Designing, Wish};
use serde_json::json;
use ship::model::Source;
use study::design_files::read_stock;
use study::figure_goals::{FigureGoals, FigureWeight, StatedAccuracy};
use study::files::{read_dictionary, read_planned};
use trial::arranging::{Arranged, Arranging};
use trial::moments::{Estimated, Moments, NoCriterion};

use crate::cli::{check_positive, choice, given};
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
    design --moments moments.json --criterion a-relative --relative-to value --out design.json\n  \
    design --refine design.json --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out refined/\n\n\
    With --refine inputs.csv and refined-dictionary.toml stand beside design.json, for `simulate campaign`."
)]
pub struct DesignArguments {
    /// The maneuvers' moments
    #[arg(long, required_unless_present = "refine", value_name = "moments.json")]
    moments: Option<PathBuf>,
    /// Improves the input signals of this design's experiment, within [limits] of the dictionary, or else those of [generate], or
    /// else what they reach
    #[arg(long, group = "of_ship", value_name = "design.json", requires_all = ["vessel", "dictionary", "campaign"],
        conflicts_with_all = ["moments", "criterion", "most_maneuvers", "accuracy", "figures", "weight", "available", "duration_s", "segments"])]
    refine: Option<PathBuf>,
    /// Disturbances and duration of the trial, for --refine
    #[arg(long, requires = "refine", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// How the estimator will remove the instruments' mean
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    mean_removal: MeanRemoval,
    /// What the shares are best for; all but d-hessian need moments made with --campaign (default: d-hessian; d for
    /// output-error; a-relative with --accuracy)
    #[arg(long, value_parser = choice(&CriterionName::ALL, CriterionName::name, CriterionName::description))]
    criterion: Option<CriterionName>,
    /// The estimator whose covariance the criterion is of; output-error needs moments made with --estimator output-error
    #[arg(long = "for", value_parser = choice(&Estimator::PREDICTED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Use at most so many maneuvers
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..))]
    most_maneuvers: Option<u64>,
    /// Find the shortest experiment of this standard error, relative to the parameters (--relative-to), and from which length on
    /// that holds; or of one of a figure of merit in its unit, repeatable
    #[arg(long, value_name = "SHARE|FIGURE=ERROR UNIT", conflicts_with_all = ["segments", "duration_s"])]
    accuracy: Vec<StatedAccuracy>,
    /// Figures of merit with their slopes, as `validate merit --slopes` writes them: says how well each will be known
    #[arg(long, value_name = "merit.json")]
    figures: Option<PathBuf>,
    /// Weight of a figure in the criterion `figures`, repeatable; without any it is 1, of those in --accuracy if there are such.
    /// Names as in merit.json: `advance`, `overshoot` for all its numbers, `circle/advance` of one maneuver, `all`
    #[arg(long, value_name = "FIGURE=NUMBER", requires = "figures")]
    weight: Vec<FigureWeight>,
    /// Which parameters the errors of a-relative are relative to
    #[arg(long, value_parser = choice(&Source::ALL, Source::name, relative_to), default_value = "nominal")]
    relative_to: Source,
    /// How much of each maneuver exists: tables `seconds` and `segments` by maneuver, or what `ingest` cut
    #[arg(long, value_name = "available.toml|ingest.json")]
    available: Option<PathBuf>,
    /// Length of the experiment, where --segments does not tell it [s]
    #[arg(long, value_name = "S", conflicts_with = "segments")]
    duration_s: Option<f64>,
    /// Find order and lengths of the maneuvers with the state carried over from one to the next; needs --vessel, --dictionary
    /// and the length of the experiment
    #[arg(long, group = "of_ship", requires_all = ["vessel", "dictionary"])]
    arrange: bool,
    /// The vessel, for --arrange and --refine
    #[arg(long, visible_alias = "model", value_name = "vessel.toml", requires = "of_ship")]
    vessel: Option<PathBuf>,
    /// The maneuvers, for --arrange and --refine
    #[arg(long, value_name = "dictionary.toml", requires = "of_ship")]
    dictionary: Option<PathBuf>,
    /// Find the best counts of this many whole segments
    #[arg(long, value_name = "N", requires = "segment_samples", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    segments: Option<u64>,
    /// Samples per segment
    #[arg(long, value_name = "N", requires = "segments", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    segment_samples: Option<u64>,
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

impl DesignArguments {
    /// The file of the moments, which there is without --refine.
    fn moments(&self) -> &Path {
        self.moments.as_deref().unwrap_or(Path::new("moments.json"))
    }

    /// Refuses invalid numbers.
    fn check(&self) -> Result<(), Failure> {
        check_positive("--duration-s", self.duration_s)?;
        let usage =
            |found: &str, expected: &str| Err(Failure::Usage(format!("{found}, expected {expected}")));
        match (self.accuracy.as_slice(), self.share(), &self.figures) {
            ([_, _, ..], Some(_), _) => {
                usage("--accuracy: found several, one a share", "one share, or figures")
            }
            ([_, ..], None, None) => {
                usage("--accuracy: found a figure without --figures", "its merit.json; add it")
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
    fn criterion_name(&self) -> Result<CriterionName, Failure> {
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
    fn estimated(&self) -> Estimated {
        match self.estimator {
            Estimator::OutputError => Estimated::OutputError,
            _ => Estimated::Iv(self.mean_removal),
        }
    }

    /// The accuracy of --accuracy, if it is given.
    fn wanted(&self) -> Option<Wanted> {
        let (accuracy, of) = match self.share() {
            None if self.accuracy.is_empty() => return None,
            None => (1.0, AccuracyOf::Figures),
            Some(share) => (share, AccuracyOf::Overall),
        };
        Some(Wanted { accuracy, of, longest_s: LONGEST_S })
    }

    /// The experiment's length, as far as it is given or needed: then that of the campaign's trials.
    fn length(&self, moments: &Moments) -> Length {
        let segments = self.segments.zip(self.segment_samples);
        let counted = segments.map(|(n, samples)| n as f64 * samples as f64);
        let duration_s = self.trial_s(moments);
        Length { samples: duration_s.map(|s| s * moments.sample_rate_hz).or(counted), segments }
    }

    /// The length of the trial \[s\]: --duration-s, or that of the campaign where only the campaign says one and one is needed.
    fn trial_s(&self, moments: &Moments) -> Option<f64> {
        let is_told = self.segments.is_some() || !self.accuracy.is_empty();
        let predicts = self.estimator == Estimator::OutputError && self.criterion == Some(CriterionName::D);
        let is_needed = self.arrange || self.counts_priors(moments) || predicts;
        let usual = || moments.disturbances.as_ref()?.trial_s.filter(|_| is_needed && !is_told);
        self.duration_s.or_else(usual)
    }

    /// Whether what is known of a ship before the trial counts, once.
    fn counts_priors(&self, moments: &Moments) -> bool {
        moments.prior.is_some() && self.estimator == Estimator::OutputError
    }

    /// `moments` with what the ship's priors add in a trial of the given length.
    fn with_prior(&self, moments: Moments) -> Result<Moments, Failure> {
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
    fn settings(&self, seed: u64, moments: &Moments, provenance: &mut Provenance) {
        let settings = &mut provenance.settings;
        settings.insert("seed".into(), json!(seed));
        let name = self.criterion_name().unwrap_or(CriterionName::DHessian);
        if name != CriterionName::DHessian {
            settings.insert("criterion".into(), json!(name));
        }
        if name == CriterionName::ARelative || self.share().is_some() {
            settings.insert("relative_to".into(), json!(self.relative_to));
        }
        if self.estimator == Estimator::OutputError {
            settings.insert("estimator".into(), json!(self.estimator));
        }
        for FigureWeight { name, weight } in &self.weight {
            settings.entry("weights".into()).or_insert_with(|| json!({}))[name.text()] = json!(weight);
        }
        if let Some(duration) = self.trial_s(moments) {
            settings.insert("duration_s".into(), json!(duration));
        }
    }
}

/// Why there is no design of the moments in `moments`, with the stock in the file `available`.
fn no_design(moments: &Path, available: Option<&Path>, why: NoDesign) -> Failure {
    let file = moments.display();
    match why {
        NoDesign::Unexcited { degree, parameter, regressor } => Failure::NoAnswer(format!(
            "{file}: parameter `{parameter}` ({degree}): found a direction that no maneuver excites, expected every parameter to \
             be excited by some maneuver; add a maneuver in which `{regressor}` varies independently of the other terms of \
             {degree}"
        )),
        NoDesign::Singular { degree, parameter } => Failure::NoAnswer(format!(
            "{file}: parameter `{parameter}` ({degree}): found a covariance that is singular, with no variance of its own, \
             expected the disturbances to reach every parameter; expect noise in {degree} too, or take --criterion d-hessian"
        )),
        NoDesign::Scarce(why) => scarce(available.unwrap_or(moments), why),
        NoDesign::OutOfReach(found) => Failure::NoAnswer(format!(
            "{file}: --accuracy: {found}; ask for that, or make more time or better maneuvers available"
        )),
        NoDesign::Search(other) => Failure::NoAnswer(format!(
            "{file}: design: found {other}, expected a convergent search; take another criterion or other maneuvers"
        )),
    }
}

/// Why the available maneuvers are not enough for an experiment.
fn scarce(file: &Path, why: Scarce) -> Failure {
    let usage = |table: &str, flags: &str| {
        Failure::Usage(format!(
            "--available: found `{table}` in {}, expected {flags} to relate them to; add it",
            file.display()
        ))
    };
    let too_little = |found: String, expected: String| {
        Failure::NoAnswer(format!(
            "{}: what is available: found {found}, expected at least {expected}; shorten the experiment or make more \
             available",
            file.display()
        ))
    };
    match why {
        Scarce::NoSegments => usage("segments", "--segments and --segment-samples"),
        Scarce::NoLength => usage("seconds", "--duration-s, or --segments and --segment-samples,"),
        Scarce::Time { share } => too_little(
            format!("{:.1} % of the experiment's time in all maneuvers together", 100.0 * share),
            "100 %".into(),
        ),
        Scarce::Segments { found, expected } => {
            too_little(format!("{found} whole segments"), expected.to_string())
        }
    }
}

/// Maneuvers and a criterion.
struct Problem<'a> {
    a: &'a DesignArguments,
    /// Of random starts and random designs.
    seed: u64,
    of: Designing<'a>,
}

impl<'a> Problem<'a> {
    fn read(
        a: &'a DesignArguments,
        seed: u64,
        moments: &'a Moments,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let (name, estimated) = (a.criterion_name()?, a.estimated());
        let wish = Wish { name, estimated, relative_to: a.relative_to, most_maneuvers: a.most_maneuvers };
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

    fn refuse(&self, why: NoDesign) -> Failure {
        no_criterion(self.a, why.into())
    }

    /// A design of the shortest experiment for the requested accuracy.
    fn shortest(&self, options: &Options) -> Result<Option<(Design, Accuracy)>, Failure> {
        let a = self.a;
        let Some(wanted) = a.wanted() else { return Ok(None) };
        let shortest = self.of.shortest(wanted, (a.mean_removal, self.seed), options);
        shortest.map_err(|e| no_criterion(a, e))
    }

    /// A design with few maneuvers, if requested.
    fn few(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        options: &Options,
    ) -> Result<Option<Restricted>, Failure> {
        self.of.few(relaxed, bounds, options).map_err(|e| {
            Failure::NoAnswer(format!(
                "{}: --most-maneuvers: found no choice of {} maneuvers that excites every parameter ({e}), expected one; allow more",
                self.a.moments().display(),
                self.a.most_maneuvers.unwrap_or_default()
            ))
        })
    }

    /// Order and lengths of the maneuvers of `design`, if requested.
    fn arranged(
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
            seed: self.seed,
        };
        let sequence = arranging.search(&design.shares, &design.sensitivities, samples.round() as usize);
        sequence.map(Some).map_err(|e| Failure::invalid(dictionary, &e))
    }
}

/// Why there is no criterion, or no design of it.
fn no_criterion(a: &DesignArguments, why: NoCriterion) -> Failure {
    match why {
        NoCriterion::Moments(e) => Failure::invalid(a.moments(), &e),
        NoCriterion::Design(e) => no_design(a.moments(), a.available.as_deref(), e),
    }
}
