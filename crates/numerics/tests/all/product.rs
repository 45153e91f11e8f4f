use numerics::{add_rows, dot, product};

#[test]
fn law_a_dot_product_of_any_length_is_the_sum_of_products() {
    for length in (0..40).chain([63, 64, 65, 200]) {
        let a: Vec<f64> = (0..length).map(|i| libm::sin(1.7 * f64::from(i))).collect();
        let b: Vec<f64> = (0..length + 3).map(|i| libm::cos(2.3 * f64::from(i)) + 0.1).collect();
        let (mut sum, mut size) = (0.0, 0.0);
        for (a, b) in a.iter().zip(&b) {
            sum += a * b;
            size += (a * b).abs();
        }
        assert!((dot(&a, &b) - sum).abs() <= 1e-14 * size, "{length}");
        assert_eq!(dot(&a, &b), dot(&b, &a), "{length}");
    }
}

#[test]
fn law_a_product_of_any_size_has_the_sums_of_rows_by_columns() {
    for n in 1..21 {
        let a: Vec<f64> = (0..n * n).map(|i| libm::sin(1.7 * i as f64)).collect();
        let b: Vec<f64> = (0..n * n).map(|i| libm::cos(2.3 * i as f64) + 0.1).collect();
        let entry = |i: usize, j: usize| (0..n).fold(0.0, |sum, k| sum + a[i * n + k] * b[k * n + j]);
        let expected: Vec<f64> = (0..n * n).map(|e| entry(e / n, e % n)).collect();
        assert_eq!(product(n, &a, &b), expected, "{n}");
    }
}

#[test]
fn law_rows_that_are_added_are_added_in_turn() {
    for width in 0..21 {
        let rows: Vec<f64> = (0..7 * width).map(|i| libm::sin(1.7 * i as f64)).collect();
        let coefficients = [0.3, 0.0, -1.2, 1e-3, 0.0, 7.0, 0.1];
        let column = |j: usize| (0..7).fold(0.5, |sum, k| sum + coefficients[k] * rows[k * width + j]);
        let expected: Vec<f64> = (0..width).map(column).collect();
        let mut out = vec![0.5; width];
        add_rows(&mut out, &rows, &coefficients);
        assert_eq!(out, expected, "{width}");
    }
}
