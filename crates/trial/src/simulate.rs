use engine::{Origin, Pose, Seen, Ship};
use refusal::Invalid;

use crate::{Autopilot, Leg, Phase, Piece, Purpose, Side};

/// One sample under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Index of the leg.
    pub leg: usize,
    /// Whether an informative maneuver is being run.
    pub informative: bool,
    /// Where the vessel is.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
    /// Inputs held until the next sample.
    pub inputs: Vec<f64>,
}

/// Where a vessel is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Index of the leg.
    pub leg: usize,
    /// Where the vessel is.
    pub pose: Pose,
}

/// What was sailed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sailed {
    /// Every sample, in order.
    pub samples: Vec<Sample>,
    /// Where the vessel was, and how fast, at the end of each leg.
    pub ends: Vec<(Pose, [f64; 3])>,
}

/// One sample as it passes.
#[derive(Clone, Copy, Debug)]
pub struct Passing<'s> {
    /// Index of the leg.
    pub leg: usize,
    /// Whether an informative maneuver is being run.
    pub informative: bool,
    /// Where the vessel is.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
    /// Inputs held until the next sample.
    pub inputs: &'s [f64],
}

impl Sailed {
    /// Where the vessel was at every sample.
    pub fn fixes(&self) -> impl Iterator<Item = Fix> + '_ {
        self.samples.iter().map(|sample| Fix { leg: sample.leg, pose: sample.pose })
    }

    /// What `legs` come to, see [`sail`].
    ///
    /// # Errors
    /// As [`sail`].
    pub fn of<'l>(
        legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
        pieces: &[Piece],
        mirror: &[f64],
        ship: &mut Ship,
        autopilot: &mut Autopilot,
    ) -> Result<Self, Invalid> {
        let mut samples = Vec::new();
        let ends = sail(legs, pieces, mirror, ship, autopilot, |passing| samples.push(passing.into()))?;
        Ok(Self { samples, ends })
    }
}

impl From<Passing<'_>> for Sample {
    fn from(Passing { leg, informative, pose, state, inputs }: Passing) -> Self {
        Self { leg, informative, pose, state, inputs: inputs.to_vec() }
    }
}

/// Where a vessel was, and how fast, at the end of a leg.
pub type End = (Pose, [f64; 3]);

/// Carries out `legs`, each from its own node (north, east), starting wherever `ship` is. Pieces' inputs are multiplied by
/// `mirror` where they are run to the other side. `record` is told of every sample; the ends of legs are given.
///
/// # Errors
/// A vessel that cannot be commanded; a simulation that leaves every bound.
pub fn sail<'l>(
    legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
    pieces: &[Piece],
    mirror: &[f64],
    ship: &mut Ship,
    autopilot: &mut Autopilot,
    mut record: impl FnMut(Passing),
) -> Result<Vec<End>, Invalid> {
    let mut ends = Vec::new();
    let mut way = Way { ship, autopilot, record: &mut record, inputs: Vec::new() };
    for (index, (node, leg)) in legs.into_iter().enumerate() {
        for phase in &leg.phases {
            match (phase, &leg.purpose) {
                (Phase::Maneuver, Purpose::Informative { piece, side }) => {
                    let signs = if *side == Side::Mirrored { mirror } else { &[] };
                    way.run(index, &pieces[*piece], signs)?;
                }
                _ => way.follow(phase, node, index)?,
            }
        }
        ends.push((way.ship.pose, way.ship.state));
    }
    Ok(ends)
}

/// No turn or line takes longer: numbers that ask for it make no sense, and its samples would fill the memory.
const LONGEST_PHASE: usize = 500_000;

/// A vessel on its way.
struct Way<'w, 's, 'a> {
    ship: &'w mut Ship<'s>,
    autopilot: &'w mut Autopilot<'a>,
    record: &'w mut dyn FnMut(Passing),
    inputs: Vec<f64>,
}

impl<'s> Way<'_, 's, '_> {
    /// Runs a piece, to the other side where there are `signs` of its inputs.
    fn run(&mut self, leg: usize, piece: &Piece, signs: &[f64]) -> Result<(), Invalid> {
        let (mut command, origin) = (piece.begin(), Origin::from(self.ship.pose));
        let side = if signs.is_empty() { 1.0 } else { -1.0 };
        self.inputs.resize(piece.inputs.len() / piece.samples, 0.0);
        for _ in 0..piece.samples {
            let ([u, v, r], pose) = (self.ship.state, origin.sees(self.ship.pose));
            let seen = Seen {
                state: [u, side * v, side * r],
                pose: Pose { x: pose.x, y: side * pose.y, psi: side * pose.psi },
            };
            command.command(&seen, &mut self.inputs);
            self.inputs.iter_mut().zip(signs).for_each(|(input, sign)| *input *= sign);
            self.advance(leg, true, Ship::command)?;
        }
        Ok(())
    }

    fn follow(&mut self, phase: &Phase, node: [f64; 2], leg: usize) -> Result<(), Invalid> {
        let start = self.ship.pose;
        let patience_s = self.autopilot.patience_s(phase, node, start);
        let mut elapsed_s = 0.0;
        while !self.autopilot.is_done(phase, node, self.ship, elapsed_s > patience_s) {
            if elapsed_s > LONGEST_PHASE as f64 * self.ship.sample_s() {
                let expected = format!("at most {LONGEST_PHASE} samples of a turn or a line");
                let remedy = "correct `cell_m`, the speeds or `handling`";
                let found = format!("over {elapsed_s:.0} s");
                return Err(Invalid::new("leg under way", found, expected, remedy));
            }
            let inputs = self.autopilot.steer(phase, node, start, self.ship)?;
            self.inputs.clear();
            self.inputs.extend_from_slice(inputs);
            self.advance(leg, false, Ship::reach)?;
            elapsed_s += self.ship.sample_s();
        }
        Ok(())
    }

    /// A sample with the inputs as `set` sets them.
    fn advance(
        &mut self,
        leg: usize,
        informative: bool,
        set: for<'i> fn(&'i mut Ship<'s>, &[f64]) -> &'i [f64],
    ) -> Result<(), Invalid> {
        let Self { ship, autopilot, record, inputs } = self;
        let (pose, state) = (ship.pose, ship.state);
        let actual = set(ship, inputs);
        inputs.copy_from_slice(actual);
        autopilot.observe(pose, state, inputs, ship.state);
        record(Passing { leg, informative, pose, state, inputs });
        if ship.state.iter().all(|s| s.abs() <= engine::DIVERGED) {
            return Ok(());
        }
        Err(Invalid::new(
            "model under way",
            format!("{:?}", ship.state),
            "speeds within bounds",
            "shorten the maneuver, or check the parameters in vessel.toml",
        ))
    }
}
