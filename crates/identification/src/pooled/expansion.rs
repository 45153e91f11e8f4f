/// A sum of numbers without rounding, as numbers that do not overlap, the smallest first: Shewchuk, *Discrete &
/// Computational Geometry* 18, 1997. So the sum of the same numbers is the same in any order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expansion(Vec<f64>);

impl Expansion {
    /// The sum of `numbers`.
    pub fn of(numbers: &[f64]) -> Self {
        let mut sum = Self::default();
        numbers.iter().for_each(|number| sum.add(*number));
        sum
    }

    /// Adds `number`.
    pub fn add(&mut self, number: f64) {
        let (mut carried, mut kept) = (number, 0);
        for i in 0..self.0.len() {
            let (sum, error) = two_sum(self.0[i], carried);
            if error != 0.0 {
                self.0[kept] = error;
                kept += 1;
            }
            carried = sum;
        }
        self.0.truncate(kept);
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        other.0.iter().for_each(|number| self.add(*number));
    }

    /// The sum, rounded once; no finite number where it is too large.
    pub fn value(&self) -> f64 {
        let mut rest = self.0.iter().rev();
        let mut high = rest.next().copied().unwrap_or(0.0);
        let mut low = 0.0;
        for number in rest.by_ref() {
            (high, low) = two_sum(high, *number);
            if low != 0.0 {
                break;
            }
        }
        // Half way between two numbers, what comes next decides.
        let next = rest.next().copied().unwrap_or(0.0);
        let (further, twice) = (high + 2.0 * low, 2.0 * low);
        if low * next > 0.0 && further - high == twice { further } else { high }
    }

    /// The sum as numbers each of which is what is left of it, rounded, the largest first: the same for equal sums.
    pub fn numbers(&self) -> Vec<f64> {
        let (mut left, mut numbers) = (self.clone(), Vec::new());
        loop {
            let value = left.value();
            if value == 0.0 || !value.is_finite() {
                return numbers;
            }
            numbers.push(value);
            left.add(-value);
        }
    }
}

/// a + b rounded, and what rounding leaves (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let other = sum - a;
    (sum, (a - (sum - other)) + (b - other))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of very different size: k 2^(e−60).
    fn numbers() -> Vec<(i128, u32)> {
        let digits = |i: i128| (i * 7_919 + 13) * 104_729 % 1_000_003 - 500_000;
        (0..300).map(|i| (digits(i), (i * 31 % 97) as u32)).collect()
    }

    #[test]
    fn law_a_sum_is_exact_in_any_order() {
        let float = |(k, e): &(i128, u32)| *k as f64 * f64::powi(2.0, *e as i32 - 60);
        let all = numbers();
        let whole: i128 = all.iter().map(|(k, e)| k << e).sum();
        let forth = Expansion::of(&all.iter().map(float).collect::<Vec<_>>());
        let mut back = Expansion::of(&all[100..].iter().rev().map(float).collect::<Vec<_>>());
        back.merge(&Expansion::of(&all[..100].iter().map(float).collect::<Vec<_>>()));
        // A whole number becomes the nearest f64.
        assert_eq!(forth.value(), whole as f64 * f64::powi(2.0, -60));
        assert_eq!((forth.value(), forth.numbers()), (back.value(), back.numbers()));
        assert_eq!(Expansion::of(&forth.numbers()).numbers(), forth.numbers());
        assert_eq!(Expansion::of(&[1e100, 1.0, -1e100]).numbers(), [1.0]);
    }

    #[test]
    fn law_half_way_what_is_left_decides() {
        let eps = f64::EPSILON;
        assert_eq!(Expansion::of(&[1.0, eps / 2.0]).value(), 1.0);
        assert_eq!(Expansion::of(&[1.0, eps / 2.0, 1e-40]).value(), 1.0 + eps);
        assert_eq!(Expansion::of(&[1.0, eps / 2.0, -1e-40]).value(), 1.0);
    }
}
