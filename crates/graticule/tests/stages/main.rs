//! Random hostile soups through all stages: every one ends in a sound result or a refusal.
//!
//! `fuzz/` has the same under coverage-guided fuzzing.

mod check;

use std::panic::catch_unwind;

use check::check_stages;
use graticule_fixtures::{HostileSoup, Noise, hostile_soup};

/// How many seeds are tried; `GRATICULE_SEEDS=FIRST..LAST` tries others.
const SEEDS: u64 = 60;

fn soup(seed: u64) -> HostileSoup {
    let mut noise = Noise::new(seed);
    hostile_soup(&mut |count| noise.below(count))
}

fn seeds() -> std::ops::Range<u64> {
    let given = std::env::var("GRATICULE_SEEDS").ok();
    let parsed = given.as_deref().and_then(|text| {
        let (first, last) = text.split_once("..")?;
        Some(first.parse().ok()?..last.parse().ok()?)
    });
    parsed.unwrap_or(0..SEEDS)
}

#[test]
fn hostile_soups_end_in_a_sound_result_or_a_refusal() {
    let fails = |seed: &u64| catch_unwind(|| check_stages(&soup(*seed))).is_err();
    let failed: Vec<u64> = seeds().filter(fails).collect();
    assert!(failed.is_empty(), "failed seeds: {failed:?}");
}
