use std::f64::consts::TAU;

/// Removes jumps of more than half a turn between neighbours, in place \[rad\].
pub fn unwrap(angles: &mut [f64]) {
    let mut turns = 0.0;
    for i in 1..angles.len() {
        let step = angles[i] + turns - angles[i - 1];
        turns -= TAU * (step / TAU).round();
        angles[i] += turns;
    }
}
