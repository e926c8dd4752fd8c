use glam::{BVec2, DVec2, DVec3};

use super::layout_map::{face_corners, spread_shares};
use super::{ArcKind, EmbeddedNet};
use crate::geometry::TriangleShape;
use crate::mesh::{
    DisjointSets, EdgeId, Element, FaceId, MeshError, PerCorner, PerEdge, PerFace, PerVertex,
    RefinedSurface, Surface, SurfacePoint, TriangleMesh, VertexId, triangulate_polygon,
};
use crate::periodic::GridMap;
use crate::quads::{NetArcKind, NetCells};
use crate::tolerance::{CHART_AGREEMENT, DEGENERATE_HEIGHT};

/// The surface refined so that the arcs of a net are chains of its edges.
///
/// Nodes on edges are moved apart where they nearly meet, and with them the lines, which stay
/// straight in each triangle: as the order of nodes along edges is kept, so is the arrangement, and
/// no refined triangle is without area. Coordinates are those of the places moved to; on a line its
/// whole number.
///
/// # Errors
/// None for cells of the surface; those of [`Surface::from_triangles`] else.
pub(super) fn embed(
    surface: &Surface,
    map: &GridMap,
    cells: &NetCells,
) -> Result<EmbeddedNet, MeshError> {
    let mut refinement = Refinement::new(surface, map, cells);
    refinement.drop_needless_arcs();
    refinement.cut_faces();
    refinement.into_net()
}

/// The dart of the same arc in the other direction.
fn twin(dart: u32) -> u32 {
    dart ^ 1
}

/// Where a node lies on an edge, as shares of the way along the edge's first halfedge.
#[derive(Clone, Copy)]
struct EdgePlace {
    edge: EdgeId,
    found: f64,
    moved: f64,
}

/// Where a node lies: as the lines were found, or moved apart from others.
#[derive(Clone, Copy)]
enum Version {
    Found,
    Moved,
}

struct Refinement<'a> {
    surface: &'a Surface,
    map: &'a GridMap,
    cells: &'a NetCells,
    edge_places: Vec<EdgePlace>,
    /// Where the nodes inside triangles come to lie.
    inner: Vec<SurfacePoint>,
    /// Which arcs are neither drawn nor needed.
    dropped: Vec<bool>,
    /// For each node the number of arcs that stay.
    degrees: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    origins: Vec<FaceId>,
    /// The kind of arc along each side of the refined triangles.
    side_kinds: Vec<Option<ArcKind>>,
}

impl<'a> Refinement<'a> {
    fn new(surface: &'a Surface, map: &'a GridMap, cells: &'a NetCells) -> Self {
        let edge_places = edge_places(surface.mesh(), cells);
        let mut refinement = Self {
            dropped: vec![false; cells.arc_count()],
            degrees: vec![0; cells.points().len()],
            inner: Vec::new(),
            triangles: Vec::new(),
            origins: Vec::new(),
            side_kinds: Vec::new(),
            surface,
            map,
            cells,
            edge_places,
        };
        refinement.place_inner_nodes();
        refinement
    }

    fn vertex_count(&self) -> u32 {
        self.surface.mesh().vertex_count() as u32
    }

    fn first_inner(&self) -> u32 {
        self.vertex_count() + self.edge_places.len() as u32
    }

    fn darts(&self) -> std::ops::Range<u32> {
        0..2 * self.cells.arc_count() as u32
    }

    /// A node as a point of a triangle that it touches.
    fn point(&self, face: FaceId, node: u32, version: Version) -> SurfacePoint {
        let mesh = self.surface.mesh();
        if node < self.vertex_count() {
            let corner = (face.halfedges().into_iter()).find(|&c| mesh.origin(c).0 == node);
            return SurfacePoint::at_corner(corner.unwrap_or(face.halfedges()[0]));
        }
        if let Some(inner) = node.checked_sub(self.first_inner()) {
            return match version {
                Version::Found => self.cells.points()[node as usize],
                Version::Moved => self.inner[inner as usize],
            };
        }
        let place = self.edge_places[(node - self.vertex_count()) as usize];
        let share = match version {
            Version::Found => place.found,
            Version::Moved => place.moved,
        };
        let side = mesh.edge_halfedge(place.edge);
        match mesh.twin(side).filter(|twin| twin.face() == face) {
            Some(twin) => SurfacePoint::on_halfedge(twin, 1.0 - share),
            None => SurfacePoint::on_halfedge(side, share),
        }
    }

    /// Puts each lattice point inside a triangle where the two lines through it cross between their
    /// moved ends.
    fn place_inner_nodes(&mut self) {
        let first = self.first_inner();
        self.inner = self.cells.points()[first as usize..].to_vec();
        let mut leaving = vec![u32::MAX; self.inner.len()];
        for dart in self.darts().rev() {
            if let Some(slot) = (self.cells.origin(dart).checked_sub(first))
                .and_then(|inner| leaving.get_mut(inner as usize))
            {
                *slot = dart;
            }
        }
        let places: Vec<SurfacePoint> = (leaving.iter().zip(&self.inner))
            .map(|(&dart, &found)| self.crossing(dart, found))
            .collect();
        self.inner = places;
    }

    fn crossing(&self, dart: u32, found: SurfacePoint) -> SurfacePoint {
        let face = found.face;
        let flat = |dart: u32| {
            let end = self.cells.origin(twin(self.end_of_line(dart)));
            let [_, u, v] = self.point(face, end, Version::Moved).barycentric;
            DVec2::new(u, v)
        };
        let second = self.cells.next(twin(dart));
        let third = self.cells.next(twin(second));
        let fourth = self.cells.next(twin(third));
        let [a, c, b, d] = [dart, second, third, fourth].map(flat);
        let (ab, cd) = (b - a, d - c);
        let share = (c - a).perp_dot(cd) / ab.perp_dot(cd);
        let DVec2 { x, y } = a.lerp(b, share);
        let barycentric = [1.0 - x - y, x, y];
        if barycentric
            .iter()
            .all(|&weight| weight > 0.0 && weight < 1.0)
        {
            SurfacePoint { face, barycentric }
        } else {
            found
        }
    }

    /// The last dart of a line inside a triangle, from one of its darts straight on.
    fn end_of_line(&self, first: u32) -> u32 {
        let mut dart = first;
        while self.cells.origin(twin(dart)) >= self.first_inner() {
            let left = self.cells.next(dart);
            dart = self.cells.next(twin(left));
        }
        dart
    }

    /// Drops arcs inside triangles that are not part of the net, as long as faces stay disks.
    fn drop_needless_arcs(&mut self) {
        let cells = self.cells;
        for dart in self.darts() {
            self.degrees[cells.origin(dart) as usize] += 1;
        }
        let is_free = |dart: u32| cells.kind(dart) == NetArcKind::Inner && !cells.is_on_edge(dart);
        let mut sets = DisjointSets::new(cells.face_count());
        for dart in self.darts().step_by(2).filter(|&dart| is_free(dart)) {
            if let (Some(one), Some(other)) = (cells.face(dart), cells.face(twin(dart)))
                && sets.join(one, other)
            {
                self.drop(dart);
            }
        }
        // What is left inside a face hangs on its border.
        let mut ends: Vec<u32> = self.darts().filter(|&dart| is_free(dart)).collect();
        while let Some(dart) = ends.pop() {
            let is_end = self.degrees[cells.origin(dart) as usize] == 1;
            if is_end && !self.is_dropped(dart) {
                let next = self.next_kept(dart);
                self.drop(dart);
                if is_free(next) {
                    ends.push(next);
                }
            }
        }
    }

    fn drop(&mut self, dart: u32) {
        self.dropped[(dart / 2) as usize] = true;
        for dart in [dart, twin(dart)] {
            self.degrees[self.cells.origin(dart) as usize] -= 1;
        }
    }

    fn is_dropped(&self, dart: u32) -> bool {
        self.dropped[(dart / 2) as usize]
    }

    /// The next dart along the same face that is not dropped.
    fn next_kept(&self, dart: u32) -> u32 {
        let mut next = self.cells.next(dart);
        while self.is_dropped(next) {
            next = self.cells.next(twin(next));
        }
        next
    }

    /// Whether a dart's origin is a corner of faces: not where just two pieces of an edge meet.
    fn is_corner(&self, dart: u32) -> bool {
        let node = self.cells.origin(dart);
        node < self.vertex_count()
            || node >= self.first_inner()
            || self.degrees[node as usize] > 2
            || self.cells.is_lattice(node) && self.cells.kind(dart) != NetArcKind::Inner
    }

    /// Cuts the faces that are left into triangles.
    fn cut_faces(&mut self) {
        let mut visited = vec![false; self.darts().len()];
        for first in self.darts() {
            let face = self.cells.face(first);
            let Some(face) = face.filter(|_| !visited[first as usize] && !self.is_dropped(first))
            else {
                continue;
            };
            let mut walk = Vec::new();
            let mut dart = first;
            while !visited[dart as usize] {
                visited[dart as usize] = true;
                walk.push(dart);
                dart = self.next_kept(dart);
            }
            walk.retain(|&dart| self.is_corner(dart));
            self.cut_face(self.cells.face_triangles()[face as usize], &walk);
        }
    }

    fn cut_face(&mut self, face: FaceId, walk: &[u32]) {
        let corners = flat_corners(self.surface, face);
        let places: Vec<DVec3> = walk
            .iter()
            .map(|&dart| self.point(face, self.cells.origin(dart), Version::Moved))
            .map(|point| point.interpolate(corners).extend(0.0))
            .collect();
        let count = walk.len() as u32;
        for triangle in triangulate_polygon(&places) {
            self.origins.push(face);
            self.triangles
                .push(triangle.map(|corner| self.cells.origin(walk[corner as usize])));
            for side in 0..3 {
                let [from, to] = [triangle[side], triangle[(side + 1) % 3]];
                let along = ((from + 1) % count == to)
                    .then(|| arc_kind(self.cells.kind(walk[from as usize])));
                self.side_kinds.push(along.flatten());
            }
        }
    }

    fn into_net(self) -> Result<EmbeddedNet, MeshError> {
        let mut numbers = vec![u32::MAX; self.cells.points().len()];
        for &node in self.triangles.as_flattened() {
            numbers[node as usize] = 0;
        }
        let mut vertex_origin = Vec::new();
        let mut nodes = Vec::new();
        for (node, number) in numbers.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
            *number = vertex_origin.len() as u32;
            vertex_origin.push(self.origin_of(node as u32));
            nodes.push(self.cells.is_lattice(node as u32));
        }
        let triangles: Vec<[u32; 3]> = (self.triangles.iter())
            .map(|triangle| triangle.map(|node| numbers[node as usize]))
            .collect();
        let positions = (vertex_origin.iter()).map(|point| point.position(self.surface));
        let surface = Surface::from_triangles(positions.collect(), &triangles)?;
        let mesh = surface.mesh();
        let edges = PerEdge::from_fn(mesh.edge_count(), |edge| {
            self.side_kinds[mesh.edge_halfedge(edge).index()]
        });
        Ok(EmbeddedNet {
            coordinates: self.coordinates(),
            nodes: PerVertex::new(nodes),
            edges,
            refined: RefinedSurface {
                surface,
                face_origin: PerFace::new(self.origins),
                vertex_origin: PerVertex::new(vertex_origin),
            },
        })
    }

    /// Where a node lies on the input.
    fn origin_of(&self, node: u32) -> SurfacePoint {
        let mesh = self.surface.mesh();
        let face = if node < self.vertex_count() {
            mesh.vertex_halfedge(VertexId(node)).face()
        } else {
            match self.edge_places.get((node - self.vertex_count()) as usize) {
                Some(place) => mesh.edge_halfedge(place.edge).face(),
                None => self.cells.points()[node as usize].face,
            }
        };
        self.point(face, node, Version::Moved)
    }

    fn coordinates(&self) -> PerCorner<Option<DVec2>> {
        let mut coordinates = Vec::with_capacity(3 * self.triangles.len());
        for (&face, triangle) in self.origins.iter().zip(&self.triangles) {
            let corners = face_corners(self.map, face);
            coordinates.extend(
                triangle.map(|node| corners.map(|corners| self.coordinate(face, node, corners))),
            );
        }
        PerCorner::new(coordinates)
    }

    /// Whether a node is a place on an edge where one line crosses it; another may cross it next to
    /// that.
    fn is_on_one_line(&self, node: u32) -> bool {
        let on_edges = self.vertex_count()..self.first_inner();
        on_edges.contains(&node) && !self.cells.is_lattice(node)
    }

    /// The coordinates of a node in a triangle, on a line exactly.
    fn coordinate(&self, face: FaceId, node: u32, corners: [DVec2; 3]) -> DVec2 {
        let [found, moved] = [Version::Found, Version::Moved]
            .map(|version| self.point(face, node, version).interpolate(corners));
        let factor = f64::from(self.cells.factor);
        let line = (found * factor).round() / factor;
        let miss = (found - line).abs();
        let mut on_line = miss.cmplt(DVec2::splat(CHART_AGREEMENT));
        if on_line.all() && self.is_on_one_line(node) {
            on_line = BVec2::new(miss.x <= miss.y, miss.y < miss.x);
        }
        DVec2::select(on_line, line, moved)
    }
}

fn edge_places(mesh: &TriangleMesh, cells: &NetCells) -> Vec<EdgePlace> {
    let mut places = Vec::new();
    for edge in mesh.edges() {
        let (nodes, forward) = cells.edge_nodes(mesh, edge);
        let side = mesh.edge_halfedge(edge);
        let side = if forward {
            side
        } else {
            mesh.twin(side).unwrap_or(side)
        };
        let found: Vec<f64> = nodes
            .map(|node| cells.points()[node as usize].barycentric[side.next().side()])
            .collect();
        let mut moved = found.clone();
        spread_shares(&mut moved);
        let along = |share: f64| if forward { share } else { 1.0 - share };
        places.extend(found.iter().zip(moved).map(|(&found, moved)| EdgePlace {
            edge,
            found: along(found),
            moved: along(moved),
        }));
    }
    places
}

/// The corners of a triangle laid in the plane; those of any other where it has no area to speak of,
/// as what lies inside does so in all.
fn flat_corners(surface: &Surface, face: FaceId) -> [DVec2; 3] {
    let shape = TriangleShape::from_positions(surface.corner_positions(face));
    if shape.height_ratio() > DEGENERATE_HEIGHT {
        shape.corners()
    } else {
        [DVec2::ZERO, DVec2::X, DVec2::Y]
    }
}

fn arc_kind(kind: NetArcKind) -> Option<ArcKind> {
    match kind {
        NetArcKind::Inner => None,
        NetArcKind::Line => Some(ArcKind::Line),
        NetArcKind::Cut => Some(ArcKind::Cut),
        NetArcKind::Feature => Some(ArcKind::Feature),
        NetArcKind::Boundary => Some(ArcKind::Boundary),
    }
}
