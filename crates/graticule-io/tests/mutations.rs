//! Random damage to valid files of every format: the readers answer, and never panic or hang.
//!
//! `fuzz/` has the same readers under coverage-guided fuzzing.

mod common;

use std::time::{Duration, Instant};

use common::{named_cubes, plain_cube, seamed_quads};
use graticule_fixtures::Noise;
use graticule_io::{Format, PolygonSoup, WriteOptions, read_bytes, write_to, write_to_with};

/// Together 100 000, for each seed.
const MUTATIONS_PER_FORMAT: usize = 12_500;

/// The one seed, unless `GRATICULE_SEEDS=FIRST..LAST` names others.
fn noise_seeds() -> std::ops::Range<u64> {
    let given = std::env::var("GRATICULE_SEEDS").ok();
    let parsed = given.as_deref().and_then(|text| {
        let (first, last) = text.split_once("..")?;
        Some(first.parse().ok()?..last.parse().ok()?)
    });
    parsed.unwrap_or(0..1)
}

/// Small valid files of a format, with all that it can hold.
fn seeds(format: Format, ascii: bool) -> Vec<Vec<u8>> {
    let write = |soup: &_| {
        let mut bytes = Vec::new();
        write_to_with(&mut bytes, soup, format, WriteOptions { ascii }).unwrap();
        bytes
    };
    [plain_cube(), seamed_quads(), named_cubes()]
        .iter()
        .map(write)
        .collect()
}

/// Times this thread by the processor where the system tells (Linux), so that other work on the machine does not count.
struct Stopwatch {
    start: Instant,
    processor: Option<Duration>,
}

impl Stopwatch {
    fn start() -> Self {
        Self {
            start: Instant::now(),
            processor: processor_time(),
        }
    }

    fn elapsed(&self) -> Duration {
        let processor = self.processor.zip(processor_time());
        processor.map_or_else(
            || self.start.elapsed(),
            |(before, now)| now.saturating_sub(before),
        )
    }
}

fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = text.split_whitespace().next()?.parse().ok()?;
    Some(Duration::from_nanos(nanoseconds))
}

fn mutate(bytes: &mut Vec<u8>, noise: &mut Noise) {
    for _ in 0..=noise.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = noise.below(bytes.len());
        let length = noise.below(16).min(bytes.len() - at);
        match noise.below(8) {
            0 => bytes[at] ^= 1 << noise.below(8),
            1 => bytes[at] = noise.bits() as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..at + length)),
            4 => {
                let piece = bytes[at..at + length].to_vec();
                let to = noise.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => replace_number(bytes, at, noise),
            6 => {
                // Counts and indices in binary parts.
                let value = [0, 1, u32::MAX, u32::MAX - 1, 1 << 31, 65_535][noise.below(6)];
                let end = bytes.len().min(at + 4);
                bytes[at..end].copy_from_slice(&value.to_le_bytes()[..end - at]);
            }
            _ => {
                let other = noise.below(bytes.len());
                bytes.swap(at, other);
            }
        }
    }
}

/// Puts another number in the place of the first one after `at`.
fn replace_number(bytes: &mut Vec<u8>, at: usize, noise: &mut Noise) {
    const NUMBERS: [&str; 12] = [
        "0",
        "-1",
        "1",
        "2147483647",
        "4294967295",
        "4294967296",
        "99999999999999999999",
        "1e308",
        "nan",
        "-inf",
        "1e-400",
        "0.5",
    ];
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    let start = at + start;
    let length = bytes[start..]
        .iter()
        .take_while(|byte| byte.is_ascii_digit())
        .count();
    let number = NUMBERS[noise.below(NUMBERS.len())].bytes();
    bytes.splice(start..start + length, number);
}

fn survive_damage(format: Format, ascii: bool) {
    for seed in noise_seeds() {
        survive_damage_of(seed, format, ascii);
    }
}

fn survive_damage_of(seed: u64, format: Format, ascii: bool) {
    let seeds = seeds(format, ascii);
    let kind = format as u64 * 2 + u64::from(ascii);
    let mut noise = Noise::new(seed << 8 | kind);
    let start = Stopwatch::start();
    let mut accepted = 0;
    for round in 0..MUTATIONS_PER_FORMAT {
        let mut bytes = seeds[round % seeds.len()].clone();
        mutate(&mut bytes, &mut noise);
        let began = Stopwatch::start();
        if let Ok(file) = read_bytes(&bytes, Some(format)) {
            accepted += 1;
            let vertices = file.soup.positions.len() as u32;
            assert!(
                file.soup
                    .polygons
                    .corner_vertices()
                    .iter()
                    .all(|&index| index < vertices)
            );
            assert!(
                file.soup
                    .polylines
                    .iter()
                    .flatten()
                    .all(|&index| index < vertices)
            );
            if round % 16 == 0 {
                pass_on(&file.soup);
            }
        }
        assert!(
            began.elapsed() < Duration::from_secs(1),
            "seed {seed}, round {round}"
        );
    }
    assert!(
        accepted > MUTATIONS_PER_FORMAT / 100,
        "damage so heavy shows nothing: {accepted}"
    );
    assert!(accepted < MUTATIONS_PER_FORMAT, "no damage was done");
    assert!(start.elapsed() < Duration::from_secs(20), "seed {seed}");
}

/// Whatever was accepted can be written, or is refused, and what is written can be read.
fn pass_on(soup: &PolygonSoup) {
    for format in Format::ALL {
        let mut bytes = Vec::new();
        if write_to(&mut bytes, soup, format).is_ok() {
            let again = read_bytes(&bytes, Some(format));
            assert_eq!(again.map(|file| file.format).ok(), Some(format));
        }
    }
}

#[test]
fn obj_survives_damage() {
    survive_damage(Format::Obj, false);
}

#[test]
fn ply_text_survives_damage() {
    survive_damage(Format::Ply, true);
}

#[test]
fn ply_binary_survives_damage() {
    survive_damage(Format::Ply, false);
}

#[test]
fn off_survives_damage() {
    survive_damage(Format::Off, false);
}

#[test]
fn stl_text_survives_damage() {
    survive_damage(Format::Stl, true);
}

#[test]
fn stl_binary_survives_damage() {
    survive_damage(Format::Stl, false);
}

#[test]
fn gltf_survives_damage() {
    survive_damage(Format::Gltf, false);
}

#[test]
fn glb_survives_damage() {
    survive_damage(Format::Glb, false);
}
