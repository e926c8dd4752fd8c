use std::io::{self, Write};

use crate::number::{push_float, push_integer, push_single};

/// Bytes gathered before they are handed on.
const FULL: usize = 64 * 1024;

/// Gathers text and binary numbers and hands them on in large pieces.
pub(crate) struct Sink<'a> {
    writer: &'a mut dyn Write,
    buffer: Vec<u8>,
}

impl<'a> Sink<'a> {
    pub(super) fn new(writer: &'a mut dyn Write) -> Self {
        Self {
            writer,
            buffer: Vec::with_capacity(FULL + 1024),
        }
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= FULL {
            self.hand_on()?;
        }
        Ok(())
    }

    pub(crate) fn text(&mut self, text: &str) -> io::Result<()> {
        self.bytes(text.as_bytes())
    }

    /// Ends a line.
    pub(crate) fn line_end(&mut self) -> io::Result<()> {
        self.bytes(b"\n")
    }

    /// Numbers with a blank before each.
    pub(crate) fn floats(&mut self, numbers: &[f64]) {
        for &number in numbers {
            self.buffer.push(b' ');
            push_float(&mut self.buffer, number);
        }
    }

    /// Single-precision numbers with a blank before each.
    pub(crate) fn singles(&mut self, numbers: &[f32]) {
        for &number in numbers {
            self.buffer.push(b' ');
            push_single(&mut self.buffer, number);
        }
    }

    /// An integer, nothing before or behind.
    pub(crate) fn integer(&mut self, number: impl itoa::Integer) {
        push_integer(&mut self.buffer, number);
    }

    fn hand_on(&mut self) -> io::Result<()> {
        self.writer.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    pub(super) fn finish(mut self) -> io::Result<()> {
        self.hand_on()?;
        self.writer.flush()
    }
}
