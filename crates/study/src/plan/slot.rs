//! The time slot of a trial in `plan.toml`.

use plan::voyage::{Area, Daylight, Slot};
use refusal::Invalid;

use super::file::PlanFile;
use super::task::second;
use super::tide::in_words;

impl PlanFile {
    /// The end of the slot for a trial that begins at `departure` \[s since 1970, UTC\], if `[slot]` has one.
    ///
    /// # Errors
    /// A slot that is empty or ends before it begins, a departure that is unknown or outside of it, a day without
    /// sun.
    pub(super) fn slot(&self, area: &Area, departure: Option<i64>) -> Result<Option<Slot>, Invalid> {
        let Some(spec) = &self.slot else { return Ok(None) };
        let time = |key: &str, text: &Option<String>| {
            text.as_ref().map(|text| second(key, text)).transpose().map(|at| at.map(|at| at as f64))
        };
        let (from, until) = (time("slot.from", &spec.from)?, time("slot.until", &spec.until)?);
        if from.is_none() && until.is_none() && !spec.daylight {
            let expected = "`from`, `until` or `daylight = true`";
            return Err(Invalid::new("`slot`", "none of its keys", expected, "add one, or leave it out"));
        }
        if let (Some(from), Some(until)) = (from, until)
            && until <= from
        {
            let expected = format!("a time after `slot.from`, {}", in_words(from));
            return Err(Invalid::new("`slot.until`", in_words(until), expected, "correct one of them"));
        }
        let Some(departure) = departure.map(|at| at as f64) else {
            let remedy = "say when the trial begins, such as departure = \"2026-06-01T08:00:00Z\"";
            return Err(Invalid::new("`departure`", "none", "a time, since there is a [slot]", remedy));
        };
        let bounds = [("slot.from", from), ("slot.until", until)];
        let day = if spec.daylight { daylight(area, departure)? } else { None };
        let [begins, ends] = [0, 1].map(|k: usize| {
            let sun = day.map(|day| ("slot.daylight", day[k]));
            [bounds[k].1.map(|at| (bounds[k].0, at)), sun].into_iter().flatten()
        });
        let begins = begins.max_by(|a, b| a.1.total_cmp(&b.1));
        let ends = ends.min_by(|a, b| a.1.total_cmp(&b.1));
        let outside = |expected: String| {
            let remedy = "take another departure, or another slot";
            Err(Invalid::new("`departure`", in_words(departure), expected, remedy))
        };
        match (begins, ends) {
            (Some((key, at)), _) if departure < at => {
                outside(format!("{} or later, by `{key}`", in_words(at)))
            }
            (_, Some((key, at))) if departure >= at => {
                outside(format!("before {}, by `{key}`", in_words(at)))
            }
            _ => Ok(ends.map(|(key, at)| Slot { key, lasts_s: at - departure })),
        }
    }
}

/// Sunrise and sunset at the centre of the area, to the second within the day; `None` if the sun does not set.
fn daylight(area: &Area, departure: f64) -> Result<Option<[f64; 2]>, Invalid> {
    let [longitude_deg, latitude_deg] = area.centre_deg();
    match Daylight::of([longitude_deg, latitude_deg], departure) {
        Daylight::Between([rise, set]) => Ok(Some([rise.ceil(), set.floor()])),
        Daylight::Always => Ok(None),
        Daylight::Never => {
            let found =
                format!("no sunrise at latitude {latitude_deg:.1} on the day of {}", in_words(departure));
            let remedy = "take another day, or leave `daylight` out";
            Err(Invalid::new("`slot.daylight`", found, "a day with sun", remedy))
        }
    }
}
