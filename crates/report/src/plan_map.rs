//! `map.svg`: the plan on its chart.

use std::collections::BTreeSet;

use chart::{Bounds, Causes, Class, GridCell, Invalid, Obstacles, Plane, Raster, Uncharted};
use study::documents::PlanDocument;
use trial::voyage::{Hull, Prepared, Sailing, Solved};
use trial::{Fix, Sample};

use crate::figures::map as figure;

/// Limits between the shades of depth [m].
const DEPTHS_M: [f64; 6] = [0.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Cells of a tube's raster along the longer side of the map.
const TUBE_CELLS: f64 = 560.0;

/// A planned trial to be drawn.
pub struct PlanMap<'a> {
    /// Chart and lattice.
    pub prepared: &'a Prepared,
    /// What is blocked.
    pub solved: &'a Solved,
    /// What is sailed.
    pub sailing: &'a Sailing,
    /// The plan.
    pub document: &'a PlanDocument,
}

impl PlanMap<'_> {
    /// The map as SVG.
    ///
    /// # Errors
    /// As [`figure::map_figure`].
    pub fn svg(&self) -> Result<String, Invalid> {
        figure::map_figure(&self.map())
    }

    fn map(&self) -> figure::Map {
        let Self { prepared, document, .. } = self;
        let bounds = self.frame();
        let ([west, south], [east, north]) = (bounds.min, bounds.max);
        figure::Map {
            title: if self.sailing.check.safe { "Planned trial" } else { "Planned trial, unsafe" }.to_owned(),
            description: format!(
                "{} steps, {} {}: {}",
                document.steps.len(),
                document.cost,
                document.cost_unit.name(),
                document.statement
            ),
            warning: (!self.sailing.check.safe).then(|| "Unsafe: the plan fails its own check".to_owned()),
            frame: figure::Frame { west, south, east, north },
            uncharted: prepared.chart.uncharted() == Uncharted::Obstacle,
            depth_limits_m: if prepared.chart.has_depth() { DEPTHS_M.to_vec() } else { Vec::new() },
            cells: self.cells(),
            areas: self.areas(&bounds),
            contours: self.contours(),
            margins: self.margins(),
            maneuvers: document.counts.iter().map(|(name, count)| (name.clone(), *count)).collect(),
            spots: self.spots(),
            names: self.names(&bounds),
            tube: self.tube(&bounds),
            corridors: self.corridors(),
            edge: self.ring(&prepared.brief.task.area.corners),
            speed_limits: prepared
                .brief
                .task
                .speed_limits
                .iter()
                .map(|own| self.ring(&own.corners))
                .collect(),
            tracks: self.tracks(),
            hulls: self.hulls(),
            start: self.sailing.sailed.samples.first().map(place),
            goal: self.end(),
            graticule: graticule(prepared.chart.plane(), &bounds),
        }
    }

    /// The lattice's area.
    fn frame(&self) -> Bounds {
        let grid = &self.prepared.grid;
        let corner =
            |i: f64, j: f64| [grid.origin_m[0] + grid.cell_m * i, grid.origin_m[1] + grid.cell_m * j];
        Bounds { min: corner(-0.5, -0.5), max: corner(grid.nx as f64 - 0.5, grid.ny as f64 - 0.5) }
    }

    /// Gridded charts, as classes on the raster of the obstacles.
    fn cells(&self) -> Option<figure::Cells> {
        let grids = self.prepared.chart.grids();
        if grids.is_empty() {
            return None;
        }
        let raster = self.solved.waters.transit().raster();
        let class = |k: usize| {
            let at = raster.node(k % raster.nx, k / raster.nx).map(|o| o + raster.cell_m / 2.0);
            grids.iter().find_map(|grid| match grid.at(at)? {
                GridCell::Missing => None,
                GridCell::Land => Some(figure::Class::Land),
                GridCell::Water => Some(figure::Class::Depth { least_m: 0.0 }),
                GridCell::Depth(least_m) => Some(figure::Class::Depth { least_m }),
            })
        };
        let classes = (0..raster.nx * raster.ny).map(class).collect();
        Some(figure::Cells { grid: raster, classes })
    }

    fn areas(&self, bounds: &Bounds) -> Vec<figure::Area> {
        let deep_m = self.prepared.brief.task.safety.trial_depth_m;
        let area = |polygon: chart::Polygon| {
            let class = match polygon.class {
                Class::Danger { least_m: Some(least_m) } if least_m >= deep_m => return None,
                Class::Danger { .. } if polygon.is_of_point => return None,
                Class::Danger { .. } => figure::Class::NoGo,
                Class::Land => figure::Class::Land,
                Class::NoGo => figure::Class::NoGo,
                Class::TransitOnly => return None,
                Class::Depth { least_m } => figure::Class::Depth { least_m: least_m? },
            };
            let mut rings = polygon.rings.into_iter();
            Some(figure::Area { class, ring: rings.next()?, holes: rings.collect() })
        };
        self.prepared.chart.drawn(bounds).into_iter().filter_map(area).collect()
    }

    fn contours(&self) -> Vec<figure::Contour> {
        let own = self.prepared.chart.contours().iter();
        own.map(|own| figure::Contour { depth_m: own.depth_m, line: own.line.clone() }).collect()
    }

    fn spots(&self) -> Vec<figure::Spot> {
        let spot = |own: &chart::Spot| figure::Spot {
            at: own.place,
            symbol: if own.sounding { figure::Symbol::Sounding } else { figure::Symbol::Danger },
            depth_m: own.called.depth_m,
            title: own.called.to_string(),
        };
        self.prepared.chart.spots().iter().map(spot).collect()
    }

    /// Names of areas, the largest first, each where its area is widest halfway up.
    fn names(&self, bounds: &Bounds) -> Vec<([f64; 2], String)> {
        let named = |polygon: chart::Polygon| {
            let Bounds { min, max } = polygon.bounds;
            let halfway = (min[1] + max[1]) / 2.0;
            let [west, east] = widest(&polygon.rings, halfway)?;
            let name = polygon.called.name.filter(|_| !polygon.is_of_point)?;
            let size = (max[0] - min[0]) * (max[1] - min[1]);
            Some((size, [(west + east) / 2.0, halfway], name.to_string()))
        };
        let mut all: Vec<_> = self.prepared.chart.drawn(bounds).into_iter().filter_map(named).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut seen = BTreeSet::new();
        all.retain(|(_, _, name)| seen.insert(name.clone()));
        all.into_iter().map(|(_, at, name)| (at, name)).collect()
    }

    /// What the hulls of the check's runs swept.
    fn tube(&self, bounds: &Bounds) -> Option<figure::Tube> {
        let side = (0..2).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
        let grid = Raster::covering(bounds, side / TUBE_CELLS).ok()?;
        let body = body(&self.prepared.brief.task.hull, grid.cell_m);
        let mut swept = vec![false; grid.nx * grid.ny];
        let own: Vec<Fix> = self.sailing.sailed.fixes().collect();
        for track in std::iter::once(&own).chain(&self.sailing.runs) {
            let mut last = [f64::INFINITY; 2];
            for Fix { pose, .. } in track {
                let place = [pose.y, pose.x];
                if libm::hypot(place[0] - last[0], place[1] - last[1]) < grid.cell_m / 2.0 {
                    continue;
                }
                last = place;
                let (sin, cos) = libm::sincos(pose.psi);
                let points =
                    body.iter().map(|[x, y]| [place[0] + x * sin + y * cos, place[1] + x * cos - y * sin]);
                let cells = points.filter_map(|point| grid.cell_at(point));
                cells.for_each(|(column, row)| swept[row * grid.nx + column] = true);
            }
        }
        let vessels = self.sailing.runs.len();
        (vessels > 0).then_some(figure::Tube { grid, swept, vessels })
    }

    /// As wide to each side as the passage plan tells.
    fn corridors(&self) -> Vec<Vec<[f64; 2]>> {
        let voyage = self.document.voyage.iter();
        let rings = voyage.flat_map(|voyage| voyage.passage.corridors(self.prepared.chart.plane()));
        rings.flatten().map(Vec::from).collect()
    }

    /// On the plane.
    fn ring(&self, corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let plane = self.prepared.chart.plane();
        corners.iter().map(|[longitude, latitude]| plane.to_plane(*longitude, *latitude)).collect()
    }

    /// What only depth (of water that is charted) or margin blocks.
    fn margins(&self) -> Vec<figure::Margin> {
        let margin = |purpose: figure::Purpose, obstacles: &Obstacles| {
            let raster = obstacles.raster();
            let own = |k: usize| {
                let (col, row) = (k % raster.nx, k / raster.nx);
                let causes = obstacles.causes(col, row);
                let solid = [Causes::LAND, Causes::NO_GO, Causes::UNCHARTED].iter().any(|c| causes.has(*c));
                obstacles.is_blocked(col, row) && !solid
            };
            let blocked = (0..raster.nx * raster.ny).map(own).collect();
            figure::Margin { purpose, grid: raster, blocked }
        };
        let waters = &self.solved.waters;
        vec![
            margin(figure::Purpose::Trial, waters.deepest(&self.prepared.rehearsed)),
            margin(figure::Purpose::Transit, waters.transit()),
        ]
    }

    fn tracks(&self) -> Vec<figure::Track> {
        let mut tracks: Vec<figure::Track> = Vec::new();
        let names: Vec<&String> = self.document.counts.keys().collect();
        let mut number = 0;
        let samples = &self.sailing.sailed.samples;
        let mut start = 0;
        for stretch in samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative) {
            let leg = &self.document.voyage.as_ref().map(|v| &v.legs[stretch[0].leg]);
            let maneuver = leg.and_then(|leg| names.iter().position(|name| **name == leg.name));
            let style = match (stretch[0].informative, maneuver) {
                (true, Some(maneuver)) => figure::TrackStyle::Maneuver(maneuver),
                (false, Some(_)) => figure::TrackStyle::RunIn,
                _ => figure::TrackStyle::Basic,
            };
            number += u32::from(stretch[0].informative);
            let end = start + stretch.len();
            let mut points: Vec<[f64; 2]> = stretch.iter().map(place).collect();
            points.extend(samples.get(end).map(place).or_else(|| self.end()));
            start = end;
            tracks.push(figure::Track { style, points, number: stretch[0].informative.then_some(number) });
        }
        tracks
    }

    fn end(&self) -> Option<[f64; 2]> {
        self.sailing.sailed.ends.last().map(|(pose, _)| [pose.y, pose.x])
    }

    /// The hull where a maneuver begins.
    fn hulls(&self) -> Vec<Vec<[f64; 2]>> {
        let begins =
            self.sailing.sailed.samples.windows(2).filter(|pair| !pair[0].informative && pair[1].informative);
        let outline = self.prepared.brief.task.hull.outline();
        let corner = |sample: &Sample, [x, y]: [f64; 2]| {
            let (sin, cos) = libm::sincos(sample.pose.psi);
            [sample.pose.y + x * sin + y * cos, sample.pose.x + x * cos - y * sin]
        };
        begins.map(|pair| outline.iter().map(|p| corner(&pair[1], *p)).collect()).collect()
    }
}

fn place(sample: &Sample) -> [f64; 2] {
    [sample.pose.y, sample.pose.x]
}

/// Points of a hull, x forward and y to starboard, apart by no more than `apart_m`.
fn body(hull: &Hull, apart_m: f64) -> Vec<[f64; 2]> {
    let steps = |length: f64| (length / apart_m).ceil().max(1.0) as u32;
    let (long, wide) = (steps(hull.length_m), steps(hull.beam_m));
    let stern = -hull.length_m / 2.0 - hull.reference_m;
    let x = move |k: u32| stern + hull.length_m * f64::from(k) / f64::from(long);
    let y = move |k: u32| hull.beam_m * (f64::from(k) / f64::from(wide) - 0.5);
    (0..=long).flat_map(|i| (0..=wide).map(move |j| [x(i), y(j)])).collect()
}

/// The longest stretch of `rings`, filled by the even-odd rule, along the parallel at `y`.
fn widest(rings: &[Vec<[f64; 2]>], y: f64) -> Option<[f64; 2]> {
    let mut crossings: Vec<f64> = Vec::new();
    for ring in rings {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        crossings.extend(
            edges
                .filter(|(p, q)| (p[1] > y) != (q[1] > y))
                .map(|(p, q)| p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])),
        );
    }
    crossings.sort_by(f64::total_cmp);
    let stretches = crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    stretches.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// Longitudes and latitudes at round minutes.
fn graticule(plane: &Plane, bounds: &Bounds) -> figure::Graticule {
    let (west, south) = plane.to_geographic(bounds.min);
    let (east, north) = plane.to_geographic(bounds.max);
    let middle = [(west + east) / 2.0, (south + north) / 2.0];
    let lines = |from: f64, to: f64| {
        let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0].map(|minutes| minutes / 60.0);
        let step = steps.into_iter().find(|step| (to - from) / step <= 6.0).unwrap_or(1.0);
        (0..).map(move |k| (from / step).ceil() * step + f64::from(k) * step).take_while(move |at| *at <= to)
    };
    let label = |degrees: f64, names: [&str; 2]| {
        let minutes = (degrees.abs() * 600.0).round() / 10.0;
        let (whole, rest) = ((minutes / 60.0).floor(), minutes % 60.0);
        format!("{whole:.0}° {rest:.1}′ {}", names[usize::from(degrees < 0.0)])
    };
    figure::Graticule {
        x: lines(west, east).map(|lon| (plane.to_plane(lon, middle[1])[0], label(lon, ["E", "W"]))).collect(),
        y: lines(south, north)
            .map(|lat| (plane.to_plane(middle[0], lat)[1], label(lat, ["N", "S"])))
            .collect(),
    }
}
