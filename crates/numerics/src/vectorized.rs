use pulp::WithSimd;

/// An expression compiled for the vector instructions that [`crate::dispatch`] selects from, with `narrow:` before it for those
/// of [`crate::dispatch_narrow`]; the functions that it calls must be inlined. Lanes are added and multiplied, and fused only in
/// [`crate::Lane::fused`], so that all instruction sets give the same bits.
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

/// Runs `op` as compiled for the widest vector instructions of this processor. On x86-64 that is AVX-512, or AVX2 with FMA: the
/// version for older processors was twenty times slower, and cost compile time all the same. With debug assertions, as tests are
/// built, AVX-512 is left out: it gives the same bits, and takes half of the time to compile.
///
/// # Panics
/// Where the processor has neither. Programs check [`missing_instructions`] first.
#[inline(always)]
pub fn dispatch<O: WithSimd>(op: O) -> O::Output {
    #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
    if let Some(wide) = pulp::x86::V4::try_new() {
        return pulp::Simd::vectorize(wide, op);
    }
    dispatch_narrow(op)
}

/// As [`dispatch`], but with AVX2 even where there is AVX-512: for code that takes long to compile and gains
/// nothing from wider lanes.
#[inline(always)]
pub fn dispatch_narrow<O: WithSimd>(op: O) -> O::Output {
    #[cfg(target_arch = "x86_64")]
    {
        use pulp::Simd;
        match pulp::x86::V3::try_new() {
            Some(simd) => Simd::vectorize(simd, op),
            None => lacking(),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    pulp::Arch::new().dispatch(op)
}

/// Required instructions that this processor lacks.
pub fn missing_instructions() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let missing = pulp::x86::V3::try_new().is_none();
    #[cfg(not(target_arch = "x86_64"))]
    let missing = false;
    missing.then_some("AVX2 and FMA")
}

#[cfg(target_arch = "x86_64")]
#[cold]
fn lacking() -> ! {
    panic!("this processor lacks AVX2 and FMA, which those of 2013 and later have")
}
