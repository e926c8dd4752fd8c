//! The unit of time **L** of `BENCHMARKS.md`: one analysis and factorisation of a mesh's cotangent
//! Laplacian by `faer`, in `faer`'s own ordering, on one thread.
//!
//! ```text
//! cargo run --release -p graticule --example unit_of_time -- RINGS [shuffled]
//! ```
//!
//! prints its seconds for the bumpy patch of so many rings, which has 3 RINGS² + 3 RINGS + 1
//! vertices; `shuffled` numbers these at random.
#![allow(clippy::print_stdout)]

mod unit;

use std::error::Error;
use std::time::Instant;

use graticule_fixtures::bumpy_patch;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rings = arguments.first().ok_or("argument: RINGS")?.parse()?;
    let mut patch = bumpy_patch(rings, 1);
    if arguments.get(1).is_some_and(|word| word == "shuffled") {
        patch = patch.renumbered(1).0;
    }
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    println!("{}", unit::unit_of_time(&patch, clock)?);
    Ok(())
}
