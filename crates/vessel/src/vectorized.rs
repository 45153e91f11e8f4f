#[doc(hidden)]
pub use pulp::Arch;

/// An expression compiled for every instruction set that pulp picks from; what it calls must be inlined. Lanes are added and
/// multiplied, and fused only where [`crate::Lane::fused`] says so, so that all give the same bits.
#[macro_export]
macro_rules! vectorized {
    ($expression:expr) => {{
        let once = $crate::vectorized::Once;
        $crate::vectorized::Arch::new().dispatch(
            #[inline(always)]
            || {
                once.spend();
                $expression
            },
        )
    }};
}

/// Makes a closure that spends it one that can be called once only. Others are called through a function of the compiler's
/// own, which is not inlined: their bodies would be compiled for the oldest processor.
#[doc(hidden)]
#[derive(Debug)]
pub struct Once;

impl Once {
    #[doc(hidden)]
    #[inline(always)]
    pub const fn spend(self) {}
}
