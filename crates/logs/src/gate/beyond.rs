//! Angles beyond a turn: those of a heading that was logged unwrapped, or no headings at all.

/// Consecutive numbers that continue each other before they are taken for a heading that kept counting over a
/// gap.
const IN_A_ROW: usize = 5;

/// Judges angles beyond a turn, which are kept where they continue the previous ones.
pub(super) struct Beyond {
    /// A turn, in the column's unit.
    turn: f64,
    start: Start,
    /// The last number that was kept.
    kept: Option<f64>,
    /// The last number that was not kept, and how many of these continue each other.
    dropped: (f64, usize),
    /// How many numbers are beyond a turn, of how many: where most are, the unit is in doubt and not the
    /// numbers. `None` for a heading.
    seen: Option<[usize; 2]>,
}

/// How a column begins.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    /// Beyond a turn; the last number so far.
    Open(Option<f64>),
    /// With angles.
    Fine,
    /// With numbers that are not angles.
    Wrong,
}

impl Beyond {
    /// For a column whose angles have this `turn`.
    pub(super) fn new(turn: f64, is_heading: bool) -> Self {
        let seen = (!is_heading).then_some([0; 2]);
        Self { turn, start: Start::Open(None), kept: None, dropped: (f64::NAN, 0), seen }
    }

    fn is_beyond(&self, number: f64) -> bool {
        number.abs() > 1.001 * self.turn
    }

    fn continues(&self, from: f64, to: f64) -> bool {
        (to - from).abs() <= 0.5 * self.turn
    }

    /// First pass: the first numbers are judged by those after them.
    #[inline]
    pub(super) fn see(&mut self, number: f64) {
        if let Some([beyond, all]) = &mut self.seen {
            *beyond += usize::from(number.abs() > 1.001 * self.turn);
            *all += 1;
        }
        if let Start::Open(last) = self.start {
            self.start = match last {
                Some(last) if !self.continues(last, number) => Start::Wrong,
                _ if self.is_beyond(number) => Start::Open(Some(number)),
                _ => Start::Fine,
            };
        }
    }

    /// Second pass: whether a number is an angle.
    #[inline]
    pub(super) fn keeps(&mut self, number: f64) -> bool {
        if self.seen.is_some_and(|[beyond, all]| 2 * beyond > all) {
            return true;
        }
        let keeps = !self.is_beyond(number)
            || match self.kept {
                Some(kept) => self.continues(kept, number) || self.again(number),
                None => self.start != Start::Wrong || self.again(number),
            };
        if keeps {
            (self.kept, self.dropped) = (Some(number), (f64::NAN, 0));
        }
        keeps
    }

    /// Whether a number continues so many dropped ones that they are not a fault.
    fn again(&mut self, number: f64) -> bool {
        let (last, count) = self.dropped;
        let moves = number != last && self.continues(last, number);
        self.dropped = (number, if moves { count + 1 } else { 0 });
        self.dropped.1 >= IN_A_ROW
    }
}
