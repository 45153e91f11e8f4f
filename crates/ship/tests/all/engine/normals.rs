//! Normal numbers from given bits.

use std::convert::Infallible;

use rand::TryRng;
use ship::engine::fill_normals;

/// A generator whose numbers are these, and zeros after them.
struct Given(std::vec::IntoIter<u64>);

impl TryRng for Given {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        unreachable!("normal numbers take 64 bits")
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.0.next().unwrap_or(0))
    }

    fn try_fill_bytes(&mut self, _: &mut [u8]) -> Result<(), Infallible> {
        unreachable!("normal numbers take 64 bits")
    }
}

/// The two numbers of every pair of radius and angle.
fn normals(pairs: &[[u64; 2]]) -> Vec<[f64; 2]> {
    let mut out = vec![0.0; 2 * pairs.len()];
    fill_normals(Given(pairs.concat().into_iter()), &mut out);
    out.as_chunks::<2>().0.to_vec()
}

/// Box and Muller's numbers: the first 52 bits are a distance and an angle within an eighth of a turn, two further bits
/// of the angle a sign and an exchange.
fn expected([radius, angle]: [u64; 2]) -> [f64; 2] {
    let fraction = |bits: u64| (bits >> 12) as f64 * 2.0_f64.powi(-52);
    let distance = (-2.0 * libm::log(1.0 - fraction(radius))).sqrt();
    let turned = std::f64::consts::FRAC_PI_4 * (2.0 * fraction(angle) - 1.0);
    let sign = if angle >> 11 & 1 == 0 { 1.0 } else { -1.0 };
    let (along, across) = (sign * distance * libm::cos(turned), distance * libm::sin(turned));
    if angle >> 10 & 1 == 0 { [along, across] } else { [across, along] }
}

#[test]
fn oracle_numbers_are_those_of_box_and_muller() {
    let bits =
        |k: u64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    // Every second one far out in the tail: a uniform number of down to 2⁻⁵².
    let radius = |k: u64| if k.is_multiple_of(2) { bits(k) } else { !(bits(k) >> (k % 52)) };
    let pairs: Vec<[u64; 2]> = (1..100_001).map(|k| [radius(k), bits(k + 200_000)]).collect();
    for (pair, found) in pairs.iter().zip(normals(&pairs)) {
        for (found, expected) in found.into_iter().zip(expected(*pair)) {
            approx::assert_relative_eq!(found, expected, max_relative = 4e-10);
        }
    }
}

#[test]
fn extreme_bits_give_finite_numbers() {
    for radius in [0, u64::MAX, 1 << 63, 0xfff] {
        for angle in [0, u64::MAX, 1 << 10, 1 << 11] {
            let [one, two] = normals(&[[radius, angle]])[0];
            assert!(one.abs() < 8.5 && two.abs() < 8.5, "{radius} {angle}: {one} {two}");
        }
    }
}
