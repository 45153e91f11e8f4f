//! What a plan on a chart starts from: files as read, and what the vessel can do on the lattice.

use std::path::Path;

use artifact::{Provenance, read_document, read_toml};
use chart::{Bounds, Chart, Plane};
use trial::{Approach, Grid, Piece, Repertoire, mirror};
use vessel::{Invalid, Motion, Steady, Streams, Vessel};

use super::chart_layers::{invalid, layers};
use super::config::PlanFile;
use super::counts::{Wanted, wanted};
use super::information::Information;
use super::moves::{Rehearsed, rehearse};
use super::places::Places;
use crate::failure::Failure;
use study::documents::DesignDocument;
use study::files::read_vessel;
use study::trajectories::{Layout, TrajectoryReader};
use vessel::Run;

/// How many vessels with other parameters rehearse every maneuver.
const OTHER_VESSELS: u32 = 16;

/// The files of a plan on a chart.
pub struct VoyageFiles<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `plan.toml`.
    pub config: &'a Path,
    /// The dictionary's trajectories.
    pub trajectories: &'a Path,
    /// `design.json`, for counts that follow from its shares.
    pub design: Option<&'a Path>,
}

/// Everything that was read, and what the vessel can do.
pub(super) struct Trial {
    pub(super) vessel: Vessel,
    pub(super) config: PlanFile,
    pub(super) chart: Chart,
    pub(super) grid: Grid,
    pub(super) wanted: Vec<Wanted>,
    pub(super) pieces: Vec<Piece>,
    pub(super) mirror: Vec<f64>,
    pub(super) known_current_m_s: [f64; 2],
    pub(super) rehearsed: Vec<Rehearsed>,
    pub(super) information: Vec<Information>,
    pub(super) design: Option<DesignDocument>,
    pub(super) dictionary: Vec<Run>,
}

impl Trial {
    /// Reads everything and rehearses every leg.
    pub(super) fn read(files: &VoyageFiles, provenance: &mut Provenance, seed: u64) -> Result<Self, Failure> {
        let vessel = read_vessel(files.vessel, provenance)?;
        let (config, digest) = read_toml::<PlanFile>(files.config)?;
        provenance.inputs.insert("plan".into(), digest);
        config.check().map_err(|e| Failure::invalid(files.config, &e))?;
        let dictionary = dictionary(files.trajectories, &vessel, provenance)?;
        let design = match files.design {
            Some(path) => {
                let loaded = read_document::<DesignDocument>(path)?;
                provenance.inputs.insert("design".into(), loaded.digest);
                Some(loaded.data)
            }
            None => None,
        };
        let own = (files.trajectories, &dictionary[..]);
        let wanted = wanted(files.config, &config, &vessel, own, files.design.zip(design.as_ref()))?;
        let chart_layers = layers(files.config, &config, provenance)?;
        let (chart, grid) = grid(files.config, &config, &vessel, &chart_layers)?;
        let pieces: Vec<Piece> = wanted.iter().map(|w| w.piece.clone()).collect();
        let information = pieces.iter().map(|piece| Information::of_piece(&vessel, piece)).collect();
        let known_current_m_s = config.known_current.map_or([0.0; 2], |c| {
            let (sin, cos) = c.towards_deg.to_radians().sin_cos();
            [c.speed_m_s * cos, c.speed_m_s * sin]
        });
        let signs = mirror(&vessel);
        let mut trial = Self {
            mirror: signs.clone().unwrap_or_default(),
            vessel,
            config,
            chart,
            grid,
            wanted,
            pieces,
            known_current_m_s,
            rehearsed: Vec::new(),
            information,
            design,
            dictionary,
        };
        trial.rehearsed =
            trial.rehearse(signs.as_deref(), seed).map_err(|e| Failure::invalid(files.config, &e))?;
        Ok(trial)
    }

    fn rehearse(&self, mirror: Option<&[f64]>, seed: u64) -> Result<Vec<Rehearsed>, Invalid> {
        let approach = Approach {
            run_in_s: self.config.approach.run_in_s,
            tolerance_m: self.config.approach.tolerance_cells * self.config.cell_m,
            tolerance_rad: self.config.approach.tolerance_deg.to_radians(),
        };
        let repertoire = Repertoire {
            vessel: &self.vessel,
            grid: &self.grid,
            handling: &self.config.handling,
            approach: &approach,
            pieces: &self.pieces,
            mirror,
            mean_current_m_s: self.known_current_m_s,
        };
        rehearse(&repertoire, &self.wanted, &self.other_vessels(seed))
    }

    /// Parameters off the nominal ones, each evenly within the stated error.
    fn other_vessels(&self, seed: u64) -> Vec<Vec<f64>> {
        const STEPS: u32 = 1 << 20;
        let (error, streams) = (self.config.safety.parameter_error, Streams::new(seed, "parameter-error"));
        let off = |draw: u32| 1.0 + error * (2.0 * (f64::from(draw) + 0.5) / f64::from(STEPS) - 1.0);
        let vessel = |run: u32| {
            let drawn = streams.choices(run, 0, STEPS, self.vessel.nominal.len());
            self.vessel.nominal.iter().zip(drawn).map(|(p, draw)| p * off(draw)).collect()
        };
        (0..if error > 0.0 { OTHER_VESSELS } else { 0 }).map(vessel).collect()
    }

    /// Names places on this lattice.
    pub(super) fn places<'a>(&'a self, files: &VoyageFiles<'a>) -> Places<'a> {
        Places { config_file: files.config, grid: &self.grid, plane: self.chart.plane() }
    }
}

/// All runs of the dictionary's trajectories.
fn dictionary(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Vec<Run>, Failure> {
    let reader = TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    reader.whole()?;
    provenance.inputs.insert("trajectories".into(), reader.digest());
    let mut runs = Vec::new();
    for block in 0..reader.blocks() {
        runs.extend(reader.runs(block)?);
    }
    Ok(runs)
}

/// The chart on its plane, and the lattice laid over `area`.
fn grid(
    file: &Path,
    config: &PlanFile,
    vessel: &Vessel,
    layers: &[chart::Layer],
) -> Result<(Chart, Grid), Failure> {
    let refuse = |e: chart::Invalid| invalid(file, &e);
    let a = config.area;
    let middle = [(a.west_deg + a.east_deg) / 2.0, (a.south_deg + a.north_deg) / 2.0];
    let plane = Plane::new(middle[0], middle[1]).map_err(refuse)?;
    let corners = [
        [a.west_deg, a.south_deg],
        [a.east_deg, a.south_deg],
        [a.west_deg, a.north_deg],
        [a.east_deg, a.north_deg],
    ]
    .map(|[lon, lat]| plane.to_plane(lon, lat));
    let least = |k: usize| corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
    let most = |k: usize| corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
    let count = |k: usize| ((most(k) - least(k)) / config.cell_m).floor();
    let cells = (count(0), count(1));
    if !(cells.0 >= 2.0 && cells.1 >= 2.0 && cells.0 * cells.1 <= 4e6) {
        let found = format!("{} × {} nodes", cells.0, cells.1);
        let expected = "from 2 × 2 to four million nodes";
        return Err(Failure::refuse(file, "`area` and `cell_m`", &found, expected, "correct one of them"));
    }
    let (nx, ny) = (cells.0 as usize, cells.1 as usize);
    let corner = [least(0), least(1)];
    let far = [corner[0] + nx as f64 * config.cell_m, corner[1] + ny as f64 * config.cell_m];
    let margin = config.safety.margin_m + 2.0 * config.cell_m + 1000.0;
    let bounds = Bounds::new(corner, far).map_err(refuse)?.grown(margin);
    let chart = Chart::new(plane, bounds, layers, config.uncharted).map_err(refuse)?;
    check_shown(file, config, layers, &chart)?;
    let modes = config.modes(can_hold(vessel));
    if modes.is_empty() {
        let expected = "at least one, for a vessel that cannot turn on the spot";
        return Err(Failure::refuse(file, "[[speed_mode]]", "none", expected, "add one"));
    }
    let origin_m = corner.map(|c| c + config.cell_m / 2.0);
    let grid = Grid { nx, ny, headings: config.headings, cell_m: config.cell_m, origin_m, modes };
    Ok((chart, grid))
}

/// Refuses charts of which none shows anything of the area: they are of another place, or in another system.
fn check_shown(
    file: &Path,
    config: &PlanFile,
    layers: &[chart::Layer],
    chart: &Chart,
) -> Result<(), Failure> {
    let a = config.area;
    let around = |layer: &chart::Layer| match layer {
        chart::Layer::Grid(_) => false,
        chart::Layer::Polygons(layer) => {
            let all = || layer.areas.iter().flat_map(|area| area.rings.iter().flatten());
            let low = |k: usize| all().map(|p| p[k]).fold(f64::INFINITY, f64::min);
            let high = |k: usize| all().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
            low(0) <= a.east_deg && high(0) >= a.west_deg && low(1) <= a.north_deg && high(1) >= a.south_deg
        }
    };
    if !chart.polygons().is_empty() || !chart.grids().is_empty() || layers.iter().any(around) {
        return Ok(());
    }
    let found = "nothing within `area`";
    let expected = "charts that cover the area, or lie around it";
    Err(Failure::refuse(
        file,
        "[[chart]]",
        found,
        expected,
        "check the charts' `crs`, and the corners of `area`",
    ))
}

/// Whether the vessel can be held at a place while it turns.
fn can_hold(vessel: &Vessel) -> bool {
    let mut unknowns = vec![0.0; vessel.model.inputs + 1];
    let turning = Motion { u: 0.0, v: Some(0.01), r: 0.01 };
    Steady::new(vessel, &vessel.nominal).solve(turning, &mut unknowns).is_ok()
}
