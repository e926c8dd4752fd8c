use std::io::{ErrorKind, Read};
use std::ops::Range;

use crate::ReadError;

/// Size of the window on the file: large against a system call, small against any mesh.
const WINDOW: usize = 256 * 1024;

/// Longest piece that [`ByteStream::ensure`] may be asked for.
pub(crate) const LONGEST_PIECE: usize = 16 * 1024;

/// A file of known size seen through a window that moves forward over it.
///
/// All readers draw on this, so that a file of any size needs one window of memory beside the
/// mesh that it holds, and bytes in memory take the same road as files.
pub(crate) struct ByteStream<'a> {
    reader: Box<dyn Read + 'a>,
    window: Vec<u8>,
    start: usize,
    end: usize,
    /// Bytes of the file before the window.
    passed: u64,
    size: u64,
    exhausted: bool,
}

impl<'a> ByteStream<'a> {
    /// `size` is the number of bytes that `reader` will give: a bound for every count that the
    /// file claims.
    pub(crate) fn new(reader: impl Read + 'a, size: u64) -> Self {
        // One byte more than the file holds, so that its end is seen without another refill.
        let capacity = usize::try_from(size).map_or(WINDOW, |size| size.saturating_add(1));
        Self {
            reader: Box::new(reader),
            window: vec![0; capacity.clamp(2 * LONGEST_PIECE, WINDOW)],
            start: 0,
            end: 0,
            passed: 0,
            size,
            exhausted: false,
        }
    }

    /// Size of the whole file.
    pub(crate) fn size(&self) -> u64 {
        self.size
    }

    /// Bytes of the file that have not been read yet.
    pub(crate) fn remaining(&self) -> u64 {
        self.size.saturating_sub(self.passed + self.start as u64)
    }

    /// The bytes in the window that have not been read yet.
    #[inline]
    pub(crate) fn available(&self) -> &[u8] {
        &self.window[self.start..self.end]
    }

    /// Marks the first `count` available bytes as read.
    #[inline]
    pub(crate) fn advance(&mut self, count: usize) {
        debug_assert!(self.start + count <= self.end);
        self.start += count;
    }

    /// Marks the first `count` available bytes as read and tells where they stand, for
    /// [`piece`](Self::piece). They stay there until the next refill.
    #[inline]
    pub(crate) fn take_range(&mut self, count: usize) -> Range<usize> {
        let start = self.start;
        self.advance(count);
        start..self.start
    }

    /// Bytes taken by [`take_range`](Self::take_range).
    #[inline]
    pub(crate) fn piece(&self, range: &Range<usize>) -> &[u8] {
        &self.window[range.clone()]
    }

    /// Moves the window forward to the first unread byte and fills it. False if the file has no
    /// more bytes, or if the window is full already.
    #[cold]
    pub(crate) fn refill(&mut self) -> Result<bool, ReadError> {
        self.window.copy_within(self.start..self.end, 0);
        self.passed += self.start as u64;
        self.end -= self.start;
        self.start = 0;
        let before = self.end;
        while self.end < self.window.len() && !self.exhausted {
            match self.reader.read(&mut self.window[self.end..]) {
                Ok(0) => self.exhausted = true,
                Ok(count) => self.end += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(ReadError::Io(error)),
            }
        }
        Ok(self.end > before)
    }

    /// Makes `count` bytes available, at most [`LONGEST_PIECE`]. False if the file has fewer.
    #[inline]
    pub(crate) fn ensure(&mut self, count: usize) -> Result<bool, ReadError> {
        debug_assert!(count <= LONGEST_PIECE);
        if self.end - self.start >= count {
            return Ok(true);
        }
        self.refill()?;
        Ok(self.end - self.start >= count)
    }

    /// The next `N` bytes, or `None` if the file has fewer.
    #[inline]
    pub(crate) fn take<const N: usize>(&mut self) -> Result<Option<[u8; N]>, ReadError> {
        if !self.ensure(N)? {
            return Ok(None);
        }
        let bytes = self.available().first_chunk::<N>().copied();
        self.advance(N);
        Ok(bytes)
    }

    /// Passes over `count` bytes. False if the file has fewer.
    pub(crate) fn skip(&mut self, mut count: u64) -> Result<bool, ReadError> {
        loop {
            let here = (self.end - self.start) as u64;
            if here >= count {
                self.advance(count as usize);
                return Ok(true);
            }
            count -= here;
            self.start = self.end;
            if !self.refill()? {
                return Ok(false);
            }
        }
    }

    /// All bytes that have not been read yet.
    pub(crate) fn read_to_end(mut self) -> Result<Vec<u8>, ReadError> {
        let mut bytes = self.available().to_vec();
        if !self.exhausted {
            self.reader.read_to_end(&mut bytes)?;
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a few bytes at a time, as a pipe may.
    struct Dribble<'a>(&'a [u8]);

    impl Read for Dribble<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let count = self.0.len().min(buffer.len()).min(7);
            buffer[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    #[test]
    fn every_byte_arrives_once_and_in_order() {
        let bytes: Vec<u8> = (0..600_000_u32).map(|i| (i % 251) as u8).collect();
        let mut stream = ByteStream::new(Dribble(&bytes), bytes.len() as u64);
        let mut position = 0;
        while let Some(piece) = stream.take::<9>().unwrap() {
            assert_eq!(piece, bytes[position..position + 9]);
            position += 9;
            assert_eq!(stream.remaining(), (bytes.len() - position) as u64);
        }
        assert_eq!(stream.available(), &bytes[position..]);
    }

    #[test]
    fn skipping_stops_at_the_end() {
        let bytes = vec![1; 500_000];
        let mut stream = ByteStream::new(&bytes[..], 500_000);
        assert!(stream.skip(499_999).unwrap());
        assert_eq!(stream.take::<1>().unwrap(), Some([1]));
        assert!(!stream.skip(1).unwrap());
    }
}
