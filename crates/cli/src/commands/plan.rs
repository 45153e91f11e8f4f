//! `plan`: one trajectory with every maneuver as often as the design requires.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use files::{Provenance, Staged, commit, read_json, stage_document, stage_set_document};
use plan::lattice::{self, ProblemFile};
use plan::voyage::{Brief, Place, Search, Shares};
use report::plan_map;
use seatrial::{ChartedTrial, PlanError, Planned};
use serde_json::json;
use study::documents::{DesignDocument, FollowStatus, PlanDocument};
use study::files::{kept_to_data, read_model, read_plan, read_planned};
use study::plan::{
    Begun, FollowFiles, FollowedPlan, PlanFile, SoFar, Unplanned, in_tide, no_plan, of_problem, out_of_time,
    place, read_begun, too_large, uncertain, unplanned, unsafe_plan,
};
use study::track::stage_track;

use crate::cli::{Common, LimitFlags, Limits, beside, budget, check_positive, given};
use crate::failure::{Failure, on_stderr};
use crate::inputs;
use crate::stage::{Summary, Task};

/// Plans a trial on a chart: the provably shortest track, with routes for the bridge; or solves a lattice problem
#[derive(Parser)]
#[command(
    name = "plan",
    after_help = "Example:\n  plan --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --out out/helsinki/plan.json\n  \
    plan --problem fixtures/lattice/channel.json --out plan.json\n\n\
    Beside the plan of a trial stand track.parquet, track.geojson, route.rtz, .gpx and .plan, map.json (what the map \
    shows) and map.svg.\n\n\
    --memory-mib counts every phase, and 24 MiB of the program's own; without it 4096 MiB at most."
)]
pub struct PlanArguments {
    /// A lattice problem to solve instead of a chart (schema experiment-lattice-planning/1)
    #[arg(long, value_name = "problem.json", conflicts_with_all = ["vessel", "trajectories", "config", "dictionary", "design", "export_problem"])]
    problem: Option<PathBuf>,
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "problem", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers' trajectories (simulate dictionary)
    #[arg(long, required_unless_present = "problem", value_name = "dictionary.parquet")]
    trajectories: Option<PathBuf>,
    /// Chart, lattice, safety, counts, start and goal
    #[arg(long, required_unless_present = "problem", value_name = "plan.toml")]
    config: Option<PathBuf>,
    /// The design, for counts that follow from its shares
    #[arg(long, value_name = "design.json")]
    design: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// Options of planning a trial.
#[derive(clap::Args)]
struct How {
    /// The dictionary of the trajectories: maneuvers that react to the ship are sailed by their own commands
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Write a plan whose check runs aground or breaks the margin, too; every output is labelled as unsafe
    #[arg(long)]
    allow_unsafe: bool,
    /// Write the lattice problem that was solved, too: for other solvers, and for --problem
    #[arg(long, value_name = "problem.json")]
    export_problem: Option<PathBuf>,
    /// Allow inputs that the logs of a model from logs do not cover; plan and report say where maneuvers leave them
    #[arg(long)]
    beyond_range: bool,
    #[command(flatten)]
    limits: LimitFlags,
}

impl Task for PlanArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        if let Some(problem) = &self.problem {
            let limits = self.how.limits.limits(common)?;
            let out = common.main_output(MAIN, [problem])?;
            return plan_problem(problem, &out, &limits, common.provenance("plan"));
        }
        let files = VoyageFiles {
            vessel: given(&self.vessel, "vessel")?,
            config: given(&self.config, "config")?,
            trajectories: given(&self.trajectories, "trajectories")?,
            dictionary: self.how.dictionary.as_deref(),
            design: self.design.as_deref(),
            beyond_range: self.how.beyond_range,
            begun: None,
        };
        let out = common.main_output(MAIN, files.inputs())?;
        self.how.plan(&files, &out, common, "plan")
    }
}

impl How {
    /// Plans a trial on a chart.
    fn plan(
        &self,
        files: &VoyageFiles,
        out: &Path,
        common: &Common,
        stage: &str,
    ) -> Result<Summary, Failure> {
        let (limits, seed) = (self.limits.limits(common)?, common.seed.unwrap_or(1));
        let wanted = (out, self.export_problem.as_deref(), self.allow_unsafe);
        plan_voyage(files, wanted, &limits, seed, common.provenance(stage))
    }
}

/// The files of a plan that was begun.
#[derive(Args)]
struct Rest {
    /// The plan that was begun
    #[arg(long, value_name = "plan.json")]
    plan: PathBuf,
    /// The vessel, or the model identified so far
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers' trajectories (simulate dictionary)
    #[arg(long, value_name = "dictionary.parquet")]
    trajectories: PathBuf,
    /// Chart, lattice, safety, start and goal, as the plan was made with
    #[arg(long, value_name = "plan.toml")]
    config: PathBuf,
    #[command(flatten)]
    how: How,
}

impl Rest {
    fn plan(&self, so_far: SoFar, common: &Common, stage: &str) -> Result<Summary, Failure> {
        let begun = Begun { plan: &self.plan, so_far };
        let files = VoyageFiles {
            vessel: &self.vessel,
            config: &self.config,
            trajectories: &self.trajectories,
            dictionary: self.how.dictionary.as_deref(),
            design: None,
            beyond_range: self.how.beyond_range,
            begun: Some(begun),
        };
        let out = common.main_output(MAIN, files.inputs().chain(begun.files()))?;
        self.how.plan(&files, &out, common, stage)
    }
}

/// Plans the rest of a trial that was interrupted or driven off, or has a maneuver to repeat, from where the ship is
#[derive(Parser)]
#[command(
    name = "resume",
    after_help = "Example:\n  plan resume --plan out/helsinki/plan.json --done 4 --from 24.96,60.14,135,half \
    --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --out out/rest/plan.json"
)]
pub struct Resume {
    /// How many of its steps are done; maneuvers among them are not repeated
    #[arg(long, value_name = "STEPS")]
    done: usize,
    /// Where the ship goes on, in degrees, and its speed mode if it is under way
    #[arg(long, value_name = "LON,LAT,HEADING[,MODE]", value_parser = place, allow_hyphen_values = true)]
    from: Place,
    #[command(flatten)]
    rest: Rest,
}

impl Task for Resume {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        self.rest.plan(SoFar::Steps(self.done, &self.from), common, "plan resume")
    }
}

/// Finds where the ship is in a plan by her positions so far, and plans the rest from there
#[derive(Parser)]
#[command(
    name = "follow",
    after_help = "Example:\n  plan follow --plan out/helsinki/plan.json --positions positions.csv \
    --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --set plan.safety.runs=64 --out out/rest/plan.json\n\n\
    positions.csv has the columns time (seconds since the departure, or 2026-06-01T08:00:00Z), longitude_deg, latitude_deg and, \
    if known, heading_deg and speed_m_s. Beside the plan of the rest stands follow.json: what is done, and how much of the \
    information it has. With nothing left to plan, it stands alone."
)]
pub struct Follow {
    /// The positions since the departure: a table, or NMEA 0183 in a file called .nmea
    #[arg(long, value_name = "positions.csv")]
    positions: PathBuf,
    /// How far from its track a step may be sailed to count as done (default: tolerance, spread and what positions may be off)
    #[arg(long, value_name = "METRES")]
    within_m: Option<f64>,
    /// The longest time between two positions within a maneuver
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0)]
    max_gap_s: f64,
    #[command(flatten)]
    rest: Rest,
}

impl Task for Follow {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let Self { positions, within_m, max_gap_s, rest } = self;
        check_positive("--within-m", *within_m)?;
        check_positive("--max-gap-s", Some(*max_gap_s))?;
        let files = FollowFiles { plan: &rest.plan, positions, within_m: *within_m, max_gap_s: *max_gap_s };
        rest.plan(SoFar::Positions(files), common, "plan follow")
    }
}

/// The files of a plan on a chart.
struct VoyageFiles<'a> {
    /// `vessel.toml`.
    vessel: &'a Path,
    /// `plan.toml`.
    config: &'a Path,
    /// The dictionary's trajectories.
    trajectories: &'a Path,
    /// `dictionary.toml`, for maneuvers that react to the ship.
    dictionary: Option<&'a Path>,
    /// `design.json`, for counts that follow from its shares.
    design: Option<&'a Path>,
    /// Whether inputs may leave the range of the model's logs.
    beyond_range: bool,
    /// The plan of which this is the rest.
    begun: Option<Begun<'a>>,
}

/// The usual name of a plan.
pub const MAIN: &str = "plan.json";

/// Where the ship is in a plan that is followed.
const FOLLOWED: &str = "follow.json";

/// The files written next to `plan.json`.
const ADDITIONAL: [&str; 8] = [
    FOLLOWED,
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.plan",
    "map.json",
    "map.svg",
];

impl<'a> VoyageFiles<'a> {
    /// The files that are read, but for the charts and the plan to be resumed.
    fn inputs(&self) -> impl Iterator<Item = &'a Path> {
        let others = self.dictionary.into_iter().chain(self.design);
        [self.vessel, self.config, self.trajectories].into_iter().chain(others)
    }

    /// Why there is no plan of these files.
    fn refused(&self, error: PlanError) -> Failure {
        self::plan([self.config, self.trajectories], self.design, error)
    }

    /// Reads everything for a plan to be written to `out`, except its charts, and `plan.toml`, which names them.
    fn read(
        &self,
        out: &Path,
        provenance: &mut Provenance,
        seed: u64,
    ) -> Result<(Brief, PlanFile, Option<FollowedPlan>), Failure> {
        check_names(out)?;
        let vessel = read_planned(self.vessel, provenance)?;
        let vessel = kept_to_data(self.vessel, vessel, self.beyond_range)?;
        // What was made before the trial is of the vessel before it was identified.
        let of_model = self.begun.is_some() && read_model(self.vessel)?.is_some();
        let model = if of_model { provenance.inputs.remove("vessel") } else { None };
        let config = read_plan(self.config, provenance)?;
        let task = config.task(&vessel).map_err(|e| Failure::invalid(self.config, &e))?;
        let task = uncertain([self.config, self.vessel], &config, &vessel, task)
            .and_then(|task| in_tide(self.config, &config, task, provenance))?;
        let plan = self.begun.map(|begun| read_begun(begun.plan, of_model, provenance)).transpose()?;
        let begun = self.begun.as_ref().zip(plan.as_ref());
        let task = begun.map_or_else(|| Ok(task.clone()), |(begun, plan)| begun.task(plan, task.clone()))?;
        let dictionary = inputs::runs(self.trajectories, &vessel, provenance)?;
        let design = self.design.map(|path| inputs::document::<DesignDocument>(path, "design", provenance));
        let design = design.transpose()?.map(|d| Shares { order: d.order, share: d.shares });
        let (layers, programs) = (Vec::new(), BTreeMap::new());
        let mut brief = Brief { vessel, task, layers, chart_bytes: 0, dictionary, programs, design, seed };
        brief.programs = study::plan::programs(self.dictionary, &brief, provenance)?;
        let followed = match begun {
            Some((begun, plan)) => {
                begun.followed(plan, &mut brief, provenance).map_err(|error| self.refused(error.into()))?
            }
            None => None,
        };
        if let Some(model) = model {
            provenance.origins.remove("vessel");
            provenance.inputs.insert("vessel".to_owned(), model);
        }
        Ok((brief, config, followed))
    }

    /// Refuses to overwrite an input: those next to `out`, and charts by the name of an output.
    fn check_inputs(&self, config: &PlanFile, out: &Path, problem: Option<&Path>) -> Result<(), Failure> {
        let folder = self.config.parent().unwrap_or(Path::new(""));
        let charts = config.chart.iter().map(|spec| folder.join(&spec.file));
        let files = self.inputs().chain(self.begun.iter().flat_map(Begun::files));
        let inputs: Vec<PathBuf> = charts.chain(files.map(Path::to_path_buf)).collect();
        let outputs: Vec<PathBuf> =
            ADDITIONAL.iter().map(|name| beside(out, MAIN, name)).chain([out.to_path_buf()]).collect();
        if let Some(problem) = problem {
            let existing = problem.canonicalize().ok();
            let is = |path: &&PathBuf| {
                **path == problem || existing.is_some() && path.canonicalize().ok() == existing
            };
            if let Some(other) = inputs.iter().chain(&outputs).find(is) {
                return Err(Failure::Usage(format!(
                    "--export-problem: found {}, which is also an input or another output, expected another file; name one",
                    other.display()
                )));
            }
        }
        for output in outputs.into_iter().filter_map(|path| path.canonicalize().ok()) {
            let same = |input: &&PathBuf| input.canonicalize().is_ok_and(|path| path == output);
            if let Some(input) = inputs.iter().find(same) {
                return Err(Failure::Usage(format!(
                    "--out: found {}, an input that what is written beside it would replace, expected another folder; name one",
                    input.display()
                )));
            }
        }
        Ok(())
    }
}

/// Refuses a main output with the name of an additional one.
fn check_names(out: &Path) -> Result<(), Failure> {
    let name = ADDITIONAL.iter().find(|name| out.file_name().is_some_and(|last| last == **name));
    let Some(name) = name else { return Ok(()) };
    let message = "which is written beside it, expected another name; take plan.json";
    Err(Failure::Usage(format!("--out: found {name}, {message}")))
}

/// Why there is no plan of `plan.toml`, for the runs in `trajectories` and a design.
fn plan(paths: [&Path; 2], design: Option<&Path>, error: PlanError) -> Failure {
    match error {
        PlanError::File(error) => error.into(),
        PlanError::Voyage(error) => unplanned(paths, design, error).into(),
        PlanError::Unsafe(check) => unsafe_plan(paths[0], &check).into(),
    }
}

impl From<Unplanned> for Failure {
    fn from(why: Unplanned) -> Self {
        match why {
            Unplanned::File(error) => error.into(),
            Unplanned::NoAnswer(message) => Self::NoAnswer(message),
        }
    }
}

/// Plans a trial and writes `plan.json` to `out`, and next to it track, routes and map; the lattice problem that was solved to
/// `problem`; with `unsafe_too` also a plan that fails its check.
fn plan_voyage(
    files: &VoyageFiles,
    (out, problem, unsafe_too): (&Path, Option<&Path>, bool),
    limits: &Limits,
    seed: u64,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    provenance.settings.insert("seed".into(), json!(seed));
    let refuse = |error| files.refused(error);
    let (brief, config, followed) = files.read(out, &mut provenance, seed)?;
    let means = (budget(), &(|| limits.keep_going()) as &(dyn Fn() -> bool + Sync));
    let trial = ChartedTrial::on_charts(brief, (files.config, &config), means, &mut provenance);
    let trial = trial.map_err(refuse)?;
    files.check_inputs(&config, out, problem)?;
    let mut said = String::new();
    let mut staged = Vec::new();
    if let (Some(followed), Some(Begun { so_far: SoFar::Positions(positions), .. })) =
        (&followed, &files.begun)
    {
        trial.check_afloat(positions, followed, &|| limits.keep_going()).map_err(refuse)?;
        staged.push(stage_document(beside(out, MAIN, FOLLOWED), &provenance, &followed.document)?);
        let doubts = followed.document.doubts.iter().filter(|_| !limits.quiet);
        doubts.for_each(|doubt| on_stderr(format_args!("plan follow: {doubt}")));
        if followed.document.status != FollowStatus::UnderWay {
            commit(staged)?;
            let details = json!({"status": followed.document.status, "step": followed.document.step});
            return Ok(Summary::of(&beside(out, MAIN, FOLLOWED), &followed.document.statement, details));
        }
        said = format!("{}; ", followed.document.summary());
    }
    let searched = limits.before_check();
    let (watch, keep_going) = (&|| searched.watch(), &|| limits.keep_going());
    let search = Search { options: limits.options(), watch, keep_going };
    let mut planned = trial.plan(&search, unsafe_too).map_err(refuse)?;
    planned.document.beyond = study::beyond(files.vessel, files.trajectories, None)?;
    if let Some(path) = problem {
        let cell_m = planned.prepared.brief.task.cell_m;
        let problem = ProblemFile::of(&planned.solved.problem, "trial on a chart", cell_m);
        let problem = problem.map_err(|e| Failure::invalid(files.config, &e))?;
        staged.push(Staged::bytes(path, &serde_json::to_vec(&problem).unwrap_or_default())?);
    }
    staged.extend(stage(&planned, out, &provenance)?);
    commit(staged)?;
    let document = &planned.document;
    document.messages().filter(|_| !limits.quiet).for_each(|chart| on_stderr(format_args!("plan: {chart}")));
    let (plan, details) = document.summary();
    Ok(Summary::of(out, said + &plan, details))
}

/// All outputs.
fn stage(planned: &Planned, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
    let (map, others) = rayon::join(
        || stage_map(planned, out, provenance),
        || stage_track_and_routes(planned, out, provenance),
    );
    let mut staged = others?;
    staged.extend(map?);
    staged.push(stage_set_document(out, provenance, &planned.document, &staged)?);
    Ok(staged)
}

fn stage_track_and_routes(
    planned: &Planned,
    out: &Path,
    provenance: &Provenance,
) -> Result<Vec<Staged>, Failure> {
    let Some(routes) = planned.routes() else { return Ok(Vec::new()) };
    let names: Vec<String> = routes.voyage.legs.iter().map(|leg| leg.name.clone()).collect();
    let (track, vessel) = (beside(out, MAIN, "track.parquet"), &planned.prepared.brief.vessel);
    let track = stage_track([&track, out], provenance, vessel, routes.plane, &names, routes.sailed)?;
    let refused = |(name, invalid)| {
        Failure::Failed(files::Error::invalid(beside(out, MAIN, name), invalid).to_string())
    };
    let route = beside(out, MAIN, "route.rtz");
    let files = routes.files(&route.file_stem().unwrap_or_default().to_string_lossy()).map_err(refused)?;
    let stage = |(name, bytes): (&str, Vec<u8>)| Ok(Staged::bytes(beside(out, MAIN, name), &bytes)?);
    std::iter::once(Ok(track)).chain(files.into_iter().map(stage)).collect()
}

/// The map document, and the map that is drawn from it.
fn stage_map(planned: &Planned, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
    let Some(map) = planned.map() else { return Ok(Vec::new()) };
    let svg = plan_map(&map).map_err(|e| Failure::Failed(format!("map: {e}")))?;
    let document = stage_document(beside(out, MAIN, "map.json"), provenance, &map)?;
    Ok(vec![document, Staged::bytes(beside(out, MAIN, "map.svg"), svg.as_bytes())?])
}

/// Solves the problem in `file` and writes the plan to `out`.
fn plan_problem(
    file: &Path,
    out: &Path,
    limits: &Limits,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    let (parsed, digest) = read_json::<ProblemFile>(file)?;
    let demand = parsed.demand();
    if demand.bytes() > u128::from(limits.memory_bytes) {
        return Err(too_large(file, &demand).into());
    }
    let problem =
        parsed.into_problem_while(&|| limits.keep_going()).map_err(|e| Failure::invalid(file, &e))?;
    let problem = problem.ok_or_else(|| out_of_time(file, "the layout of the map"))?;
    let solution = lattice::plan(&problem, &limits.options(), &mut *limits.before_writing().watch())
        .map_err(|why| no_plan(file, &why))?;
    let document = of_problem(&problem, &solution);
    provenance.inputs.insert("problem".into(), digest);
    commit(vec![stage_document(out, &provenance, &document)?])?;
    let PlanDocument { status, cost, lower_bound, gap, .. } = &document;
    let steps = document.steps.len();
    let details =
        json!({"status": status, "cost": cost, "lower_bound": lower_bound, "gap": gap, "steps": steps});
    Ok(Summary::of(out, format!("{}, cost {cost}, {steps} steps", document.known()), details))
}
