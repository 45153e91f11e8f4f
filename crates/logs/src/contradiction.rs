//! Measured velocities that contradict position and heading in time, size or direction.

use crate::MotionSummary;
use crate::axes::Turned;
use crate::suspicion::{Oddity, WarningKind};

/// From where on a contradiction is a warning, and from where on the recording is doubtful, so that estimates
/// refuse it by default.
struct Bounds {
    warned: f64,
    broken: f64,
}

/// In seconds, and in samples of the common rate: the larger one counts.
const LAG_S: Bounds = Bounds { warned: 0.25, broken: 2.0 };
const LAG_SAMPLES: Bounds = Bounds { warned: 0.75, broken: 2.0 };

/// Distance of the slope from 1.
const GAIN: Bounds = Bounds { warned: 0.2, broken: 0.5 };

/// Rotation of the velocities against the derivative of position \[rad\] …
const TURN: Bounds = Bounds { warned: 0.0175, broken: 0.0873 };

/// … where without it less than this share of the squared difference remains.
const LEFT: f64 = 0.5;

/// The course over ground against the heading where the ship does not turn \[rad\].
const DRIFT: f64 = 0.0873;

/// The contradictions within a recording.
pub(crate) struct Contradictions {
    /// Warnings, by channel.
    pub(crate) warnings: Vec<(String, Oddity)>,
    /// Why estimates refuse the recording by default, in words.
    pub(crate) broken: Vec<String>,
}

impl Contradictions {
    /// Compares measured velocities with position and heading, on a common clock of `rate_hz`.
    pub(crate) fn of(motion: &[Option<MotionSummary>; 3], turned: Option<Turned>, rate_hz: f64) -> Self {
        let mut found = Self { warnings: Vec::new(), broken: Vec::new() };
        for (channel, of, motion) in [("y_u", "position"), ("y_v", "position"), ("y_r", "heading")]
            .into_iter()
            .zip(motion)
            .filter_map(|((channel, of), motion)| Some((channel, of, motion.as_ref()?)))
        {
            found.lag(channel, of, motion, rate_hz);
            found.gain(channel, of, motion);
        }
        found.turn(turned);
        found
    }

    fn note(&mut self, channel: &'static str, kind: WarningKind, text: String, is_broken: bool) {
        if is_broken {
            self.broken.push(format!("`{channel}` {text}"));
        }
        self.warnings.push((channel.to_owned(), (kind, 1, text)));
    }

    /// Notes that channels cover different times, that the course lies `drift` \[rad\] off the heading, and channels whose unit
    /// changes.
    pub(crate) fn also(
        &mut self,
        uncovered: Option<(String, Oddity)>,
        drift: Option<f64>,
        changed: Vec<(String, Oddity)>,
    ) {
        if let Some(drift) = drift.filter(|drift| drift.abs() > DRIFT) {
            let text = format!(
                "differs by {:.1} deg from the course over ground where the ship does not turn: a variation that is missing or \
                 applied twice, a rotated sensor, or a current and wind?",
                -drift.to_degrees()
            );
            self.note("psi", WarningKind::Bias, text, false);
        }
        self.broken.extend(changed.iter().map(|(channel, (_, _, text))| format!("`{channel}` {text}")));
        self.warnings.extend(uncovered.into_iter().chain(changed));
    }

    fn lag(&mut self, channel: &'static str, of: &str, motion: &MotionSummary, rate_hz: f64) {
        let at_least = |s: f64, samples: f64| s.max(samples / rate_hz);
        let Some(lag_s) = motion.lag_s.filter(|lag| lag.abs() > at_least(LAG_S.warned, LAG_SAMPLES.warned))
        else {
            return;
        };
        let when = if lag_s > 0.0 { "after" } else { "before" };
        let text = format!(
            "comes {:.2} s {when} the derivative of {of}: compare the clocks, or set `delay_s`",
            lag_s.abs()
        );
        let is_broken = lag_s.abs() > at_least(LAG_S.broken, LAG_SAMPLES.broken);
        self.note(channel, WarningKind::Lag, text, is_broken);
    }

    fn gain(&mut self, channel: &'static str, of: &str, motion: &MotionSummary) {
        let Some(gain) = motion.gain.filter(|gain| (gain - 1.0).abs() > GAIN.warned) else { return };
        let text = format!("is {gain:.3} times the derivative of {of}: check the units and scales of both");
        self.note(channel, WarningKind::Gain, text, (gain - 1.0).abs() > GAIN.broken);
    }

    fn turn(&mut self, turned: Option<Turned>) {
        let Some(Turned { angle, .. }) =
            turned.filter(|own| own.angle.abs() > TURN.warned && own.left < LEFT)
        else {
            return;
        };
        let text = format!(
            "differs by {:.1} deg throughout from what `y_u`, `y_v` and position imply: a magnetic heading, \
             or a rotated sensor?",
            angle.to_degrees()
        );
        self.note("psi", WarningKind::Bias, text, angle.abs() > TURN.broken);
    }
}
