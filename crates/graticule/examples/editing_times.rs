//! How fast a boundary is edited: the figures of `BENCHMARKS.md`.
//!
//! ```text
//! cargo run --release -p graticule --example editing_times -- RINGS
//! ```
//!
//! prints, for the bumpy patch of so many rings (3 RINGS² + 3 RINGS + 1 vertices), the seconds to
//! factor, to make 64 handles ready, and to move one of them with all coordinates.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use glam::DVec2;
use graticule::flatten::{BoundaryCurve, BoundaryEditor, EditorOptions, Patch, boundary_on_curve};
use graticule::mesh::{Surface, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::bumpy_patch;

const HANDLES: usize = 64;
const MOVES: usize = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let rings = std::env::args().nth(1).ok_or("argument: RINGS")?.parse()?;
    let fixture = bumpy_patch(rings, 1);
    let watch = Watch::new();
    let surface = Surface::from_triangles(fixture.positions, &fixture.triangles)?;
    let patch = Patch::new(surface, &watch)?;
    let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch)?;
    let start = Instant::now();
    let mut editor = BoundaryEditor::new(&patch, &circle, &EditorOptions::default(), &watch)?;
    println!("factor {}", start.elapsed().as_secs_f64());
    let movable = editor.movable();
    let step = movable.len() / HANDLES;
    let handles: Vec<VertexId> = (0..HANDLES).map(|k| movable[k * step]).collect();
    let start = Instant::now();
    editor.begin(&handles, &watch)?;
    println!("{HANDLES} handles {}", start.elapsed().as_secs_f64());
    let mut places: Vec<DVec2> = handles.iter().map(|&handle| editor.uv()[handle]).collect();
    let start = Instant::now();
    for k in 0..MOVES {
        places[k % HANDLES] *= 1.001;
        editor.move_to(&places)?;
    }
    println!("move {}", start.elapsed().as_secs_f64() / MOVES as f64);
    editor.commit()?;
    Ok(())
}
