//! Mathematical functions of a WebAssembly program for a native one: preloaded (`LD_PRELOAD`), they replace those of
//! the C library. The standard library of `wasm32-unknown-unknown` takes them from the crate `libm`.

macro_rules! functions {
    ($($name:ident($($x:ident),+)),+ $(,)?) => { $(
        /// The function of this name.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($x: f64),+) -> f64 {
            libm::$name($($x),+)
        }
    )+ };
}

functions! {
    acos(x), asin(x), atan(x), atan2(y, x), cbrt(x), cos(x), cosh(x), exp(x), exp2(x), expm1(x), hypot(x, y), log(x), log10(x), log1p(x),
    log2(x), pow(x, y), sin(x), sinh(x), tan(x), tanh(x),
}

/// Both at once, as optimizers combine the calls.
///
/// # Safety
/// Both pointers are valid for writes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sincos(x: f64, sin: *mut f64, cos: *mut f64) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        *sin = libm::sin(x);
        *cos = libm::cos(x);
    }
}
