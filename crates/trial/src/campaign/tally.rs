use std::collections::BTreeMap;
use std::fmt;

use maneuver::Exceeded;
use refusal::Invalid;

/// Name of the one reason for leaving out a maneuver that is not a limit.
const UNSTEADY: &str = "no steady inputs";
/// Suffix of the reason that a maneuver leaves the motion in the logs of its model, after `u`, `v` or `r`.
pub(super) const BEYOND_LOGS: &str = "beyond the model's logs";

/// How many maneuvers were simulated, and how many were left out for which reason.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Number of maneuvers.
    pub maneuvers: usize,
    /// Their samples.
    pub samples: usize,
    /// How many of them are generated.
    pub kept: usize,
    /// Generated maneuvers that were left out, by the limit that they exceed most.
    pub left_out: BTreeMap<String, LeftOut>,
}

/// Maneuvers left out for one reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeftOut {
    /// Their number.
    pub count: usize,
    /// The limit.
    pub allowed: f64,
    /// The smallest of their values.
    pub nearest: f64,
}

impl Tally {
    pub(super) fn simulated(&mut self, samples: usize, generated: bool) {
        self.maneuvers += 1;
        self.samples += samples;
        self.kept += usize::from(generated);
    }

    pub(super) fn exceeds(&mut self, Exceeded { limit, allowed, found }: &Exceeded) {
        self.leave_out(limit, LeftOut { count: 1, allowed: *allowed, nearest: *found });
    }

    pub(super) fn unsteady(&mut self) {
        self.leave_out(UNSTEADY, LeftOut { count: 1, ..LeftOut::default() });
    }

    fn leave_out(&mut self, name: &str, about: LeftOut) {
        self.left_out
            .entry(name.to_owned())
            .and_modify(|known| {
                known.count += about.count;
                known.nearest = known.nearest.min(about.nearest);
            })
            .or_insert(about);
    }

    /// Adds the counts for other maneuvers.
    pub fn merge(&mut self, other: &Self) {
        self.maneuvers += other.maneuvers;
        self.samples += other.samples;
        self.kept += other.kept;
        other.left_out.iter().for_each(|(name, about)| self.leave_out(name, *about));
    }

    /// Refuses limits that no generated maneuver keeps: names the one that most exceed, and the least excess.
    ///
    /// # Errors
    /// Generated maneuvers that are all left out.
    pub fn check(&self) -> Result<(), Invalid> {
        if self.kept > 0 || self.left_out.is_empty() {
            return Ok(());
        }
        let all = self.all_left_out();
        let tightest = self.left_out.iter().max_by(|a, b| a.1.count.cmp(&b.1.count).then(b.0.cmp(a.0)));
        let (name, about) =
            tightest.map_or(("", LeftOut::default()), |(name, about)| (name.as_str(), *about));
        if name == UNSTEADY {
            return Err(Invalid::new(
                "`generate`",
                format!("no candidate of {all} that inputs hold steady"),
                "at least one",
                "give `speed_m_s` and limits that the vessel can reach, or other `kinds`",
            ));
        }
        if name.ends_with(BEYOND_LOGS) {
            return Err(Invalid::new(
                "`generate`",
                format!(
                    "{} of {all} candidates with {name} most, the nearest by {:.4}",
                    about.count, about.nearest
                ),
                "at least one within the motion in the logs of the model",
                "request speeds and yaw rates as in the logs, or allow more with --beyond-range",
            ));
        }
        Err(Invalid::new(
            format!("`generate.limits.{name}`"),
            format!(
                "{}, which is the tightest: {} of {all} candidates exceed it most, the nearest reaches {:.4}, and none \
                 keeps all limits",
                about.allowed, about.count, about.nearest
            ),
            "limits that at least one candidate keeps",
            format!("raise `{name}`, or draw more `candidates`"),
        ))
    }

    fn all_left_out(&self) -> usize {
        self.left_out.values().map(|left_out| left_out.count).sum()
    }
}

impl fmt::Display for Tally {
    /// `12 maneuvers, 960 samples; 8 of 20 generated left out: 5 by u_m_s, …`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} maneuvers, {} samples", self.maneuvers, self.samples)?;
        let out = self.all_left_out();
        if out == 0 {
            return Ok(());
        }
        let reasons: Vec<String> =
            self.left_out.iter().map(|(name, l)| format!("{} by {name}", l.count)).collect();
        write!(f, "; {out} of {} generated left out: {}", out + self.kept, reasons.join(", "))
    }
}
