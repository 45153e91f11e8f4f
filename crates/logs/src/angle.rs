use std::f64::consts::TAU;

/// Removes jumps of more than half a turn between neighbours \[rad\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwrapping {
    last: Option<f64>,
    turns: f64,
}

impl Unwrapping {
    /// The next angle, without a jump from the previous one.
    pub fn next(&mut self, angle: f64) -> f64 {
        if let Some(last) = self.last {
            let step = angle + self.turns - last;
            self.turns -= TAU * (step / TAU).round();
        }
        // The first angle is passed on bit for bit.
        let unwrapped = if self.last.is_some() { angle + self.turns } else { angle };
        self.last = Some(unwrapped);
        unwrapped
    }
}
