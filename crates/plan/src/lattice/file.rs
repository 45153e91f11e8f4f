use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::lattice::watch::Poll;
use crate::lattice::{Action, Cost, Demand, Goal, Invalid, Lattice, Move, MoveId, Pose, Problem};

/// The schema of [`ProblemFile`].
pub const SCHEMA: &str = "experiment-lattice-planning/1";

/// The schema of any document. Read this before [`ProblemFile`]: a newer version may have unknown fields.
#[derive(Clone, Debug, Deserialize)]
pub struct SchemaId {
    /// Name and version, such as `experiment-lattice-planning/1`.
    pub schema: String,
}

impl SchemaId {
    /// Refuses anything but [`SCHEMA`].
    ///
    /// # Errors
    /// Another schema or another version.
    pub fn check(&self) -> Result<(), Invalid> {
        if self.schema == SCHEMA {
            return Ok(());
        }
        let newer = self.schema.strip_prefix("experiment-lattice-planning/").and_then(|v| v.parse().ok());
        let remedy = match newer {
            Some(2u32..) => "use a newer version of the planner, or write the file again in version 1",
            _ => "give a lattice problem",
        };
        Err(Invalid::new("schema", &self.schema, SCHEMA, remedy))
    }
}

/// A planning problem with a map of boxes, all lengths in metres; x east, y north. Heading level h of H points
/// `360 h / H` degrees counter-clockwise from x.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// Name of the problem.
    pub name: String,
    /// What it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// For people; not read.
    #[serde(default, skip_serializing)]
    #[schemars(skip)]
    pub variant: Option<IgnoredAny>,
    /// Cells and heading levels.
    pub lattice: LatticeFile,
    /// Every swept box lies in this box, edges included \[m\].
    pub bounds: [f64; 4],
    /// Boxes that no swept box overlaps \[m\].
    pub obstacles: Vec<[f64; 4]>,
    /// Actions with a count.
    pub informative: Vec<InformativeFile>,
    /// Actions to use as one likes.
    pub basic: Vec<BasicFile>,
    /// `[i, j, h]`.
    pub start: [usize; 3],
    /// `[i, j, h]`.
    pub goal: [usize; 3],
    /// What others found; not read.
    #[serde(default, skip_serializing)]
    #[schemars(skip)]
    pub expected: Option<IgnoredAny>,
}

/// Size and place of the lattice.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LatticeFile {
    /// Number of cells along x.
    pub nx: usize,
    /// Number of cells along y.
    pub ny: usize,
    /// Number of heading levels.
    pub headings: usize,
    /// Distance of neighbouring nodes \[m\].
    pub cell: f64,
    /// Node (0, 0) \[m\].
    pub origin: [f64; 2],
}

/// An action with a count.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct InformativeFile {
    /// Unique name.
    pub name: String,
    /// How often a plan uses it, exactly.
    pub count: u32,
    /// Cost per use.
    #[serde(default)]
    pub cost: f64,
    /// What it does from which heading.
    pub moves: Vec<MoveFile>,
}

/// An action to use as one likes.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BasicFile {
    /// Unique name.
    pub name: String,
    /// Cost per use.
    pub cost: f64,
    /// What it does from which heading.
    pub moves: Vec<MoveFile>,
}

/// A move.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MoveFile {
    /// Heading level in which it starts.
    pub h: usize,
    /// Cells along x.
    pub di: i32,
    /// Cells along y.
    pub dj: i32,
    /// Heading level in which it ends.
    pub to_h: usize,
    /// Its own cost, where it is not that of its action.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// Boxes relative to the start node that the hull sweeps \[m\].
    pub swept: Vec<[f64; 4]>,
}

impl ProblemFile {
    /// The problem with its map turned into allowed moves. Informative actions of count 0 are left out.
    ///
    /// # Errors
    /// Another schema, a lattice without size, boxes that are inverted or not finite, and what [`Problem::new`] refuses.
    pub fn into_problem(&self) -> Result<Problem, Invalid> {
        let whole = self.into_problem_while(&|| true)?;
        whole.map_or_else(|| unreachable!("it is never cancelled"), Ok)
    }

    /// The demand of [`Self::into_problem`], known before the map is read.
    pub fn demand(&self) -> Demand {
        let lattice = Lattice { nx: self.lattice.nx, ny: self.lattice.ny, layers: self.lattice.headings };
        Demand::new(lattice, &self.actions().0)
    }

    /// [`Self::into_problem`] with a poll; `None` once `keep_going` returns false.
    ///
    /// # Errors
    /// As [`Self::into_problem`].
    pub fn into_problem_while(&self, keep_going: &dyn Fn() -> bool) -> Result<Option<Problem>, Invalid> {
        SchemaId { schema: self.schema.clone() }.check()?;
        self.check_map()?;
        self.check_moves()?;
        let lattice = Lattice { nx: self.lattice.nx, ny: self.lattice.ny, layers: self.lattice.headings };
        super::grid::lattice(&lattice)?;
        let (actions, moves) = self.actions();
        // Refuses a bad start or goal before the map is processed, and moves with it.
        super::grid::ends(&lattice, pose(self.start), &Goal::Poses(vec![pose(self.goal)]))?;
        let Some(free) = self.free_cells(&moves, keep_going) else { return Ok(None) };
        let mut poll = Poll::new(keep_going);
        let allowed =
            |id: MoveId, i: usize, j: usize| poll.proceed() && free[id.action][id.index][j * lattice.nx + i];
        let goal = Goal::Poses(vec![pose(self.goal)]);
        let problem = Problem::new(lattice, actions, pose(self.start), goal, allowed)?;
        Ok(Some(problem).filter(|_| !poll.stopped))
    }

    /// Name, count (none of a basic action), cost and moves of every action.
    fn all_actions(&self) -> impl Iterator<Item = (&String, Option<u32>, f64, &[MoveFile])> {
        let informative = self.informative.iter().map(|a| (&a.name, Some(a.count), a.cost, &a.moves[..]));
        informative.chain(self.basic.iter().map(|a| (&a.name, None, a.cost, &a.moves[..])))
    }

    /// Actions with their required counts, and their moves with swept boxes.
    fn actions(&self) -> (Vec<Action>, Vec<&[MoveFile]>) {
        let used = self.all_actions().filter(|(_, count, ..)| *count != Some(0));
        let build = |(name, count, cost, moves): (&String, Option<u32>, f64, &[MoveFile])| {
            let one = |m: &MoveFile| {
                let cost = Cost::primary(m.cost.unwrap_or(cost));
                Move { from: m.h, di: m.di, dj: m.dj, to: m.to_h, cost }
            };
            let moves = moves.iter().map(one).collect();
            Action { name: name.clone(), required: count.unwrap_or(0), moves }
        };
        used.map(|action| (build(action), action.3)).unzip()
    }

    /// By action, move and cell: whether the swept boxes are free. `None` if cancelled.
    fn free_cells(&self, all: &[&[MoveFile]], keep_going: &dyn Fn() -> bool) -> Option<Vec<Vec<Vec<bool>>>> {
        let cells = FreeCells::new(self.lattice);
        let of = |one: &MoveFile| keep_going().then(|| cells.of(&self.bounds, &self.obstacles, &one.swept));
        let of_action = |moves: &&[MoveFile]| moves.iter().map(of).collect();
        all.iter().map(of_action).collect()
    }

    fn check_map(&self) -> Result<(), Invalid> {
        let LatticeFile { cell, origin, .. } = self.lattice;
        if !(cell.is_finite() && cell > 0.0) {
            let expected = "a finite length above 0 m";
            return Err(Invalid::new("lattice.cell", cell.to_string(), expected, "give the cells' pitch"));
        }
        if !origin.iter().all(|value| value.is_finite()) {
            let value = format!("{origin:?}");
            let (expected, remedy) = ("finite coordinates", "give node (0, 0) in metres");
            return Err(Invalid::new("lattice.origin", value, expected, remedy));
        }
        check_box("bounds", &self.bounds)?;
        let mut obstacles = self.obstacles.iter().enumerate();
        obstacles.try_for_each(|(k, obstacle)| check_box(&format!("obstacles[{k}]"), obstacle))
    }

    fn check_moves(&self) -> Result<(), Invalid> {
        for (name, _, _, moves) in self.all_actions() {
            for (index, step) in moves.iter().enumerate() {
                let thing = format!("action {name}, move {index}");
                check_headings(&thing, step, self.lattice.headings)?;
                for (k, swept) in step.swept.iter().enumerate() {
                    check_box(&format!("{thing}, swept[{k}]"), swept)?;
                }
            }
        }
        Ok(())
    }
}

fn pose([i, j, layer]: [usize; 3]) -> Pose {
    Pose { i, j, layer }
}

fn check_headings(thing: &str, step: &MoveFile, headings: usize) -> Result<(), Invalid> {
    for (field, heading) in [("h", step.h), ("to_h", step.to_h)] {
        if heading >= headings {
            let expected = format!("a heading level below {headings}");
            let remedy = "levels count from 0";
            return Err(Invalid::new(format!("{thing}, {field}"), heading.to_string(), expected, remedy));
        }
    }
    Ok(())
}

fn check_box(thing: &str, bounds: &[f64; 4]) -> Result<(), Invalid> {
    let [xmin, ymin, xmax, ymax] = *bounds;
    if bounds.iter().all(|value| value.is_finite()) && xmin <= xmax && ymin <= ymax {
        return Ok(());
    }
    let expected = "finite [xmin, ymin, xmax, ymax] with min <= max";
    Err(Invalid::new(thing, format!("{bounds:?}"), expected, "order the box's corners"))
}

impl ProblemFile {
    /// `problem` on nodes `cell_m` apart, for other solvers: the same poses, moves, counts and (primary)
    /// costs. The map is not that of the sea: every move sweeps a small box in a strip of its own, with an
    /// obstacle at each node where it is not allowed.
    ///
    /// # Errors
    /// A goal that is not one pose, which the format cannot hold.
    pub fn of(problem: &Problem, name: &str, cell_m: f64) -> Result<Self, Invalid> {
        let goal = match problem.goal() {
            Goal::Poses(poses) if poses.len() == 1 => poses[0],
            other => {
                let given = match other {
                    Goal::Any => "any pose".to_owned(),
                    Goal::Poses(poses) => format!("{} poses", poses.len()),
                };
                let (wanted, remedy) = ("one pose, which is all that the format holds", "plan for one goal");
                return Err(Invalid::new("goal", given, wanted, remedy));
            }
        };
        let Lattice { nx, ny, layers: headings } = problem.lattice();
        let strips = Strips { problem, cell_m, width_m: 2.0 * nx as f64 * cell_m };
        let mut obstacles = Vec::new();
        let (mut informative, mut basic, mut strip) = (Vec::new(), Vec::new(), 0);
        for (action, wanted) in problem.actions().iter().enumerate() {
            let moves = (0..wanted.moves.len()).map(|index| {
                strips.add_obstacles(MoveId { action, index }, strip, &mut obstacles);
                strip += 1;
                strips.step(wanted, index, strip - 1)
            });
            let (name, moves) = (wanted.name.clone(), moves.collect());
            match wanted.required {
                0 => basic.push(BasicFile { name, cost: 0.0, moves }),
                count => informative.push(InformativeFile { name, count, cost: 0.0, moves }),
            }
        }
        let [right, top] = [strip as f64 * strips.width_m, ny as f64 * cell_m];
        let node = |pose: Pose| [pose.i, pose.j, pose.layer];
        Ok(Self {
            schema: SCHEMA.to_owned(),
            name: name.to_owned(),
            description: Some(
                "A level h is a heading in a speed mode. The boxes are no map: each move has a strip of its own along x.".to_owned(),
            ),
            variant: None,
            lattice: LatticeFile { nx, ny, headings, cell: cell_m, origin: [0.0; 2] },
            bounds: [-cell_m, -cell_m, right, top],
            obstacles,
            informative,
            basic,
            start: node(problem.start()),
            goal: node(goal),
            expected: None,
        })
    }
}

/// The positions of the strips.
struct Strips<'a> {
    problem: &'a Problem,
    cell_m: f64,
    width_m: f64,
}

impl Strips<'_> {
    fn step(&self, action: &Action, index: usize, strip: usize) -> MoveFile {
        let step = &action.moves[index];
        let (x, half) = (strip as f64 * self.width_m, 0.25 * self.cell_m);
        MoveFile {
            h: step.from,
            di: step.di,
            dj: step.dj,
            to_h: step.to,
            cost: Some(step.cost.primary),
            swept: vec![[x - half, -half, x + half, half]],
        }
    }

    /// A box for every run of neighbours along x from which the move would stay in the lattice and is not allowed.
    fn add_obstacles(&self, id: MoveId, strip: usize, obstacles: &mut Vec<[f64; 4]>) {
        let lattice = self.problem.lattice();
        let shape = &self.problem.actions()[id.action].moves[id.index];
        let forbidden = |i: usize, j: usize| {
            let pose = Pose { i, j, layer: shape.from };
            lattice.end(pose, shape).is_some() && !self.problem.is_allowed(pose, id)
        };
        for j in 0..lattice.ny {
            let mut i = 0;
            while i < lattice.nx {
                let run = (i..lattice.nx).take_while(|i| forbidden(*i, j)).count();
                if run > 0 {
                    obstacles.push(self.wall(strip, i, i + run - 1, j));
                }
                i += run + 1;
            }
        }
    }

    fn wall(&self, strip: usize, first: usize, last: usize, j: usize) -> [f64; 4] {
        let (x, half) = (strip as f64 * self.width_m, 0.25 * self.cell_m);
        let [first, last, y] = [first, last, j].map(|k| k as f64 * self.cell_m);
        [x + first - half, y - half, x + last + half, y + half]
    }
}

// Where the boxes that a move sweeps are free, for all cells at once.
//
// Boxes are `[xmin, ymin, xmax, ymax]` \[m\]. A swept box moves with the cell, so the cells at which it
// overlaps an obstacle form a rectangle of indices. The rectangles of a move are summed in a table of
// differences. The result equals a test of every cell, bit for bit.

/// A half-open range of indices.
type Span = std::ops::Range<usize>;

/// Reusable answer to "at which cells are these swept boxes free?".
#[derive(Clone, Debug)]
pub struct FreeCells {
    grid: LatticeFile,
    per_cell: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl FreeCells {
    /// A grid with `cell` above 0 and finite numbers.
    pub fn new(grid: LatticeFile) -> Self {
        let nodes = |axis: usize, count: usize| {
            (0..count).map(|k| grid.origin[axis] + grid.cell * k as f64).collect()
        };
        Self { grid, per_cell: 1.0 / grid.cell, x: nodes(0, grid.nx), y: nodes(1, grid.ny) }
    }

    /// Cells at which all `swept` boxes (relative to the node, `min <= max`) lie in `bounds`, edges included, and share no
    /// area with any of `obstacles`; `nx * ny`, i fastest.
    pub fn of(&self, bounds: &[f64; 4], obstacles: &[[f64; 4]], swept: &[[f64; 4]]) -> Vec<bool> {
        let (nx, ny) = (self.grid.nx, self.grid.ny);
        let (mut inside_x, mut inside_y) = (0..nx, 0..ny);
        let mut hits = Hits::new(nx, ny);
        for swept in swept {
            inside_x = both(&inside_x, &self.inside(0, swept, bounds));
            inside_y = both(&inside_y, &self.inside(1, swept, bounds));
            for obstacle in obstacles {
                let across = self.overlap(0, swept, obstacle);
                if !across.is_empty() {
                    hits.add(&across, &self.overlap(1, swept, obstacle));
                }
            }
        }
        hits.free(&inside_x, &inside_y)
    }

    /// Indices along an axis at which the swept box lies in the bounds.
    fn inside(&self, axis: usize, swept: &[f64; 4], bounds: &[f64; 4]) -> Span {
        let first = self.first(axis, bounds[axis] - swept[axis], |node| node + swept[axis] >= bounds[axis]);
        let high = axis + 2;
        let end = self.first(axis, bounds[high] - swept[high], |node| node + swept[high] > bounds[high]);
        first..end
    }

    /// Indices along an axis at which the inner parts of swept box and obstacle overlap.
    fn overlap(&self, axis: usize, swept: &[f64; 4], block: &[f64; 4]) -> Span {
        let high = axis + 2;
        let first = self.first(axis, block[axis] - swept[high], |node| node + swept[high] > block[axis]);
        let end = self.first(axis, block[high] - swept[axis], |node| node + swept[axis] >= block[high]);
        first..end
    }

    /// The first index whose node passes a test that all later ones pass as well; it is near the place `near` \[m\].
    fn first(&self, axis: usize, near: f64, passes: impl Fn(f64) -> bool) -> usize {
        let nodes = if axis == 0 { &self.x } else { &self.y };
        // The guess may be off; the cast maps negative numbers to 0.
        let mut index = ((near - self.grid.origin[axis]) * self.per_cell) as usize;
        index = index.min(nodes.len());
        while index > 0 && passes(nodes[index - 1]) {
            index -= 1;
        }
        while index < nodes.len() && !passes(nodes[index]) {
            index += 1;
        }
        index
    }
}

fn both(a: &Span, b: &Span) -> Span {
    a.start.max(b.start)..a.end.min(b.end)
}

/// Hits per cell, as differences along both axes.
struct Hits {
    nx: usize,
    ny: usize,
    differences: Vec<i32>,
}

impl Hits {
    fn new(nx: usize, ny: usize) -> Self {
        Self { nx, ny, differences: vec![0; (nx + 1) * (ny + 1)] }
    }

    fn add(&mut self, across: &Span, along: &Span) {
        if along.is_empty() {
            return;
        }
        let row = self.nx + 1;
        self.differences[along.start * row + across.start] += 1;
        self.differences[along.start * row + across.end] -= 1;
        self.differences[along.end * row + across.start] -= 1;
        self.differences[along.end * row + across.end] += 1;
    }

    fn free(&self, inside_x: &Span, inside_y: &Span) -> Vec<bool> {
        let mut above = vec![0; self.nx];
        let mut free = Vec::with_capacity(self.nx * self.ny);
        for j in 0..self.ny {
            let mut along = 0;
            for (i, above) in above.iter_mut().enumerate() {
                along += self.differences[j * (self.nx + 1) + i];
                *above += along;
                free.push(*above == 0 && inside_x.contains(&i) && inside_y.contains(&j));
            }
        }
        free
    }
}
