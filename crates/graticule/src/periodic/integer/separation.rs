//! Which whole places must not be rounded together, or past each other.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;

use super::cut::Jump;
use super::energy::SideEnergy;
use super::form::Form;
use super::unknowns::{Slot, Unknowns, turned};
use crate::mesh::{HalfedgeId, PerVertex, TriangleMesh, VertexId};

/// Two places, of singular vertices or on lines, that are neighbours on the surface: how far the
/// second is from the first in the net.
#[derive(Clone, Debug)]
pub(super) struct Separation {
    /// The difference of their coordinates, where it is whole.
    pub(super) difference: [Option<Form>; 2],
    /// The difference wished for, at a density of one line per unit of length.
    pub(super) wish: DVec2,
}

impl Separation {
    /// The part of the wish that whole numbers decide on.
    pub(super) fn decided(&self) -> DVec2 {
        let part = |c: usize| {
            if self.difference[c].is_some() {
                self.wish[c]
            } else {
                0.0
            }
        };
        DVec2::new(part(0), part(1))
    }
}

/// The pairs of places whose regions on the surface, those of the points nearest to them, meet.
/// A region that meets itself round a thin part gives a place and its own image.
///
/// Of pairs with the same whole difference the one wished to be closest stands for all. A place on
/// a line counts only against what lies across it.
///
/// Cost: that of shortest paths along edges.
pub(super) fn separations(
    mesh: &TriangleMesh,
    unknowns: &Unknowns,
    energy: &SideEnergy,
) -> Vec<Separation> {
    let regions = Regions::grow(mesh, unknowns, energy);
    let mut closest = BTreeMap::<Vec<Vec<(u32, i64)>>, Separation>::new();
    for edge in mesh.edges() {
        let halfedge = mesh.edge_halfedge(edge);
        let Some(found) = regions.across(mesh, unknowns, energy, halfedge) else {
            continue;
        };
        let key = |form: &Option<Form>| form.as_ref().map_or(Vec::new(), |f| f.terms().to_vec());
        let key = found.difference.iter().map(key).collect();
        let entry = closest.entry(key).or_insert_with(|| found.clone());
        if found.decided().length() < entry.decided().length() {
            *entry = found;
        }
    }
    closest.into_values().collect()
}

/// Where a vertex was reached from.
#[derive(Clone, Debug)]
struct Reached {
    source: VertexId,
    distance: f64,
    /// From the coordinates of the source to those of the vertex.
    jump: Jump,
    /// The vertex as seen from the source, as wished, in coordinates of the vertex.
    wish: DVec2,
}

struct Regions {
    reached: PerVertex<Option<Reached>>,
}

impl Regions {
    fn grow(mesh: &TriangleMesh, unknowns: &Unknowns, energy: &SideEnergy) -> Self {
        let mut reached: PerVertex<Option<Reached>> = PerVertex::filled(mesh.vertex_count(), None);
        let mut heap = BinaryHeap::new();
        for vertex in mesh.vertices() {
            if unknowns.slots[vertex]
                .iter()
                .any(|slot| matches!(slot, Slot::Whole(_)))
            {
                reached[vertex] = Some(Reached {
                    source: vertex,
                    distance: 0.0,
                    jump: Jump::default(),
                    wish: DVec2::ZERO,
                });
                heap.push(Reverse((0_u64, vertex)));
            }
        }
        while let Some(Reverse((bits, vertex))) = heap.pop() {
            let Some(from) = reached[vertex].clone() else {
                continue;
            };
            // An entry of the heap that a shorter way has overtaken.
            if from.distance.to_bits() != bits {
                continue;
            }
            for corner in mesh.outgoing(vertex) {
                for other in [corner.next(), corner.previous()] {
                    let next = step(unknowns, energy, &from, [corner, other]);
                    let known = &mut reached[mesh.origin(other)];
                    if known
                        .as_ref()
                        .is_none_or(|known| next.distance < known.distance)
                    {
                        // Distances are not negative: their bits are in their order.
                        heap.push(Reverse((next.distance.to_bits(), mesh.origin(other))));
                        *known = Some(next);
                    }
                }
            }
        }
        Self { reached }
    }

    /// The separation of the places whose regions hold the two ends of an edge.
    fn across(
        &self,
        mesh: &TriangleMesh,
        unknowns: &Unknowns,
        energy: &SideEnergy,
        halfedge: HalfedgeId,
    ) -> Option<Separation> {
        let corners = [halfedge, halfedge.next()];
        let ends = corners.map(|corner| self.reached[mesh.origin(corner)].as_ref());
        let [from, to] = [ends[0]?, ends[1]?];
        let seen = |reached: &Reached, corner: HalfedgeId| {
            let jump = &unknowns.jumps[corner];
            (reached.jump.then(jump), jump.turn.apply(reached.wish))
        };
        let (from_jump, from_wish) = seen(from, corners[0]);
        let (to_jump, to_wish) = seen(to, corners[1]);
        let wish = from_wish + energy.wishes[halfedge] - to_wish;
        let difference = [0, 1].map(|coordinate| {
            let mut sum = place(unknowns, to.source, &to_jump, coordinate)?;
            sum.add(-1, &place(unknowns, from.source, &from_jump, coordinate)?);
            Some(sum)
        });
        is_decisive(&difference, wish).then_some(Separation { difference, wish })
    }
}

/// Goes on along a side of a triangle, from the first corner to the second.
fn step(
    unknowns: &Unknowns,
    energy: &SideEnergy,
    from: &Reached,
    [here, there]: [HalfedgeId; 2],
) -> Reached {
    let side = if here.next() == there {
        energy.wishes[here]
    } else {
        -energy.wishes[there]
    };
    let back = unknowns.jumps[there].inverse();
    let jump = from.jump.then(&unknowns.jumps[here]).then(&back);
    let wish = back
        .turn
        .apply(unknowns.jumps[here].turn.apply(from.wish) + side);
    Reached {
        source: from.source,
        distance: from.distance + side.length(),
        jump,
        wish,
    }
}

/// A coordinate of a vertex after a jump, where it is whole.
fn place(unknowns: &Unknowns, vertex: VertexId, jump: &Jump, coordinate: usize) -> Option<Form> {
    let (which, sign) = turned(jump.turn, coordinate);
    let Slot::Whole(sum) = unknowns.slots[vertex][which] else {
        return None;
    };
    let mut place = Unknowns::shift(jump, coordinate);
    place.add(sign, &unknowns.sums[sum as usize]);
    Some(place)
}

/// Whether the whole part of a difference says if two places lie apart: it is not always the same,
/// and the wish runs along it rather than across.
pub(super) fn is_decisive(difference: &[Option<Form>; 2], wish: DVec2) -> bool {
    let varies = |form: &Option<Form>| form.as_ref().is_some_and(|form| !form.is_zero());
    match difference {
        [Some(_), Some(_)] => difference.iter().any(varies),
        [Some(_), None] => varies(&difference[0]) && wish.x.abs() >= wish.y.abs(),
        [None, Some(_)] => varies(&difference[1]) && wish.y.abs() >= wish.x.abs(),
        [None, None] => false,
    }
}
