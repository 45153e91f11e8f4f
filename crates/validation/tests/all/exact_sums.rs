//! Sums that do not depend on their order.

use validation::tally::ExactSum;

#[test]
fn law_numbers_are_rounded_alike_however_large() {
    let edges = [0.0, 0.25, 0.5, 1.0 - f64::EPSILON / 2.0, 1.5, 2.5, 1e6 + 0.5, 4_503_599_627_370_495.5];
    let large = [4_503_599_627_370_496.0, 9e15, 1e25];
    let whole = |number: f64| {
        let mut sum = ExactSum::default();
        assert!(sum.add(number * 2.0_f64.powi(-40)));
        String::from(sum).parse::<i128>().unwrap()
    };
    for number in edges.into_iter().chain([0.5_f64.next_down()]).chain(large) {
        assert_eq!(whole(number), number.round() as i128, "{number}");
        assert_eq!(whole(-number), -whole(number), "{number}");
    }
}
