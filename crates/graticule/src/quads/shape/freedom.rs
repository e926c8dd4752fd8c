use super::Net;
use super::ground::Ground;
use crate::mesh::{PolygonConnectivity, SurfacePoint};

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Freedom {
    /// Anywhere on the surface.
    Surface,
    /// Along the line it lies on.
    Line,
    /// Nowhere.
    Fixed,
}

/// The freedom of each vertex: inside, on a line that passes it, or at the end or crossing of lines.
pub(super) fn freedoms(
    net: &Net<'_>,
    mesh: &PolygonConnectivity,
    ground: &Ground,
    origins: &[SurfacePoint],
) -> Vec<Freedom> {
    let mut line_edges: Vec<[u32; 2]> = net
        .feature_edges
        .iter()
        .map(|&[a, b]| [a.min(b), a.max(b)])
        .collect();
    let single = mesh.edges().filter(|sides| sides.len() != 2);
    line_edges.extend(single.map(|sides| mesh.edge(sides[0])));
    line_edges.sort_unstable();
    line_edges.dedup();
    let mut lines_at = vec![0_u32; mesh.vertex_count()];
    for vertex in line_edges.into_iter().flatten() {
        if let Some(count) = lines_at.get_mut(vertex as usize) {
            *count += 1;
        }
    }
    let freedom = |(count, &origin): (u32, &SurfacePoint)| match count {
        0 => Freedom::Surface,
        2 if ground.lines.halfedge_at(&ground.surface, origin).is_some() => Freedom::Line,
        _ => Freedom::Fixed,
    };
    lines_at.into_iter().zip(origins).map(freedom).collect()
}
