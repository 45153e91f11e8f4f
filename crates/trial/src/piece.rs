use vessel::Invalid;

/// A piece of a dictionary maneuver: what is run open loop as one use of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Name of the maneuver.
    pub maneuver: String,
    /// Surge speed at the start \[m/s\].
    pub speed_m_s: f64,
    /// N′ × inputs, row-major.
    pub inputs: Vec<f64>,
    /// N′.
    pub samples: usize,
}

impl Piece {
    /// The first `target` samples of a maneuver's `inputs` (N × `width`), or as many whole periods as come nearest where
    /// the inputs repeat themselves; all of it without a target.
    ///
    /// # Errors
    /// A target longer than the maneuver, or no sample at all.
    pub fn cut(
        maneuver: &str,
        speed_m_s: f64,
        inputs: &[f64],
        width: usize,
        target: Option<usize>,
    ) -> Result<Self, Invalid> {
        let all = inputs.len() / width.max(1);
        let wanted = target.unwrap_or(all);
        if wanted == 0 || wanted > all {
            return Err(Invalid::new(
                format!("piece of maneuver `{maneuver}`"),
                format!("{wanted} samples"),
                format!("1 to {all}, the maneuver's length in the dictionary"),
                "shorten the piece, or lengthen the maneuver in the dictionary",
            ));
        }
        let samples = match period(inputs, width) {
            Some(period) => {
                let whole = ((wanted as f64 / period as f64).round() as usize).clamp(1, all / period);
                whole * period
            }
            None => wanted,
        };
        let inputs = inputs[..samples * width].to_vec();
        Ok(Self { maneuver: maneuver.to_owned(), speed_m_s, inputs, samples })
    }
}

/// The period of inputs (N × `width`) in samples: the shortest shift that leaves all of them unchanged, to a millionth
/// of their range, over at least one further period.
pub fn period(inputs: &[f64], width: usize) -> Option<usize> {
    let samples = inputs.len() / width.max(1);
    let range = inputs.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let repeats = |shift: &usize| {
        inputs.iter().zip(&inputs[shift * width..]).all(|(a, b)| (a - b).abs() <= 1e-6 * range)
    };
    let constant = repeats(&1.min(samples));
    if constant { None } else { (2..=samples / 2).find(repeats) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(samples: usize, period: f64) -> Vec<f64> {
        (0..samples).map(|k| (std::f64::consts::TAU * k as f64 / period).sin()).collect()
    }

    #[test]
    fn swings_are_cut_at_whole_periods() {
        assert_eq!(period(&swing(300, 80.0), 1), Some(80));
        assert_eq!(Piece::cut("z", 1.0, &swing(300, 80.0), 1, Some(130)).unwrap().samples, 160);
        assert_eq!(Piece::cut("z", 1.0, &swing(300, 80.0), 1, None).unwrap().samples, 240);
    }

    #[test]
    fn sweeps_and_steps_are_cut_where_asked() {
        let sweep: Vec<f64> = (0..300).map(f64::from).collect();
        assert_eq!(Piece::cut("s", 1.0, &sweep, 1, Some(130)).unwrap().samples, 130);
        assert_eq!(Piece::cut("s", 1.0, &[2.0; 300], 1, Some(70)).unwrap().samples, 70);
        let error = Piece::cut("s", 1.0, &sweep, 1, Some(301)).unwrap_err();
        assert!(error.to_string().contains("1 to 300"), "{error}");
    }
}
