//! Quaternions to heading, roll and pitch.

use refusal::Invalid;

use crate::columns::cell_of;
use crate::{Cells, QuaternionSpec, Samples};

/// Heading, roll and pitch \[rad\] of the quaternion in `cells` (w, x, y, z), as far as `spec` names channels
/// for them: rotations about the vertical, the forward and the transverse axis, in this order. `line` says on
/// which line a row stands.
///
/// # Errors
/// The first row whose quaternion is not of unit length or puts the ship upside down, which means that its
/// axes are different ones.
pub(crate) fn angles(
    spec: &QuaternionSpec,
    cells: [Cells; 4],
    line: impl Fn(usize) -> String,
) -> Result<Vec<Cells>, Invalid> {
    let [w, x, y, z] = cells.map(numbers);
    let [mut heading, mut roll, mut pitch] = [w.none(), w.none(), w.none()];
    let rows = w.iter().zip(x.iter()).zip(y.iter().zip(z.iter()));
    for (row, ((w, x), (y, z))) in rows.enumerate() {
        let q = [w, x, y, z];
        check(spec, q, || line(row))?;
        let norm = (w * w + x * x + y * y + z * z).sqrt();
        let [yaw, own_roll, own_pitch] = of_unit(q.map(|part| part / norm));
        heading.push(yaw);
        roll.push(own_roll);
        pitch.push(own_pitch);
    }
    let roll = spec.roll.is_some().then_some(roll);
    let pitch = spec.pitch.is_some().then_some(pitch);
    Ok([Some(heading), roll, pitch].into_iter().flatten().map(Cells::Numbers).collect())
}

fn numbers(cells: Cells) -> Samples {
    match cells {
        Cells::Numbers(numbers) => numbers,
        Cells::Labels(_) => unreachable!("quaternions are read as numbers"),
    }
}

/// Refuses quaternions that are not the rotation of a ship; one with a missing component is missing.
fn check(spec: &QuaternionSpec, [w, x, y, z]: [f64; 4], line: impl Fn() -> String) -> Result<(), Invalid> {
    let length = libm::sqrt(w * w + x * x + y * y + z * z);
    let called = || cell_of(line(), &spec.columns().map(String::as_str).join("`, `"));
    if (length - 1.0).abs() > spec.tolerance {
        return Err(Invalid::new(
            called(),
            format!("a quaternion of length {length:.4}"),
            format!("length 1, give or take {}", spec.tolerance),
            "correct or empty the row, check the columns, or raise the quaternion's `tolerance`",
        ));
    }
    // Compares the ship's vertical with the earth's.
    if 1.0 - 2.0 * (x * x + y * y) < 0.0 {
        return Err(Invalid::new(
            called(),
            "a quaternion that puts the ship upside down",
            "one from forward, starboard, down to north, east, down, or from forward, port, up to east, north, up",
            "check the order of the columns w, x, y, z and the axes",
        ));
    }
    Ok(())
}

/// Yaw, roll and pitch of a unit quaternion.
fn of_unit([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let yaw = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let roll = libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
    // Rounding may exceed a right angle slightly.
    let pitch = libm::asin((2.0 * (w * y - z * x)).clamp(-1.0, 1.0));
    [yaw, roll, pitch]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of rotations about z, y and x by these angles.
    fn turned(yaw: f64, pitch: f64, roll: f64) -> [f64; 4] {
        let product = |[a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]| {
            [
                a * e - b * f - c * g - d * h,
                a * f + b * e + c * h - d * g,
                a * g - b * h + c * e + d * f,
                a * h + b * g - c * f + d * e,
            ]
        };
        let half = |angle: f64| (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
        let ((sz, cz), (sy, cy), (sx, cx)) = (half(yaw), half(pitch), half(roll));
        product(product([cz, 0.0, 0.0, sz], [cy, 0.0, sy, 0.0]), [cx, sx, 0.0, 0.0])
    }

    #[test]
    fn law_the_angles_that_a_quaternion_was_made_of_come_back() {
        for (yaw, pitch, roll) in [(0.3, 0.1, -0.2), (3.1, -1.2, 0.7), (-2.0, 0.0, 1.5), (0.0, 1.5, 0.0)] {
            let found = of_unit(turned(yaw, pitch, roll));
            for (found, expected) in found.into_iter().zip([yaw, roll, pitch]) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}
