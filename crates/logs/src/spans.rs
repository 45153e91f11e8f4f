//! When each needed channel was logged, where that was hardly at the same time.

use refusal::Invalid;

use crate::source::called;
use crate::stamp::moment;
use crate::suspicion::{Oddity, WarningKind};
use crate::{Channels, Source};

/// Share of a recording that some needed channel may not cover.
const UNCOVERED: f64 = 0.1;

/// Needed channels by their first and last times \[s\].
pub(crate) struct Spans(Vec<([f64; 2], Vec<String>)>);

impl Spans {
    /// Of those of `channels` that are `needed`, whose clock starts at `start_s`.
    pub(crate) fn of<'a>(channels: &Channels, needed: impl Iterator<Item = &'a str>, start_s: f64) -> Self {
        let mut all: Vec<([f64; 2], Vec<String>)> = Vec::new();
        for name in needed {
            let Some(t) = channels.get(name).map(|series| &series.t) else { continue };
            let (Some(first), Some(last)) = (t.first(), t.last()) else { continue };
            let span = [start_s + first, start_s + last];
            match all.iter_mut().find(|(own, _)| *own == span) {
                Some((_, names)) => names.push(format!("`{name}`")),
                None => all.push((span, vec![format!("`{name}`")])),
            }
        }
        Self(all)
    }

    /// The time that all have in common, and the channels that begin last and end first (or last, where these are the same), in
    /// words.
    fn common(&self) -> Option<([f64; 2], String)> {
        let late = self.0.iter().max_by(|a, b| a.0[0].total_cmp(&b.0[0]))?;
        let early = self.0.iter().min_by(|a, b| a.0[1].total_cmp(&b.0[1]))?;
        let other = self.0.iter().filter(|own| own.0 != late.0).max_by(|a, b| a.0[1].total_cmp(&b.0[1]));
        let is_dated = self.0.iter().any(|([_, to], _)| *to > 1e8);
        let said = |([from, to], names): &([f64; 2], Vec<String>)| {
            let [from, to] =
                [from, to].map(|end| if is_dated { moment(*end) } else { format!("{end:.1} s") });
            format!("{} from {from} to {to}", names.join(", "))
        };
        let first = if early.0 == late.0 { other? } else { early };
        Some(([late.0[0], early.0[1]], format!("{}; {}", said(late), said(first))))
    }

    /// Refuses channels that were never logged at the same time.
    pub(crate) fn check(&self, source: &Source) -> Result<(), Invalid> {
        let Some((_, said)) = self.common().filter(|([from, to], _)| from > to) else { return Ok(()) };
        Err(Invalid::new(
            called(&source.name),
            said,
            "channels that were logged at the same time",
            "check the clock of each [[file]]: simulated time beside a computer's? Name one that all have as `time`, such as \
             `log_time` of bags, or set its `offset_s`",
        ))
    }

    /// The warning where not all channels cover much of the recording.
    pub(crate) fn uncovered(&self, max_gap_s: f64) -> Option<(String, Oddity)> {
        let ([from, to], said) = self.common()?;
        let end = |end: usize, more: fn(f64, f64) -> f64| self.0.iter().map(|own| own.0[end]).reduce(more);
        let whole_s = end(1, f64::max)? - end(0, f64::min)?;
        let lost_s = whole_s - (to - from);
        let text = format!(
            "and others cover different times, {lost_s:.1} s of {whole_s:.1} s ({:.0} %) are not covered by all: {said}; compare the \
             clocks",
            100.0 * lost_s / whole_s
        );
        let name = said.split('`').nth(1)?.to_owned();
        (lost_s > (UNCOVERED * whole_s).max(2.0 * max_gap_s)).then_some((name, (WarningKind::Clock, 1, text)))
    }
}
