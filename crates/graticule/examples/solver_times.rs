//! Times of a Laplacian's ordering, analysis, factorisation and solution, beside `faer`'s own
//! minimum degree on the same matrix.
//!
//! ```text
//! cargo run --release -p graticule --example solver_times -- torus 1000000
//! ```
//!
//! prints CPU seconds (on Linux) of the process, one line for each way. `torus`, `disk`; a third argument
//! `mean-value` times a directed Laplacian and its `L U` too.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use graticule::solve::{
    Cholesky, Graph, Lu, LuSymbolic, Ordering, SparseMatrix, Symbolic, SymmetricMatrix,
};
use graticule_fixtures::{Fixture, irregular_disk, torus};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [shape, vertices, ..] = arguments.as_slice() else {
        return Err("arguments: torus|disk VERTICES [mean-value]".into());
    };
    let fixture = surface(shape, vertices.parse()?)?;
    let edges = edges(&fixture);
    if arguments.len() > 2 {
        return time_lu(&fixture, &edges);
    }
    let matrix = laplacian(fixture.positions.len(), &edges)?;
    println!("{shape}, {} vertices", matrix.order());
    println!("way                order  analyse   factor    solve    total  entries  residual");
    let by_degree = |graph: &Graph| Ordering::minimum_degree(graph);
    let total = time_cholesky("minimum degree", &matrix, by_degree)?;
    let dissected = |graph: &Graph| Ordering::nested_dissection(graph, &fixture.positions);
    let ours = time_cholesky("nested dissection", &matrix, dissected)?;
    println!("ratio {:.2}", ours / total);
    Ok(())
}

fn time_cholesky(
    name: &str,
    matrix: &SymmetricMatrix,
    order: impl Fn(&Graph) -> Ordering,
) -> Result<f64, Box<dyn Error>> {
    let clock = Clock::start();
    let ordering = order(&Graph::of_pattern(matrix.lower().pattern()));
    let ordered = clock.seconds();
    let symbolic = Symbolic::new(matrix, &ordering)?;
    let analysed = clock.seconds();
    let factor = Cholesky::factor(&symbolic, matrix)?;
    let factored = clock.seconds();
    let right_sides: Vec<f64> = (0..2 * matrix.order())
        .map(|i| (i % 7) as f64 - 3.0)
        .collect();
    let solution = factor.solve(&right_sides)?;
    let solved = clock.seconds();
    println!(
        "{name:17} {ordered:6.2} {:8.2} {:8.2} {:8.2} {solved:8.2} {:7.1}M  {:.1e}",
        analysed - ordered,
        factored - analysed,
        solved - factored,
        symbolic.factor_entries() as f64 / 1e6,
        solution.residual
    );
    Ok(factored)
}

fn time_lu(fixture: &Fixture, edges: &[[usize; 2]]) -> Result<(), Box<dyn Error>> {
    let count = fixture.positions.len();
    let directed = edges.iter().enumerate().flat_map(|(index, &[a, b])| {
        let [ab, ba] = [1.0 + (index % 5) as f64, 1.0 + (index % 3) as f64];
        [(a, a, ab), (a, b, -ab), (b, b, ba), (b, a, -ba)]
    });
    let mass = (0..count).map(|index| (index, index, 1e-4));
    let matrix = SparseMatrix::from_triplets(count, count, directed.chain(mass))?;
    let clock = Clock::start();
    let graph = Graph::of_pattern(matrix.pattern());
    let ordering = Ordering::nested_dissection(&graph, &fixture.positions);
    let symbolic = LuSymbolic::new(&matrix, &ordering)?;
    let analysed = clock.seconds();
    let factor = Lu::factor(&symbolic, &matrix)?;
    let factored = clock.seconds();
    let solution = factor.solve(&vec![1.0; 2 * count])?;
    let solved = clock.seconds();
    println!(
        "L U, {count} vertices: order and analyse {analysed:.2}, factor {:.2}, solve {:.2}, \
         residual {:.1e}, rows exchanged {:?}",
        factored - analysed,
        solved - factored,
        solution.residual,
        factor.exchange()
    );
    Ok(())
}

/// CPU seconds of the whole process where the system tells, else elapsed ones.
struct Clock {
    cpu: Option<f64>,
    wall: Instant,
}

impl Clock {
    fn start() -> Self {
        Self {
            cpu: cpu_seconds(),
            wall: Instant::now(),
        }
    }

    fn seconds(&self) -> f64 {
        match (self.cpu, cpu_seconds()) {
            (Some(start), Some(now)) => now - start,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// User and system time in ticks of a hundredth of a second: fields 14 and 15 of Linux's `stat`.
fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// A surface of about the given number of vertices, numbered at random.
fn surface(shape: &str, vertices: u32) -> Result<Fixture, String> {
    let surface = match shape {
        "torus" => {
            let around = (2 * vertices).isqrt();
            torus(1.0, 0.4, around, vertices / around).map(|p| {
                let bumps = 0.08 * (9.0 * p.x).sin() * (7.0 * p.y).cos();
                p * (1.0 + bumps + 0.05 * (13.0 * p.z).sin())
            })
        }
        "disk" => irregular_disk((vertices / 3).isqrt(), 1),
        other => return Err(format!("no such surface: {other}")),
    };
    Ok(surface.renumbered(1).0)
}

fn edges(fixture: &Fixture) -> Vec<[usize; 2]> {
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let mut edges: Vec<[u32; 2]> = fixture.triangles.iter().flat_map(sides).collect();
    for edge in &mut edges {
        edge.sort_unstable();
    }
    edges.sort_unstable();
    edges.dedup();
    edges
        .into_iter()
        .map(|edge| edge.map(|end| end as usize))
        .collect()
}

fn laplacian(vertices: usize, edges: &[[usize; 2]]) -> Result<SymmetricMatrix, Box<dyn Error>> {
    let weights = edges
        .iter()
        .flat_map(|&[a, b]| [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0)]);
    let mass = (0..vertices).map(|index| (index, index, 1e-4));
    Ok(SymmetricMatrix::from_triplets(
        vertices,
        weights.chain(mass),
    )?)
}
