//! Any bytes through the readers; what is read goes out again in every format and comes back.
#![no_main]

use graticule_io::{Format, read_bytes, write_to};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((&choice, bytes)) = data.split_first() else {
        return;
    };
    let hint = Format::ALL.get(usize::from(choice) % 7).copied();
    let Ok(file) = read_bytes(bytes, hint) else {
        return;
    };
    let vertices = file.soup.positions.len();
    let corners = file.soup.polygons.corner_vertices();
    assert!(corners.iter().all(|&index| (index as usize) < vertices));
    // Cutting polygons into triangles is not the subject here, and it is slow on huge ones.
    if file.soup.polygons.iter().any(|corners| corners.len() > 64) {
        return;
    }
    for format in Format::ALL {
        let mut written = Vec::new();
        if write_to(&mut written, &file.soup, format).is_ok() {
            let again = read_bytes(&written, Some(format)).expect("what is written can be read");
            assert_eq!(again.format, format);
        }
    }
});
