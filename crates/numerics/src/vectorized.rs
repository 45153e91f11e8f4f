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

/// Runs `op` as compiled for the widest vector instructions of this processor: on x86-64 AVX-512, or AVX2 with FMA, or none of
/// them, which gives the same bits and takes several times as long. With debug assertions, as tests are built, AVX-512 is left out:
/// it takes half of the time to compile.
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
            None => any_processor(op),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    pulp::Arch::new().dispatch(op)
}

/// Runs `op` on a processor of x86-64 that lacks AVX2 or FMA.
#[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
#[cold]
#[inline(never)]
fn any_processor<O: WithSimd>(op: O) -> O::Output {
    pulp::Simd::vectorize(pulp::Scalar::new(), op)
}

/// Programs built for tests are compiled for one kind of processor alone, and check [`missing_instructions`] first.
#[cfg(all(target_arch = "x86_64", debug_assertions))]
#[cold]
fn any_processor<O: WithSimd>(_: O) -> O::Output {
    panic!("this processor lacks AVX2 and FMA, which programs built for tests need")
}

/// Instructions that this processor lacks, without which the programs take several times as long.
pub fn missing_instructions() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let missing = pulp::x86::V3::try_new().is_none();
    #[cfg(not(target_arch = "x86_64"))]
    let missing = false;
    missing.then_some("AVX2 and FMA")
}
