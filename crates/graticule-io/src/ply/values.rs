use super::header::Scalar;
use crate::ReadError;
use crate::stream::ByteStream;
use crate::text::Text;

/// The numbers of the body, one after the other, however they are written.
pub(super) trait Values {
    /// The next number, or `None` at the end of the file.
    fn next(&mut self, scalar: Scalar) -> Result<Option<f64>, ReadError>;

    /// Passes over `count` numbers. False if the file has fewer.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<bool, ReadError>;

    /// The most numbers of a type that can still follow.
    fn room(&self, scalar: Scalar) -> u64;

    /// Bytes that have not been read yet.
    fn remaining(&self) -> u64;
}

impl Values for Text<'_> {
    #[inline]
    fn next(&mut self, _: Scalar) -> Result<Option<f64>, ReadError> {
        match self.any_word()? {
            Some(word) => self.to_float(&word).map(Some),
            None => Ok(None),
        }
    }

    fn skip(&mut self, _: Scalar, count: u64) -> Result<bool, ReadError> {
        for _ in 0..count {
            if self.any_word()?.is_none() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn room(&self, _: Scalar) -> u64 {
        Values::remaining(self).div_ceil(2)
    }

    fn remaining(&self) -> u64 {
        Text::remaining(self)
    }
}

/// A binary body.
pub(super) struct Binary<'a, const BIG_ENDIAN: bool>(pub(super) ByteStream<'a>);

impl<const BIG_ENDIAN: bool> Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<Option<[u8; N]>, ReadError> {
        let mut bytes = self.0.take::<N>()?;
        if BIG_ENDIAN && let Some(bytes) = &mut bytes {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG_ENDIAN: bool> Values for Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Result<Option<f64>, ReadError> {
        Ok(match scalar {
            Scalar::I8 => self
                .take()?
                .map(|bytes| f64::from(i8::from_le_bytes(bytes))),
            Scalar::U8 => self
                .take()?
                .map(|bytes| f64::from(u8::from_le_bytes(bytes))),
            Scalar::I16 => self
                .take()?
                .map(|bytes| f64::from(i16::from_le_bytes(bytes))),
            Scalar::U16 => self
                .take()?
                .map(|bytes| f64::from(u16::from_le_bytes(bytes))),
            Scalar::I32 => self
                .take()?
                .map(|bytes| f64::from(i32::from_le_bytes(bytes))),
            Scalar::U32 => self
                .take()?
                .map(|bytes| f64::from(u32::from_le_bytes(bytes))),
            Scalar::F32 => self
                .take()?
                .map(|bytes| f64::from(f32::from_le_bytes(bytes))),
            Scalar::F64 => self.take()?.map(f64::from_le_bytes),
        })
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<bool, ReadError> {
        self.0.skip(count.saturating_mul(scalar.size()))
    }

    fn room(&self, scalar: Scalar) -> u64 {
        self.0.remaining() / scalar.size()
    }

    fn remaining(&self) -> u64 {
        self.0.remaining()
    }
}
