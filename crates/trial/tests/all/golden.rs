//! Golden numbers: a table of names and values, a line each.

use std::fmt::Write;

/// What a whole result consists of, in lines of a name and its values.
#[derive(Default)]
pub struct Table {
    rows: Vec<(String, Vec<f64>)>,
}

/// Largest relative difference of a number from its golden value, and what is no difference at all.
const RELATIVE: f64 = 1e-6;
const ABSOLUTE: f64 = 1e-9;
/// The mark of lines whose numbers may differ by a hundred times as much.
const ROUGH: char = '~';

impl Table {
    /// Adds a line.
    pub fn row(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) {
        self.rows.push((name.into().replace(' ', "_"), values.into_iter().collect()));
    }

    /// Adds a line of numbers whose last digits are lost by rounding: the first four or five count.
    pub fn rough(&mut self, name: &str, values: impl IntoIterator<Item = f64>) {
        self.row(format!("{ROUGH}{name}"), values);
    }

    /// Adds a line of counts.
    pub fn counts(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = usize>) {
        self.row(name, values.into_iter().map(|count| count as f64));
    }

    /// Adds a line that has all of `values` in few numbers: how many they are, their sum, that of their moduli and one
    /// in which each has another weight.
    pub fn summed<'v>(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = &'v f64>) {
        let values: Vec<f64> = values.into_iter().copied().collect();
        let modulus = values.iter().map(|value| value.abs()).sum::<f64>();
        let weight = |k: usize| 1.0 / (1.0 + k as f64);
        let weighted = values.iter().enumerate().map(|(k, value)| weight(k) * value).sum::<f64>();
        self.row(name, [values.len() as f64, values.iter().sum(), modulus, weighted]);
    }

    /// Adds a line of a square matrix in few numbers: those of its correlations, row by row, and the sum of the logarithms of
    /// its diagonal, so that large entries do not hide small ones.
    #[allow(dead_code, reason = "rooms share this file")]
    pub fn matrix(&mut self, name: impl Into<String>, values: &[f64]) {
        let n = values.len().isqrt();
        let size = |i: usize| Some(values[i * n + i].abs().sqrt()).filter(|size| *size > 0.0).unwrap_or(1.0);
        let correlations = (0..n * n).map(|k| values[k] / (size(k / n) * size(k % n)));
        self.summed(name, &correlations.collect::<Vec<_>>());
        let logarithms = (0..n).map(|i| 2.0 * size(i).ln()).sum();
        self.rows.last_mut().unwrap().1.push(logarithms);
    }

    /// The lines as text, numbers to nine digits.
    fn text(&self) -> String {
        self.rows.iter().fold(String::new(), |mut text, (name, values)| {
            text += name;
            values.iter().for_each(|value| write!(text, " {}", nine_digits(*value)).unwrap());
            text + "\n"
        })
    }

    /// Compares with the golden lines; prints all that was found where they differ.
    #[track_caller]
    pub fn assert(&self, golden: &str) {
        let lines: Vec<&str> = golden.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let differing = self.rows.iter().zip(&lines).find(|((name, values), line)| {
            let mut words = line.split(' ');
            let same_name = words.next() == Some(name);
            let expected: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
            let within = if name.starts_with(ROUGH) { 100.0 * RELATIVE } else { RELATIVE };
            let close = values.len() == expected.len()
                && values.iter().zip(&expected).all(|(found, expected)| is_close(*found, *expected, within));
            !(same_name && close)
        });
        let found = self.text();
        assert!(
            differing.is_none(),
            "expected {}, found {:?} in\n{found}",
            differing.unwrap().1,
            differing.unwrap().0
        );
        assert_eq!(self.rows.len(), lines.len(), "{found}");
    }
}

/// A value to nine digits; 0 for what is smaller than any difference that counts.
fn nine_digits(value: f64) -> f64 {
    if value.abs() < ABSOLUTE { 0.0 } else { format!("{value:.8e}").parse().unwrap() }
}

fn is_close(found: f64, expected: f64, within: f64) -> bool {
    found == expected || (found - expected).abs() <= within * expected.abs() + ABSOLUTE
}

#[test]
fn numbers_that_differ_in_the_seventh_digit_differ() {
    let table = |value: f64| {
        let mut table = Table::default();
        table.row("a b", [value, -2.0]);
        table
    };
    table(1.0000005).assert("a_b 1 -2");
    for (value, golden) in
        [(1.000002, "a_b 1 -2"), (1.0, "a_b 1 2"), (1.0, "b 1 -2"), (1.0, "a_b 1"), (1.0, "a_b 1 -2\nc")]
    {
        assert!(std::panic::catch_unwind(|| table(value).assert(golden)).is_err(), "{golden}");
    }
    assert_eq!(table(0.123_456_789_12).text(), "a_b 0.123456789 -2\n");
}
