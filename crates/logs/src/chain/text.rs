use std::fmt::Write;

use super::Recording;

impl Recording {
    /// As CSV: time, north, east, heading, and speed and angle of every thruster; rows without a fix have no
    /// position. The header says that the log is simulated.
    pub fn csv(&self, rate_hz: f64) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut out, rate_hz);
        out
    }

    fn write(&self, out: &mut String, rate_hz: f64) -> std::fmt::Result {
        out.push_str("simulated t [s],north [m],east [m],heading [deg]");
        for i in 1..=self.settings.first().map_or(0, Vec::len) {
            write!(out, ",thruster {i} [rpm],thruster {i} [deg]")?;
        }
        out.push('\n');
        for (k, heading) in self.heading.iter().enumerate() {
            write!(out, "{:.6},", k as f64 / rate_hz)?;
            match self.fixes[k] {
                Some([north, east]) => write!(out, "{north:.6},{east:.6}")?,
                None => out.push(','),
            }
            write!(out, ",{:.6}", heading.to_degrees())?;
            for setting in &self.settings[k] {
                write!(out, ",{:.4},{:.5}", 60.0 * setting.n, setting.alpha.to_degrees())?;
            }
            out.push('\n');
        }
        Ok(())
    }
}
