use super::{ArcKind, ChartId, LayoutError};
use crate::mesh::{Element, FaceId, HalfedgeId, PerEdge, PerFace, PerVertex, TriangleMesh};

/// The closed walk of halfedges along each chart, its inside on the left.
pub(super) struct Borders {
    pub(super) walks: Vec<Vec<HalfedgeId>>,
}

impl Borders {
    /// # Errors
    /// [`LayoutError::NoDisk`].
    pub(super) fn of(
        mesh: &TriangleMesh,
        edges: &PerEdge<Option<ArcKind>>,
        chart_of: &PerFace<ChartId>,
        count: usize,
    ) -> Result<Self, LayoutError> {
        let mut walks: Vec<Vec<HalfedgeId>> = vec![Vec::new(); count];
        let mut visited = vec![false; mesh.halfedge_count()];
        let mut stamps = PerVertex::filled(mesh.vertex_count(), None);
        let euler = euler_characteristics(mesh, edges, chart_of, count);
        for first in mesh.halfedges() {
            if visited[first.index()] || edges[mesh.edge(first)].is_none() {
                continue;
            }
            let chart = chart_of[first.face()];
            let broken = |rule| no_disk(chart, first.face(), rule);
            let walk = border_walk(mesh, edges, first);
            for &halfedge in &walk {
                visited[halfedge.index()] = true;
                let stamp = &mut stamps[mesh.origin(halfedge)];
                if *stamp == Some(chart) {
                    return Err(broken("its border passes a vertex twice"));
                }
                *stamp = Some(chart);
            }
            if !walks[chart.index()].is_empty() {
                return Err(broken("it has two borders"));
            }
            walks[chart.index()] = walk;
        }
        for (face, &chart) in chart_of.enumerate() {
            if walks[chart.index()].is_empty() {
                return Err(no_disk(chart, face, "it has no border"));
            }
            if euler[chart.index()] != 1 {
                return Err(no_disk(chart, face, "its Euler characteristic is not 1"));
            }
        }
        Ok(Self { walks })
    }
}

fn no_disk(chart: ChartId, face: FaceId, rule: &'static str) -> LayoutError {
    LayoutError::NoDisk { chart, face, rule }
}

/// The halfedges along a chart from one of them on.
fn border_walk(
    mesh: &TriangleMesh,
    edges: &PerEdge<Option<ArcKind>>,
    first: HalfedgeId,
) -> Vec<HalfedgeId> {
    let after = |halfedge: HalfedgeId| {
        let mut next = halfedge.next();
        while let Some(twin) = mesh.twin(next).filter(|_| edges[mesh.edge(next)].is_none()) {
            next = twin.next();
        }
        next
    };
    std::iter::successors(Some(first), |&halfedge| {
        Some(after(halfedge)).filter(|&next| next != first)
    })
    .collect()
}

/// Vertices less edges plus triangles inside each chart: 1 for a disk.
fn euler_characteristics(
    mesh: &TriangleMesh,
    edges: &PerEdge<Option<ArcKind>>,
    chart_of: &PerFace<ChartId>,
    count: usize,
) -> Vec<i64> {
    let mut euler = vec![0_i64; count];
    let mut inside = PerVertex::filled(mesh.vertex_count(), true);
    for &chart in chart_of {
        euler[chart.index()] += 1;
    }
    for edge in mesh.edges() {
        let side = mesh.edge_halfedge(edge);
        if edges[edge].is_some() {
            for end in mesh.ends(side) {
                inside[end] = false;
            }
        } else {
            euler[chart_of[side.face()].index()] -= 1;
        }
    }
    for vertex in mesh.vertices().filter(|&vertex| inside[vertex]) {
        euler[chart_of[mesh.vertex_halfedge(vertex).face()].index()] += 1;
    }
    euler
}
