/// An expression compiled for every instruction set that pulp picks from; what it calls must be inlined. Lanes are only added
/// and multiplied, never fused, so that all give the same bits.
macro_rules! vectorized {
    ($expression:expr) => {{
        let once = $crate::vectorized::Once;
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                once.spend();
                $expression
            },
        )
    }};
}
pub(crate) use vectorized;

/// Makes a closure that spends it one that can be called once only. Others are called through a function of the compiler's
/// own, which is not inlined: their bodies would be compiled for the oldest processor.
pub(crate) struct Once;

impl Once {
    #[inline(always)]
    pub(crate) const fn spend(self) {}
}
