//! Tail probabilities of the chi-square and normal distributions.

/// P(χ² ≥ x) for `freedom` degrees of freedom: the regularised upper incomplete gamma function Q(freedom/2, x/2), by its
/// series below freedom/2 + 1 and by its continued fraction (Lentz) above: Press et al., *Numerical Recipes*, 6.2.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    let (a, x) = (0.5 * freedom, 0.5 * x);
    if !(x > 0.0 && a > 0.0) {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let front = (a * x.ln() - x - log_gamma(a)).exp();
    let tail = if x < a + 1.0 { 1.0 - front * series(a, x) } else { front * fraction(a, x) };
    tail.clamp(0.0, 1.0)
}

/// P(|Z| ≥ |z|) for a standard normal Z.
pub fn normal_tails(z: f64) -> f64 {
    chi_square_tail(z * z, 1.0)
}

fn series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
    for _ in 0..10_000 {
        n += 1.0;
        term *= x / n;
        sum += term;
        if term < sum * f64::EPSILON {
            break;
        }
    }
    sum
}

fn fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / if d.abs() < TINY { TINY } else { d };
        c = b + an / c;
        c = if c.abs() < TINY { TINY } else { c };
        h *= d * c;
        if (d * c - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    h
}

/// ln Γ(x) for x > 0 by Lanczos' approximation (g = 7, nine terms).
fn log_gamma(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        let pi = std::f64::consts::PI;
        return (pi / (pi * x).sin()).ln() - log_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let tail = COEFFICIENTS[1..].iter().zip(1..).map(|(c, i)| c / (x + f64::from(i)));
    let sum = COEFFICIENTS[0] + tail.sum::<f64>();
    let t = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_tails_are_one_at_zero_and_none_at_infinity() {
        approx::assert_relative_eq!(normal_tails(-1.959963984540054), 0.05, max_relative = 1e-12);
        assert_eq!((chi_square_tail(0.0, 4.0), chi_square_tail(f64::INFINITY, 4.0)), (1.0, 0.0));
    }
}
