//! Numbers and names of `plan.toml` that are written well and still make no sense.

use trial::Mode;
use trial::voyage::AT_REST;
use vessel::{Invalid, MOST_CURRENT_M_S};

use super::file::PlanFile;

/// A number: its key, where it may be (above or from the first, up to the second), and its unit.
type Range = (String, f64, Least, f64, &'static str);

/// Whether the least value of a range belongs to it.
#[derive(Clone, Copy)]
enum Least {
    Above(f64),
    From(f64),
}

impl PlanFile {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub(super) fn check(&self) -> Result<(), Invalid> {
        self.handling.check()?;
        let positive = [
            ("cell_m", self.cell_m),
            ("hull.length_m", self.hull.length_m),
            ("hull.beam_m", self.hull.beam_m),
            ("approach.tolerance_cells", self.approach.tolerance_cells),
            ("approach.tolerance_deg", self.approach.tolerance_deg),
            ("informative_s", self.informative_s.unwrap_or(1.0)),
        ];
        let not_negative = [
            ("safety.margin_m", self.safety.margin_m),
            ("safety.transit_depth_m", self.safety.transit_depth_m),
            ("safety.trial_depth_m", self.safety.trial_depth_m),
            ("safety.unknown_current_m_s", self.safety.unknown_current_m_s),
            ("safety.parameter_error", self.safety.parameter_error),
            ("approach.run_in_s", self.approach.run_in_s),
            ("known_current.speed_m_s", self.known_current.map_or(0.0, |c| c.speed_m_s)),
        ];
        let bad = |(key, value): &(&str, f64), least: f64, expected: &str| {
            let fine = value.is_finite() && (*value > least || (least < 0.0 && *value >= 0.0));
            (!fine).then(|| Invalid::new(format!("`{key}`"), value.to_string(), expected, "correct it"))
        };
        let refused = positive.iter().find_map(|p| bad(p, 0.0, "a number above 0"));
        let refused =
            refused.or_else(|| not_negative.iter().find_map(|p| bad(p, -1.0, "a number from 0 up")));
        match refused {
            Some(invalid) => Err(invalid),
            None => self.check_choices().and_then(|()| self.check_ranges()),
        }
    }

    fn check_choices(&self) -> Result<(), Invalid> {
        if ![4, 8, 16].contains(&self.headings) {
            return Err(Invalid::new("`headings`", self.headings.to_string(), "4, 8 or 16", "correct it"));
        }
        if self.raster_per_cell == 0 || self.raster_per_cell % 2 == 1 || self.raster_per_cell > 64 {
            let found = self.raster_per_cell.to_string();
            return Err(Invalid::new(
                "`raster_per_cell`",
                found,
                "an even number from 2 to 64",
                "correct it",
            ));
        }
        if self.safety.trial_depth_m < self.safety.transit_depth_m {
            return Err(Invalid::new(
                "`safety.trial_depth_m`",
                self.safety.trial_depth_m.to_string(),
                format!("at least the transit depth, {}", self.safety.transit_depth_m),
                "informative maneuvers need the deeper water",
            ));
        }
        let a = self.area;
        let ordered = a.west_deg < a.east_deg && a.south_deg < a.north_deg;
        if !ordered || a.west_deg < -180.0 || a.east_deg > 180.0 || a.south_deg < -90.0 || a.north_deg > 90.0
        {
            let found = format!("{} to {} E, {} to {} N", a.west_deg, a.east_deg, a.south_deg, a.north_deg);
            return Err(Invalid::new(
                "`area`",
                found,
                "west below east, south below north, in degrees",
                "correct it",
            ));
        }
        let slow = self.speed_mode.iter().find(|m| !(m.speed_m_s.is_finite() && m.speed_m_s > 0.0));
        match slow {
            Some(mode) => Err(Invalid::new(
                format!("speed mode `{}`", mode.name),
                format!("{} m/s", mode.speed_m_s),
                "a speed above 0 m/s",
                "being at rest is always there where the vessel can hold it: leave it out",
            )),
            None => Ok(()),
        }
    }

    /// Refuses numbers out of any sensible range, and speed modes that cannot be told apart.
    fn check_ranges(&self) -> Result<(), Invalid> {
        let outside = |(_, value, least, most, _): &Range| {
            let low = match *least {
                Least::Above(least) => *value > least,
                Least::From(least) => *value >= least,
            };
            !(low && value <= most)
        };
        let Some((thing, value, least, most, unit)) = self.ranges().into_iter().find(outside) else {
            return self.check_modes();
        };
        let least = match least {
            Least::Above(least) => format!("above {least}"),
            Least::From(least) => format!("from {least}"),
        };
        Err(Invalid::new(thing, value.to_string(), format!("{least} to {most} {unit}"), "correct it"))
    }

    fn ranges(&self) -> Vec<Range> {
        let (hull, safety, known) = (self.hull, self.safety, self.known_current);
        let half = hull.length_m / 2.0;
        let keys = [
            ("hull.length_m", hull.length_m, Least::Above(0.0), 1000.0, "m"),
            ("hull.beam_m", hull.beam_m, Least::Above(0.0), 1000.0, "m"),
            ("hull.reference_m", hull.reference_m, Least::From(-half), half, "m, a point of the hull"),
            ("safety.margin_m", safety.margin_m, Least::From(0.0), 1e5, "m"),
            (
                "safety.unknown_current_m_s",
                safety.unknown_current_m_s,
                Least::From(0.0),
                MOST_CURRENT_M_S,
                "m/s",
            ),
            ("safety.parameter_error", safety.parameter_error, Least::From(0.0), 0.99, "(1 is 100 %)"),
            ("safety.runs", f64::from(safety.runs), Least::From(1.0), 1e6, "runs"),
            ("approach.run_in_s", self.approach.run_in_s, Least::From(0.0), 1e4, "s"),
            (
                "known_current.speed_m_s",
                known.map_or(0.0, |c| c.speed_m_s),
                Least::From(0.0),
                MOST_CURRENT_M_S,
                "m/s",
            ),
            (
                "known_current.towards_deg",
                known.map_or(0.0, |c| c.towards_deg),
                Least::From(-360.0),
                360.0,
                "degrees",
            ),
        ];
        let keys = keys.map(|(key, value, least, most, unit)| (format!("`{key}`"), value, least, most, unit));
        let pieces = self.maneuver.iter().filter_map(|m| {
            let thing = format!("`piece_s` of maneuver `{}`", m.name);
            Some((thing, m.piece_s?, Least::Above(0.0), 1e7, "s"))
        });
        let around = self.chart.iter().filter_map(|chart| {
            let thing = format!("`radius_m` of chart `{}`", chart.file.display());
            Some((thing, chart.radius_m?, Least::Above(0.0), 1e4, "m"))
        });
        keys.into_iter().chain(pieces).chain(around).collect()
    }

    fn check_modes(&self) -> Result<(), Invalid> {
        let refuse = |mode: &Mode, found: String, expected: &str| {
            let thing = format!("speed mode `{}`", mode.name);
            Err(Invalid::new(thing, found, expected, "correct it or leave it out"))
        };
        for (index, mode) in self.speed_mode.iter().enumerate() {
            let earlier = &self.speed_mode[..index];
            if mode.name == AT_REST {
                return refuse(mode, "the name of being at rest".to_owned(), "another name");
            }
            if mode.speed_m_s > 50.0 {
                return refuse(mode, format!("{} m/s", mode.speed_m_s), "at most 50 m/s");
            }
            if earlier.iter().any(|m| m.name == mode.name) {
                return refuse(mode, "the name twice".to_owned(), "every name once");
            }
            if let Some(other) = earlier.iter().find(|m| m.speed_m_s == mode.speed_m_s) {
                let found = format!("{} m/s, the speed of mode `{}`", mode.speed_m_s, other.name);
                return refuse(mode, found, "every speed once");
            }
        }
        Ok(())
    }
}
