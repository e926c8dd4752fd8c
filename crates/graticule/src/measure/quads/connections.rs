use std::collections::BTreeMap;

use serde::Serialize;

use crate::mesh::{Defects, PolygonConnectivity, PolygonSoup, Topology};

/// How the polygons hang together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Connections {
    /// Vertices of polygons.
    pub vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Vertices less edges plus polygons.
    pub euler_characteristic: i64,
    /// Components: polygons joined by common edges.
    pub components: usize,
    /// Boundary loops, with non-manifold edges cut and non-manifold vertices split.
    pub boundary_loops: usize,
    /// Edges with one polygon.
    pub boundary_edges: usize,
    /// Edges with more than two polygons.
    pub non_manifold_edges: usize,
    /// Vertices whose polygons hang together only there.
    pub non_manifold_vertices: usize,
    /// Edges that two polygons run along in the same direction.
    pub inconsistent_edges: usize,
    /// Boundary vertices that lie inside another boundary edge: cracks.
    pub t_vertices: usize,
    /// Polygons over the same vertices as an earlier one.
    pub duplicate_polygons: usize,
    /// Polygons without area.
    pub flat_polygons: usize,
    /// Vertices of the soup without polygon.
    pub unused_vertices: usize,
    /// Whether every edge has at most two polygons, which run along it in opposite directions, and
    /// the polygons of every vertex make one fan.
    pub manifold: bool,
}

/// Edges at the vertices. A vertex is regular with four edges inside and three on the boundary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Valences {
    /// Vertices that are not regular.
    pub irregular: usize,
    /// Those of them that are not on the boundary.
    pub irregular_inside: usize,
    /// Share of the vertices that are irregular, in `0.0..=1.0`; 0 without any.
    pub irregular_share: f64,
    /// Vertices inside for each number of edges.
    pub inside: BTreeMap<usize, usize>,
    /// Vertices on the boundary for each number of edges.
    pub boundary: BTreeMap<usize, usize>,
}

/// A vertex that is not regular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IrregularVertex {
    /// Its number in the soup.
    pub vertex: u32,
    /// Its edges.
    pub valence: usize,
    /// The edges that a regular vertex has there: 4, or 3 on the boundary.
    pub regular: usize,
}

/// Valences, and the irregular vertices with theirs.
pub(super) fn valences(mesh: &PolygonConnectivity) -> (Valences, Vec<IrregularVertex>) {
    let mut edges_at = vec![0_usize; mesh.vertex_count()];
    let mut on_boundary = vec![false; mesh.vertex_count()];
    for sides in mesh.edges() {
        for vertex in mesh.edge(sides[0]) {
            edges_at[vertex as usize] += 1;
            on_boundary[vertex as usize] |= sides.len() == 1;
        }
    }
    let [mut inside, mut boundary] = [BTreeMap::new(), BTreeMap::new()];
    let mut irregular = Vec::new();
    let mut irregular_inside = 0;
    let used = (0_u32..).zip(edges_at.into_iter().zip(on_boundary));
    for (vertex, (valence, is_boundary)) in used.filter(|(_, (valence, _))| *valence > 0) {
        let (histogram, regular) = if is_boundary {
            (&mut boundary, 3)
        } else {
            (&mut inside, 4)
        };
        *histogram.entry(valence).or_insert(0) += 1;
        if valence != regular {
            irregular.push(IrregularVertex {
                vertex,
                valence,
                regular,
            });
            irregular_inside += usize::from(!is_boundary);
        }
    }
    let vertices: usize = inside.values().chain(boundary.values()).sum();
    let valences = Valences {
        irregular: irregular.len(),
        irregular_inside,
        irregular_share: irregular.len() as f64 / vertices.max(1) as f64,
        inside,
        boundary,
    };
    (valences, irregular)
}

pub(super) fn connections(
    mesh: &PolygonConnectivity,
    defects: &Defects,
    valences: &Valences,
) -> Connections {
    let vertices: usize = valences
        .inside
        .values()
        .chain(valences.boundary.values())
        .sum();
    let edges = mesh.edges().count();
    let signed = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
    let non_manifold_edges = mesh.edges().filter(|sides| sides.len() > 2).count();
    let non_manifold_vertices = defects.non_manifold_vertices.count();
    let inconsistent_edges = mesh.edges().filter(|sides| run_alike(mesh, sides)).count();
    Connections {
        vertices,
        edges,
        euler_characteristic: signed(vertices) - signed(edges) + signed(mesh.polygon_count()),
        components: defects.components,
        boundary_loops: defects.boundary_loops,
        boundary_edges: mesh.edges().filter(|sides| sides.len() == 1).count(),
        non_manifold_edges,
        non_manifold_vertices,
        inconsistent_edges,
        t_vertices: defects.t_junctions.count(),
        duplicate_polygons: defects.duplicate_polygons.count(),
        flat_polygons: defects.zero_area.count(),
        unused_vertices: mesh.vertex_count() - vertices,
        manifold: non_manifold_edges + non_manifold_vertices + inconsistent_edges == 0,
    }
}

/// Whether two of the sides on an edge run in the same direction.
fn run_alike(mesh: &PolygonConnectivity, sides: &[u32]) -> bool {
    let first = mesh.edge(sides[0])[0];
    let forward = sides
        .iter()
        .filter(|&&side| mesh.origin(side) == first)
        .count();
    forward > 1 || sides.len() - forward > 1
}

/// Whether a soup has the components, boundary loops and Euler characteristic of a surface.
pub(super) fn same_topology(soup: &PolygonSoup, topology: &Topology) -> bool {
    let mesh = PolygonConnectivity::of(soup);
    let (valences, _) = valences(&mesh);
    let own = connections(&mesh, &Defects::find(soup), &valences);
    own.components == topology.components.len()
        && own.boundary_loops == topology.total.boundary_loops
        && own.euler_characteristic == topology.total.euler_characteristic
}
