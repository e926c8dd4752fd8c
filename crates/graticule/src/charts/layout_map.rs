use glam::DVec2;

use super::layout_corners::orientation;
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, TriangleMesh, VertexId};
use crate::periodic::{GridMap, GridMapError, Transition};
use crate::tolerance::{LEAST_SNAPPED_AREA, NODE_GAP, SNAPPED_CHART, SNAPPED_SHARE, SPREAD_SHARE};

/// The map as charts are read off it: triangles that it turns over or flattens are left out, as
/// singular ones ([PGP06] §3.2), and lines that pass close by a vertex pass through it.
///
/// # Errors
/// None for a sound map; those of [`GridMap::new`] else.
///
/// [PGP06]: crate::papers::PGP06
pub(super) fn map_for_charts(mesh: &TriangleMesh, map: &GridMap) -> Result<GridMap, GridMapError> {
    let left_out = PerFace::from_fn(mesh.face_count(), |face| {
        map.is_left_out(face) || orientation(map.face_coordinates(face)) <= 0.0
    });
    let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
        let other = mesh.twin(halfedge).map(HalfedgeId::face);
        let both = other.is_some_and(|other| !left_out[other]) && !left_out[halfedge.face()];
        map.transition(halfedge).filter(|_| both)
    });
    let mut snapping = Snapping {
        mesh,
        coordinates: map.coordinates().clone(),
        transitions: &transitions,
        left_out: &left_out,
    };
    for vertex in mesh.vertices() {
        snapping.snap(vertex);
    }
    let coordinates = snapping.coordinates;
    GridMap::new(mesh, coordinates, transitions, left_out)
}

/// Moves vertices onto lines that pass close by.
struct Snapping<'a> {
    mesh: &'a TriangleMesh,
    coordinates: PerCorner<DVec2>,
    transitions: &'a PerCorner<Option<Transition>>,
    left_out: &'a PerFace<bool>,
}

impl Snapping<'_> {
    /// Snaps a vertex in each unbroken part of the fan of triangles around it.
    fn snap(&mut self, vertex: VertexId) {
        let mut fan: Vec<HalfedgeId> = self.mesh.outgoing(vertex).collect();
        let step_after = |corner: &HalfedgeId| self.transitions[corner.previous()];
        if let Some(last) = fan.iter().rposition(|corner| step_after(corner).is_none()) {
            fan.rotate_left(last);
            fan.rotate_left(1);
        } else {
            let round = fan.iter().filter_map(step_after);
            if !round
                .fold(Transition::identity(), Transition::then)
                .is_identity()
            {
                return;
            }
        }
        let broken =
            |corner: &HalfedgeId, _: &HalfedgeId| self.transitions[corner.previous()].is_some();
        let parts: Vec<Vec<HalfedgeId>> = fan.chunk_by(broken).map(<[_]>::to_vec).collect();
        for part in parts {
            if !self.left_out[part[0].face()] {
                for axis in 0..2 {
                    self.snap_part(&part, axis);
                }
            }
        }
    }

    /// Puts one coordinate of a vertex on the nearest line, if that is near and neither turns a triangle
    /// over nor squeezes one.
    fn snap_part(&mut self, part: &[HalfedgeId], axis: usize) {
        let point = self.coordinates[part[0]];
        let distance = (point[axis].round() - point[axis]).abs();
        let reach = (SNAPPED_SHARE * self.reach(part, axis)).min(SNAPPED_CHART);
        if distance == 0.0 || distance > reach {
            return;
        }
        let before: Vec<DVec2> = part
            .iter()
            .map(|&corner| self.coordinates[corner])
            .collect();
        let areas: Vec<f64> = part.iter().map(|corner| self.area(corner.face())).collect();
        let mut moved = point;
        moved[axis] = point[axis].round();
        for &corner in part {
            self.coordinates[corner] = moved;
            let step = self.transitions[corner.previous()];
            moved = step.map_or(moved, |step| step.apply(moved));
        }
        let mut faces = part.iter().map(|corner| corner.face()).zip(areas);
        if !faces.all(|(face, before)| self.area(face) > LEAST_SNAPPED_AREA * before) {
            for (&corner, point) in part.iter().zip(before) {
                self.coordinates[corner] = point;
            }
        }
    }

    /// Twice the area of a triangle in the map, with the exact sign.
    fn area(&self, face: FaceId) -> f64 {
        orientation(face.halfedges().map(|corner| self.coordinates[corner]))
    }

    /// How far the triangles of a part reach from the vertex along a coordinate of the first one.
    fn reach(&self, part: &[HalfedgeId], axis: usize) -> f64 {
        let mut axis = axis;
        let mut reach = 0.0_f64;
        for &corner in part {
            let apex = self.coordinates[corner];
            for end in [corner.next(), corner.previous()] {
                reach = reach.max((self.coordinates[end] - apex)[axis].abs());
            }
            let turns = self.transitions[corner.previous()].map_or(0, |step| step.turn.quarters());
            axis = (axis + usize::from(turns)) % 2;
        }
        reach
    }
}

/// The number of triangles left out.
pub(super) fn left_out_count(map: &GridMap) -> usize {
    map.left_out().iter().filter(|&&left_out| left_out).count()
}

/// The share of the way along each edge at which its nodes lie, at least a small part of the edge
/// apart from each other and from its ends.
///
/// Nodes that are too near to each other move apart in both directions, each as little as it can (least
/// squares: pools of neighbours about their means): where two lines cross beside the edge, both make
/// room for the crossing.
pub(super) fn spread_shares(shares: &mut [f64]) {
    let count = shares.len();
    let gap = (NODE_GAP / (count + 1) as f64).min(SPREAD_SHARE);
    let mut pools: Vec<(f64, u32)> = Vec::new();
    for (index, &share) in shares.iter().enumerate() {
        let mut pool = (share - index as f64 * gap, 1);
        while let Some(&(sum, count)) = pools.last()
            && sum * f64::from(pool.1) > pool.0 * f64::from(count)
        {
            pools.pop();
            pool = (pool.0 + sum, pool.1 + count);
        }
        pools.push(pool);
    }
    let mut index = 0;
    for (sum, count) in pools {
        for _ in 0..count {
            if count > 1 {
                shares[index] = sum / f64::from(count) + index as f64 * gap;
            }
            index += 1;
        }
    }
    let mut least = gap;
    for share in shares.iter_mut() {
        *share = share.max(least);
        least = *share + gap;
    }
    let mut most = 1.0 - gap;
    for share in shares.iter_mut().rev() {
        *share = share.min(most);
        most = *share - gap;
    }
}

/// A point of a triangle by the coordinates of its corners.
pub(super) fn face_corners(map: &GridMap, face: FaceId) -> Option<[DVec2; 3]> {
    (!map.is_left_out(face)).then(|| map.face_coordinates(face))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Element;
    use graticule_fixtures::grid;

    #[test]
    fn shares_keep_their_order_and_their_distance() {
        let mut shares = [0.0, 1e-12, 1e-12, 0.5, 0.5, 1.0];
        spread_shares(&mut shares);
        let bounds: Vec<f64> = [0.0].into_iter().chain(shares).chain([1.0]).collect();
        assert!(
            bounds
                .windows(2)
                .all(|pair| pair[1] - pair[0] > 0.9 * SPREAD_SHARE),
            "{shares:?}"
        );
        let mut pair = [0.5, 0.5];
        spread_shares(&mut pair);
        assert!(
            (pair[0] + pair[1] - 1.0).abs() < 1e-12 && pair[0] < 0.5,
            "{pair:?}"
        );
        let mut apart = [0.2, 0.6];
        spread_shares(&mut apart);
        assert_eq!(apart.map(f64::to_bits), [0.2, 0.6].map(f64::to_bits));
    }

    #[test]
    fn vertices_close_to_lines_come_to_lie_on_them() {
        let fixture = grid(4.0, 4.0, 40, 40);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let offset = DVec2::new(1e-5, 0.03);
        let place = |corner| fixture.positions[mesh.origin(corner).index()].truncate() + offset;
        let coordinates = PerCorner::from_fn(mesh.halfedge_count(), place);
        let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            mesh.twin(halfedge).map(|_| Transition::identity())
        });
        let left_out = PerFace::filled(mesh.face_count(), false);
        let map = GridMap::new(&mesh, coordinates, transitions, left_out).unwrap();
        let snapped = map_for_charts(&mesh, &map).unwrap();
        for corner in mesh.halfedges() {
            let [before, after] = [&map, &snapped].map(|map| map.coordinate(corner));
            assert_eq!(after.y.to_bits(), before.y.to_bits());
            let near = (before.x - before.x.round()).abs() < 2e-5;
            assert_eq!(near, after.x.fract().abs() < 1e-12, "{before}");
        }
    }
}
