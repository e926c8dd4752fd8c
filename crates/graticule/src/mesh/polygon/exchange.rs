use super::Outline;
use crate::mesh::HalfedgeId;
use crate::mesh::faces::TriangleFaces;
use crate::mesh::gluing::{EdgeUses, NONE, glue};
use crate::tolerance;

/// Exchanges diagonals for each triangle at most about this many times. Each exchange raises the
/// sorted list of qualities, so there is an end; this one comes sooner on bad cases.
const ROUNDS: usize = 16;

/// Exchanges the diagonals of a cut polygon while the worse triangle beside one gets better.
pub(super) fn improve(outline: &Outline, triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let twins = EdgeUses::of(&TriangleFaces(&triangles), outline.len()).twins();
    let mut budget = ROUNDS * triangles.len();
    let mut waiting: Vec<u32> = (0..twins.len() as u32).rev().collect();
    let mut diagonals = Diagonals { triangles, twins };
    while let Some(side) = waiting.pop() {
        if diagonals.gain(outline, side) <= tolerance::SHAPE_GAIN {
            continue;
        }
        if budget == 0 {
            break;
        }
        budget -= 1;
        waiting.extend(diagonals.exchange(side));
    }
    diagonals.triangles
}

struct Diagonals {
    triangles: Vec<[u32; 3]>,
    twins: Vec<u32>,
}

impl Diagonals {
    fn vertex(&self, corner: HalfedgeId) -> u32 {
        self.triangles[corner.face().0 as usize][corner.side()]
    }

    /// The corners of the quad around a diagonal: its ends, then what lies left and right of it.
    fn quad(&self, side: u32) -> Option<[u32; 4]> {
        let twin = self.twins[side as usize];
        let [side, other] = [HalfedgeId(side), HalfedgeId(twin)];
        (twin != NONE).then(|| {
            [side, side.next(), side.previous(), other.previous()].map(|corner| self.vertex(corner))
        })
    }

    fn gain(&self, outline: &Outline, side: u32) -> f64 {
        let Some([from, to, left, right]) = self.quad(side) else {
            return 0.0;
        };
        let worse = |one, other| outline.quality(one).min(outline.quality(other));
        worse([from, right, left], [right, to, left]) - worse([from, to, left], [to, from, right])
    }

    /// Replaces the diagonal by the other one; returns the four sides of the quad.
    fn exchange(&mut self, side: u32) -> [u32; 4] {
        let Some([from, to, left, right]) = self.quad(side) else {
            return [side; 4];
        };
        let [first, second] = [HalfedgeId(side), HalfedgeId(self.twins[side as usize])];
        let outer = [
            first.next(),
            first.previous(),
            second.next(),
            second.previous(),
        ]
        .map(|corner| self.twins[corner.0 as usize]);
        let [one, other] = [first.face(), second.face()];
        self.triangles[one.0 as usize] = [from, right, left];
        self.triangles[other.0 as usize] = [right, to, left];
        let [one, other] = [one.halfedges(), other.halfedges()].map(|sides| sides.map(|h| h.0));
        let quad = [other[1], one[2], one[0], other[0]];
        for (side, twin) in quad.into_iter().zip(outer) {
            self.twins[side as usize] = twin;
            if twin != NONE {
                self.twins[twin as usize] = side;
            }
        }
        glue(&mut self.twins, one[1], other[2]);
        quad
    }
}
