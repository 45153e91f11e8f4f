#[doc(hidden)]
pub use crate::{dispatch, dispatch_narrow};

/// An expression compiled for the vector instructions that [`crate::dispatch`] selects from, with `narrow:`
/// before it for those of [`crate::dispatch_narrow`]; the functions that it calls must be inlined. Lanes are
/// added and multiplied, and fused only in [`crate::Lane::fused`], so that all instruction sets give the same
/// bits.
#[macro_export]
macro_rules! vectorized {
    (narrow: $expression:expr) => {
        $crate::vectorized!(dispatch_narrow, $expression)
    };
    ($expression:expr) => {
        $crate::vectorized!(dispatch, $expression)
    };
    ($dispatch:ident, $expression:expr) => {{
        let once = $crate::vectorized::Once;
        $crate::vectorized::$dispatch(
            #[inline(always)]
            || {
                once.spend();
                $expression
            },
        )
    }};
}

/// Makes a closure `FnOnce`. Others are called through a function of the compiler's own that is not inlined,
/// so their bodies would be compiled for the oldest processor.
#[doc(hidden)]
#[derive(Debug)]
pub struct Once;

impl Once {
    #[doc(hidden)]
    #[inline(always)]
    pub const fn spend(self) {}
}
