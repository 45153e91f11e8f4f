//! Inputs as a correction of those at the start: piecewise linear between knots.

/// Corrections of inputs at knots, `knot` samples apart, in units of half the width of the inputs' limits.
pub(super) struct Signal<'a> {
    /// Inputs at the start, N × inputs.
    start: &'a [f64],
    /// Lowest and highest value of every input.
    limits: &'a [[f64; 2]],
    knot: usize,
}

impl<'a> Signal<'a> {
    pub(super) fn new(start: &'a [f64], limits: &'a [[f64; 2]], knot: usize) -> Self {
        Self { start, limits, knot }
    }

    fn samples(&self) -> usize {
        self.start.len() / self.limits.len().max(1)
    }

    /// Knots of every input: the first at sample 0, the last at the last sample or after it.
    pub(super) fn knots(&self) -> usize {
        self.samples().saturating_sub(1).div_ceil(self.knot) + 1
    }

    /// The knot before sample `k`, and the fraction of the way to the next.
    fn place(&self, k: usize) -> (usize, f64) {
        (k / self.knot, (k % self.knot) as f64 / self.knot as f64)
    }

    /// Bounds of the corrections that keep every sample within the limits: those of the nearest samples.
    pub(super) fn bounds(&self) -> [Vec<f64>; 2] {
        let width = self.limits.len();
        let mut low = vec![f64::NEG_INFINITY; self.knots() * width];
        let mut high = vec![f64::INFINITY; self.knots() * width];
        for (k, row) in self.start.chunks_exact(width).enumerate() {
            let (knot, share) = self.place(k);
            let touched = if share > 0.0 { knot..knot + 2 } else { knot..knot + 1 };
            for (i, x) in touched.flat_map(|m| row.iter().enumerate().map(move |(i, x)| (m * width + i, x))) {
                let [middle, half] = centred(self.limits[i % width]);
                let start = ((x - middle) / half).clamp(-1.0, 1.0);
                low[i] = low[i].max(-1.0 - start);
                high[i] = high[i].min(1.0 - start);
            }
        }
        let unused = |x: &f64| x.is_infinite();
        low.iter_mut().chain(&mut high).filter(|x| unused(x)).for_each(|x| *x = 0.0);
        [low, high]
    }

    /// The inputs of corrections, N × inputs, never beyond the limits by rounding.
    pub(super) fn inputs(&self, corrections: &[f64]) -> Vec<f64> {
        let width = self.limits.len();
        let of = |(e, x): (usize, &f64)| {
            let (knot, share) = self.place(e / width);
            let at = |m: usize| corrections.get(m * width + e % width).copied().unwrap_or(0.0);
            let correction =
                if share > 0.0 { (1.0 - share) * at(knot) + share * at(knot + 1) } else { at(knot) };
            let [low, high] = self.limits[e % width];
            let [_, half] = centred([low, high]);
            if correction == 0.0 { *x } else { (x + half * correction).clamp(low, high) }
        };
        self.start.iter().enumerate().map(of).collect()
    }

    /// The gradient by the corrections from that by the inputs.
    pub(super) fn gathered(&self, slopes: &[f64]) -> Vec<f64> {
        let width = self.limits.len();
        let mut out = vec![0.0; self.knots() * width];
        for (e, slope) in slopes.iter().enumerate() {
            let (knot, share) = self.place(e / width);
            let slope = slope * centred(self.limits[e % width])[1];
            out[knot * width + e % width] += (1.0 - share) * slope;
            if share > 0.0 {
                out[(knot + 1) * width + e % width] += share * slope;
            }
        }
        out
    }
}

/// Middle and half width of limits.
pub(super) fn centred([low, high]: [f64; 2]) -> [f64; 2] {
    [0.5 * (low + high), 0.5 * (high - low)]
}
