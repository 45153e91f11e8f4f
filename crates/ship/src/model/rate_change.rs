/// How a sample follows from the steps that the terms hold for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RateChange {
    /// It is one.
    #[default]
    Own,
    /// It is as many, one after the other.
    Repeated(u32),
    /// It is a part of one, by Newton's forward formula.
    Divided {
        /// How many samples make a step.
        by: u32,
        /// Order of the formula: how many steps ahead it looks.
        order: u32,
    },
}

/// The order of Newton's forward formula.
pub const ORDER: u32 = 4;

impl RateChange {
    /// The weights of the states after one, two, … steps; what they lack in 1 is that of the state before the first. Sums of
    /// differences Δᵏ of the states times s (s − 1) … (s − k + 1) / k!, where s is a part of a step.
    pub fn weights(self) -> Vec<f64> {
        match self {
            Self::Own => vec![1.0],
            Self::Repeated(count) => {
                let mut weights = vec![0.0; count as usize];
                if let Some(last) = weights.last_mut() {
                    *last = 1.0;
                }
                weights
            }
            Self::Divided { by, order } => {
                let mut weights = vec![0.0; order as usize + 1];
                let part = 1.0 / f64::from(by);
                let mut factor = 1.0;
                for k in 0..=order {
                    // Δᵏ is the sum of (−1)^(k − j) (k over j) times state j.
                    let mut share = factor * if k % 2 == 0 { 1.0 } else { -1.0 };
                    for j in 0..=k {
                        weights[j as usize] += share;
                        share *= -f64::from(k - j) / f64::from(j + 1);
                    }
                    factor *= (part - f64::from(k)) / f64::from(k + 1);
                }
                weights.split_off(1)
            }
        }
    }
}
