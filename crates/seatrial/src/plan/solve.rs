//! The lattice problem of a trial, and its solution.

use lattice::{Lattice, MoveId, Problem, Solution};
use trial::Purpose;

use super::config::Primary;
use super::information::Information;
use super::moves::{Moves, Rehearsed};
use super::search::{Limits, affordable, in_words, search};
use super::trial::{Trial, VoyageFiles};
use super::waters::Waters;
use crate::failure::Failure;
use study::documents::FrontPoint;

/// A solved trial.
pub(super) struct Solved {
    pub waters: Waters,
    pub moves: Moves,
    pub problem: Problem,
    pub solution: Solution,
}

impl Trial {
    /// Puts the trial on the lattice and searches.
    pub(super) fn solve(&self, files: &VoyageFiles, limits: &Limits) -> Result<Solved, Failure> {
        let waters = self.waters(files)?;
        let moves = Moves::new(&self.rehearsed, &self.wanted, &self.config.cost, self.vessel.sample_rate_hz);
        let problem = self.problem(files, &waters, &moves)?;
        let solution = self.search(files, &problem, &moves, limits)?;
        Ok(Solved { waters, moves, problem, solution })
    }

    fn problem(&self, files: &VoyageFiles, waters: &Waters, moves: &Moves) -> Result<Problem, Failure> {
        let places = self.places(files);
        let start = places.pose("start", &self.config.start)?;
        let goal = places.goal(&self.config, start)?;
        self.check_water(files, waters, "start", start)?;
        if let lattice::Goal::Poses(poses) = &goal {
            poses.iter().try_for_each(|pose| self.check_water(files, waters, "goal", *pose))?;
        }
        let lattice = Lattice { nx: self.grid.nx, ny: self.grid.ny, layers: self.grid.layers() };
        let allowed = |id: MoveId, i: usize, j: usize| {
            let (leg, class) = moves.legs[id.action][id.index];
            let shared = moves.legs[id.action].iter().any(|(other, c)| *other == leg && *c != class);
            (!shared || waters.class(i, j) == class) && waters.fits(leg, i, j)
        };
        Problem::new(lattice, moves.actions.clone(), start, goal, allowed)
            .map_err(|e| Failure::refuse(files.config, &e.thing, &e.found, &e.expected, &e.remedy))
    }

    fn search(
        &self,
        files: &VoyageFiles,
        problem: &Problem,
        moves: &Moves,
        limits: &Limits,
    ) -> Result<Solution, Failure> {
        let places = self.places(files);
        search(files.config, problem, limits, |reason| {
            let text = in_words(reason, |pose| places.words(pose), self.grid.cell_m);
            let best = self.front(problem, moves, limits).pop();
            let instead =
                best.filter(|point| point.counts.values().any(|n| *n > 0)).map_or(String::new(), |point| {
                    let counts: Vec<String> =
                        point.counts.iter().map(|(name, n)| format!("{name} × {n}")).collect();
                    format!("; the most informative counts that can be sailed are {}", counts.join(", "))
                });
            format!("{text}{instead}")
        })
    }

    /// Counts that no others beat in both cost and information, cheapest first.
    pub(super) fn front(&self, problem: &Problem, moves: &Moves, limits: &Limits) -> Vec<FrontPoint> {
        let found = affordable(problem, limits);
        let leg_s = |q: usize| {
            let of = |own: &&Rehearsed| matches!(own.leg.purpose, Purpose::Informative { piece, .. } if piece == q);
            let own = self.rehearsed.iter().filter(of).map(|own| own.seconds(self.vessel.sample_rate_hz));
            own.fold(f64::INFINITY, f64::min)
        };
        let order: Vec<usize> = (0..self.wanted.len())
            .filter_map(|slot| {
                let name = &moves.actions.iter().filter(|a| a.required > 0).nth(slot)?.name;
                self.wanted.iter().position(|w| w.piece.maneuver == *name)
            })
            .collect();
        let point = |(counts, cost): (Vec<u32>, f64)| {
            let mut information = Information::default();
            let mut named = std::collections::BTreeMap::new();
            let mut informative_s = 0.0;
            for (q, count) in order.iter().zip(&counts) {
                information.add(&self.information[*q], f64::from(*count));
                named.insert(self.wanted[*q].piece.maneuver.clone(), u64::from(*count));
                informative_s += f64::from(*count) * leg_s(*q);
            }
            FrontPoint { counts: named, cost, informative_s, log_det: information.log_det() }
        };
        let mut points: Vec<FrontPoint> =
            found.into_iter().map(point).filter(|p| p.log_det.is_finite()).collect();
        let time = |p: &FrontPoint| match self.config.cost.primary {
            Primary::BasicMoves => (p.cost, p.informative_s),
            Primary::Seconds => (p.cost, 0.0),
        };
        points.sort_by(|a, b| {
            let (a, b, x, y) = (time(a), time(b), a.log_det, b.log_det);
            a.0.total_cmp(&b.0).then(y.total_cmp(&x)).then(a.1.total_cmp(&b.1))
        });
        let mut best = f64::NEG_INFINITY;
        points.retain(|p| {
            let better = p.log_det > best;
            best = best.max(p.log_det);
            better
        });
        points
    }
}
