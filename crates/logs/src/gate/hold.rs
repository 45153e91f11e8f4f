//! Stretches in which a channel has exactly the same value.

use crate::Series;

/// Values in a row that may be the same by chance, on a channel that hardly ever repeats one.
const ROWS: usize = 5;

/// Seconds that they may take.
const SHORT_S: f64 = 3.0;

/// Lengths that are counted one by one.
const LENGTHS: usize = 1024;

/// A stretch with one value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hold {
    /// The value; of a place the first of its two.
    pub(super) value: f64,
    /// The first time and the last \[s\].
    pub(super) times: [f64; 2],
    /// Modulus of the step to it and from it; NaN where there is none, or a gap.
    pub(super) step_in: f64,
    pub(super) step_out: f64,
    rows: usize,
}

/// All stretches of a channel that may be long.
pub(super) struct Holds {
    candidates: Vec<Hold>,
    /// Length that nine tenths of all stretches do not exceed, most of a single row.
    usual: usize,
    /// Mean modulus of the steps between stretches.
    pub(super) step: f64,
}

/// What is counted while a channel is gone through.
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

    /// Whether it lasts from the start of what is known, or until its end.
    pub(super) fn is_cut(&self) -> bool {
        self.step_in.is_nan() || self.step_out.is_nan()
    }

    /// Moments within it, one per row but no more than some.
    pub(super) fn moments(&self) -> impl Iterator<Item = f64> + use<> {
        const MOST: usize = 1000;
        let ([from, to], steps) = (self.times, self.rows.clamp(2, MOST) - 1);
        (0..=steps).map(move |i| from + (to - from) * i as f64 / steps as f64)
    }
}

impl Holds {
    /// Of `first`, or of a place whose other coordinate is `second`; `step` is how far two values are apart.
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

    /// Those that are far longer than what the channel repeats usually.
    pub(super) fn long(&self) -> impl Iterator<Item = Hold> {
        self.candidates.iter().filter(|hold| hold.rows >= ROWS * self.usual).cloned()
    }

    /// Whether hardly any value is the one before, as under the noise of a sensor that is finely resolved.
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
