use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::lattice::collision::FreeCells;
use crate::lattice::watch::Poll;
use crate::lattice::{Action, Cost, Demand, Goal, Invalid, Lattice, Move, Pose, Problem};

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
#[derive(Clone, Debug, Deserialize, Serialize)]
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
    pub expected: Option<IgnoredAny>,
}

/// Size and place of the lattice.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
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
#[derive(Clone, Debug, Deserialize, Serialize)]
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
#[derive(Clone, Debug, Deserialize, Serialize)]
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
#[derive(Clone, Debug, Deserialize, Serialize)]
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
        crate::lattice::validate::lattice(&lattice)?;
        let (actions, moves) = self.actions();
        // Refuses a bad start or goal before the map is processed, and moves with it.
        crate::lattice::validate::ends(&lattice, pose(self.start), &Goal::Poses(vec![pose(self.goal)]))?;
        let Some(free) = self.free_cells(&moves, keep_going) else { return Ok(None) };
        let mut poll = Poll::new(keep_going);
        let allowed = |id: crate::lattice::MoveId, i: usize, j: usize| {
            poll.proceed() && free[id.action][id.index][j * lattice.nx + i]
        };
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
    fn free_cells(
        &self,
        moves: &[&[MoveFile]],
        keep_going: &dyn Fn() -> bool,
    ) -> Option<Vec<Vec<Vec<bool>>>> {
        let cells = FreeCells::new(self.lattice);
        let of = |one: &MoveFile| keep_going().then(|| cells.of(&self.bounds, &self.obstacles, &one.swept));
        let of_action = |moves: &&[MoveFile]| moves.iter().map(of).collect();
        moves.iter().map(of_action).collect()
    }

    fn check_map(&self) -> Result<(), Invalid> {
        let LatticeFile { cell, origin, .. } = self.lattice;
        if !(cell.is_finite() && cell > 0.0) {
            let expected = "a finite length above 0 m";
            return Err(Invalid::new("lattice.cell", cell.to_string(), expected, "give the cells' pitch"));
        }
        if !origin.iter().all(|value| value.is_finite()) {
            let found = format!("{origin:?}");
            return Err(Invalid::new(
                "lattice.origin",
                found,
                "finite coordinates",
                "give node (0, 0) in metres",
            ));
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

fn check_box(thing: &str, found: &[f64; 4]) -> Result<(), Invalid> {
    let [xmin, ymin, xmax, ymax] = *found;
    if found.iter().all(|value| value.is_finite()) && xmin <= xmax && ymin <= ymax {
        return Ok(());
    }
    let expected = "finite [xmin, ymin, xmax, ymax] with min <= max";
    Err(Invalid::new(thing, format!("{found:?}"), expected, "order the box's corners"))
}
