use std::path::Path;

use design::{Bounds, CountOptions, Design, Length, Options, Segments, Streamed, counted, solve_streamed};
use files::{Digest, Provenance, Staged, commit, exists, read_document, stage_document, stage_set_document};
use maneuver::Generator;
use numerics::Watch;
use serde_json::json;
use ship::engine::refuse_endless;
use ship::model::Vessel;
use study::campaign_file::CampaignFile;
use study::documents::{DesignDocument, MomentsDocument, RefinedFiles, Solved};
use study::files::{StageOfTerms, is_guess, read_campaign, read_dictionary};
use study::moments_table::{MomentsTable, TableError, table_of};
use trial::campaign::Plan;
use trial::moments::{Moments, check_constants};
use trial::refining::{Limits, Refinement, RefinementStart, Refusal};

use crate::cli::{Common, beside, given};
use crate::design::{DesignArguments, Problem, no_criterion, no_design, scarce};
use crate::failure::{Failure, WorkProgress};
use crate::inputs;
use crate::simulate::Files;
use crate::stage::{Summary, Task};

/// The usual name of the document.
const MAIN: &str = "design.json";

impl Task for DesignArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        if let Some(design) = &self.refine {
            let (vessel, dictionary) =
                (given(&self.vessel, "vessel")?, given(&self.dictionary, "dictionary")?);
            let campaign = given(&self.campaign, "campaign")?;
            let design = design.as_path();
            return Refine { vessel, dictionary, design, campaign }.run(common);
        }
        self.check()?;
        let file = self.moments();
        let inputs = [file].into_iter().chain(self.available.as_deref()).chain(self.figures.as_deref());
        let out = common.main_output(MAIN, inputs)?;
        let loaded = read_document::<MomentsDocument>(file)?;
        let moments = loaded.data.moments().map_err(|e| Failure::invalid(file, &e))?;
        let moments = self.with_prior(moments)?;
        let mut provenance = common.provenance("design");
        provenance.made("moments", file, loaded.digest, &loaded.provenance)?;
        // The label of simulated logs is copied from the moments to the design.
        let label = loaded.provenance.settings.get_key_value("data");
        provenance.settings.extend(label.map(|(k, v)| (k.clone(), v.clone())));
        let seed = common.seed.unwrap_or(1);
        let (moments, streamed) = match moments.maneuvers.is_empty() && exists(table_of(file)) {
            true => self.streamed(moments, seed).map(|(moments, streamed)| (moments, Some(streamed)))?,
            false => (moments, None),
        };
        let document = design(self, (seed, streamed), &moments, &mut provenance)?;
        self.settings(seed, &moments, &mut provenance);
        commit(vec![stage_document(&out, &provenance, &document)?])?;
        let (status, gap, used) = (document.status, document.relative_gap, document.used());
        let details = json!({"status": status, "relative_gap": gap, "used": used});
        Ok(Summary::of(&out, document.summary(), details))
    }
}

impl DesignArguments {
    /// The maneuvers of the table that have a share, and the result over the whole table.
    fn streamed(&self, head: Moments, seed: u64) -> Result<(Moments, Streamed), Failure> {
        let limits =
            [(self.available.is_some(), "--available"), (self.most_maneuvers.is_some(), "--most-maneuvers")];
        if let Some((_, flag)) = limits.into_iter().find(|(given, _)| *given) {
            return Err(Failure::Usage(format!(
                "{flag}: found moments in a table, which is gone through without it, expected moments in a document; run `moments` \
                 without --keep table, or leave it out"
            )));
        }
        let table = MomentsTable::open(self.moments(), head, self.estimated())?;
        let streamed =
            solve_streamed(&table, &Options { seed, ..Options::default() }).map_err(|e| match e {
                TableError::Table(error) => error.into(),
                TableError::Design(error) => {
                    let dictionary = table.with(&[(0, 0)]).map_err(Failure::from).and_then(|moments| {
                        let dictionary = moments.dictionary(self.estimated());
                        dictionary.map_err(|e| Failure::invalid(self.moments(), &e))
                    });
                    match dictionary {
                        Ok(dictionary) => no_design(self.moments(), None, dictionary.explain(error)),
                        Err(failure) => failure,
                    }
                }
            })?;
        Ok((table.with(&streamed.members)?, streamed))
    }
}

/// The design of `moments`: criterion, stock, shares, counts, order.
fn design(
    a: &DesignArguments,
    (seed, streamed): (u64, Option<Streamed>),
    moments: &Moments,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let problem = Problem::read(a, seed, moments, provenance)?;
    let (dictionary, criterion) = (&problem.of.dictionary, &problem.of.criterion);
    let refuse = |e| problem.refuse(dictionary.explain(e));
    let options = Options { seed, ..Options::default() };
    let shortest = problem.shortest(&options)?;
    let length = match &shortest {
        Some((_, accuracy)) => Length { samples: Some(accuracy.samples as f64), segments: None },
        None => a.length(moments),
    };
    let available = match (&problem.of.stock, &a.available) {
        (Some(stock), Some(path)) => Some(stock.within(dictionary, &length).map_err(|e| scarce(path, e))?),
        _ => None,
    };
    let bounds = available.as_ref().map_or(Ok(Bounds::default()), |a| Bounds::new(&a.shares));
    let bounds = bounds.map_err(refuse)?;
    let (relaxed, accuracy) = match shortest {
        Some((design, accuracy)) => (design, Some(accuracy)),
        None => (criterion.solve(&bounds, &options).map_err(refuse)?, None),
    };
    let relaxed = match &streamed {
        // The same shares, with the certificate over all candidates.
        Some(Streamed { design, .. }) => Design { gap: design.gap, status: design.status, ..relaxed },
        None => relaxed,
    };
    let few = problem.few(&relaxed, &bounds, &options)?;
    let restricted = few.as_ref().map(|few| &few.design);
    let design = restricted.unwrap_or(&relaxed);
    let count_options = CountOptions { seed, ..CountOptions::default() };
    let figures = problem.of.figures(design, &bounds, length.samples, &options);
    let figures = figures.map_err(|e| no_criterion(a, e))?;
    let sequence = problem.arranged(design, length.samples, provenance)?;
    let segments = length.segments.map(|(total, samples)| {
        let segments = Segments::within((total, samples), available.as_ref(), restricted);
        let whole = counted(criterion, design, &segments, &count_options, dictionary.parameters());
        whole.map(|whole| (segments, whole))
    });
    Ok(Solved {
        dictionary,
        name: problem.of.wish.name,
        criterion,
        estimated: problem.of.wish.estimated,
        design,
        available: available.as_ref(),
        segments: segments.transpose().map_err(refuse)?,
        samples: length.samples,
        restricted: a.most_maneuvers.zip(few.as_ref()),
        figures,
        accuracy: accuracy.as_ref(),
        sequence,
        streamed: streamed.as_ref(),
        moments,
    }
    .into())
}

/// What `design --refine` reads.
struct Refine<'a> {
    vessel: &'a Path,
    dictionary: &'a Path,
    /// The design whose experiment is the start.
    design: &'a Path,
    campaign: &'a Path,
}

/// Most iterations of a search.
const ITERATIONS: usize = 3000;

impl Refine<'_> {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("design");
        let inputs = || [self.vessel, self.dictionary, self.design, self.campaign].into_iter();
        let out = common.main_output(MAIN, inputs())?;
        let others = ["inputs.csv", "refined-dictionary.toml"].map(|name| beside(&out, MAIN, name));
        for path in &others {
            Common { out: path.clone(), ..common.clone() }.main_output("", inputs())?;
        }
        let vessel = StageOfTerms::Refine.read(self.vessel, &mut provenance)?.with_disturbances_held();
        check_constants(&vessel.model).map_err(|e| Failure::invalid(self.vessel, &e))?;
        let refinement = search(self, &vessel, &mut provenance, common.quiet)?;
        settings(&refinement, &mut provenance);
        let is_guess = is_guess(self.vessel, &vessel);
        let files = RefinedFiles { vessel: &vessel, found: &refinement, is_guess };
        let [csv, dictionary] = &others;
        let refined = files.dictionary(&csv.file_name().unwrap_or_default().to_string_lossy());
        let mut staged = vec![
            Staged::bytes(csv, files.inputs().as_bytes())?,
            Staged::bytes(dictionary, refined.as_bytes())?,
        ];
        // The refined design belongs to the refined dictionary, no longer to the one that it was made of.
        if let Some(original) =
            provenance.inputs.insert("dictionary".into(), Digest::of_bytes(refined.as_bytes()))
        {
            provenance.inputs.insert("refined-from".into(), original);
        }
        let document = files.design();
        staged.push(stage_set_document(&out, &provenance, &document, &staged)?);
        commit(staged)?;
        let details = document.refined.as_ref().map(|refined| {
            json!({
                "before": refined.before.value, "after": refined.after.value, "worth": refined.worth,
                "iterations": refined.iterations, "settled": refined.settled,
            })
        });
        Ok(Summary::of(&out, document.summary(), details.unwrap_or_default()))
    }
}

/// Reads the design's experiment and its limits, and refines it.
fn search(
    a: &Refine<'_>,
    vessel: &Vessel,
    provenance: &mut Provenance,
    quiet: bool,
) -> Result<Refinement, Failure> {
    let generator = read_dictionary(a.dictionary, vessel, provenance)?;
    let config = read_campaign(a.campaign, provenance)?;
    let design = inputs::document(a.design, "design", provenance)?;
    let plan = plan(a, vessel, &generator, &config, &design)?;
    let noise = config.some_noise().map_err(|e| Failure::invalid(a.campaign, &e))?;
    let refused = |e| not_refined(a, e);
    let start = RefinementStart::new(vessel, &generator, &plan, noise).map_err(|e| files(a).refused(e))?;
    let (limits, start) = Limits::new(vessel, &generator, start).map_err(refused)?;
    let progress = WorkProgress::new("iterations, at most", ITERATIONS, quiet);
    let watch = Watch::new(move || {
        progress.advance(1);
        true
    });
    Refinement::search(vessel, start, limits, ITERATIONS, &watch).map_err(refused)
}

/// The experiment of the design in a campaign.
fn plan(
    a: &Refine<'_>,
    vessel: &Vessel,
    generator: &Generator,
    config: &CampaignFile,
    design: &DesignDocument,
) -> Result<Plan, Failure> {
    let samples = vessel.samples(config.duration_s);
    refuse_endless("`duration_s`", samples).map_err(|e| Failure::invalid(a.campaign, &e))?;
    let names: Vec<String> = generator.maneuvers().iter().map(|m| m.name.clone()).collect();
    design.designed().plan(&names, generator.tables(), samples).map_err(|e| files(a).refused(e))
}

fn files<'a>(a: &Refine<'a>) -> Files<'a> {
    let Refine { vessel, dictionary, design, campaign } = *a;
    Files { vessel, dictionary, campaign, sea: campaign, design }
}

/// The settings that the result depends on besides the inputs.
fn settings(found: &Refinement, provenance: &mut Provenance) {
    let settings = &mut provenance.settings;
    settings.insert("simulate_with".into(), json!(found.start.source));
    settings.insert("relative_to".into(), json!(found.start.source));
}

/// Why an experiment is not refined.
fn not_refined(a: &Refine<'_>, why: Refusal) -> Failure {
    match why {
        Refusal::Trial(why) => files(a).refused(why),
        Refusal::Limits(e) => Failure::invalid(a.dictionary, &e),
        Refusal::NotIdentifiable { parameter } => Failure::NoAnswer(format!(
            "{}: the design's experiment: found one that does not distinguish `{parameter}` from the other parameters, expected a \
             start that excites all; begin with another design",
            a.design.display()
        )),
    }
}
