//! Quantiles of values of which some are absent.

use estimation::Quantiles;

#[test]
fn absent_values_count_as_infinite() {
    let q = Quantiles::of([Some(1.0), None, Some(3.0), Some(2.0)].into_iter());
    assert_eq!((q.median, q.max), (Some(2.5), None));
    assert_eq!(Quantiles::of(std::iter::empty()).median, None);
}
