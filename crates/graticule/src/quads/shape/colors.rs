use crate::mesh::PolygonConnectivity;

/// Vertices in groups, no two of a group in one polygon, so that all vertices of a group can move
/// at once; greedily in the order of the vertices. Only vertices that `may_move` are in a group.
pub(super) fn independent_groups(
    mesh: &PolygonConnectivity,
    may_move: impl Fn(usize) -> bool,
) -> Vec<Vec<u32>> {
    const NONE: u32 = u32::MAX;
    let mut colors = vec![NONE; mesh.vertex_count()];
    let mut groups: Vec<Vec<u32>> = Vec::new();
    // For each color the vertex that found it taken last.
    let mut taken_for: Vec<u32> = Vec::new();
    for vertex in (0..mesh.vertex_count()).filter(|&vertex| may_move(vertex)) {
        let name = vertex as u32;
        for &corner in mesh.corners_at(vertex) {
            for &other in mesh.vertices(mesh.polygon(corner)) {
                if let Some(taken) = taken_for.get_mut(colors[other as usize] as usize) {
                    *taken = name;
                }
            }
        }
        let free = taken_for.iter().position(|&taken| taken != name);
        let color = free.unwrap_or_else(|| {
            groups.push(Vec::new());
            taken_for.push(NONE);
            groups.len() - 1
        });
        colors[vertex] = color as u32;
        groups[color].push(name);
    }
    groups
}
