use std::ops::Range;

use crate::{Grid, Stretch};

/// A stretch of samples that is to be one sub-experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its samples; the row at `samples.end` holds the state after the last.
    pub samples: Range<usize>,
    /// Name of the maneuver.
    pub maneuver: String,
}

/// How a recording becomes sub-experiments.
#[derive(Clone, Debug, PartialEq)]
pub enum Cut {
    /// All of it is one.
    Whole {
        /// Its maneuver.
        maneuver: String,
    },
    /// Windows of equal length, one after the other; what is left at the end of a stretch is too short.
    Windows {
        /// Samples per window.
        samples: usize,
        /// What the maneuvers' names begin with.
        kind: String,
        /// Speed classes that their names end with.
        classes: Option<SpeedClasses>,
    },
    /// As labelled: rows and maneuver; in order, without overlap.
    Labels(Vec<Part>),
}

/// Names for ranges of the mean speed over ground.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedClasses {
    /// Bounds between the classes, increasing \[m/s\].
    pub bounds_m_s: Vec<f64>,
    /// One name more than bounds.
    pub names: Vec<String>,
}

impl SpeedClasses {
    /// The class of rows with surge `u` and sway `v`.
    pub fn of(&self, u: &[f64], v: &[f64]) -> &str {
        let mean = u.iter().zip(v).map(|(u, v)| u.hypot(*v)).sum::<f64>() / u.len() as f64;
        &self.names[self.bounds_m_s.iter().filter(|bound| mean >= **bound).count()]
    }
}

/// The sub-experiments of one stretch, in order, and how many were left out for having fewer than `least` samples.
/// `u` and `v` are surge and sway on the grid \[m/s\].
pub fn cut(cut: &Cut, stretch: &Stretch, [u, v]: [&[f64]; 2], least: usize) -> (Vec<Part>, usize) {
    let all = stretch.start..stretch.start + stretch.samples;
    let parts = match cut {
        Cut::Whole { maneuver } => vec![Part { samples: all, maneuver: maneuver.clone() }],
        Cut::Windows { samples, kind, classes } => {
            let window = |start: usize| {
                let range = start..(start + samples).min(all.end);
                let maneuver = match classes {
                    Some(classes) => format!("{kind}/{}", classes.of(&u[range.clone()], &v[range.clone()])),
                    None => kind.clone(),
                };
                Part { samples: range, maneuver }
            };
            all.clone().step_by((*samples).max(1)).map(window).collect()
        }
        Cut::Labels(parts) => parts.iter().filter_map(|part| overlap(part, &all)).collect(),
    };
    let found = parts.len();
    let least = if let Cut::Windows { samples, .. } = cut { least.max(*samples) } else { least };
    let kept: Vec<Part> = parts.into_iter().filter(|part| part.samples.len() >= least.max(1)).collect();
    let short = found - kept.len();
    (kept, short)
}

fn overlap(part: &Part, all: &Range<usize>) -> Option<Part> {
    let samples = part.samples.start.max(all.start)..part.samples.end.min(all.end);
    (!samples.is_empty()).then(|| Part { samples, maneuver: part.maneuver.clone() })
}

/// The samples from `from_s` to `to_s` \[s\], both rows included, as one sub-experiment.
pub fn within(grid: &Grid, from_s: f64, to_s: f64, maneuver: &str) -> Part {
    let rows = grid.rows_within(from_s, to_s);
    Part { samples: rows.start..rows.end.saturating_sub(1).max(rows.start), maneuver: maneuver.to_owned() }
}

/// One sub-experiment per stretch of equal labels; `labels` hold from their time in `times` on. Rows under an empty label,
/// or before the first label, belong to none.
pub fn labelled(grid: &Grid, times: &[f64], labels: &[String]) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    for (row, time) in grid.times().into_iter().enumerate() {
        let place = times.partition_point(|t| *t <= time + 1e-6);
        let label = place.checked_sub(1).map_or("", |place| labels[place].trim());
        match parts.last_mut() {
            Some(part) if part.maneuver == label && part.samples.end == row => part.samples.end += 1,
            _ if label.is_empty() => {}
            _ => parts.push(Part { samples: row..row + 1, maneuver: label.to_owned() }),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(parts: &[Part]) -> Vec<(usize, usize, &str)> {
        parts.iter().map(|p| (p.samples.start, p.samples.end, p.maneuver.as_str())).collect()
    }

    #[test]
    fn windows_are_whole_and_named_by_speed() {
        let u: Vec<f64> = (0..26).map(|k| 0.02 * f64::from(k)).collect();
        let v = vec![0.0; 26];
        let classes = SpeedClasses {
            bounds_m_s: vec![0.15, 0.3],
            names: ["slow", "medium", "fast"].map(String::from).into(),
        };
        let windows = Cut::Windows { samples: 10, kind: "zigzag".into(), classes: Some(classes) };
        let stretch = Stretch { start: 1, samples: 24 };
        let (parts, short) = cut(&windows, &stretch, [&u, &v], 1);
        assert_eq!(ranges(&parts), [(1, 11, "zigzag/slow"), (11, 21, "zigzag/fast")]);
        assert_eq!(short, 1);
    }

    #[test]
    fn labels_hold_until_the_next_and_empty_ones_belong_to_nothing() {
        let grid = Grid { start_s: 0.0, rate_hz: 1.0, rows: 9 };
        let labels = ["a", "a", "", "b"].map(String::from);
        let parts = labelled(&grid, &[1.0, 2.0, 4.0, 5.5], &labels);
        assert_eq!(ranges(&parts), [(1, 4, "a"), (6, 9, "b")]);
        let (parts, short) =
            cut(&Cut::Labels(parts), &Stretch { start: 2, samples: 5 }, [&[0.0; 9], &[0.0; 9]], 2);
        assert_eq!(ranges(&parts), [(2, 4, "a")]);
        assert_eq!(short, 1);
    }

    #[test]
    fn an_interval_of_ten_seconds_has_ten_samples() {
        let grid = Grid { start_s: 0.0, rate_hz: 2.0, rows: 100 };
        assert_eq!(within(&grid, 5.0, 15.0, "turn").samples, 10..30);
        assert!(within(&grid, 500.0, 600.0, "turn").samples.is_empty());
    }
}
