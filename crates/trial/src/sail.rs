use vessel::Invalid;

use crate::{Autopilot, Leg, Phase, Piece, Purpose, Ship, Side};

/// One sample under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Index of the leg.
    pub leg: usize,
    /// Whether an informative maneuver is being run.
    pub informative: bool,
    /// Where the vessel is.
    pub pose: vessel::Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
    /// Inputs held until the next sample.
    pub inputs: Vec<f64>,
}

/// What was sailed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sailed {
    /// Every sample, in order.
    pub samples: Vec<Sample>,
    /// Where the vessel was, and how fast, at the end of each leg.
    pub ends: Vec<(vessel::Pose, [f64; 3])>,
}

/// Carries out `legs`, each from its own node (north, east), starting wherever `ship` is. Pieces' inputs are multiplied by
/// `mirror` where they are run to the other side.
///
/// # Errors
/// A command that the model cannot hold; a simulation that leaves every bound.
pub fn sail<'l>(
    legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
    pieces: &[Piece],
    mirror: &[f64],
    ship: &mut Ship,
    autopilot: &mut Autopilot,
) -> Result<Sailed, Invalid> {
    let mut sailed = Sailed { samples: Vec::new(), ends: Vec::new() };
    for (index, (node, leg)) in legs.into_iter().enumerate() {
        for phase in &leg.phases {
            match (phase, &leg.purpose) {
                (Phase::Maneuver, Purpose::Informative { piece, side }) => {
                    let piece = &pieces[*piece];
                    let width = piece.inputs.len() / piece.samples;
                    for row in piece.inputs.chunks_exact(width) {
                        let sign = |i: usize| match side {
                            Side::AsDesigned => 1.0,
                            Side::Mirrored => mirror[i],
                        };
                        let inputs = row.iter().enumerate().map(|(i, u)| sign(i) * u).collect();
                        advance(ship, index, true, inputs, &mut sailed)?;
                    }
                }
                _ => follow(phase, node, index, ship, autopilot, &mut sailed)?,
            }
        }
        sailed.ends.push((ship.pose, ship.state));
    }
    Ok(sailed)
}

/// No turn or line takes longer: numbers that ask for it make no sense, and its samples would fill the memory.
const LONGEST_PHASE: usize = 500_000;

fn follow(
    phase: &Phase,
    node: [f64; 2],
    leg: usize,
    ship: &mut Ship,
    autopilot: &mut Autopilot,
    sailed: &mut Sailed,
) -> Result<(), Invalid> {
    let start = ship.pose;
    let mut elapsed_s = 0.0;
    while !autopilot.is_done(phase, node, start, ship, elapsed_s) {
        if elapsed_s > LONGEST_PHASE as f64 * ship.sample_s() {
            let expected = format!("at most {LONGEST_PHASE} samples of a turn or a line");
            let remedy = "correct `cell_m`, the speeds or `handling`";
            return Err(Invalid::new("leg under way", format!("over {elapsed_s:.0} s"), expected, remedy));
        }
        let inputs = autopilot.steer(phase, node, start, ship)?.to_vec();
        advance(ship, leg, false, inputs, sailed)?;
        elapsed_s += ship.sample_s();
    }
    Ok(())
}

fn advance(
    ship: &mut Ship,
    leg: usize,
    informative: bool,
    inputs: Vec<f64>,
    sailed: &mut Sailed,
) -> Result<(), Invalid> {
    let (pose, state) = (ship.pose, ship.state);
    ship.step(&inputs);
    sailed.samples.push(Sample { leg, informative, pose, state, inputs });
    if ship.state.iter().all(|s| s.abs() <= vessel::DIVERGED) {
        return Ok(());
    }
    Err(Invalid::new(
        "model under way",
        format!("{:?} after sample {}", ship.state, sailed.samples.len()),
        "speeds within bounds",
        "shorten the maneuver, or check the parameters in vessel.toml",
    ))
}
