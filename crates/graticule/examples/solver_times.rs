//! scratch
#![allow(missing_docs, clippy::all, clippy::pedantic)]
use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::*;
use glam::DVec3;
use graticule::solve::{Graph, Ordering, SymmetricMatrix};

#[derive(Clone, Copy)]
struct Instant(f64);
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
impl Instant {
    fn now() -> Self {
        Self(cpu())
    }
    fn elapsed(self) -> std::time::Duration {
        std::time::Duration::from_secs_f64((cpu() - self.0).max(0.0))
    }
}

fn bumpy_torus(n: u32) -> graticule_fixtures::Fixture {
    let a = ((n as f64) * 2.0).sqrt() as u32;
    let b = n / a;
    graticule_fixtures::torus(1.0, 0.4, a, b).map(|p| {
        p * (1.0 + 0.08 * (9.0 * p.x).sin() * (7.0 * p.y).cos() + 0.05 * (13.0 * p.z).sin())
    })
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: u32 = args[2].parse().unwrap();
    let mut f = match args[1].as_str() {
        "torus" => bumpy_torus(n),
        "disk" => graticule_fixtures::irregular_disk((n as f64 / 3.0).sqrt() as u32, 1),
        "ico" => graticule_fixtures::icosphere(((n as f64 / 10.0).ln() / 4f64.ln()).round() as u32),
        _ => panic!(),
    };
    if args.len() > 4 {
        f = f.renumbered(3).0;
    }
    let n = f.positions.len();
    let tri = f.triangles.clone();
    let edges: std::collections::BTreeSet<[usize; 2]> = if n < 3_000_000 {
        let mut v: Vec<[u32; 2]> = tri
            .iter()
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        v.sort();
        v.dedup();
        v.into_iter()
            .map(|[a, b]| [a as usize, b as usize])
            .collect()
    } else {
        Default::default()
    };
    let m = SymmetricMatrix::from_triplets(
        n,
        edges
            .iter()
            .flat_map(|&[a, b]| [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0)])
            .chain((0..n).map(|i| (i, i, 1e-4))),
    )
    .unwrap();
    drop(edges);
    let pts: Vec<DVec3> = f.positions.clone();
    let t = Instant::now();
    let graph = Graph::of_pattern(m.lower().pattern());
    let tg = t.elapsed().as_secs_f64();
    let t = Instant::now();
    let ord = match args[3].as_str() {
        "nd" => Some(Ordering::nested_dissection(&graph, &pts)),
        _ => None,
    };
    let to = t.elapsed().as_secs_f64();
    if std::env::var("ORDER_ONLY").is_ok() {
        println!("order {to:.3}");
        return;
    }
    let t = Instant::now();
    let pat = m.lower().pattern();
    let starts: Vec<u32> = std::iter::once(0)
        .chain((0..n).scan(0, |s, j| {
            *s += pat.column(j).len() as u32;
            Some(*s)
        }))
        .collect();
    let rows: Vec<u32> = (0..n).flat_map(|j| pat.column(j).to_vec()).collect();
    let sym = faer::sparse::SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let s = match &ord {
        Some(o) => factorize_symbolic_cholesky(
            sym,
            Side::Lower,
            SymmetricOrdering::Custom(faer::perm::PermRef::new_checked(o.order(), o.places(), n)),
            Default::default(),
        ),
        None => factorize_symbolic_cholesky(
            sym,
            Side::Lower,
            SymmetricOrdering::Amd,
            Default::default(),
        ),
    }
    .unwrap();
    let ts = t.elapsed().as_secs_f64();
    let t = Instant::now();
    let mut l = vec![0.0; s.len_val()];
    let a = faer::sparse::SparseColMatRef::new(sym, m.lower().values());
    let mut mem =
        MemBuffer::new(s.factorize_numeric_llt_scratch::<f64>(faer::Par::Seq, Default::default()));
    s.factorize_numeric_llt(
        &mut l,
        a,
        Side::Lower,
        Default::default(),
        faer::Par::Seq,
        MemStack::new(&mut mem),
        Default::default(),
    )
    .unwrap();
    let tn = t.elapsed().as_secs_f64();
    let (fill, flops) = match s.raw() {
        SymbolicCholeskyRaw::Supernodal(s) => {
            let mut fill = 0usize;
            let mut flops = 0f64;
            for i in 0..s.n_supernodes() {
                let c = (s.supernode_end()[i] - s.supernode_begin()[i]) as usize;
                let p = s.supernode(i).pattern().len();
                fill += c * (c + 1) / 2 + c * p;
                for k in 0..c {
                    flops += ((c - k + p) as f64).powi(2);
                }
            }
            (fill, flops)
        }
        SymbolicCholeskyRaw::Simplicial(s) => (s.len_val(), 0.0),
    };
    let hwm = std::fs::read_to_string("/proc/self/status").unwrap();
    let hwm = hwm
        .lines()
        .find(|l| l.starts_with("VmHWM"))
        .unwrap()
        .to_string();
    println!(
        "{} {} {n}: graph {tg:.3} order {to:.3} symbolic {ts:.3} numeric {tn:.3} total {:.3} fill {:.2}M len {:.2}M flops {:.2}G {hwm}",
        args[1],
        args[3],
        tg + to + ts + tn,
        fill as f64 / 1e6,
        s.len_val() as f64 / 1e6,
        flops / 1e9
    );
}
