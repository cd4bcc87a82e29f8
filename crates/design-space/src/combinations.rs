//! Counting through all combinations of a few digits, each with a base of its own.

use crate::Error;

/// All combinations of digits d₁ … d_K with 0 ≤ d_j < n_j, numbered from 0, the last digit changing fastest.
///
/// This is the only place of the workspace that turns an index into digits and back: grids, lattices, sampled points
/// and pictures all count through it.
///
/// ```
/// use design_space::Combinations;
/// let clock = Combinations::new([24, 60])?;
/// assert_eq!(clock.len(), 1440);
/// assert_eq!(clock.digits(61), [1, 1]);
/// assert_eq!(clock.index(&[1, 1]), 61);
/// assert_eq!(clock.neighbors(61).collect::<Vec<_>>(), [1, 121, 60, 62]);
/// assert_eq!(clock.all().nth(61), Some(vec![1, 1]));
/// # Ok::<(), design_space::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Combinations {
    counts: Vec<u64>,
    /// How far apart two indices are that differ by one in a digit.
    strides: Vec<u64>,
    n_combinations: u64,
}

impl Combinations {
    /// Digits with these bases; a base of 0 leaves no combination.
    ///
    /// # Errors
    ///
    /// [`Error::GridTooLarge`] beyond 2⁶⁴ − 1 combinations.
    pub fn new(counts: impl Into<Vec<u64>>) -> Result<Self, Error> {
        let counts = counts.into();
        let too_large = || Error::GridTooLarge { n_parameters: counts.len() };
        counts.iter().try_fold(1_u64, |n, &count| n.checked_mul(count)).ok_or_else(too_large)?;
        Ok(Self::saturating(counts))
    }

    /// The same without an error: beyond 2⁶⁴ − 1 combinations only the first 2⁶⁴ − 1 have an index.
    #[must_use]
    pub fn saturating(counts: impl Into<Vec<u64>>) -> Self {
        let counts = counts.into();
        let mut n_combinations = 1_u64;
        let mut strides = vec![1; counts.len()];
        for (stride, &count) in strides.iter_mut().zip(&counts).rev() {
            *stride = n_combinations;
            n_combinations = n_combinations.saturating_mul(count);
        }
        Self { counts, strides, n_combinations }
    }

    /// The base of each digit.
    #[must_use]
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// How many combinations there are.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.n_combinations
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.n_combinations == 0
    }

    /// The digits of an index below [`len`](Self::len), one per base.
    #[must_use]
    pub fn digits(&self, index: u64) -> Vec<u64> {
        let mut digits = vec![0; self.counts.len()];
        self.fill_digits(index, &mut digits);
        digits
    }

    /// The same, written into a slice with one place per base.
    pub fn fill_digits(&self, index: u64, digits: &mut [u64]) {
        for (place, digit) in digits.iter_mut().rev().zip(self.digits_from_last(index)) {
            *place = digit;
        }
    }

    /// The same one after the other, the last digit first.
    pub fn digits_from_last(&self, index: u64) -> impl Iterator<Item = u64> {
        let mut rest = index;
        self.counts.iter().rev().map(move |&count| {
            let digit = rest % count;
            rest /= count;
            digit
        })
    }

    /// The index of these digits, each below its base.
    #[must_use]
    pub fn index(&self, digits: &[u64]) -> u64 {
        digits.iter().zip(&self.counts).fold(0, |index, (digit, count)| index * count + digit)
    }

    /// The digits of all combinations, in order.
    pub fn all(&self) -> impl Iterator<Item = Vec<u64>> {
        (0..self.n_combinations).map(|index| self.digits(index))
    }

    /// The indices that differ from this one by one in one digit, where there are any: below, then above, digit by digit.
    pub fn neighbors(&self, index: u64) -> impl Iterator<Item = u64> {
        (0..self.counts.len()).flat_map(move |place| {
            let digit = index / self.strides[place] % self.counts[place];
            self.neighbors_along(place, index, digit)
        })
    }

    /// The same in the digit of one place alone, which is `digit` at this index.
    #[inline]
    pub fn neighbors_along(&self, place: usize, index: u64, digit: u64) -> impl Iterator<Item = u64> {
        let stride = self.strides[place];
        let below = (digit > 0).then(|| index - stride);
        let above = (digit + 1 < self.counts[place]).then(|| index + stride);
        below.into_iter().chain(above)
    }

    /// Whether digits without an index were turned to the next combination; `false` after the last one, which then
    /// is the first again.
    pub fn advance(&self, digits: &mut [u64]) -> bool {
        for (digit, &count) in digits.iter_mut().zip(&self.counts).rev() {
            *digit += 1;
            if *digit < count {
                return true;
            }
            *digit = 0;
        }
        false
    }
}
