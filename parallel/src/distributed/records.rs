//! Values of one size, many at a time, as bytes.

use crate::protocol::WorkerId;
use crate::wire::WireError;

/// A value of one size.
pub(crate) trait Record: Copy + 'static {
    /// Its bytes.
    const BYTES: usize;

    /// Adds them.
    fn put(self, to: &mut Vec<u8>);

    /// The value of these bytes, of which there are [`Record::BYTES`].
    fn get(bytes: &[u8]) -> Self;
}

/// Whole numbers are their bytes, the lowest first.
macro_rules! whole {
    ($($number:ty)+) => {$(
        impl Record for $number {
            const BYTES: usize = size_of::<Self>();

            #[inline]
            fn put(self, to: &mut Vec<u8>) {
                to.extend_from_slice(&self.to_le_bytes());
            }

            #[inline]
            fn get(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(0, |own| Self::from_le_bytes(*own))
            }
        }
    )+};
}

whole!(u32 u64 u128);

impl<R: Record, const N: usize> Record for [R; N] {
    const BYTES: usize = N * R::BYTES;

    #[inline]
    fn put(self, to: &mut Vec<u8>) {
        self.into_iter().for_each(|own| own.put(to));
    }

    #[inline]
    fn get(bytes: &[u8]) -> Self {
        std::array::from_fn(|k| R::get(&bytes[k * R::BYTES..]))
    }
}

/// Values as bytes.
pub(crate) fn bytes_of<R: Record>(values: impl ExactSizeIterator<Item = R>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * R::BYTES);
    values.for_each(|value| value.put(&mut bytes));
    bytes
}

/// The values that bytes of `from` are.
///
/// # Errors
/// [`WireError`] if the bytes end within a value.
pub(crate) fn values_of<R: Record>(
    from: WorkerId,
    bytes: &[u8],
) -> Result<impl ExactSizeIterator<Item = R> + '_, WireError> {
    let values = bytes.chunks_exact(R::BYTES);
    match values.remainder() {
        [] => Ok(values.map(R::get)),
        rest => {
            let at = bytes.len() - rest.len();
            Err(refused(from, [at, bytes.len()], "the bytes end within a value"))
        }
    }
}

/// The error for bytes of `from` that make no sense at a place; their number comes after it.
pub(super) fn refused(from: WorkerId, [at, length]: [usize; 2], reason: &str) -> WireError {
    WireError { from, at, length, reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_and_cut_bytes_are_refused() {
        let values = [[1_u32, 2, u32::MAX], [0, 7, 9]];
        let bytes = bytes_of(values.iter().copied());
        let from = WorkerId::new(3);
        let back: Vec<[u32; 3]> = values_of(from, &bytes).unwrap().collect();
        assert_eq!(back, values);
        for length in (0..24).filter(|length| length % 12 != 0) {
            let error = values_of::<[u32; 3]>(from, &bytes[..length]).map(|_| ()).unwrap_err();
            assert_eq!((error.from, error.at, error.length), (from, length / 12 * 12, length));
        }
        assert_eq!(values_of::<u64>(from, &[]).unwrap().len(), 0);
    }
}
