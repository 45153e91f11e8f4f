//! Exports a problem whose moves were allowed by any rule as a file with a map of boxes.

use crate::lattice::file::{BasicFile, InformativeFile, LatticeFile, MoveFile, ProblemFile, SCHEMA};
use crate::lattice::{Action, Goal, Invalid, MoveId, Pose, Problem};

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
                let found = match other {
                    Goal::Any => "any pose".to_owned(),
                    Goal::Poses(poses) => format!("{} poses", poses.len()),
                };
                let (expected, remedy) =
                    ("one pose, which is all that the format holds", "plan for one goal");
                return Err(Invalid::new("goal", found, expected, remedy));
            }
        };
        let lattice = problem.lattice();
        let strips = Strips { problem, cell_m, width_m: 2.0 * lattice.nx as f64 * cell_m };
        let mut obstacles = Vec::new();
        let (mut informative, mut basic, mut strip) = (Vec::new(), Vec::new(), 0);
        for (action, own) in problem.actions().iter().enumerate() {
            let moves = (0..own.moves.len()).map(|index| {
                strips.add_obstacles(MoveId { action, index }, strip, &mut obstacles);
                strip += 1;
                strips.step(own, index, strip - 1)
            });
            let (name, moves) = (own.name.clone(), moves.collect());
            match own.required {
                0 => basic.push(BasicFile { name, cost: 0.0, moves }),
                count => informative.push(InformativeFile { name, count, cost: 0.0, moves }),
            }
        }
        let [right, top] = [strip as f64 * strips.width_m, lattice.ny as f64 * cell_m];
        let node = |pose: Pose| [pose.i, pose.j, pose.layer];
        Ok(Self {
            schema: SCHEMA.to_owned(),
            name: name.to_owned(),
            description: Some(
                "A level h is a heading in a speed mode. The boxes are no map: each move has a strip of its own along x.".to_owned(),
            ),
            variant: None,
            lattice: LatticeFile {
                nx: lattice.nx,
                ny: lattice.ny,
                headings: lattice.layers,
                cell: cell_m,
                origin: [0.0; 2],
            },
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
        let own = &action.moves[index];
        let (x, half) = (strip as f64 * self.width_m, 0.25 * self.cell_m);
        MoveFile {
            h: own.from,
            di: own.di,
            dj: own.dj,
            to_h: own.to,
            cost: Some(own.cost.primary),
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
