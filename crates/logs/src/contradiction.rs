//! Measured velocities that position and heading contradict, by time, size or direction.

use crate::MotionSummary;
use crate::axes::Turned;
use crate::suspicion::{Oddity, WarningKind};

/// From where on a contradiction is told, and from where on no estimate is made of it unless asked.
struct Bounds {
    told: f64,
    broken: f64,
}

/// Seconds; or as many samples of the common rate.
const LAG_S: Bounds = Bounds { told: 0.25, broken: 2.0 };
const LAG_SAMPLES: Bounds = Bounds { told: 0.75, broken: 2.0 };

/// Distance of the slope from 1.
const GAIN: Bounds = Bounds { told: 0.2, broken: 0.5 };

/// Turn of the velocities against the derivative of position \[rad\] …
const TURN: Bounds = Bounds { told: 0.0175, broken: 0.0873 };

/// … where without it so much is left of the squares of what they are off it.
const LEFT: f64 = 0.5;

/// What contradicts each other in a recording.
pub(crate) struct Contradictions {
    /// By channel.
    pub(crate) told: Vec<(&'static str, Oddity)>,
    /// Why no estimate is made of it unless asked, in words.
    pub(crate) broken: Vec<String>,
}

impl Contradictions {
    /// Of what velocities, position and heading say, on a common clock of `rate_hz`.
    pub(crate) fn of(motion: &[Option<MotionSummary>; 3], turned: Option<Turned>, rate_hz: f64) -> Self {
        let mut found = Self { told: Vec::new(), broken: Vec::new() };
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
        self.told.push((channel, (kind, 1, text)));
    }

    fn lag(&mut self, channel: &'static str, of: &str, motion: &MotionSummary, rate_hz: f64) {
        let at_least = |s: f64, samples: f64| s.max(samples / rate_hz);
        let Some(lag_s) = motion.lag_s.filter(|lag| lag.abs() > at_least(LAG_S.told, LAG_SAMPLES.told))
        else {
            return;
        };
        let when = if lag_s > 0.0 { "after" } else { "before" };
        let text = format!(
            "comes {:.2} s {when} the derivative of {of}: compare the clocks, or say `delay_s`",
            lag_s.abs()
        );
        let is_broken = lag_s.abs() > at_least(LAG_S.broken, LAG_SAMPLES.broken);
        self.note(channel, WarningKind::Lag, text, is_broken);
    }

    fn gain(&mut self, channel: &'static str, of: &str, motion: &MotionSummary) {
        let Some(gain) = motion.gain.filter(|gain| (gain - 1.0).abs() > GAIN.told) else { return };
        let text = format!("is {gain:.3} times the derivative of {of}: check the units and scales of both");
        self.note(channel, WarningKind::Gain, text, (gain - 1.0).abs() > GAIN.broken);
    }

    fn turn(&mut self, turned: Option<Turned>) {
        let Some(Turned { angle, .. }) = turned.filter(|own| own.angle.abs() > TURN.told && own.left < LEFT)
        else {
            return;
        };
        let text = format!(
            "is {:.1} deg off what `y_u`, `y_v` and position say throughout: a magnetic heading, or a sensor that is turned?",
            angle.to_degrees()
        );
        self.note("psi", WarningKind::Bias, text, angle.abs() > TURN.broken);
    }
}
