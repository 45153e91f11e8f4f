//! A thruster's forces as a table over its speed, and its pitch where it is controllable.

use refusal::Invalid;

/// Forces \[N\] at speeds, and at pitches if there are any, interpolated linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceTable {
    speeds: Vec<f64>,
    /// A single unused one where the table has no pitch.
    pitches: Vec<f64>,
    /// Row by row: all speeds at the first pitch, and so on.
    forces: Vec<f64>,
}

impl ForceTable {
    /// A table over `speeds` alone, or over `pitches` too: then with a row of `forces` for each.
    ///
    /// # Errors
    /// Speeds or pitches that do not increase, or forces that are not numbers or not one for each point.
    pub fn new(speeds: Vec<f64>, pitches: Option<Vec<f64>>, forces: Vec<Vec<f64>>) -> Result<Self, Invalid> {
        let axes = [("speed", Some(&speeds)), ("pitch", pitches.as_ref())];
        for (name, places) in axes.into_iter().filter_map(|(name, places)| Some((name, places?))) {
            let rising = places.windows(2).all(|pair| pair[0] < pair[1]);
            if places.len() < 2 || !rising || places.iter().any(|place| !place.is_finite()) {
                let found = format!("{places:?}");
                let expected = "at least two numbers that increase";
                return Err(Invalid::new(format!("`{name}` of a table"), found, expected, "correct them"));
            }
        }
        let pitches = pitches.unwrap_or_else(|| vec![0.0]);
        let whole = forces.len() == pitches.len() && forces.iter().all(|row| row.len() == speeds.len());
        if !whole || forces.iter().flatten().any(|force| !force.is_finite()) {
            let lengths: Vec<usize> = forces.iter().map(Vec::len).collect();
            let expected = format!(
                "{} rows of {} numbers: a row per pitch, a force per speed",
                pitches.len(),
                speeds.len()
            );
            let found = format!("rows of {lengths:?} numbers");
            return Err(Invalid::new("forces of a table", found, expected, "correct them"));
        }
        Ok(Self { speeds, pitches, forces: forces.concat() })
    }

    /// The force at a speed and a pitch, which a table without pitches ignores; NaN where either is NaN.
    ///
    /// # Errors
    /// The value outside of the table, and the table's range.
    pub fn force(&self, speed: f64, pitch: f64) -> Result<f64, (Axis, f64, [f64; 2])> {
        let pitched = self.pitches.len() > 1;
        if speed.is_nan() || pitched && pitch.is_nan() {
            return Ok(f64::NAN);
        }
        let (n, along) = place(&self.speeds, speed).map_err(|range| (Axis::Speed, speed, range))?;
        let row = |p: usize| {
            let row = &self.forces[p * self.speeds.len()..];
            row[n] + along * (row[n + 1] - row[n])
        };
        if !pitched {
            return Ok(row(0));
        }
        let (p, across) = place(&self.pitches, pitch).map_err(|range| (Axis::Pitch, pitch, range))?;
        let (low, high) = (row(p), row(p + 1));
        Ok(low + across * (high - low))
    }
}

/// An axis of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The speed.
    Speed,
    /// The pitch.
    Pitch,
}

/// The interval of `places` that contains `at`, and the fraction along it; the whole range where `at` lies
/// outside.
fn place(places: &[f64], at: f64) -> Result<(usize, f64), [f64; 2]> {
    let (first, last) = (places[0], places[places.len() - 1]);
    if !(first..=last).contains(&at) {
        return Err([first, last]);
    }
    let i = (places.partition_point(|place| *place <= at) - 1).min(places.len() - 2);
    Ok((i, (at - places[i]) / (places[i + 1] - places[i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_plane_is_met_everywhere_and_nothing_outside() {
        let plane = |n: f64, p: f64| 3.0 + 2.0 * n - 0.5 * p;
        let (speeds, pitches) = (vec![-2.0, 0.5, 4.0], vec![-10.0, 0.0, 20.0]);
        let forces = pitches.iter().map(|p| speeds.iter().map(|n| plane(*n, *p)).collect()).collect();
        let table = ForceTable::new(speeds.clone(), Some(pitches), forces).unwrap();
        for (n, p) in [(-2.0, -10.0), (4.0, 20.0), (0.5, 0.0), (1.3, 7.0), (-0.2, -3.0)] {
            assert!((table.force(n, p).unwrap() - plane(n, p)).abs() < 1e-12);
        }
        assert_eq!(table.force(4.1, 0.0), Err((Axis::Speed, 4.1, [-2.0, 4.0])));
        assert_eq!(table.force(0.0, -11.0), Err((Axis::Pitch, -11.0, [-10.0, 20.0])));
        assert!(table.force(f64::NAN, 0.0).unwrap().is_nan());
        let line = ForceTable::new(speeds, None, vec![vec![-8.0, 0.0, 7.0]]).unwrap();
        assert_eq!([line.force(4.0, 0.0), line.force(-1.0, f64::NAN)], [Ok(7.0), Ok(-4.8)]);
    }
}
