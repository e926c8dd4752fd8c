//! Hostile polygon soups through repair, flattening, coordinates and quads. The bytes choose the
//! surface and its faults.
#![no_main]

#[path = "../../crates/graticule/tests/stages/check.rs"]
mod check;

use graticule_fixtures::hostile_soup;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut bytes = data.iter();
    let mut choose = |count: usize| {
        let mut byte = || usize::from(bytes.next().copied().unwrap_or_default());
        (byte() + if count > 256 { byte() << 8 } else { 0 }) % count
    };
    check::check_stages(&hostile_soup(&mut choose));
});
