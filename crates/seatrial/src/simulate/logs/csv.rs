use logs::chain::Recording;

/// A recording as CSV: time, north, east, heading, and speed and angle of every thruster; rows without a fix have no
/// position. The header says that it is simulated.
pub fn text(recording: &Recording, rate_hz: f64) -> String {
    let thrusters = recording.settings.first().map_or(0, Vec::len);
    let mut out = "simulated t [s],north [m],east [m],heading [deg]".to_owned();
    for i in 1..=thrusters {
        out.push_str(&format!(",thruster {i} [rpm],thruster {i} [deg]"));
    }
    out.push('\n');
    for (k, heading) in recording.heading.iter().enumerate() {
        out.push_str(&format!("{:.6},", k as f64 / rate_hz));
        match recording.fixes[k] {
            Some([north, east]) => out.push_str(&format!("{north:.6},{east:.6}")),
            None => out.push(','),
        }
        out.push_str(&format!(",{:.6}", heading.to_degrees()));
        for setting in &recording.settings[k] {
            out.push_str(&format!(",{:.4},{:.5}", 60.0 * setting.n, setting.alpha.to_degrees()));
        }
        out.push('\n');
    }
    out
}
