//! Numbers that lie all over a range.

/// The k-th of numbers below n that lie all over, the fractional parts of multiples of the golden section.
pub(crate) fn spread(k: u64, n: u64) -> u64 {
    let fraction = u128::from(k.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    u64::try_from((fraction * u128::from(n)) >> 64).unwrap_or(0)
}
