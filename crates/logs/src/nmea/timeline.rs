//! The sequence of the clock's times: midnights, late sentences, leap seconds, receivers that do not know the date yet.

use jiff::civil::Date;
use jiff::tz::TimeZone;

use super::sentence::Sentence;

/// A reported time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stamp {
    /// What it is \[s\].
    pub(crate) time: f64,
    /// As reported, without `added`.
    raw: f64,
    /// Leap seconds and weeks added to it \[s\].
    added: f64,
    is_sixty: bool,
}

/// The effect of a reported time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ClockStep {
    /// No time is known.
    Unknown,
    /// Time advances.
    To(Stamp),
    /// The sentence was late: time stays. If it is unclear which sentence was late, the times since the last
    /// but one are in doubt.
    Late { in_doubt: bool },
    /// Time goes back, and continues from there.
    Back(Stamp),
    /// The clock was set.
    Set(Stamp),
}

/// A period in which the clock was not set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Era {
    pub(super) first: Stamp,
    /// The number of times, and how many of them a receiver with a fix reported.
    pub(super) stamps: usize,
    pub(super) fixes: usize,
}

/// The times so far.
#[derive(Debug, Default)]
pub(super) struct Timeline {
    pub(crate) last: Option<Stamp>,
    /// The last two steps \[s\].
    steps: [f64; 2],
    pub(super) eras: Vec<Era>,
    /// Late sentences in a row, and the latest of them \[s\].
    late: (usize, f64),
    leap: f64,
    weeks: f64,
    /// How many times had so many weeks added.
    by_weeks: Vec<(f64, usize)>,
    pub(super) leaps: usize,
    /// From where on times are a second later than reported.
    pub(super) leap_s: Option<f64>,
}

/// A receiver that does not know the time yet differs by less than this, or the clock was set \[s\].
const NEAR: f64 = 3600.0;

/// Sentences are not later than this \[s\].
const LATEST: f64 = 600.0;

/// So many late sentences in a row are not late: the clock was set back.
const MANY: usize = 3;

/// Clocks that jump further have another date \[s\].
const YEAR: f64 = 365.0 * DAY;

/// A step that is this many times as long as the previous one follows a lost time, or a wrong one.
const LONG: f64 = 1.5;

/// `difference` of two times of day, wrapped to half a day \[s\].
fn wrapped(difference: f64) -> f64 {
    difference - DAY * (difference / DAY).round()
}

impl Timeline {
    /// Takes the next reported time; `is_dated` says whether such sentences have a date.
    pub(crate) fn next(&mut self, reported: Option<Reported>, is_dated: bool) -> ClockStep {
        let Some(reported) = reported.filter(|reported| reported.midnight.is_some() || !is_dated) else {
            return ClockStep::Unknown;
        };
        let Some(last) = self.last else {
            let raw = reported.midnight.unwrap_or(0.0) + reported.of_day;
            return ClockStep::To(self.set(self.stamp(raw, &reported), &reported));
        };
        self.count_leap(&last, &reported);
        let raw = reported
            .midnight
            .map_or_else(|| undated(&last, &reported), |midnight| midnight + reported.of_day);
        let mut stamp = self.stamp(raw, &reported);
        let mut step = stamp.time - last.time;
        if let Some(weeks) =
            [-WEEKS, WEEKS].into_iter().find(|weeks| (-LATEST..NEAR).contains(&(step + weeks)))
        {
            self.weeks += weeks;
            stamp = self.stamp(raw, &reported);
            step += weeks;
        }
        let far = !(0.0..=NEAR).contains(&step);
        let knew = self.eras.last().is_some_and(|era| era.fixes > 0);
        match reported.is_fix {
            false if knew && far => ClockStep::Unknown,
            true if !knew && far => ClockStep::Set(self.set(stamp, &reported)),
            _ if step.abs() > YEAR => ClockStep::Set(self.set(stamp, &reported)),
            _ if step < 0.0 => self.late(stamp, &last, &reported),
            _ => ClockStep::To(self.advance(stamp, step, &reported)),
        }
    }

    /// Detects the second after a leap second that repeats its time: from there on all times are a second later.
    fn count_leap(&mut self, last: &Stamp, reported: &Reported) {
        let since = wrapped(last.raw - reported.of_day);
        if last.is_sixty && !reported.is_sixty && (0.0..1.0).contains(&since) {
            self.leap += 1.0;
            self.leaps += 1;
            self.leap_s.get_or_insert(last.time.floor() + 1.0);
        }
    }

    fn stamp(&self, raw: f64, reported: &Reported) -> Stamp {
        let added = self.leap + self.weeks;
        Stamp { time: raw + added, raw, added, is_sixty: reported.is_sixty }
    }

    fn set(&mut self, first: Stamp, reported: &Reported) -> Stamp {
        self.eras.push(Era { first, stamps: 0, fixes: 0 });
        self.steps = [f64::NAN; 2];
        self.advance(first, f64::NAN, reported)
    }

    fn advance(&mut self, stamp: Stamp, step: f64, reported: &Reported) -> Stamp {
        if step != 0.0 {
            self.steps = [self.steps[1], step];
        }
        self.late = (0, f64::NEG_INFINITY);
        self.last = Some(stamp);
        if let Some(era) = self.eras.last_mut() {
            era.stamps += 1;
            era.fixes += usize::from(reported.is_fix);
        }
        match self.by_weeks.iter_mut().find(|(weeks, _)| *weeks == self.weeks) {
            Some((_, count)) => *count += 1,
            None => self.by_weeks.push((self.weeks, 1)),
        }
        stamp
    }

    /// A time before the last.
    fn late(&mut self, stamp: Stamp, last: &Stamp, reported: &Reported) -> ClockStep {
        let (count, latest) = self.late;
        let in_row = if stamp.time > latest { count + 1 } else { 1 };
        if in_row >= MANY || last.time - stamp.time > LATEST {
            return ClockStep::Back(self.advance(stamp, f64::NAN, reported));
        }
        self.late = (in_row, stamp.time);
        let [before, step] = self.steps;
        let is_long = step > LONG * before;
        ClockStep::Late { in_doubt: is_long && last.time - stamp.time < step }
    }

    /// The weeks to be added to all times so that most of them are as reported \[s\], and how many are not then.
    pub(super) fn weeks(&self) -> (f64, usize) {
        let most = self.by_weeks.iter().max_by_key(|(_, count)| *count).map_or(0.0, |(weeks, _)| *weeks);
        let others = self.by_weeks.iter().filter(|(weeks, _)| *weeks != most).map(|(_, count)| count).sum();
        (-most, others)
    }
}

/// A time of day after `last`, on the nearest day: a day passes from evening to morning.
fn undated(last: &Stamp, reported: &Reported) -> f64 {
    let day = DAY * (last.raw / DAY).floor();
    let of_day = last.raw - day;
    let late = of_day < NEAR && reported.of_day > DAY - NEAR && !reported.is_sixty;
    let passed = reported.of_day - of_day < -0.5 * DAY;
    day + reported.of_day + if late { -DAY } else { f64::from(u8::from(passed)) * DAY }
}

impl Stamp {
    /// The time next to this one with the reported time of day.
    fn nearest(&self, reported: &Reported) -> f64 {
        self.raw + wrapped(reported.of_day - self.raw) + self.added
    }

    /// How much later than this the reported time of day is \[s\].
    pub(super) fn until(&self, reported: &Reported) -> f64 {
        wrapped(reported.of_day - self.raw)
    }

    /// Whether `reported` is this time of day, or up to `after` later \[s\].
    pub(super) fn is_reached(&self, reported: &Reported, after: f64) -> bool {
        reported.is_sixty == self.is_sixty && (-1e-6..after).contains(&self.until(reported))
    }
}

/// A sentence's own time, between those of the clock before and after it \[s\], and its distance outside of
/// these. `None` where the clock never had a time.
pub(super) fn own_time(
    reported: &Reported,
    before: Option<Stamp>,
    after: Option<Stamp>,
) -> Option<(f64, f64)> {
    let away =
        |stamp: &Stamp| (stamp.is_sixty != reported.is_sixty, (stamp.nearest(reported) - stamp.time).abs());
    let ends = || [before, after].into_iter().flatten();
    let anchor = ends().min_by(|a, b| away(a).partial_cmp(&away(b)).unwrap_or(std::cmp::Ordering::Equal))?;
    let mut time = anchor.nearest(reported);
    // The reported date differs.
    if let Some(midnight) = reported.midnight.filter(|_| anchor.raw > YEAR) {
        let dated = midnight + reported.of_day + anchor.added;
        if (dated - time).abs() > 0.5 * DAY
            && (dated - time - WEEKS * ((dated - time) / WEEKS).round()).abs() > 0.5 * DAY
        {
            time = dated;
        }
    }
    let early = before.map_or(0.0, |before| before.time - time);
    let late = after.map_or(0.0, |after| time - after.time);
    Some((time, early.max(late).max(0.0)))
}

/// A time that a sentence reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reported {
    /// Since midnight \[s\]; from 86,400 in a leap second.
    pub(crate) of_day: f64,
    /// From 1970 to that midnight, if the date is reported \[s\].
    pub(crate) midnight: Option<f64>,
    /// Whether it lies in a leap second.
    is_sixty: bool,
    /// Whether the receiver has a fix.
    pub(crate) is_fix: bool,
}

/// Sentences with a time, and the field of the time.
const TIMED: [(&str, usize); 5] = [("RMC", 0), ("ZDA", 0), ("GGA", 0), ("GNS", 0), ("GLL", 4)];

/// Whether sentences whose addresses end with `kind` have a time.
pub(super) fn has_time(kind: &str) -> bool {
    TIMED.iter().any(|(known, _)| kind.ends_with(known)) && !kind.starts_with('P') && kind.len() <= 5
}

/// Whether they have a date.
pub(crate) fn is_dated(kind: &str) -> bool {
    kind.ends_with("RMC") || kind.ends_with("ZDA")
}

/// The time in `sentence`: `None` where it is of another kind or has none.
pub(crate) fn reported_time<'a>(
    sentence: &Sentence<'a>,
) -> Result<Option<Reported>, (&'a str, &'static str)> {
    let Some((kind, place)) = TIMED.iter().find(|(kind, _)| sentence.is_a(kind)) else { return Ok(None) };
    let text = sentence.field(*place);
    if text.is_empty() {
        return Ok(None);
    }
    let is_fix = is_fix(kind, sentence);
    let (date, midnight) = match *kind {
        "RMC" => (sentence.field(8), joined(sentence.field(8))),
        "ZDA" => (sentence.field(3), apart([1, 2, 3].map(|place| sentence.field(place)))),
        _ => ("", None),
    };
    // A receiver without a date writes nothing, or zeros.
    let dateless = date.bytes().all(|byte| byte == b'0');
    match of_day(text) {
        Some((of_day, is_sixty)) if midnight.is_some() || dateless || !is_fix => {
            // A receiver that does not know the date yet begins with the first day of its week count.
            let is_fix = is_fix && !(*kind == "ZDA" && midnight.is_some_and(is_first_day));
            Ok(Some(Reported { of_day, midnight, is_sixty, is_fix }))
        }
        Some(_) => Err((date, "a valid date")),
        None if is_fix => Err((text, "a time such as 123519.00")),
        None => Ok(None),
    }
}

fn is_fix(kind: &str, sentence: &Sentence) -> bool {
    match kind {
        "RMC" => sentence.field(1) == "A",
        "GLL" => sentence.field(5) == "A",
        "GGA" => !["", "0"].contains(&sentence.field(5)),
        "GNS" => sentence.field(5).chars().any(|mode| mode != 'N'),
        _ => true,
    }
}

/// Period of the receivers' week count \[s\].
const WEEKS: f64 = 1024.0 * 7.0 * DAY;

pub(crate) const DAY: f64 = 86_400.0;

/// From 1970 to their first week \[s\].
const FIRST: f64 = 315_964_800.0;

/// Whether a day is within two days of the start of a week count.
fn is_first_day(midnight: f64) -> bool {
    (midnight - FIRST).rem_euclid(WEEKS) < 2.0 * DAY
}

/// Seconds since midnight of `hhmmss.ss`, and whether it is a second 60.
fn of_day(text: &str) -> Option<(f64, bool)> {
    let whole = text.get(..6)?.bytes().all(|byte| byte.is_ascii_digit());
    let part = |from: usize, to: usize| text.get(from..to)?.parse::<u8>().ok().map(f64::from);
    let (hours, minutes) = (part(0, 2)?, part(2, 4)?);
    let seconds: f64 = text.get(4..)?.parse().ok()?;
    let fits = whole && hours < 24.0 && minutes < 60.0 && (0.0..61.0).contains(&seconds);
    fits.then_some((3600.0 * hours + 60.0 * minutes + seconds, seconds >= 60.0))
}

/// Seconds from 1970 to the day `ddmmyy`, in the years from 1980 on.
fn joined(text: &str) -> Option<f64> {
    let year = text.get(4..6)?;
    let century = if year >= "80" { "19" } else { "20" };
    apart([text.get(0..2)?, text.get(2..4)?, &format!("{century}{year}")])
}

fn apart([day, month, year]: [&str; 3]) -> Option<f64> {
    let date = Date::new(year.parse().ok()?, month.parse().ok()?, day.parse().ok()?).ok()?;
    let midnight = date.to_zoned(TimeZone::UTC).ok()?.timestamp();
    Some(midnight.as_duration().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reported(of_day: f64, midnight: Option<f64>, is_fix: bool) -> Option<Reported> {
        let is_sixty = false;
        Some(Reported { of_day, midnight, is_sixty, is_fix })
    }

    /// The times that result from times of day, as far as time advances.
    fn advanced(times: &[f64]) -> Vec<f64> {
        let mut timeline = Timeline::default();
        let step = |time: &f64| timeline.next(reported(*time, None, true), false);
        let time = |step| if let ClockStep::To(stamp) = step { Some(stamp.time) } else { None };
        times.iter().map(step).filter_map(time).collect()
    }

    #[test]
    fn a_day_passes_from_evening_to_morning_alone() {
        assert_eq!(advanced(&[86_399.0, 0.0, 1.0]), [86_399.0, 86_400.0, 86_401.0]);
        assert_eq!(advanced(&[86_399.0, 0.0, 86_399.0, 1.0]), [86_399.0, 86_400.0, 86_401.0]);
        assert_eq!(advanced(&[0.0, 86_399.0, 1.0]), [0.0, 1.0]);
        assert_eq!(advanced(&[3600.0, 50_000.0, 80_000.0, 100.0]), [3600.0, 50_000.0, 80_000.0, 86_500.0]);
        assert_eq!(advanced(&[40_000.0, 39_990.0, 40_001.0]), [40_000.0, 40_001.0]);
    }

    #[test]
    fn a_clock_that_is_set_back_goes_on_from_there() {
        let mut timeline = Timeline::default();
        let mut step = |time: f64| timeline.next(reported(time, Some(1.7e9), true), true);
        step(100.0);
        assert_eq!([step(83.0), step(84.0)], [ClockStep::Late { in_doubt: false }; 2]);
        assert!(matches!(step(85.0), ClockStep::Back(stamp) if stamp.time == 1.7e9 + 85.0));
        assert!(matches!(step(86.0), ClockStep::To(_)));
    }

    #[test]
    fn a_leap_second_and_weeks_that_begin_anew_move_what_follows() {
        let mut timeline = Timeline::default();
        let day = 1_483_142_400.0;
        timeline.next(reported(86_399.0, Some(day), true), true);
        timeline.next(
            Some(Reported { of_day: 86_400.0, midnight: Some(day), is_sixty: true, is_fix: true }),
            true,
        );
        let after = timeline.next(reported(0.0, Some(day + DAY), true), true);
        assert!(matches!(after, ClockStep::To(stamp) if stamp.time == day + DAY + 1.0), "{after:?}");
        let earlier = timeline.next(reported(1.0, Some(day + DAY - WEEKS), true), true);
        assert!(matches!(earlier, ClockStep::To(stamp) if stamp.time == day + DAY + 2.0), "{earlier:?}");
        assert_eq!((timeline.leaps, timeline.weeks()), (1, (0.0, 1)));
    }

    #[test]
    fn a_receiver_that_knows_no_time_yet_sets_the_clock_when_it_does() {
        let mut timeline = Timeline::default();
        timeline.next(reported(12.0, Some(315_964_800.0), false), true);
        let set = timeline.next(reported(33_000.0, Some(1.7e9), true), true);
        assert!(matches!(set, ClockStep::Set(_)), "{set:?}");
        assert_eq!(timeline.next(reported(13.0, Some(315_964_800.0), false), true), ClockStep::Unknown);
        assert_eq!(timeline.eras.iter().map(|era| era.fixes).collect::<Vec<_>>(), [0, 1]);
    }

    #[test]
    fn the_time_of_a_sentence_is_that_next_to_the_clocks() {
        let stamp = |time| Stamp { time, raw: time, added: 0.0, is_sixty: false };
        let time_of = |of_day, before, after| own_time(&reported(of_day, None, true).unwrap(), before, after);
        let day = 1_700_006_400.0;
        assert_eq!(time_of(10.0, None, None), None);
        assert_eq!(time_of(0.5, Some(stamp(day)), Some(stamp(day + 1.0))), Some((day + 0.5, 0.0)));
        assert_eq!(time_of(86_399.0, Some(stamp(day)), None), Some((day - 1.0, 1.0)));
        assert_eq!(time_of(3600.0, Some(stamp(day)), Some(stamp(day + 1.0))), Some((day + 3600.0, 3599.0)));
    }

    #[test]
    fn days_and_times_are_read_as_the_standard_writes_them() {
        assert_eq!(of_day("123519.25"), Some((45_319.25, false)));
        assert_eq!(of_day("235960"), Some((86_400.0, true)));
        assert_eq!([of_day("246000"), of_day("1235"), of_day("")], [None; 3]);
        assert_eq!(joined("310720"), Some(1_596_153_600.0));
        assert_eq!(apart(["31", "07", "2020"]), Some(1_596_153_600.0));
        assert_eq!([joined("310220"), joined("3107")], [None; 2]);
    }

    #[test]
    fn years_from_1980_on_are_those_of_the_receivers() {
        let first = joined("060180").unwrap();
        assert_eq!(first, FIRST);
        assert!([first, joined("220899").unwrap(), joined("070419").unwrap()].into_iter().all(is_first_day));
        assert!(!is_first_day(joined("110425").unwrap()));
    }
}
