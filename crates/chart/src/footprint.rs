use crate::plane::{MOST_CELLS, Size, along, centres};
use crate::{Bounds, Invalid};

/// Cells that a hull sweeps, relative to a node of a raster.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    cell_m: f64,
    runs: Vec<Run>,
}

/// Cells `first..=last` of a row. Column 0 and row 0 are the cell north-east of the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Row, north of the node.
    pub row: i32,
    /// First column, east of the node.
    pub first: i32,
    /// Last column.
    pub last: i32,
}

/// x east, y north \[m\] of the node, compass heading \[rad\].
type Pose = (f64, f64, f64);

impl Footprint {
    /// All cells that any part of a hull touches on its way along poses.
    ///
    /// `hull`: corners of a simple polygon in body axes (x forward, y starboard \[m\]); `poses`: (x east, y
    /// north \[m\] of the node, compass heading \[rad\]); between poses the ship moves straight and turns
    /// evenly, the shorter way. The motion is divided so that no corner moves more than half a cell at a
    /// time, and the area that the edges sweep between two poses is covered as well, so nothing is missed.
    ///
    /// # Errors
    /// A hull of fewer than three corners, no pose, numbers that are not finite, a cell size that is not
    /// positive, or a motion too long for a raster.
    pub fn swept(hull: &[[f64; 2]], poses: &[Pose], cell_m: f64) -> Result<Self, Invalid> {
        check(hull, poses, cell_m)?;
        let radius = hull.iter().map(|p| libm::hypot(p[0], p[1])).fold(0.0, f64::max) / cell_m;
        let poses: Vec<Pose> = poses.iter().map(|p| (p.0 / cell_m, p.1 / cell_m, p.2)).collect();
        let hull: Vec<[f64; 2]> = hull.iter().map(|p| p.map(|v| v / cell_m)).collect();
        let mut canvas = Canvas::covering(&poses, radius, cell_m)?;
        canvas.fill(&placed(&hull, poses[0]));
        for pair in poses.windows(2) {
            canvas.sweep(&hull, radius, pair[0], pair[1]);
        }
        Ok(Self { cell_m, runs: canvas.runs() })
    }

    /// The union of both; unchanged if the cell sizes differ.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let others = if other.cell_m == self.cell_m { &other.runs[..] } else { &[] };
        Self::merged(self.cell_m, self.runs.iter().chain(others).copied().collect())
    }

    /// The footprint rotated to port by quarter turns about the node.
    #[must_use]
    pub fn turned(&self, quarters: usize) -> Self {
        let Some(more) = quarters.checked_sub(1) else { return self.clone() };
        let cell = |row: i32, column: i32| Run { row: column, first: -row - 1, last: -row - 1 };
        let all = self.runs.iter().flat_map(|run| (run.first..=run.last).map(|column| cell(run.row, column)));
        Self::merged(self.cell_m, all.collect()).turned(more)
    }

    fn merged(cell_m: f64, mut all: Vec<Run>) -> Self {
        all.sort_unstable_by_key(|run| (run.row, run.first));
        let mut runs: Vec<Run> = Vec::with_capacity(all.len());
        for run in all {
            match runs.last_mut() {
                Some(last) if last.row == run.row && run.first <= last.last.saturating_add(1) => {
                    last.last = last.last.max(run.last);
                }
                _ => runs.push(run),
            }
        }
        Self { cell_m, runs }
    }

    /// Side of the cells \[m\].
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The cells, by row and then by column, merged.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }
}

fn check(hull: &[[f64; 2]], poses: &[Pose], cell_m: f64) -> Result<(), Invalid> {
    let finite = hull.iter().flatten().all(|v| v.is_finite())
        && poses.iter().all(|p| p.0.is_finite() && p.1.is_finite() && p.2.is_finite());
    if finite && hull.len() >= 3 && !poses.is_empty() && cell_m.is_finite() && cell_m > 0.0 {
        return Ok(());
    }
    Err(Invalid::new(
        "footprint",
        format!("{} corners, {} poses, cells of {cell_m} m, finite: {finite}", hull.len(), poses.len()),
        "at least three corners and a pose, cells of a positive size, finite numbers",
        "correct the hull, the poses or the cell size",
    ))
}

/// Hull corners at a pose: the bow points to the compass heading.
fn placed(hull: &[[f64; 2]], (x, y, heading): Pose) -> Vec<[f64; 2]> {
    let (sin, cos) = libm::sincos(heading);
    hull.iter().map(|[ahead, right]| [x + ahead * sin + right * cos, y + ahead * cos - right * sin]).collect()
}

/// Cells around the node, as far as the hull reaches.
struct Canvas {
    first: [i32; 2],
    size: Size,
    slack: f64,
    covered: Vec<bool>,
}

impl Canvas {
    fn covering(poses: &[Pose], radius: f64, cell_m: f64) -> Result<Self, Invalid> {
        let points: Vec<[f64; 2]> = poses.iter().map(|p| [p.0, p.1]).collect();
        let reach = Bounds::enclosing(&points).map(|b| b.grown(radius + 1.0));
        let Bounds { min, max } = reach.unwrap_or(Bounds { min: [0.0; 2], max: [0.0; 2] });
        let count = [0, 1].map(|k: usize| max[k].floor() - min[k].floor() + 1.0);
        let far = min.iter().chain(&max).any(|v| v.abs() > f64::from(i32::MAX / 2));
        if far || count[0] * count[1] > MOST_CELLS as f64 {
            return Err(Invalid::new(
                "footprint",
                format!("{:.0} × {:.0} cells of {cell_m} m", count[0], count[1]),
                format!("up to {MOST_CELLS} cells"),
                "choose larger cells or shorter motions",
            ));
        }
        let size = Size { nx: count[0] as usize, ny: count[1] as usize };
        let first = min.map(|v| v.floor() as i32);
        Ok(Self { first, size, slack: 1e-6 / cell_m, covered: vec![false; size.nx * size.ny] })
    }

    fn local(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().map(|p| [p[0] - f64::from(self.first[0]), p[1] - f64::from(self.first[1])]).collect()
    }

    fn fill(&mut self, polygon: &[[f64; 2]]) {
        let ring = self.local(polygon);
        for (i, p) in ring.iter().enumerate() {
            self.segment(*p, ring[(i + 1) % ring.len()], self.slack);
        }
        let nx = self.size.nx;
        centres(&[ring], self.size, |row, first, last| {
            self.covered[row * nx + first..=row * nx + last].fill(true)
        });
    }

    fn segment(&mut self, a: [f64; 2], b: [f64; 2], slack: f64) {
        let nx = self.size.nx;
        along(a, b, slack, self.size, |row, first, last| {
            self.covered[row * nx + first..=row * nx + last].fill(true);
        });
    }

    /// Covers the area that the hull's edges sweep between two poses; the hull at the first one is covered already.
    ///
    /// In one step, a point of an edge leaves the straight line between its ends by up to r Δψ²/8: that is
    /// the slack. The quadrangle that the edge sweeps is then less than a cell wide, so its sides and
    /// diagonals touch every cell it touches.
    fn sweep(&mut self, hull: &[[f64; 2]], radius: f64, from: Pose, to: Pose) {
        let turn =
            (to.2 - from.2 + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        let moved = libm::hypot(to.0 - from.0, to.1 - from.1) + radius * turn.abs();
        let cuts = (2.0 * moved).ceil().max(1.0);
        let slack = self.slack + radius * (turn / cuts).powi(2) / 8.0;
        let mut before = self.local(&placed(hull, from));
        for cut in 1..=cuts as u64 {
            let t = cut as f64 / cuts;
            let pose = (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1), from.2 + t * turn);
            let after = self.local(&placed(hull, pose));
            for i in 0..hull.len() {
                let next = (i + 1) % hull.len();
                self.segment(before[i], after[i], slack);
                self.segment(after[i], after[next], slack);
                self.segment(before[i], after[next], slack);
                self.segment(after[i], before[next], slack);
            }
            before = after;
        }
    }

    fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        for (j, row) in (self.first[1]..).zip(self.covered.chunks(self.size.nx)) {
            let mut column = self.first[0];
            for run in row.chunk_by(|a, b| a == b) {
                let next = column + run.len() as i32;
                if run[0] {
                    runs.push(Run { row: j, first: column, last: next - 1 });
                }
                column = next;
            }
        }
        runs
    }
}
