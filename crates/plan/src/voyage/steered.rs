//! Whether every vessel within the stated errors can be steered at all, before legs are tried.

use refusal::Invalid;

use super::off_nominal::parameters_in_words;
use super::prepared::Prepared;
use crate::Used;
use crate::deviations::Candidate;

/// For how many response times a vessel is steered.
const RESPONSES: f64 = 10.0;

impl Prepared {
    /// Refuses errors within which a vessel does not come to hold its course and speed in some mode: the vessels at
    /// either end of a parameter, and the worst corner by these.
    pub(super) fn check_steered(&self) -> Result<(), Invalid> {
        let doubt = self.brief.doubt();
        if doubt.deviations.is_none() {
            return Ok(());
        }
        for mode in 0..self.grid.modes.len() {
            let layer = self.grid.layer(0, mode);
            let mut tried: Vec<(f64, Candidate)> = Vec::new();
            for who in doubt.axes() {
                tried.push((self.held(layer, &who)?.part(), who));
            }
            let parts: Vec<f64> = tried.iter().map(|(part, _)| part.min(LOST)).collect();
            let corner = doubt.extreme(&parts);
            tried.push((self.held(layer, &corner)?.part(), corner));
            if let Some((_, who)) = tried.iter().find(|(part, _)| *part > 1.0) {
                return Err(self.cannot_be_steered(mode, who, self.held(layer, who)?));
            }
        }
        Ok(())
    }

    /// The used part of the tolerance of a settled motion, after being steered along a line for a while.
    fn held(&self, layer: usize, who: &Candidate) -> Result<Used, Invalid> {
        let (doubt, repertoire) = (self.brief.doubt(), self.repertoire());
        let (level, mode) = self.grid.level_and_mode(layer);
        let (heading, speed) = (self.grid.heading_rad(level), self.grid.modes[mode].speed_m_s);
        let mut underway = repertoire.underway(layer, Some(&doubt.on_node(who)), None)?;
        underway.hold(heading, speed, RESPONSES * repertoire.handling.response_s)?;
        let tolerance = repertoire.approach.tolerance;
        let [u, v, r] = underway.ship.state;
        Ok(if [u, v, r].iter().all(|own| own.is_finite()) {
            tolerance.used_in_motion([u, v, r], speed)
        } else {
            Used::Lost
        })
    }

    fn cannot_be_steered(&self, mode: usize, who: &Candidate, used: Used) -> Invalid {
        let doubt = self.brief.doubt();
        let words = parameters_in_words(&self.brief.vessel, &doubt.parameters(who));
        let (mode, s) = (&self.grid.modes[mode].name, RESPONSES * self.brief.task.handling.response_s);
        Invalid::new(
            format!("`{}`", self.brief.task.safety.key()),
            format!("a vessel with {words} that cannot be steered: in mode `{mode}` after {s:.0} s {used}"),
            "errors within which every vessel holds its course and speed",
            "lower it, or leave the mode out",
        )
    }
}

/// Parts of a tolerance beyond this are all the same.
const LOST: f64 = 1e6;
