//! Costs as integers: one unit that divides all of them, and both criteria in one key.

use crate::lattice::{Cost, Invalid};

/// The finest decimal of a cost.
const FINEST_DECIMAL: i32 = 9;
/// Largest sum of keys, so that sums and differences stay within 64 bits.
const LARGEST_SUM: u128 = 1 << 61;

/// The common unit of one criterion: `unit = divisor / 10^decimals`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    ten: f64,
    divisor: u64,
    /// Largest cost in units.
    largest: u64,
}

impl Scale {
    fn of(criterion: &str, costs: &[f64]) -> Result<Self, Invalid> {
        let ten = (0..FINEST_DECIMAL).map(|k| 10f64.powi(k)).find(|&ten| costs.iter().all(|&c| fits(c, ten)));
        let ten = ten.unwrap_or(10f64.powi(FINEST_DECIMAL));
        if let Some(&cost) = costs.iter().find(|&&cost| cost * ten > 1e15) {
            let thing = format!("{criterion} cost");
            let expected = format!("at most {:e} with so many decimals", 1e15 / ten);
            return Err(Invalid::new(thing, cost.to_string(), expected, "give costs with fewer digits"));
        }
        let whole = || costs.iter().map(|&cost| (cost * ten).round() as u64);
        let divisor = whole().fold(0, gcd).max(1);
        Ok(Self { ten, divisor, largest: whole().max().unwrap_or(0) / divisor })
    }

    fn units(&self, cost: f64) -> u64 {
        (cost * self.ten).round() as u64 / self.divisor
    }

    fn cost(&self, units: u64) -> f64 {
        (u128::from(units) * u128::from(self.divisor)) as f64 / self.ten
    }
}

/// Whether `cost` is a whole number of `1 / ten`, as read from decimals.
fn fits(cost: f64, ten: f64) -> bool {
    (cost * ten).round() / ten == cost
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Converts costs to keys: `key = primary units * radix + secondary units`. The radix exceeds the secondary
/// units of any plan without a repeated state, so keys order plans like costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Units {
    primary: Scale,
    secondary: Scale,
    /// Keys divided by it are primary units.
    pub radix: u64,
    /// Bound on the key of any plan without a repeated state.
    pub largest_sum: u64,
}

impl Units {
    /// The units of `costs` for plans of at most `steps` steps.
    pub fn new(costs: &[Cost], steps: u64) -> Result<Self, Invalid> {
        let primary = Scale::of("primary", &costs.iter().map(|cost| cost.primary).collect::<Vec<_>>())?;
        let secondary = Scale::of("secondary", &costs.iter().map(|cost| cost.secondary).collect::<Vec<_>>())?;
        let steps = u128::from(steps.max(1));
        let radix = steps * u128::from(secondary.largest) + 1;
        let sum =
            u128::from(primary.largest).checked_mul(radix).and_then(|key| (key + radix).checked_mul(steps));
        match sum.filter(|&sum| sum < LARGEST_SUM) {
            Some(sum) => Ok(Self { primary, secondary, radix: radix as u64, largest_sum: sum as u64 }),
            None => Err(Invalid::new(
                "costs",
                format!(
                    "{} different steps of cost at their common unit",
                    primary.largest.max(secondary.largest)
                ),
                "sums below 2^61 in units of the costs' common divisor",
                "round the costs, for instance to 0.1, or leave out the secondary cost",
            )),
        }
    }

    /// The key of a move's cost.
    pub fn key(&self, cost: Cost) -> u64 {
        self.primary.units(cost.primary) * self.radix + self.secondary.units(cost.secondary)
    }

    /// The cost of a sum of keys.
    pub fn cost(&self, key: u64) -> Cost {
        Cost {
            primary: self.primary.cost(key / self.radix),
            secondary: self.secondary.cost(key % self.radix),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(values: &[f64]) -> Vec<Cost> {
        values.iter().map(|&value| Cost::primary(value)).collect()
    }

    #[test]
    fn seconds_get_the_greatest_common_unit() {
        let units = Units::new(&seconds(&[12.5, 31.5, 0.0]), 100).unwrap();
        assert_eq!(units.key(Cost::primary(12.5)), 25);
        assert_eq!(units.key(Cost::primary(31.5)), 63);
        assert_eq!(units.cost(88), Cost::primary(44.0));
    }

    #[test]
    fn costs_without_decimals_end_at_a_billionth() {
        let units = Units::new(&seconds(&[1.0 / 3.0]), 10).unwrap();
        assert!((units.cost(units.key(Cost::primary(1.0 / 3.0))).primary - 1.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_key_orders_primary_before_secondary() {
        let costs = [Cost { primary: 1.0, secondary: 0.0 }, Cost { primary: 0.0, secondary: 7.5 }];
        let units = Units::new(&costs, 1000).unwrap();
        assert!(units.key(costs[0]) > 1000 * units.key(costs[1]));
        assert_eq!(units.cost(2 * units.key(costs[0]) + 3 * units.key(costs[1])).secondary, 22.5);
    }

    #[test]
    fn sums_beyond_64_bits_are_refused() {
        let costs =
            [(1.0 / 3.0, 1.0 / 7.0), (1.0, 1.0)].map(|(primary, secondary)| Cost { primary, secondary });
        assert!(Units::new(&costs, 1_000_000).unwrap_err().to_string().contains("round the costs"));
    }
}
