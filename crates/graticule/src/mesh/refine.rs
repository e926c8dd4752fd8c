//! Smaller triangles on the same surface.

use std::cmp::Ordering;

use glam::DVec3;

use super::{
    EdgeId, FaceId, PerEdge, PerFace, PerVertex, RefinedSurface, Surface, SurfacePoint,
    TriangleMesh, VertexId,
};
use crate::tolerance::COTANGENT_FLIP;
use crate::watch::{Stopped, Watch};

/// A surface whose triangles are cut into smaller ones, and the way back.
///
/// It is the same set of points up to the rounding of midpoints. Vertices of the original keep
/// their numbers, as does one part of each triangle.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// The surface with small triangles, and where they lie on the original.
    pub refined: RefinedSurface,
    /// The original edge that each edge is a part of, if it is not inside a triangle.
    pub edge_parents: PerEdge<Option<EdgeId>>,
}

/// Halves edges until none is longer than `longest`, in the unit of the positions.
///
/// First edges of the surface, then those inside its triangles. Meanwhile the parts of each triangle
/// are kept a Delaunay triangulation, so that a needle becomes a ladder, not a pile of needles.
/// Deterministic. Cost: near-linear in the triangles that come out, see [`refined_count`]; at eight
/// times that it stops.
///
/// # Errors
/// [`Stopped`].
pub fn refine(surface: &Surface, longest: f64, watch: &Watch) -> Result<Refinement, Stopped> {
    let _stage = watch.stage("refine triangles");
    let most = 8.0 * refined_count(surface, longest);
    let mut draft = Draft::of(surface);
    draft.halve_edges(longest, watch)?;
    draft.halve_inside(longest, most, watch)?;
    Ok(draft.finish())
}

/// About how many triangles [`refine`] would make of a surface.
///
/// A triangle with sides of `a ≥ b ≥ c` pieces becomes about `a·b` where it is round and `a` where it
/// is a needle. Linear time.
#[must_use]
pub fn refined_count(surface: &Surface, longest: f64) -> f64 {
    let pieces = |face| {
        let [a, b, c] = surface.corner_positions(face);
        let mut counts = [a.distance(b), b.distance(c), c.distance(a)]
            .map(|length| (length / longest).ceil().max(1.0));
        counts.sort_by(f64::total_cmp);
        counts[2] * counts[0]
    };
    surface.mesh().faces().map(pieces).sum()
}

impl Refinement {
    /// The edges that are parts of the given original ones, in order.
    #[must_use]
    pub fn edges_of(&self, originals: &[EdgeId]) -> Vec<EdgeId> {
        let mut originals = originals.to_vec();
        originals.sort_unstable();
        let wanted = |parent: &Option<EdgeId>| {
            parent.is_some_and(|parent| originals.binary_search(&parent).is_ok())
        };
        let edges = self.edge_parents.enumerate();
        edges
            .filter(|(_, parent)| wanted(parent))
            .map(|(edge, _)| edge)
            .collect()
    }
}

/// No piece: the side is on the boundary.
const NONE: u32 = u32::MAX;

/// Pieces between two looks at the watch.
const PIECES_PER_CHECK: usize = 4096;

/// A triangle that is a part of an original one.
#[derive(Clone, Copy)]
struct Piece {
    vertices: [u32; 3],
    parent: FaceId,
    /// Barycentric coordinates of the corners in the original triangle.
    corners: [[f64; 3]; 3],
    /// The original edge that each side is a part of.
    edges: [Option<EdgeId>; 3],
    /// The piece across each side.
    across: [u32; 3],
}

impl Piece {
    fn of(mesh: &TriangleMesh, face: FaceId) -> Self {
        let across = |side| mesh.twin(side).map_or(NONE, |twin| twin.face().0);
        Self {
            vertices: mesh.triangle(face).map(|vertex| vertex.0),
            parent: face,
            corners: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            edges: face.halfedges().map(|side| Some(mesh.edge(side))),
            across: face.halfedges().map(across),
        }
    }

    /// The vertices at the ends of a side.
    fn ends(&self, side: usize) -> [u32; 2] {
        [self.vertices[side], self.vertices[(side + 1) % 3]]
    }

    /// The piece with two sides of others, each told with the corner it starts from, then a third
    /// corner, and then the side back to the first, with `across` on its other side.
    fn joined(sides: [(&Self, usize); 2], last: (&Self, usize), across: u32) -> Self {
        let [one, two] = sides;
        let corners = [one, two, last];
        Self {
            vertices: corners.map(|(piece, corner)| piece.vertices[corner]),
            parent: one.0.parent,
            corners: corners.map(|(piece, corner)| piece.corners[corner]),
            edges: [one.0.edges[one.1], two.0.edges[two.1], None],
            across: [one.0.across[one.1], two.0.across[two.1], across],
        }
    }

    /// Shrinks to the part before the midpoint of a side and returns the part behind it, which
    /// gets the number `behind`. What is across the two halves is left open.
    fn halve(&mut self, side: usize, middle: u32, itself: u32, behind: u32) -> Self {
        let turned = |side_of: usize| (side + side_of) % 3;
        let (from, to, tip) = (side, turned(1), turned(2));
        let place =
            std::array::from_fn(|axis| 0.5 * (self.corners[from][axis] + self.corners[to][axis]));
        let second = Self {
            vertices: [middle, self.vertices[to], self.vertices[tip]],
            corners: [place, self.corners[to], self.corners[tip]],
            edges: [self.edges[from], self.edges[to], None],
            across: [NONE, self.across[to], itself],
            parent: self.parent,
        };
        *self = Self {
            vertices: [self.vertices[from], middle, self.vertices[tip]],
            corners: [self.corners[from], place, self.corners[tip]],
            edges: [self.edges[from], None, self.edges[tip]],
            across: [NONE, behind, self.across[tip]],
            parent: self.parent,
        };
        second
    }
}

/// A side, in an order that both pieces beside it agree on.
#[derive(Clone, Copy, PartialEq)]
struct Length {
    length: f64,
    ends: [u32; 2],
}

impl Length {
    fn order(&self, other: &Self) -> Ordering {
        let by_length = self.length.total_cmp(&other.length);
        by_length.then_with(|| self.ends.cmp(&other.ends))
    }
}

struct Draft {
    positions: Vec<DVec3>,
    /// Pieces of the originals first, in their order: each keeps the corner it shrank to.
    pieces: Vec<Piece>,
}

impl Draft {
    fn of(surface: &Surface) -> Self {
        let mesh = surface.mesh();
        Self {
            positions: surface.positions().iter().copied().collect(),
            pieces: mesh.faces().map(|face| Piece::of(mesh, face)).collect(),
        }
    }

    /// Halves what is too long of the edges of the surface.
    fn halve_edges(&mut self, longest: f64, watch: &Watch) -> Result<(), Stopped> {
        let mut at = 0;
        while at < self.pieces.len() {
            let piece = &self.pieces[at];
            let too_long = (0..3).find(|&side| {
                piece.edges[side].is_some() && self.length(piece, side).length > longest
            });
            match too_long {
                Some(side) => self.bisect(at as u32, side),
                None => at += 1,
            }
            if at.is_multiple_of(PIECES_PER_CHECK) {
                watch.check()?;
            }
        }
        Ok(())
    }

    /// Halves what is still too long, nearly all of it inside triangles, each time one that is the longest of
    /// both pieces beside it: a piece waits for its neighbour to get there (Rivara 1984).
    fn halve_inside(&mut self, longest: f64, most: f64, watch: &Watch) -> Result<(), Stopped> {
        let mut at = 0;
        while at < self.pieces.len() && (self.pieces.len() as f64) < most {
            let mut piece = at as u32;
            let (mut side, mut length) = self.longest_side(piece);
            if length.length <= longest {
                at += 1;
                continue;
            }
            loop {
                let other = self.pieces[piece as usize].across[side];
                if other == NONE {
                    break;
                }
                let (other_side, other_length) = self.longest_side(other);
                if other_length == length {
                    break;
                }
                (piece, side, length) = (other, other_side, other_length);
            }
            self.bisect(piece, side);
            if self.pieces.len().is_multiple_of(PIECES_PER_CHECK) {
                watch.check()?;
            }
        }
        Ok(())
    }

    fn length(&self, piece: &Piece, side: usize) -> Length {
        let mut ends = piece.ends(side);
        ends.sort_unstable();
        let [a, b] = ends.map(|end| self.positions[end as usize]);
        let length = a.distance(b);
        Length { length, ends }
    }

    fn longest_side(&self, piece: u32) -> (usize, Length) {
        let piece = &self.pieces[piece as usize];
        let length = |side| (side, self.length(piece, side));
        let longer = |a: (usize, Length), b: (usize, Length)| {
            if a.1.order(&b.1).is_ge() { a } else { b }
        };
        longer(longer(length(0), length(1)), length(2))
    }

    /// Halves a side and the pieces on both sides of it.
    fn bisect(&mut self, piece: u32, side: usize) {
        let [from, to] = self.pieces[piece as usize].ends(side);
        let other = self.pieces[piece as usize].across[side];
        let middle = self.positions.len() as u32;
        let (a, b) = (self.positions[from as usize], self.positions[to as usize]);
        self.positions.push(0.5 * a + 0.5 * b);
        let other_side = (other != NONE).then(|| self.side_from(other, to, from));
        let behind = self.halve(piece, side, middle);
        let mut suspects = vec![[piece, 2], [behind, 1]];
        if let Some(other_side) = other_side {
            let other_behind = self.halve(other, other_side, middle);
            self.pieces[piece as usize].across[0] = other_behind;
            self.pieces[other_behind as usize].across[0] = piece;
            self.pieces[other as usize].across[0] = behind;
            self.pieces[behind as usize].across[0] = other;
            suspects.extend([[other, 2], [other_behind, 1]]);
        }
        // Lawson's flips: only edges across from the new vertex can break the Delaunay rule.
        while let Some([piece, side]) = suspects.pop() {
            if let Some(exchanged) = self.flip_if_better(piece, side as usize) {
                suspects.extend(exchanged);
            }
        }
    }

    /// Exchanges an edge inside an original triangle for the other diagonal of the two pieces beside
    /// it if the angles across from it sum to more than π. Then returns the sides across from the
    /// vertex that was across from it.
    fn flip_if_better(&mut self, piece: u32, side: usize) -> Option<[[u32; 2]; 2]> {
        let first = self.pieces[piece as usize];
        let other = first.across[side];
        if first.edges[side].is_some() || other == NONE {
            return None;
        }
        let [a, b] = first.ends(side);
        let second = self.pieces[other as usize];
        let other_side = self.side_from(other, b, a);
        let at = |side: usize| (side + 2) % 3;
        let cotangents = self.cotangent(&first, at(side)) + self.cotangent(&second, at(other_side));
        // Rounding must not flip an edge to and fro.
        if cotangents.is_nan() || cotangents >= -COTANGENT_FLIP {
            return None;
        }
        let next = |side: usize| (side + 1) % 3;
        // The first becomes c, a, d and the second d, b, c, where c and d are across from a b.
        let one = Piece::joined(
            [(&first, at(side)), (&second, next(other_side))],
            (&second, at(other_side)),
            other,
        );
        let two = Piece::joined(
            [(&second, at(other_side)), (&first, next(side))],
            (&first, at(side)),
            piece,
        );
        self.pieces[piece as usize] = one;
        self.pieces[other as usize] = two;
        self.tell(one.across[1], one.ends(1), piece);
        self.tell(two.across[1], two.ends(1), other);
        Some([[piece, 1], [other, 0]])
    }

    /// Tells a piece which one is across its side that leads back from the ends of that one's.
    fn tell(&mut self, piece: u32, [from, to]: [u32; 2], across: u32) {
        if piece != NONE {
            let back = self.side_from(piece, to, from);
            self.pieces[piece as usize].across[back] = across;
        }
    }

    /// The cotangent of the angle at a corner; infinite where the piece is flat.
    fn cotangent(&self, piece: &Piece, corner: usize) -> f64 {
        let at = |step: usize| self.positions[piece.vertices[(corner + step) % 3] as usize];
        let (u, v) = (at(1) - at(0), at(2) - at(0));
        u.dot(v) / u.cross(v).length()
    }

    /// Halves a piece and tells the one across the part that is now another's; its number.
    fn halve(&mut self, piece: u32, side: usize, middle: u32) -> u32 {
        let behind = self.pieces.len() as u32;
        let second = self.pieces[piece as usize].halve(side, middle, piece, behind);
        self.tell(second.across[1], second.ends(1), behind);
        self.pieces.push(second);
        behind
    }

    /// The side of a piece that leads from one vertex to another.
    fn side_from(&self, piece: u32, from: u32, to: u32) -> usize {
        let piece = &self.pieces[piece as usize];
        let sides = (0..3).find(|&side| piece.ends(side) == [from, to]);
        sides.expect("pieces across a side have it both")
    }

    fn finish(self) -> Refinement {
        let triangles: Vec<[u32; 3]> = self.pieces.iter().map(|piece| piece.vertices).collect();
        let mesh = TriangleMesh::new(self.positions.len(), &triangles)
            .expect("halving both sides of edges keeps a mesh sound");
        let mut edge_parents = PerEdge::filled(mesh.edge_count(), None);
        for (face, piece) in mesh.faces().zip(&self.pieces) {
            for (side, edge) in face.halfedges().into_iter().zip(piece.edges) {
                edge_parents[mesh.edge(side)] = edge;
            }
        }
        let mut vertex_origin = PerVertex::filled(
            mesh.vertex_count(),
            SurfacePoint {
                face: FaceId(0),
                barycentric: [0.0; 3],
            },
        );
        for piece in &self.pieces {
            for (vertex, barycentric) in piece.vertices.into_iter().zip(piece.corners) {
                let face = piece.parent;
                vertex_origin[VertexId(vertex)] = SurfacePoint { face, barycentric };
            }
        }
        let refined = RefinedSurface {
            surface: Surface::new(mesh, PerVertex::new(self.positions))
                .expect("midpoints are as finite as the ends"),
            face_origin: PerFace::new(self.pieces.iter().map(|piece| piece.parent).collect()),
            vertex_origin,
        };
        Refinement {
            refined,
            edge_parents,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Element, HalfedgeId, Topology};

    fn refined(fixture: graticule_fixtures::Fixture, longest: f64) -> (Surface, Refinement) {
        let surface = Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap();
        let refinement = refine(&surface, longest, &Watch::new()).unwrap();
        (surface, refinement)
    }

    fn lengths(surface: &Surface) -> Vec<f64> {
        let mesh = surface.mesh();
        let vector = |edge| surface.halfedge_vector(mesh.edge_halfedge(edge));
        mesh.edges().map(|edge| vector(edge).length()).collect()
    }

    #[test]
    fn no_edge_is_too_long_and_the_surface_is_the_same() {
        for fixture in [
            graticule_fixtures::cube(),
            graticule_fixtures::needles(4, 1e3, 1),
            graticule_fixtures::annulus(0.2, 1.0, 9, 2),
        ] {
            let (surface, finer) = refined(fixture, 0.1);
            assert!(
                lengths(&finer.refined.surface)
                    .iter()
                    .all(|&length| length <= 0.1)
            );
            let area = |surface: &Surface| -> f64 {
                let of_face = |face| {
                    let [a, b, c] = surface.corner_positions(face);
                    0.5 * (b - a).cross(c - a).length()
                };
                surface.mesh().faces().map(of_face).sum()
            };
            let ratio = area(&finer.refined.surface) / area(&surface);
            assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
            let topology = |surface: &Surface| {
                let total = Topology::of(surface.mesh()).total;
                (total.euler_characteristic, total.boundary_loops)
            };
            assert_eq!(topology(&finer.refined.surface), topology(&surface));
        }
    }

    #[test]
    fn points_go_back_to_where_they_are() {
        let (surface, finer) = refined(graticule_fixtures::torus(2.0, 0.7, 9, 5), 0.3);
        for halfedge in finer.refined.surface.mesh().halfedges() {
            let point = SurfacePoint::on_halfedge(halfedge, 0.3);
            let back = finer.refined.to_original(surface.mesh(), point).unwrap();
            let distance = back
                .position(&surface)
                .distance(point.position(&finer.refined.surface));
            assert!(distance < 1e-14, "{distance}");
        }
        for face in surface.mesh().faces() {
            assert_eq!(finer.refined.face_origin[face], face);
        }
    }

    #[test]
    fn parts_of_an_edge_add_up_to_it() {
        let (surface, finer) = refined(graticule_fixtures::bumpy_patch(5, 3), 0.02);
        let fine = lengths(&finer.refined.surface);
        for (edge, length) in surface.mesh().edges().zip(lengths(&surface)) {
            let parts = finer.edges_of(&[edge]);
            let sum: f64 = parts.iter().map(|part| fine[part.index()]).sum();
            assert!((sum / length - 1.0).abs() < 1e-12, "{sum} of {length}");
        }
    }

    #[test]
    fn a_fine_surface_is_left_as_it_is() {
        let (surface, finer) = refined(graticule_fixtures::icosphere(2), 1.0);
        assert_eq!(finer.refined.surface, surface);
        let point = SurfacePoint::at_corner(HalfedgeId(7));
        assert_eq!(
            finer.refined.to_original(surface.mesh(), point),
            Some(point)
        );
    }

    #[test]
    fn the_count_is_foretold_within_a_factor_of_three() {
        for fixture in [
            graticule_fixtures::cube(),
            graticule_fixtures::icosphere(3),
            graticule_fixtures::cylinder_patch(1.0, 40.0, 60, 1),
        ] {
            let (surface, finer) = refined(fixture, 0.07);
            let ratio = refined_count(&surface, 0.07) / finer.refined.face_origin.len() as f64;
            assert!((1.0 / 3.0..3.0).contains(&ratio), "{ratio}");
        }
    }
}
