use crate::mesh::{EdgeId, HalfedgeId};
use crate::tolerance::{FLIP_SHARE, FLIP_SINE};

use super::IntrinsicTriangulation;
use super::intrinsic::wrapped;
use super::triangle::TriangleShape;

/// Two triangles on either side of an edge from `i` to `j`: `left` has the corners `i, j, k`,
/// `right` has `j, i, l`.
pub(super) struct Diamond {
    left: TriangleShape,
    right: TriangleShape,
}

impl Diamond {
    /// The triangles at an interior edge, `None` on the boundary.
    pub(super) fn around(triangulation: &IntrinsicTriangulation, edge: EdgeId) -> Option<Self> {
        let halfedge = triangulation.edge_halfedge(edge);
        let twin = triangulation.twin(halfedge)?;
        let seen_from =
            |side: HalfedgeId| triangulation.shape(side.face()).starting_at(side.side());
        Some(Self::between(seen_from(halfedge), seen_from(twin)))
    }

    /// Two triangles whose common edge is side 0 of each.
    pub(super) fn between(left: TriangleShape, right: TriangleShape) -> Self {
        Self { left, right }
    }

    /// Whether the angles at `k` and `l` sum to more than π by more than rounding explains.
    ///
    /// Up to the positive factor `|ki| |kj| |li| |lj|` the sum of the cotangents at `k` and `l` is
    /// the sine of the sum of the angles; no quotient by an area is formed, so that triangles
    /// without area are told apart too.
    pub(super) fn is_negative(&self) -> bool {
        let (left, right) = (&self.left, &self.right);
        let sine_left = left.double_area() * right.dot(2);
        let sine_right = right.double_area() * left.dot(2);
        let [sides_left, sides_right] = [left, right].map(|s| s.length(1) * s.length(2));
        let spread = left.double_area() * sides_right + right.double_area() * sides_left;
        let rounding = (FLIP_SINE * sides_left * sides_right).max(FLIP_SHARE * spread);
        sine_left + sine_right < -rounding
    }

    /// The triangles `l, k, i` and `k, l, j` after the flip; `None` unless both have an area.
    ///
    /// Everything is computed in the plane with the origin in `i` and `j` on the x axis, from the
    /// products that the triangles hold: a rounding error is a few ε times the two sides that are
    /// multiplied, as if the products were taken from exact coordinates.
    fn flipped(&self) -> Option<[TriangleShape; 2]> {
        let Self { left, right } = self;
        let base = left.length(0);
        let [from_i, from_j] = [[left.dot(0), right.dot(1)], [left.dot(1), right.dot(0)]];
        let height = [left.double_area(), right.double_area()];
        // k - l along the base, from the end where less cancels.
        let across = if reach(from_i) <= reach(from_j) {
            from_i[0] - from_i[1]
        } else {
            from_j[1] - from_j[0]
        } / base;
        let along = (height[0] + height[1]) / base;
        let diagonal = (across * across + along * along).sqrt();
        let corner = |from: [f64; 2], x_sign: f64| {
            let at_end =
                ((from[0] / base) * (from[1] / base)) - ((height[0] / base) * (height[1] / base));
            let shift = x_sign * across;
            let at_k = (from[0] * shift + height[0] * along) / base;
            let at_l = (height[1] * along - from[1] * shift) / base;
            let double_area =
                (height[0] / base) * (from[1] / base) + (height[1] / base) * (from[0] / base);
            (at_end, at_k, at_l, double_area)
        };
        let (at_i, k_by_i, l_by_i, area_i) = corner(from_i, 1.0);
        let (at_j, k_by_j, l_by_j, area_j) = corner(from_j, -1.0);
        let by_i = [diagonal, left.length(2), right.length(1)];
        let by_j = [diagonal, right.length(2), left.length(1)];
        let sound = area_i > 0.0 && area_j > 0.0 && diagonal.is_finite();
        sound.then(|| {
            [
                TriangleShape::from_parts(by_i, [l_by_i, k_by_i, at_i], area_i),
                TriangleShape::from_parts(by_j, [k_by_j, l_by_j, at_j], area_j),
            ]
        })
    }
}

fn reach([left, right]: [f64; 2]) -> f64 {
    left.abs().max(right.abs())
}

impl IntrinsicTriangulation {
    /// Replaces an edge by the other diagonal of its two triangles and tells whether it did: it
    /// does not on the boundary, if both sides of the edge are the same triangle, or if the new
    /// triangles would not both have an area.
    ///
    /// The edge keeps its number; of the halfedges, those of the two triangles are renumbered.
    pub fn flip(&mut self, edge: EdgeId) -> bool {
        let halfedge = self.edge_halfedge(edge);
        let Some(twin) = self.twin(halfedge) else {
            return false;
        };
        if halfedge.face() == twin.face() {
            return false;
        }
        let Some([by_i, by_j]) = Diamond::around(self, edge).and_then(|diamond| diamond.flipped())
        else {
            return false;
        };
        let moved = self.table.rotate_diamond(halfedge, twin);
        let directions = moved.map(|(from, to)| (to, self.directions[from]));
        for (side, direction) in directions {
            self.directions[side] = direction;
        }
        self.shapes[halfedge.face()] = by_i.starting_at((3 - halfedge.side()) % 3);
        self.shapes[twin.face()] = by_j.starting_at((3 - twin.side()) % 3);
        self.point_diagonal(twin, by_i.angle(1));
        self.point_diagonal(halfedge, by_j.angle(1));
        true
    }

    /// Sets the direction of a new diagonal from that of the side before it, clockwise, and the
    /// angle between them.
    fn point_diagonal(&mut self, diagonal: HalfedgeId, angle: f64) {
        let Some(opposite) = self.twin(diagonal) else {
            return;
        };
        let before = opposite.next();
        let scale = self.angle_scale(self.origin(diagonal));
        self.directions[diagonal] = wrapped(self.directions[before] + scale * angle);
    }
}
