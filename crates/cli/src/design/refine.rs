//! `design refine`: optimises the input signals of an experiment, starting from a design.

use std::path::PathBuf;

use clap::Parser;
use files::{Digest, Provenance, Staged, commit, stage_document, stage_set_document};
use maneuver::Generator;
use numerics::Watch;
use serde_json::json;
use ship::engine::refuse_endless;
use ship::model::Vessel;
use study::campaign_file::CampaignFile;
use study::design_files::read_limits;
use study::documents::{DesignDocument, RefinedFiles};
use study::files::{StageOfTerms, is_guess, read_campaign, read_dictionary};
use trial::campaign::Plan;
use trial::moments::check_constants;
use trial::refining::{Limits, Refinement, Refusal, Start, StatedLimits};

use crate::cli::{Common, beside};
use crate::failure::Failure;
use crate::inputs;
use crate::progress::Progress;
use crate::simulate::Files;
use crate::stage::{Summary, Task};

/// Improves the input signals of a designed trial, within limits of inputs and motion
#[derive(Parser)]
#[command(
    name = "refine",
    after_help = "Writes refined.json, and inputs.csv, refined-dictionary.toml and design.json for `simulate campaign`.\n\n\
    Example:\n  design refine --vessel vessel.toml --dictionary dictionary.toml --design design.json --campaign campaign.toml --out refined/"
)]
pub struct Refine {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    pub(super) vessel: PathBuf,
    /// The maneuvers that the design is of
    #[arg(long, value_name = "dictionary.toml")]
    pub(super) dictionary: PathBuf,
    /// The design whose experiment is the start
    #[arg(long, value_name = "design.json")]
    pub(super) design: PathBuf,
    /// Disturbances, and the experiment's duration
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// Limits: u_m_s, v_m_s, r_rad_s, tables `inputs` and `rates` (per second) by input; default: those of [generate] in the
    /// dictionary, else what the start reaches
    #[arg(long, value_name = "limits.toml")]
    pub(super) limits: Option<PathBuf>,
    /// Maximum number of iterations
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    iterations: u32,
}

impl Task for Refine {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("design refine");
        let inputs = || {
            let all = [&self.vessel, &self.dictionary, &self.design, &self.campaign];
            all.into_iter().chain(&self.limits)
        };
        let out = common.main_output("refined.json", inputs())?;
        let others = ["inputs.csv", "refined-dictionary.toml", "design.json"]
            .map(|name| beside(&out, "refined.json", name));
        for path in &others {
            Common { out: path.clone(), ..common.clone() }.main_output("", inputs())?;
        }
        let vessel = StageOfTerms::Refine.read(&self.vessel, &mut provenance)?.with_disturbances_held();
        check_constants(&vessel.model).map_err(|e| Failure::invalid(&self.vessel, &e))?;
        let found = search(self, &vessel, &mut provenance, common.quiet)?;
        settings(self, &found, &mut provenance);
        let is_guess = is_guess(&self.vessel, &vessel);
        let files = RefinedFiles { vessel: &vessel, found: &found, is_guess };
        let document = files.document();
        let [csv, dictionary, design] = &others;
        let refined = files.dictionary();
        // The refined design belongs to the refined dictionary, no longer to the original one.
        let mut of_design = provenance.clone();
        of_design.inputs.insert("dictionary".into(), Digest::of_bytes(refined.as_bytes()));
        let mut staged = vec![
            Staged::bytes(csv, files.inputs().as_bytes())?,
            Staged::bytes(dictionary, refined.as_bytes())?,
            stage_document(design, &of_design, &files.design(&document))?,
        ];
        staged.push(stage_set_document(&out, &provenance, &document, &staged)?);
        commit(staged)?;
        let details = json!({
            "before": document.before.value, "after": document.after.value, "worth": document.worth,
            "iterations": document.iterations, "settled": document.settled,
        });
        Ok(Summary::of(&out, document.summary(), details))
    }
}

/// Reads the design's experiment and its limits, and refines it.
fn search(
    a: &Refine,
    vessel: &Vessel,
    provenance: &mut Provenance,
    quiet: bool,
) -> Result<Refinement, Failure> {
    let generator = read_dictionary(&a.dictionary, vessel, provenance)?;
    let config = read_campaign(&a.campaign, provenance)?;
    let design = inputs::document(&a.design, "design", provenance)?;
    let plan = plan(a, vessel, &generator, &config, &design)?;
    let noise = config.some_noise().map_err(|e| Failure::invalid(&a.campaign, &e))?;
    let refused = |e| not_refined(a, e);
    let start = Start::new(vessel, &generator, &plan, noise).map_err(|e| files(a).refused(e))?;
    let model = &vessel.model;
    let inputs: Vec<&str> = model.variables[3..3 + model.inputs].iter().map(|v| v.name.as_str()).collect();
    let stated = match &a.limits {
        Some(path) => read_limits(path, &inputs, provenance)?,
        None => StatedLimits::default(),
    };
    let (limits, start) = Limits::new(&stated, vessel, &generator, start).map_err(refused)?;
    let progress = Progress::new("iterations, at most", a.iterations as usize, quiet);
    let watch = Watch::new(move || {
        progress.advance(1);
        true
    });
    Refinement::search(vessel, start, limits, a.iterations as usize, &watch).map_err(refused)
}

/// The experiment of the design in a campaign.
fn plan(
    a: &Refine,
    vessel: &Vessel,
    generator: &Generator,
    config: &CampaignFile,
    design: &DesignDocument,
) -> Result<Plan, Failure> {
    let samples = vessel.samples(config.duration_s);
    refuse_endless("`duration_s`", samples).map_err(|e| Failure::invalid(&a.campaign, &e))?;
    let names: Vec<String> = generator.maneuvers().iter().map(|m| m.name.clone()).collect();
    design.designed().plan(&names, generator.tables(), samples).map_err(|e| files(a).refused(e))
}

fn files(a: &Refine) -> Files<'_> {
    let (campaign, sea) = (&a.campaign, &a.campaign);
    Files { vessel: &a.vessel, dictionary: &a.dictionary, campaign, sea, design: &a.design }
}

/// The settings that the result depends on besides the inputs.
fn settings(a: &Refine, found: &Refinement, provenance: &mut Provenance) {
    let settings = &mut provenance.settings;
    settings.insert("simulate_with".into(), json!(found.start.source));
    settings.insert("relative_to".into(), json!(found.start.source));
    settings.insert("iterations".into(), json!(a.iterations));
}

/// Why an experiment is not refined.
fn not_refined(a: &Refine, why: Refusal) -> Failure {
    match why {
        Refusal::Trial(why) => files(a).refused(why),
        Refusal::Limits(e) => Failure::invalid(a.limits.as_ref().unwrap_or(&a.dictionary), &e),
        Refusal::NotIdentifiable { parameter } => Failure::NoAnswer(format!(
            "{}: the design's experiment: found one that does not distinguish `{parameter}` from the other parameters, expected a \
             start that excites all; begin with another design",
            a.design.display()
        )),
    }
}
