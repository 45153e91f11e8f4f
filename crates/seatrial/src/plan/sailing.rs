//! The plan in continuous space: sailed, checked against the chart, and what it tells.

use chart::Obstacles;
use trial::{Leg, Piece, Purpose, Sailed};
use vessel::Invalid;

use super::chart_layers::invalid;
use super::check::{Clearance, Script, Trials};
use super::information::Information;
use super::search::Limits;
use super::solve::Solved;
use super::trial::{Trial, VoyageFiles};
use crate::failure::Failure;
use study::documents::{Information as InformationDocument, Voyage};

/// The voyage as simulated, and its document.
pub(super) struct Sailing {
    pub sailed: Sailed,
    /// In unknown currents.
    pub runs: Vec<Sailed>,
    pub voyage: Voyage,
}

impl Trial {
    /// Steps 5 to 7: the plan in continuous space, against the chart, and what it tells.
    pub(super) fn sail(
        &self,
        files: &VoyageFiles,
        solved: &Solved,
        limits: &Limits,
        seed: u64,
    ) -> Result<Sailing, Failure> {
        let Solved { waters, moves, problem, solution } = solved;
        let refuse = |e: Invalid| Failure::invalid(files.config, &e);
        let legs: Vec<usize> = solution.steps.iter().map(|step| moves.leg_of_step(step)).collect();
        let script_legs: Vec<([f64; 2], Leg)> = solution
            .steps
            .iter()
            .zip(&legs)
            .map(|(step, leg)| (self.node(step.from), self.rehearsed[*leg].leg.clone()))
            .collect();
        let (level, mode) = self.grid.level_and_mode(problem.start().layer);
        let script = Script {
            vessel: &self.vessel,
            handling: self.config.handling,
            pieces: &self.pieces,
            mirror: &self.mirror,
            legs: &script_legs,
            start: self.grid.pose(problem.start().i, problem.start().j, level),
            speed_m_s: self.grid.modes[mode].speed_m_s,
            known_current_m_s: self.known_current_m_s,
        };
        let sailed = script.sail(&self.vessel.nominal, [0.0; 2]).map_err(refuse)?;
        let safety = &self.config.safety;
        let charted = |depth: f64| {
            Obstacles::new(&self.chart, self.raster(), depth, 0.0).map_err(|e| invalid(files.config, &e))
        };
        let (transit, deep) = (charted(safety.transit_depth_m)?, charted(safety.trial_depth_m)?);
        let distance = [
            &(|[x, y]: [f64; 2]| transit.distance_m(x, y)) as &(dyn Fn([f64; 2]) -> f64 + Sync),
            &(|[x, y]: [f64; 2]| deep.distance_m(x, y)),
        ];
        let outline = self.config.hull.outline();
        let clearance = Clearance { outline: &outline, distance_m: distance };
        let trials = Trials {
            script: &script,
            clearance: &clearance,
            unknown_current_m_s: safety.unknown_current_m_s,
            runs: safety.runs,
            seed,
        };
        let (check, runs) = trials.check(&sailed).map_err(refuse)?;
        if !check.clear {
            return Err(Failure::NoAnswer(format!(
                "{}: plan at sea: found the hull on an obstacle in the simulated plan, expected it clear; raise \
                 `safety.margin_m` or lower `approach.tolerance_cells`",
                files.config.display()
            )));
        }
        let mut information = self.realised(&legs, &sailed);
        information.design_efficiency = self.design_efficiency(&legs);
        let rate = self.vessel.sample_rate_hz;
        let informative = sailed.samples.iter().filter(|s| s.informative).count() as f64 / rate;
        let voyage = Voyage {
            lattice: self.lattice_document(),
            legs: self.leg_documents(solution, &legs, &sailed),
            primitives: self.primitives(waters),
            duration_s: sailed.samples.len() as f64 / rate,
            informative_s: informative,
            check,
            information,
            front: self.front(problem, moves, limits),
        };
        Ok(Sailing { sailed, runs, voyage })
    }

    /// North and east of a pose's node.
    pub(super) fn node(&self, pose: lattice::Pose) -> [f64; 2] {
        let at = self.grid.pose(pose.i, pose.j, 0);
        [at.x, at.y]
    }

    /// Information of the sailed stretches against what the counts promise.
    fn realised(&self, legs: &[usize], sailed: &Sailed) -> InformationDocument {
        let (mut predicted, mut realised) = (Information::default(), Information::default());
        for leg in legs {
            if let Purpose::Informative { piece, .. } = self.rehearsed[*leg].leg.purpose {
                predicted.add(&self.information[piece], 1.0);
            }
        }
        let mut start = 0;
        let stretches = sailed.samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative);
        for stretch in stretches {
            let end = start + stretch.len();
            if stretch[0].informative {
                realised.add(&self.information_of(sailed, start..end), 1.0);
            }
            start = end;
        }
        let whole = self.information_of(sailed, 0..sailed.samples.len());
        let dimension = predicted.dimension();
        let (a, b) = (predicted.log_det(), realised.log_det());
        let known = |x: f64| Some(x).filter(|x| x.is_finite());
        InformationDocument {
            predicted_log_det: known(a),
            realised_log_det: known(b),
            whole_log_det: known(whole.log_det()),
            efficiency: known(((b - a) / dimension as f64).exp()),
            design_efficiency: None,
            dimension: dimension as u64,
        }
    }

    fn information_of(&self, sailed: &Sailed, range: std::ops::Range<usize>) -> Information {
        let own = &sailed.samples[range.clone()];
        let inputs: Vec<f64> = own.iter().flat_map(|s| s.inputs.iter().copied()).collect();
        let after = sailed.samples.get(range.end).map(|s| s.state);
        let after = after.or(sailed.ends.last().map(|(_, state)| *state)).unwrap_or_default();
        let states: Vec<f64> = own.iter().map(|s| s.state).chain([after]).flatten().collect();
        Information::of(&self.vessel, &inputs, &states)
    }

    /// How the counts compare with the design's shares over the same time in maneuvers.
    fn design_efficiency(&self, legs: &[usize]) -> Option<f64> {
        let design = self.design.as_ref()?;
        let (mut own, mut best, mut samples) = (Information::default(), Information::default(), 0.0);
        for leg in legs {
            if let Purpose::Informative { piece, .. } = self.rehearsed[*leg].leg.purpose {
                own.add(&self.information[piece], 1.0);
                samples += self.pieces[piece].samples as f64;
            }
        }
        for run in &self.dictionary {
            let share = design.shares.get(&run.segments[0].maneuver).copied().unwrap_or(0.0);
            if share > 0.0 {
                let (width, all) = (self.vessel.model.inputs, self.vessel.model.exogenous());
                let rows = run.exogenous.chunks_exact(all);
                let piece = Piece {
                    maneuver: String::new(),
                    speed_m_s: run.initial[0],
                    inputs: rows.flat_map(|row| row[..width].iter().copied()).collect(),
                    samples: run.samples(),
                };
                best.add(
                    &Information::of_piece(&self.vessel, &piece),
                    share * samples / run.samples() as f64,
                );
            }
        }
        let efficiency = ((own.log_det() - best.log_det()) / own.dimension() as f64).exp();
        efficiency.is_finite().then_some(efficiency)
    }
}
