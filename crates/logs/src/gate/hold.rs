//! Holds: rows in which a channel has exactly the same value.

use crate::Series;

/// Equal values in a row that may occur by chance, on a channel that hardly ever repeats one.
const ROWS: usize = 5;

/// Seconds that they may take.
const SHORT_S: f64 = 3.0;

/// Hold lengths that are counted individually.
const LENGTHS: usize = 1024;

/// Consecutive rows with one value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hold {
    /// The value; for a position the first of its two coordinates.
    pub(super) value: f64,
    /// The first and the last time \[s\].
    pub(super) times: [f64; 2],
    /// Modulus of the steps to it and from it; NaN where there is none, or a gap.
    pub(super) step_in: f64,
    pub(super) step_out: f64,
    rows: usize,
}

/// All potentially long holds of a channel.
pub(super) struct Holds {
    candidates: Vec<Hold>,
    /// Length that nine tenths of all holds do not exceed, most of them a single row.
    usual: usize,
    /// Mean modulus of the steps between holds.
    pub(super) step: f64,
}

/// Counts during a pass over a channel.
struct Counting {
    candidates: Vec<Hold>,
    lengths: Vec<u64>,
    steps: (f64, u64),
}

impl Hold {
    pub(super) fn duration_s(&self) -> f64 {
        self.times[1] - self.times[0]
    }

    /// Whether it begins or ends by a step of more than `step`.
    pub(super) fn is_abrupt(&self, step: f64) -> bool {
        self.step_in > step || self.step_out > step
    }

    /// Whether it lasts from the first known row, or until the last.
    pub(super) fn is_cut(&self) -> bool {
        self.step_in.is_nan() || self.step_out.is_nan()
    }

    /// Times within it, one per row up to a limit.
    pub(super) fn moments(&self) -> impl Iterator<Item = f64> + use<> {
        const MOST: usize = 1000;
        let ([from, to], steps) = (self.times, self.rows.clamp(2, MOST) - 1);
        (0..=steps).map(move |i| from + (to - from) * i as f64 / steps as f64)
    }
}

impl Holds {
    /// The holds of `first`, or of a position whose other coordinate is `second`; `step` is the distance
    /// between two values.
    pub(super) fn of(
        first: &Series,
        second: Option<&Series>,
        step: impl Fn([f64; 2], [f64; 2]) -> f64,
    ) -> Self {
        let mut counting = Counting { candidates: Vec::new(), lengths: vec![0; LENGTHS], steps: (0.0, 0) };
        let mut seconds = second.map(|second| second.at(first.t.iter()));
        let (mut hold, mut value): (Option<Hold>, _) = (None, [f64::NAN; 2]);
        for (time, first_value) in first.t.iter().zip(first.values.iter()) {
            let next =
                [first_value, seconds.as_mut().map_or(0.0, |seconds| seconds.next().unwrap_or(f64::NAN))];
            let gap = hold.as_ref().is_some_and(|hold| time - hold.times[1] > first.max_gap_s);
            match &mut hold {
                Some(hold) if !gap && next == value => (hold.times[1], hold.rows) = (time, hold.rows + 1),
                _ => {
                    let own = if gap { f64::NAN } else { step(value, next) };
                    if let Some(hold) = hold.take() {
                        counting.close(Hold { step_out: own, ..hold });
                    }
                    let begun = Hold {
                        value: first_value,
                        times: [time; 2],
                        step_in: own,
                        step_out: f64::NAN,
                        rows: 1,
                    };
                    (hold, value) = (Some(begun), next);
                }
            }
        }
        hold.into_iter().for_each(|hold| counting.close(hold));
        counting.done()
    }

    /// Those that are far longer than the channel's usual ones.
    pub(super) fn long(&self) -> impl Iterator<Item = Hold> {
        self.candidates.iter().filter(|hold| hold.rows >= ROWS * self.usual).cloned()
    }

    /// Whether hardly any value repeats the previous one, as under the noise of a finely resolved sensor.
    pub(super) fn hardly_repeat(&self) -> bool {
        self.usual == 1
    }
}

impl Counting {
    fn close(&mut self, hold: Hold) {
        self.lengths[hold.rows.min(LENGTHS) - 1] += 1;
        if hold.step_out > 0.0 {
            self.steps = (self.steps.0 + hold.step_out, self.steps.1 + 1);
        }
        if hold.rows >= ROWS && hold.duration_s() >= SHORT_S {
            self.candidates.push(hold);
        }
    }

    fn done(self) -> Holds {
        let all: u64 = self.lengths.iter().sum();
        let mut so_far = 0;
        let usual = self.lengths.iter().position(|count| {
            so_far += count;
            so_far * 10 >= all * 9
        });
        let step = self.steps.0 / self.steps.1.max(1) as f64;
        Holds { candidates: self.candidates, usual: usual.map_or(1, |place| place + 1), step }
    }
}
