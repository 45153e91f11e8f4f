//! Angles beyond a turn: those of a heading that went on counting, or of no heading at all.

/// Numbers in a row that go on from each other before they are taken for a heading that counts on after a gap.
const IN_A_ROW: usize = 5;

/// Tells apart angles beyond a turn, which are kept where they go on from those before them.
pub(super) struct Beyond {
    /// A turn, in the column's unit.
    turn: f64,
    start: Start,
    /// The last that was kept.
    kept: Option<f64>,
    /// The last that was not, and how many went on from each other.
    dropped: (f64, usize),
    /// Where most are beyond a turn the unit is in doubt, and no number: how many are, of how many. None of a heading.
    seen: Option<[usize; 2]>,
}

/// How a column begins.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    /// Beyond a turn, with this number last.
    Open(Option<f64>),
    /// As angles do.
    Fine,
    /// With numbers that are no angles.
    Wrong,
}

impl Beyond {
    /// Of a column whose angles have this `turn`.
    pub(super) fn new(turn: f64, is_heading: bool) -> Self {
        let seen = (!is_heading).then_some([0; 2]);
        Self { turn, start: Start::Open(None), kept: None, dropped: (f64::NAN, 0), seen }
    }

    fn is_beyond(&self, number: f64) -> bool {
        number.abs() > 1.001 * self.turn
    }

    fn goes_on(&self, from: f64, to: f64) -> bool {
        (to - from).abs() <= 0.5 * self.turn
    }

    /// Looks at a number: the first ones are judged by those after them.
    #[inline]
    pub(super) fn see(&mut self, number: f64) {
        if let Some([beyond, all]) = &mut self.seen {
            *beyond += usize::from(number.abs() > 1.001 * self.turn);
            *all += 1;
        }
        if let Start::Open(last) = self.start {
            self.start = match last {
                Some(last) if !self.goes_on(last, number) => Start::Wrong,
                _ if self.is_beyond(number) => Start::Open(Some(number)),
                _ => Start::Fine,
            };
        }
    }

    /// Whether a number is an angle; all have been seen.
    #[inline]
    pub(super) fn keeps(&mut self, number: f64) -> bool {
        if self.seen.is_some_and(|[beyond, all]| 2 * beyond > all) {
            return true;
        }
        let keeps = !self.is_beyond(number)
            || match self.kept {
                Some(kept) => self.goes_on(kept, number) || self.again(number),
                None => self.start != Start::Wrong || self.again(number),
            };
        if keeps {
            (self.kept, self.dropped) = (Some(number), (f64::NAN, 0));
        }
        keeps
    }

    /// Whether a number goes on from as many others that were left out as no fault makes.
    fn again(&mut self, number: f64) -> bool {
        let (last, count) = self.dropped;
        let moves = number != last && self.goes_on(last, number);
        self.dropped = (number, if moves { count + 1 } else { 0 });
        self.dropped.1 >= IN_A_ROW
    }
}
