//! Components so small beside the quads that the net has no room on them: a few triangles that stand
//! alone, such as the fins that a scan leaves behind.

use std::collections::BTreeMap;

use crate::measure::scaled_jacobian;
use crate::mesh::{
    ComponentId, Components, Element, FaceId, HalfedgeId, PerComponent, PerEdge, Surface,
    SurfacePoint, Topology,
};
use crate::tolerance::{CRUMPLED_COMPONENT, MENDED_QUAD, SMALL_COMPONENT};

use super::PolygonMesh;

/// Gives components that the net left with poor quads, or with two on the same vertices, their own
/// triangles instead, each cut into three quads, where the component is small and these are better: so
/// small that no net is seen in it, or a little larger where quads are inverted. Returns the number of
/// such components.
pub(super) fn split_small_components(
    mesh: &mut PolygonMesh,
    surface: &Surface,
    is_feature: &PerEdge<bool>,
) -> usize {
    let topology = Topology::of(surface.mesh());
    let component_of = |polygon: usize| {
        let vertex = mesh.polygons.vertices(polygon)[0];
        topology.face_components[mesh.origins[vertex as usize].face]
    };
    let states = states(mesh, component_of, topology.components.len());
    let components = Components::new(surface, &topology);
    let is_split = PerComponent::from_fn(states.len(), |component| {
        states[component].is_worse_than(components.faces(component), surface)
    });
    let count = is_split.iter().filter(|&&split| split).count();
    if count == 0 {
        return 0;
    }
    let rest = kept(mesh, |polygon| !is_split[component_of(polygon)]);
    let mut quads = TriangleQuads::new(rest, surface, is_feature);
    let all = (0..is_split.len()).map(ComponentId::from_index);
    for component in all.filter(|&component| is_split[component]) {
        quads.add(components.faces(component));
    }
    *mesh = quads.finish();
    count
}

/// How good the polygons of a component are.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    polygons: usize,
    /// The least scaled Jacobian of a quad.
    least: f64,
    has_duplicates: bool,
}

impl State {
    /// Whether no solver can use the polygons.
    pub(super) fn is_crumpled(&self) -> bool {
        self.has_duplicates || self.least <= 0.0
    }

    /// Whether the triangles, each cut into three quads, serve better.
    fn is_worse_than(&self, faces: &[FaceId], surface: &Surface) -> bool {
        if self.has_duplicates {
            return true;
        }
        let few = if self.least > 0.0 {
            SMALL_COMPONENT
        } else {
            CRUMPLED_COMPONENT
        };
        let shapes = faces.iter().map(|&face| least_jacobian(surface, face));
        self.polygons.max(faces.len()) <= few
            && self.least < MENDED_QUAD
            && shapes.fold(1.0, f64::min) > self.least.max(0.0)
    }
}

/// The states of the components; `component_of` tells that of a polygon.
pub(super) fn states(
    mesh: &PolygonMesh,
    component_of: impl Fn(usize) -> ComponentId,
    count: usize,
) -> PerComponent<State> {
    let fine = State {
        polygons: 0,
        least: 1.0,
        has_duplicates: false,
    };
    let mut states = PerComponent::filled(count, fine);
    let mut seen = BTreeMap::new();
    for polygon in 0..mesh.polygons.len() {
        let vertices = mesh.polygons.vertices(polygon);
        let state = &mut states[component_of(polygon)];
        state.polygons += 1;
        if let Ok(quad) = <[u32; 4]>::try_from(vertices) {
            let corners = quad.map(|vertex| mesh.positions[vertex as usize]);
            state.least = state.least.min(scaled_jacobian(corners));
        }
        let mut key = vertices.to_vec();
        key.sort_unstable();
        state.has_duplicates |= seen.insert(key, polygon).is_some();
    }
    states
}

/// The least scaled Jacobian of the three quads of a triangle.
fn least_jacobian(surface: &Surface, face: FaceId) -> f64 {
    let corners = surface.corner_positions(face);
    let centre = corners.iter().sum::<glam::DVec3>() / 3.0;
    let quads = (0..3).map(|side| {
        let [before, at, after] = [2, 0, 1].map(|step| corners[(side + step) % 3]);
        [at, at.midpoint(after), centre, at.midpoint(before)]
    });
    quads.map(scaled_jacobian).fold(1.0, f64::min)
}

/// The polygons that are kept, with their vertices.
pub(super) fn kept(mesh: &PolygonMesh, is_kept: impl Fn(usize) -> bool) -> PolygonMesh {
    let mut numbers = vec![None; mesh.positions.len()];
    let mut rest = PolygonMesh::default();
    for polygon in (0..mesh.polygons.len()).filter(|&polygon| is_kept(polygon)) {
        let vertices = mesh.polygons.vertices(polygon).iter().map(|&vertex| {
            *numbers[vertex as usize].get_or_insert_with(|| {
                rest.positions.push(mesh.positions[vertex as usize]);
                rest.origins.push(mesh.origins[vertex as usize]);
                (rest.positions.len() - 1) as u32
            })
        });
        let vertices: Vec<u32> = vertices.collect();
        rest.polygons.push(&vertices);
    }
    let renumbered = |&[from, to]: &[u32; 2]| {
        let [from, to] = [numbers[from as usize]?, numbers[to as usize]?];
        Some([from.min(to), from.max(to)])
    };
    rest.feature_edges = mesh.feature_edges.iter().filter_map(renumbered).collect();
    rest
}

/// A mesh that grows by components of which each triangle is cut into three quads.
pub(super) struct TriangleQuads<'a> {
    mesh: PolygonMesh,
    surface: &'a Surface,
    is_feature: &'a PerEdge<bool>,
}

impl<'a> TriangleQuads<'a> {
    pub(super) fn new(
        mesh: PolygonMesh,
        surface: &'a Surface,
        is_feature: &'a PerEdge<bool>,
    ) -> Self {
        Self {
            mesh,
            surface,
            is_feature,
        }
    }

    pub(super) fn finish(mut self) -> PolygonMesh {
        self.mesh.feature_edges.sort_unstable();
        self.mesh
    }

    /// Adds the three quads of each triangle of a component.
    pub(super) fn add(&mut self, faces: &[FaceId]) {
        let mesh = self.surface.mesh();
        let mut numbers = BTreeMap::new();
        for &face in faces {
            let centre = self.vertex(SurfacePoint {
                face,
                barycentric: [1.0 / 3.0; 3],
            });
            let [corners, middles] = [0.0, 0.5].map(|share| {
                face.halfedges().map(|side| {
                    let key = if share > 0.0 {
                        (1, mesh.edge(side).0)
                    } else {
                        (0, mesh.origin(side).0)
                    };
                    *numbers
                        .entry(key)
                        .or_insert_with(|| self.vertex(SurfacePoint::on_halfedge(side, share)))
                })
            });
            for (side, halfedge) in face.halfedges().into_iter().enumerate() {
                let [at, after] = [corners[side], middles[side]];
                self.mesh
                    .polygons
                    .push(&[at, after, centre, middles[(side + 2) % 3]]);
                self.mark(halfedge, [at, after, corners[(side + 1) % 3]]);
            }
        }
    }

    fn vertex(&mut self, origin: SurfacePoint) -> u32 {
        self.mesh.positions.push(origin.position(self.surface));
        self.mesh.origins.push(origin);
        (self.mesh.positions.len() - 1) as u32
    }

    /// Marks both halves of a side that is a feature, once.
    fn mark(&mut self, side: HalfedgeId, [from, middle, to]: [u32; 3]) {
        let mesh = self.surface.mesh();
        let edge = mesh.edge(side);
        if self.is_feature[edge] && mesh.edge_halfedge(edge) == side {
            for [one, other] in [[from, middle], [middle, to]] {
                self.mesh
                    .feature_edges
                    .push([one.min(other), one.max(other)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleTree;
    use crate::periodic::GridDensity;
    use crate::quads::{RemeshOptions, remesh};
    use crate::watch::Watch;
    use glam::DVec3;
    use graticule_fixtures::{CUBE_QUADS, Fixture, icosphere, tetrahedron};

    fn surface(fixture: Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    /// A ball with a lone triangle and a tetrahedron beside it, both far smaller than a quad.
    fn with_debris() -> Surface {
        let triangle = Fixture {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.9, 0.1)],
            triangles: vec![[0, 1, 2]],
        };
        let beside = |fixture: Fixture, x: f64| fixture.map(|p| p * 0.02 + DVec3::X * x);
        surface(
            icosphere(3)
                .joined(&beside(triangle, 2.0))
                .joined(&beside(tetrahedron(), 3.0)),
        )
    }

    #[test]
    fn lone_triangles_and_tiny_tetrahedra_become_sound_quads() {
        let surface = with_debris();
        let options = RemeshOptions {
            density: GridDensity::Quads(300),
            ..RemeshOptions::default()
        };
        let made = remesh(&surface, &options, &Watch::new()).unwrap();
        made.mesh.check(&surface).unwrap();
        assert_eq!(made.report.split_components, 2);
        let polygons = &made.mesh.polygons;
        let mut sorted: Vec<Vec<u32>> = (0..polygons.len())
            .map(|polygon| {
                let corners = <[u32; 4]>::try_from(polygons.vertices(polygon)).unwrap();
                let jacobian = scaled_jacobian(corners.map(|v| made.mesh.positions[v as usize]));
                assert!(jacobian > MENDED_QUAD, "quad {polygon}: {jacobian}");
                let mut corners = corners.to_vec();
                corners.sort_unstable();
                corners
            })
            .collect();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), polygons.len());
    }

    #[test]
    fn inverted_quads_give_way_to_a_hundred_triangles_but_not_to_more() {
        for (level, split) in [(1, 1), (2, 0)] {
            let surface = surface(icosphere(level));
            let tree = TriangleTree::of_surface(&surface);
            let sign = |vertex: u32, bit: u32| if vertex >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let corner = |vertex: u32| match vertex {
                0 => DVec3::new(2.0, 2.0, -1.0),
                _ => DVec3::new(sign(vertex, 0), sign(vertex, 1), sign(vertex, 2)),
            };
            let origins: Vec<_> = (0..8).map(|v| tree.closest(corner(v)).unwrap()).collect();
            let mut mesh = PolygonMesh {
                positions: origins.iter().map(|o| o.position(&surface)).collect(),
                polygons: CUBE_QUADS.iter().map(|quad| &quad[..]).collect(),
                origins,
                feature_edges: Vec::new(),
            };
            mesh.check(&surface).unwrap();
            let none = PerEdge::filled(surface.mesh().edge_count(), false);
            assert_eq!(split_small_components(&mut mesh, &surface, &none), split);
            mesh.check(&surface).unwrap();
        }
    }

    #[test]
    fn good_components_stay_as_they_are() {
        let surface = surface(icosphere(3));
        let options = RemeshOptions {
            density: GridDensity::Quads(300),
            ..RemeshOptions::default()
        };
        let made = remesh(&surface, &options, &Watch::new()).unwrap();
        let mut mesh = made.mesh.clone();
        let none = PerEdge::filled(surface.mesh().edge_count(), false);
        assert_eq!(split_small_components(&mut mesh, &surface, &none), 0);
        assert_eq!(mesh, made.mesh);
    }
}
