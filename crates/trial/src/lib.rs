//! Whole trials: the sea, campaigns, moments of maneuvers, their order, refined inputs, rounds; and pieces of maneuvers.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod arranging;
pub mod campaign;
pub mod moments;
pub mod refining;
pub mod rounds;

use refusal::Invalid;
use ship::engine::{Command, Helm, Pose, Progress, Run, Seen, Ship};
use ship::model::Vessel;

/// A piece of a dictionary maneuver: the segment that is run as one use of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Name of the maneuver.
    pub maneuver: String,
    /// Surge speed at the start \[m/s\].
    pub speed_m_s: f64,
    /// N′ × inputs, row-major; of a maneuver that reacts, those of the nominal vessel.
    pub inputs: Vec<f64>,
    /// Its commands, if they depend on the ship's motion.
    pub helm: Option<Helm>,
    /// N′, of the nominal vessel.
    pub samples: usize,
    /// Samples after which any vessel gives it up.
    pub longest: usize,
}

impl Piece {
    /// A whole maneuver: `run` of a dictionary.
    pub fn whole(vessel: &Vessel, run: &Run) -> Self {
        Self {
            maneuver: run.segments[0].maneuver.clone(),
            speed_m_s: run.initial[0],
            inputs: vessel.model.inputs_of(&run.exogenous),
            samples: run.samples(),
            longest: run.samples(),
            helm: None,
        }
    }

    /// The piece as long as the nominal vessel needs for its commands in still water; itself if they are a table.
    ///
    /// # Errors
    /// A vessel that does not come to their end.
    pub fn timed(mut self, vessel: &Vessel) -> Result<Self, Invalid> {
        if self.helm.is_none() {
            return Ok(self);
        }
        let width = vessel.model.inputs;
        let mut ship = Ship::new(vessel, &vessel.nominal, Pose::default(), self.speed_m_s);
        let (mut command, mut inputs) = (self.begin(), vec![0.0; width]);
        self.samples = 0;
        while !self.is_over(&*command, self.samples, ship.sample_s())? {
            let seen = Seen { state: ship.state, own: ship.state, pose: ship.pose };
            command.command(&seen, &mut inputs);
            let settings = ship.command(&inputs, command.ends());
            self.inputs[self.samples * width..][..width].copy_from_slice(settings);
            self.samples += 1;
        }
        self.inputs.truncate(self.samples * width);
        Ok(self)
    }

    /// Whether `command` of it is over after so many samples.
    ///
    /// # Errors
    /// It still waits for something when it is given up.
    pub fn is_over(&self, command: &dyn Command, samples: usize, sample_s: f64) -> Result<bool, Invalid> {
        match command.progress() {
            Progress::Done => Ok(true),
            _ if samples < self.longest => Ok(false),
            Progress::Open => Ok(true),
            Progress::Waiting(what) => Err(Invalid::new(
                format!("maneuver `{}`", self.maneuver),
                format!("its {what} not reached after {} s", samples as f64 * sample_s),
                "a maneuver that is carried out in its time",
                "lengthen its `duration_s` in the dictionary, or its `piece_s`",
            )),
        }
    }

    /// Begins its commands.
    pub fn begin(&self) -> Box<dyn Command> {
        self.helm.as_ref().map_or_else(|| Helm::table(&self.inputs).begin(), Helm::begin)
    }

    /// Whether its inputs, multiplied by `signs`, are within their ranges, too.
    pub fn is_mirrored_within(&self, vessel: &Vessel, signs: &[f64]) -> bool {
        let mirrored = |row: &[f64]| row.iter().zip(signs).map(|(u, sign)| sign * u).collect::<Vec<f64>>();
        self.inputs.chunks_exact(signs.len()).all(|row| vessel.beyond_range(&mirrored(row)).is_none())
    }

    /// Its first `target` samples, or the nearest number of whole periods if it is a table that is periodic; all of
    /// it without a target.
    ///
    /// # Errors
    /// A target longer than the maneuver, or of zero samples.
    pub fn cut(self, target: Option<usize>) -> Result<Self, Invalid> {
        let Self { maneuver, speed_m_s, mut inputs, samples: all, helm, .. } = self;
        let width = inputs.len() / all.max(1);
        let wanted = target.unwrap_or(all);
        if wanted == 0 || wanted > all {
            return Err(Invalid::new(
                format!("piece of maneuver `{maneuver}`"),
                format!("{wanted} samples"),
                format!("1 to {all}, the maneuver's length in the dictionary"),
                "shorten the piece, or lengthen the maneuver in the dictionary",
            ));
        }
        let periodic = target.filter(|_| helm.is_none()).and_then(|_| period(&inputs, width));
        let whole = |period: usize| {
            period * ((wanted as f64 / period as f64).round() as usize).clamp(1, all / period)
        };
        let samples = periodic.map_or(wanted, whole);
        inputs.truncate(samples * width);
        Ok(Self { maneuver, speed_m_s, inputs, samples, helm, longest: samples })
    }
}

/// The period of inputs (N × `width`) in samples: the shortest shift that leaves all of them unchanged, to a millionth
/// of their range, over at least one further period.
pub fn period(inputs: &[f64], width: usize) -> Option<usize> {
    let samples = inputs.len() / width.max(1);
    let range = inputs.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * range;
    let repeats = |shift: &usize| inputs.iter().zip(&inputs[shift * width..]).all(is_same);
    if repeats(&1.min(samples)) { None } else { (2..=samples / 2).find(repeats) }
}
