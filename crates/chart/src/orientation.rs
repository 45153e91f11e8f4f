//! On which side of a line a point lies, decided exactly: ring checks must not depend on rounding.

use std::cmp::Ordering;

/// `Greater` where a, b, c turn left, `Less` where they turn right, `Equal` where they are on one line.
/// Exact for finite coordinates whose products neither overflow nor underflow.
pub fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Ordering {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    let det = left - right;
    // Shewchuk's bound of the rounding error: (3 + 16 ε) ε, ε = 2⁻⁵³.
    if det.abs() > 3.3306690738754716e-16 * (left.abs() + right.abs()) {
        return det.total_cmp(&0.0);
    }
    exact_sign([(a[0], b[1]), (-a[0], c[1]), (-c[0], b[1]), (-a[1], b[0]), (a[1], c[0]), (c[1], b[0])])
}

/// Whether segments p q and r s cross at a point inside both.
pub fn cross_properly(p: [f64; 2], q: [f64; 2], r: [f64; 2], s: [f64; 2]) -> bool {
    let opposite = |a: Ordering, b: Ordering| a != Ordering::Equal && a == b.reverse();
    opposite(turn(p, q, r), turn(p, q, s)) && opposite(turn(r, s, p), turn(r, s, q))
}

/// Sign of a sum of products, by an expansion of non-overlapping terms that grows without rounding.
fn exact_sign(products: [(f64, f64); 6]) -> Ordering {
    let mut parts = [0.0; 12];
    let mut used = 0;
    for (x, y) in products {
        let product = x * y;
        for term in [x.mul_add(y, -product), product] {
            let mut sum = term;
            for part in &mut parts[..used] {
                let (total, error) = two_sum(sum, *part);
                *part = error;
                sum = total;
            }
            parts[used] = sum;
            used += 1;
        }
    }
    let leading = parts.iter().rev().find(|v| **v != 0.0);
    leading.map_or(Ordering::Equal, |v| v.total_cmp(&0.0))
}

/// The rounded sum and its error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}
