/// An expression compiled for every instruction set that pulp picks from; what it calls must be inlined. Lanes are only added
/// and multiplied, never fused, so that all give the same bits.
macro_rules! vectorized {
    ($expression:expr) => {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || $expression,
        )
    };
}
pub(crate) use vectorized;
