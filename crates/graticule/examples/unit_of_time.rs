//! The unit of time **L** of `BENCHMARKS.md`: one analysis and factorisation of a mesh's cotangent
//! Laplacian by `faer`, in `faer`'s own ordering, on one thread.
//!
//! ```text
//! cargo run --release -p graticule --example unit_of_time -- RINGS
//! ```
//!
//! prints its seconds for the bumpy patch of so many rings, which has 3 RINGS² + 3 RINGS + 1
//! vertices.
#![allow(clippy::print_stdout)]

mod unit;

use std::error::Error;
use std::time::Instant;

use graticule_fixtures::bumpy_patch;

fn main() -> Result<(), Box<dyn Error>> {
    let rings = std::env::args().nth(1).ok_or("argument: RINGS")?.parse()?;
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    println!("{}", unit::unit_of_time(&bumpy_patch(rings, 1), clock)?);
    Ok(())
}
