use std::ops::Range;

use crate::error::{Place, Problem, quoted};
use crate::number::{parse_float, parse_integer};
use crate::stream::{ByteStream, LONGEST_PIECE};
use crate::{Format, ReadError};

/// Longest word: no number or keyword comes near it.
const LONGEST_WORD: usize = 4 * 1024;

/// Longest name of an object, group, material or library.
const LONGEST_NAME: usize = 64 * 1024;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Class {
    Word,
    Blank,
    LineEnd,
    Backslash,
}

const CLASSES: [Class; 256] = {
    let mut classes = [Class::Word; 256];
    classes[b' ' as usize] = Class::Blank;
    classes[b'\t' as usize] = Class::Blank;
    classes[0x0b] = Class::Blank;
    classes[0x0c] = Class::Blank;
    classes[b'\n' as usize] = Class::LineEnd;
    classes[b'\r' as usize] = Class::LineEnd;
    classes[b'\\' as usize] = Class::Backslash;
    classes
};

/// Text as words on numbered lines, read once from front to end.
///
/// A line ends with LF, CR LF or CR. A backslash before a line end joins two lines. No line is
/// held as a whole, so that its length does not matter.
pub(crate) struct Text<'a> {
    stream: ByteStream<'a>,
    format: Format,
    line: u64,
    comments: bool,
}

impl<'a> Text<'a> {
    pub(crate) fn new(stream: ByteStream<'a>, format: Format) -> Self {
        Self {
            stream,
            format,
            line: 1,
            comments: false,
        }
    }

    /// From here on `#` at the start of a word hides the rest of the line.
    pub(crate) fn with_comments(mut self) -> Self {
        self.comments = true;
        self
    }

    /// Counts lines from `line` on.
    pub(crate) fn from_line(mut self, line: u64) -> Self {
        self.line = line;
        self
    }

    /// Number of the present line, from 1.
    pub(crate) fn line(&self) -> u64 {
        self.line
    }

    /// Bytes of the file that have not been read yet.
    pub(crate) fn remaining(&self) -> u64 {
        self.stream.remaining()
    }

    /// An error on the present line.
    #[cold]
    pub(crate) fn error(&self, problem: Problem) -> ReadError {
        ReadError::malformed(self.format, Place::Line(self.line), problem)
    }

    /// The bytes of a word just found.
    #[inline]
    pub(crate) fn bytes(&self, word: &Range<usize>) -> &[u8] {
        self.stream.piece(word)
    }

    /// The next word on this line; `None` at the end of the line or the file.
    #[inline]
    pub(crate) fn word(&mut self) -> Result<Option<Range<usize>>, ReadError> {
        loop {
            let bytes = self.stream.available();
            let blanks = bytes
                .iter()
                .take_while(|&&byte| CLASSES[byte as usize] == Class::Blank)
                .count();
            match bytes.get(blanks).map(|&byte| CLASSES[byte as usize]) {
                Some(Class::Word) => {
                    if self.comments && bytes[blanks] == b'#' {
                        return Ok(None);
                    }
                    let length = bytes[blanks..]
                        .iter()
                        .take_while(|&&byte| CLASSES[byte as usize] == Class::Word)
                        .count();
                    self.stream.advance(blanks);
                    if let Some(word) = self.finished_word(length)? {
                        return Ok(Some(word));
                    }
                }
                Some(Class::LineEnd) => {
                    self.stream.advance(blanks);
                    return Ok(None);
                }
                Some(Class::Backslash) => {
                    self.stream.advance(blanks);
                    if !self.join_lines()? {
                        return self.backslash_word().map(Some);
                    }
                }
                _ => {
                    self.stream.advance(blanks);
                    if !self.stream.refill()? {
                        return Ok(None);
                    }
                }
            }
        }
    }

    /// Takes a word of `length` bytes unless the window may have cut it.
    #[inline]
    fn finished_word(&mut self, length: usize) -> Result<Option<Range<usize>>, ReadError> {
        if length > LONGEST_WORD {
            return Err(self.error(Problem::LongWord {
                limit: LONGEST_WORD,
            }));
        }
        if length == self.stream.available().len() && self.stream.refill()? {
            return Ok(None);
        }
        Ok(Some(self.stream.take_range(length)))
    }

    /// Passes over a backslash and the line end behind it. False if there is no line end.
    #[cold]
    fn join_lines(&mut self) -> Result<bool, ReadError> {
        self.stream.ensure(3)?;
        let length = match self.stream.available() {
            [b'\\', b'\r', b'\n', ..] => 3,
            [b'\\', b'\r' | b'\n', ..] => 2,
            _ => return Ok(false),
        };
        self.stream.advance(length);
        self.line += 1;
        Ok(true)
    }

    /// A word that begins with a backslash: part of a path, or rubbish.
    #[cold]
    fn backslash_word(&mut self) -> Result<Range<usize>, ReadError> {
        self.stream.ensure(LONGEST_WORD)?;
        let bytes = self.stream.available();
        let tail = bytes[1..].iter().take(LONGEST_WORD - 1);
        let length = tail
            .take_while(|&&byte| CLASSES[byte as usize] == Class::Word)
            .count();
        Ok(self.stream.take_range(1 + length))
    }

    /// The next word on this line or a later one; `None` at the end of the file.
    #[inline]
    pub(crate) fn any_word(&mut self) -> Result<Option<Range<usize>>, ReadError> {
        loop {
            if let Some(word) = self.word()? {
                return Ok(Some(word));
            }
            if !self.next_line()? {
                return Ok(None);
            }
        }
    }

    /// Goes to the start of the next line, over whatever is left of this one. False at the end of
    /// the file.
    #[inline]
    pub(crate) fn next_line(&mut self) -> Result<bool, ReadError> {
        loop {
            let bytes = self.stream.available();
            if let Some(length) = memchr::memchr2(b'\n', b'\r', bytes) {
                self.stream.advance(length);
                self.pass_line_end()?;
                return Ok(true);
            }
            self.stream.advance(bytes.len());
            if !self.stream.refill()? {
                return Ok(false);
            }
        }
    }

    #[inline]
    fn pass_line_end(&mut self) -> Result<(), ReadError> {
        self.line += 1;
        if self.stream.available()[0] == b'\r' {
            self.stream.ensure(2)?;
            if self.stream.available().get(1) == Some(&b'\n') {
                self.stream.advance(1);
            }
        }
        self.stream.advance(1);
        Ok(())
    }

    /// What is left of this line, without blanks around it; comments count as text.
    pub(crate) fn rest_of_line(&mut self) -> Result<String, ReadError> {
        let mut rest = Vec::new();
        loop {
            let bytes = self.stream.available();
            let end = memchr::memchr3(b'\n', b'\r', b'\\', bytes);
            let length = end.unwrap_or(bytes.len());
            if rest.len() + length > LONGEST_NAME {
                return Err(self.error(Problem::LongWord {
                    limit: LONGEST_NAME,
                }));
            }
            rest.extend_from_slice(&bytes[..length]);
            self.stream.advance(length);
            match end.map(|_| self.stream.available()[0]) {
                Some(b'\\') if self.join_lines()? => rest.push(b' '),
                Some(b'\\') => {
                    rest.push(b'\\');
                    self.stream.advance(1);
                }
                Some(_) => break,
                None => {
                    if !self.stream.refill()? {
                        break;
                    }
                }
            }
        }
        Ok(decode(rest.trim_ascii()))
    }

    /// The next number on this line; `None` at its end.
    #[inline]
    pub(crate) fn float(&mut self) -> Result<Option<f64>, ReadError> {
        let Some(word) = self.word()? else {
            return Ok(None);
        };
        self.to_float(&word).map(Some)
    }

    /// The number that a word just found spells.
    #[inline]
    pub(crate) fn to_float(&self, word: &Range<usize>) -> Result<f64, ReadError> {
        parse_float(self.bytes(word)).ok_or_else(|| self.bad_number(word))
    }

    /// The integer that a word just found spells.
    #[inline]
    pub(crate) fn to_integer(&self, word: &Range<usize>) -> Result<i64, ReadError> {
        parse_integer(self.bytes(word)).ok_or_else(|| self.bad_number(word))
    }

    #[cold]
    fn bad_number(&self, word: &Range<usize>) -> ReadError {
        self.error(Problem::BadNumber {
            text: quoted(self.bytes(word)),
        })
    }
}

const _: () = assert!(LONGEST_WORD < LONGEST_PIECE);

/// UTF-8, or else Latin-1, in which every byte is a character: names survive either way.
pub(crate) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(u64, String)> {
        let bytes = text.as_bytes();
        let stream = ByteStream::new(bytes, bytes.len() as u64);
        let mut text = Text::new(stream, Format::Obj).with_comments();
        let mut found = Vec::new();
        while let Some(word) = text.any_word().unwrap() {
            found.push((text.line(), decode(text.bytes(&word))));
        }
        found
    }

    #[test]
    fn all_line_ends_count_as_one() {
        for end in ["\n", "\r\n", "\r"] {
            let found = words(&format!("a b{end}{end}c # d{end}e"));
            let expected = [(1, "a"), (1, "b"), (3, "c"), (4, "e")];
            assert_eq!(found, expected.map(|(line, word)| (line, word.to_owned())));
        }
    }

    #[test]
    fn a_backslash_joins_lines_also_behind_a_word() {
        let found = words("f 1 \\\n 2\\\r\n3 \\x\n");
        let expected = [(1, "f"), (1, "1"), (2, "2"), (3, "3"), (3, "\\x")];
        assert_eq!(found, expected.map(|(line, word)| (line, word.to_owned())));
    }

    #[test]
    fn words_cut_by_the_window_come_whole() {
        let text: String = (0..200_000).map(|i| format!("word{i} ")).collect();
        let found = words(&text);
        assert_eq!(found.len(), 200_000);
        assert!(
            found
                .iter()
                .enumerate()
                .all(|(i, (_, word))| *word == format!("word{i}"))
        );
    }

    #[test]
    fn a_word_without_end_is_refused() {
        let text = "x".repeat(1_000_000);
        let stream = ByteStream::new(text.as_bytes(), 1_000_000);
        assert!(Text::new(stream, Format::Obj).word().is_err());
    }

    #[test]
    fn names_keep_blanks_inside_and_latin_letters() {
        let bytes = b"  Gr\xf6\xdfe # 2 \r\nnext";
        let stream = ByteStream::new(&bytes[..], bytes.len() as u64);
        let mut text = Text::new(stream, Format::Obj).with_comments();
        assert_eq!(text.rest_of_line().unwrap(), "Größe # 2");
        assert!(text.next_line().unwrap());
        assert_eq!(text.rest_of_line().unwrap(), "next");
        assert!(!text.next_line().unwrap());
    }
}
