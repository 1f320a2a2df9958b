//! Inner loops compiled for vectors of four numbers (AVX2) where the processor has them.
//!
//! Vectors change how many numbers are taken at once, never a number: products and sums stay apart
//! and in their order, so every processor gives the same bits.

/// `f()`, compiled for what the processor has, with everything that is inlined into it.
#[inline(always)]
pub(crate) fn wide<T>(f: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(f)
}
