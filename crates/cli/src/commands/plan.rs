//! `plan`: one trajectory with every maneuver as often as the design requires.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Parser;
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

use crate::cli::{Allowed, Common, LimitFlags, Limits, allowance, beside, budget, given};
use crate::failure::{Failure, on_stderr};
use crate::inputs;
use crate::stage::{Summary, Task};

/// Plans a trial on a chart, or the rest of one: the provably shortest track, with routes; or solves a lattice problem
#[derive(Parser)]
#[command(
    name = "plan",
    after_help = "Example:\n  plan --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --out out/helsinki/plan.json\n  \
    plan --problem fixtures/lattice/channel.json --out plan.json\n  \
    plan --rest-of plan.json --from positions.csv --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml \
    --set plan.safety.runs=64 --out rest/plan.json\n  \
    plan --rest-of plan.json --from 24.96,60.14,135,half --done 4 --vessel vessel.toml --trajectories dictionary.parquet \
    --config plan.toml --out rest/plan.json\n\n\
    Beside the plan of a trial stand track.parquet, track.geojson, route.rtz, .gpx and .plan, map.json (what the map \
    shows) and map.svg.\n\n\
    positions.csv has the columns time (seconds since the departure, or 2026-06-01T08:00:00Z), longitude_deg, latitude_deg and, \
    if known, heading_deg and speed_m_s. By positions, `begun` of the plan of the rest says what is done, and how much of \
    the information it has.\n\n\
    --memory-mib counts every phase, and 24 MiB of the program's own; without it 4096 MiB at most."
)]
pub struct PlanArguments {
    /// A lattice problem to solve instead of a chart (schema experiment-lattice-planning/1)
    #[arg(long, value_name = "problem.json", conflicts_with_all = ["vessel", "trajectories", "config", "dictionary", "design", "keep", "rest_of", "from", "done"])]
    problem: Option<PathBuf>,
    /// A plan that was begun: plans the rest, where the trial was interrupted or driven off, or has a maneuver to repeat
    #[arg(long, value_name = "plan.json", requires = "from")]
    rest_of: Option<PathBuf>,
    /// Where the ship is: her positions since the departure (a table, or NMEA 0183 in a file called .nmea); or the place where
    /// she continues, in degrees, and her speed mode if she is under way
    #[arg(long, value_name = "positions.csv|LON,LAT,HEADING[,MODE]", requires = "rest_of", value_parser = whereabouts, allow_hyphen_values = true)]
    from: Option<Whereabouts>,
    /// How many steps of the plan are done, if --from is a place; maneuvers among them are not repeated
    #[arg(long, value_name = "STEPS", requires = "rest_of")]
    done: Option<usize>,
    /// The vessel, or the model identified so far
    #[arg(long, visible_alias = "model", required_unless_present = "problem", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers' trajectories (simulate dictionary)
    #[arg(long, required_unless_present = "problem", value_name = "dictionary.parquet")]
    trajectories: Option<PathBuf>,
    /// Chart, lattice, safety, counts, start and goal; of a rest, as the plan was made with
    #[arg(long, required_unless_present = "problem", value_name = "plan.toml")]
    config: Option<PathBuf>,
    /// The design, for counts that follow from its shares
    #[arg(long, value_name = "design.json", conflicts_with_all = ["rest_of", "from", "done"])]
    design: Option<PathBuf>,
    /// The dictionary of the trajectories: maneuvers that react to the ship are sailed by their own commands
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Accepts what is refused otherwise; the outputs say so
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = allowance(&[Allowed::Mixed, Allowed::BeyondRange, Allowed::Unsafe]))]
    allow: Vec<Allowed>,
    /// Write the lattice problem that was solved as problem.json, too: for other solvers, and for --problem
    #[arg(long, value_parser = ["problem"])]
    keep: Option<String>,
    #[command(flatten)]
    limits: LimitFlags,
}

/// What says where a ship is.
#[derive(Clone)]
enum Whereabouts {
    /// The place where she continues.
    Place(Place),
    /// The file of her positions.
    Positions(PathBuf),
}

/// A place, if there are two commas or more in `text`, and a number before the first; else a file.
fn whereabouts(text: &str) -> Result<Whereabouts, String> {
    let mut cells = text.split(',');
    let begins_with_number = cells.next().is_some_and(|first| first.trim().parse::<f64>().is_ok());
    match begins_with_number && cells.count() >= 2 {
        true => place(text).map(Whereabouts::Place),
        false => Ok(Whereabouts::Positions(PathBuf::from(text))),
    }
}

impl Task for PlanArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        if let Some(problem) = &self.problem {
            let limits = self.limits.limits(common)?;
            let out = common.main_output(MAIN, [problem])?;
            return plan_problem(problem, &out, &limits, common.provenance("plan"));
        }
        let files = VoyageFiles {
            vessel: given(&self.vessel, "vessel")?,
            config: given(&self.config, "config")?,
            trajectories: given(&self.trajectories, "trajectories")?,
            dictionary: self.dictionary.as_deref(),
            design: self.design.as_deref(),
            beyond_range: self.allow.contains(&Allowed::BeyondRange),
            begun: self.begun()?,
        };
        let out = common.main_output(MAIN, files.inputs())?;
        self.plan_voyage(&files, &out, common)
    }
}

impl PlanArguments {
    /// The plan that was begun, and what is known of it.
    fn begun(&self) -> Result<Option<Begun<'_>>, Failure> {
        let (Some(plan), Some(from)) = (&self.rest_of, &self.from) else { return Ok(None) };
        let so_far = match (from, self.done) {
            (Whereabouts::Place(place), Some(done)) => SoFar::Steps(done, place),
            (Whereabouts::Positions(positions), None) => SoFar::Positions(FollowFiles { plan, positions }),
            (Whereabouts::Place(_), None) => {
                let (found, expected) =
                    ("none with a place as --from", "how many steps of the plan are done");
                let remedy = "add --done STEPS, or name a file of positions";
                return Err(Failure::Usage(format!("--done: found {found}, expected {expected}; {remedy}")));
            }
            (Whereabouts::Positions(file), Some(_)) => {
                let expected = "LONGITUDE,LATITUDE,HEADING[,MODE] with --done";
                let remedy = "name a place, or leave --done out: positions say what is done";
                let named = file.display();
                return Err(Failure::Usage(format!(
                    "--from: found file {named}, expected {expected}; {remedy}"
                )));
            }
        };
        Ok(Some(Begun { plan, so_far }))
    }

    /// Plans a trial and writes `plan.json` to `out`, and next to it track, routes and map.
    fn plan_voyage(&self, files: &VoyageFiles, out: &Path, common: &Common) -> Result<Summary, Failure> {
        let (limits, seed) = (self.limits.limits(common)?, common.seed.unwrap_or(1));
        let mut provenance = common.provenance("plan");
        provenance.settings.insert("seed".into(), json!(seed));
        let refuse = |error| files.refused(error);
        let (brief, config, followed) = files.read(out, &mut provenance, seed)?;
        let means = (budget(), &(|| limits.keep_going()) as &(dyn Fn() -> bool + Sync));
        let trial = ChartedTrial::on_charts(brief, (files.config, &config), means, &mut provenance);
        let trial = trial.map_err(refuse)?;
        files.check_inputs(&config, out)?;
        let mut said = String::new();
        let mut staged = Vec::new();
        if let (Some(followed), Some(Begun { so_far: SoFar::Positions(positions), .. })) =
            (&followed, &files.begun)
        {
            trial.check_afloat(positions, followed, &|| limits.keep_going()).map_err(refuse)?;
            let begun = &followed.begun;
            let doubts = begun.doubts.iter().filter(|_| !limits.quiet);
            doubts.for_each(|doubt| on_stderr(format_args!("plan: {doubt}")));
            if begun.status != FollowStatus::UnderWay {
                commit(vec![stage_document(out, &provenance, &PlanDocument::done(begun.clone()))?])?;
                let details = json!({"status": begun.status, "step": begun.step});
                return Ok(Summary::of(out, &begun.statement, details));
            }
            said = format!("{}; ", begun.summary());
        }
        let searched = limits.before_check();
        let (watch, keep_going) = (&|| searched.watch(), &|| limits.keep_going());
        let search = Search { options: limits.options(), watch, keep_going };
        let mut planned = trial.plan(&search, self.allow.contains(&Allowed::Unsafe)).map_err(refuse)?;
        planned.document.begun = followed.map(|followed| followed.begun);
        planned.document.beyond = study::beyond(files.vessel, files.trajectories, None)?;
        if self.keep.is_some() {
            let cell_m = planned.prepared.brief.task.cell_m;
            let problem = ProblemFile::of(&planned.solved.problem, "trial on a chart", cell_m);
            let problem = problem.map_err(|e| Failure::invalid(files.config, &e))?;
            let bytes = serde_json::to_vec(&problem).unwrap_or_default();
            staged.push(Staged::bytes(beside(out, MAIN, PROBLEM), &bytes)?);
        }
        staged.extend(stage(&planned, out, &provenance)?);
        commit(staged)?;
        let document = &planned.document;
        document
            .messages()
            .filter(|_| !limits.quiet)
            .for_each(|chart| on_stderr(format_args!("plan: {chart}")));
        let (plan, details) = document.summary();
        Ok(Summary::of(out, said + &plan, details))
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

/// The lattice problem of a plan.
const PROBLEM: &str = "problem.json";

/// The files written next to `plan.json`.
const ADDITIONAL: [&str; 10] = [
    PROBLEM,
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.plan",
    "aborts.gpx",
    "aborts.geojson",
    "map.json",
    "map.svg",
];

impl<'a> VoyageFiles<'a> {
    /// The files that are read, but for the charts.
    fn inputs(&self) -> impl Iterator<Item = &'a Path> {
        let others = self.dictionary.into_iter().chain(self.design);
        let begun = self.begun.iter().flat_map(Begun::files);
        [self.vessel, self.config, self.trajectories].into_iter().chain(others).chain(begun)
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
    fn check_inputs(&self, config: &PlanFile, out: &Path) -> Result<(), Failure> {
        let folder = self.config.parent().unwrap_or(Path::new(""));
        let charts = config.chart.iter().map(|spec| folder.join(&spec.file));
        let inputs: Vec<PathBuf> = charts.chain(self.inputs().map(Path::to_path_buf)).collect();
        let outputs = ADDITIONAL.iter().map(|name| beside(out, MAIN, name)).chain([out.to_path_buf()]);
        for output in outputs.filter_map(|path| path.canonicalize().ok()) {
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
    let refused = |(name, invalid): (String, _)| {
        Failure::Failed(files::Error::invalid(beside(out, MAIN, &name), invalid).to_string())
    };
    let route = beside(out, MAIN, "route.rtz");
    let files = routes.files(&route.file_stem().unwrap_or_default().to_string_lossy()).map_err(refused)?;
    let stage = |(name, bytes): (String, Vec<u8>)| Ok(Staged::bytes(beside(out, MAIN, &name), &bytes)?);
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
