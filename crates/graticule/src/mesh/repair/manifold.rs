use std::collections::VecDeque;
use std::f64::consts::PI;

use glam::DVec3;

use super::RepairChanges;
use super::draft::Draft;
use crate::mesh::faces::Faces;
use crate::mesh::gluing::{EdgeUses, NONE, Patches, edge_components, fans, glue, number_fans};
use crate::mesh::measures::{component_bounds, component_volumes, length};
use crate::watch::{Stopped, Watch};

/// Splits vertices and edges so that at most two triangles share an edge and each vertex has one
/// fan; drops unused vertices. Returns the other side on the edge of each, or [`NONE`].
pub(super) fn make_manifold(
    draft: &mut Draft,
    changes: &mut RepairChanges,
    watch: &Watch,
) -> Result<Vec<u32>, Stopped> {
    let uses = EdgeUses::of(&draft.faces(), draft.positions.len());
    let mut twins = uses.twins();
    let crowded: Vec<_> = uses.iter().filter(|group| group.len() > 2).collect();
    if !crowded.is_empty() {
        pair_at_crowded_edges(draft, &uses, &crowded, &mut twins, watch)?;
        let edges = crowded.iter().map(|group| draft.source_edge(group[0]));
        changes.edges_split.extend(edges);
    }
    let vertices = number_fans(
        &draft.faces(),
        &fans(&draft.faces(), &twins),
        draft.positions.len(),
    );
    draft.renumber(&vertices);
    Ok(twins)
}

/// Chooses which sides hold together at edges with more than two.
///
/// In a component that encloses a solid, faces that enclose it between them do; in others those
/// that go on flattest, so that a sheet stays whole where another one meets it. Then no two edges
/// may end up with the same ends: where they would, all sides at the edge are let go. A fan cut
/// there ends in at most two of them, so that vertices of their own tell all edges apart.
fn pair_at_crowded_edges(
    draft: &Draft,
    uses: &EdgeUses,
    crowded: &[&[u32]],
    twins: &mut [u32],
    watch: &Watch,
) -> Result<(), Stopped> {
    let solids = Solids::of(draft, uses, twins);
    for group in crowded {
        let sides = solids.sides_around_edge(draft, group);
        let pairs = if solids.encloses(group[0]) || group.len() > FLATTEST_OF {
            pair_around_solids(&sides)
        } else {
            pair_flattest(&sides)
        };
        for [side, twin] in pairs {
            glue(twins, side, twin);
        }
    }
    let mut let_go = vec![false; crowded.len()];
    loop {
        watch.check()?;
        let fans = fans(&draft.faces(), twins);
        let mut changed = false;
        for (group, let_go) in crowded.iter().zip(&mut let_go) {
            if !*let_go && has_clash(draft, &fans, group, twins) {
                for &side in *group {
                    twins[side as usize] = NONE;
                }
                *let_go = true;
                changed = true;
            }
        }
        if !changed {
            glue_what_coincides(draft, &fans, crowded, twins);
            return Ok(());
        }
    }
}

/// Sides on one edge up to which the flattest pairs are sought among all.
const FLATTEST_OF: usize = 64;

/// On which side of its faces each component is solid.
struct Solids {
    /// Whether the solid begins at a side when one turns around its edge counter-clockwise, the
    /// edge pointing at one from its smaller to its larger vertex. For this each patch is oriented
    /// like most of its faces, and each component turned round if its volume is negative.
    opening: Vec<bool>,
    face_components: Vec<u32>,
    /// Whether every edge of a component has an even number of faces.
    is_closed: Vec<bool>,
}

impl Solids {
    fn of(draft: &Draft, uses: &EdgeUses, twins: &[u32]) -> Self {
        let faces = draft.faces();
        let reversed = Patches::of(&faces, twins).reversed;
        let (face_components, count) = edge_components(&faces, uses);
        let component = |side: u32| face_components[faces.face(side) as usize] as usize;
        let bounds = component_bounds(&faces, &draft.positions, &face_components, count);
        let volumes = component_volumes(
            &faces,
            &draft.positions,
            &face_components,
            &bounds,
            &reversed,
        );
        let opening = (0..faces.corner_count() as u32)
            .map(|side| {
                let backward = faces.origin(side) != faces.edge(side)[0];
                backward ^ reversed[faces.face(side) as usize] ^ (volumes[component(side)] < 0.0)
            })
            .collect();
        let mut is_closed = vec![true; count];
        for group in uses.iter() {
            is_closed[component(group[0])] &= group.len() % 2 == 0;
        }
        Self {
            opening,
            face_components,
            is_closed,
        }
    }

    fn encloses(&self, side: u32) -> bool {
        self.is_closed[self.face_components[side as usize / 3] as usize]
    }

    /// The sides in the order of their faces around the edge. Of faces that coincide, those that
    /// close a solid come before those that open the next.
    fn sides_around_edge(&self, draft: &Draft, group: &[u32]) -> Vec<AngledSide> {
        let angles = angles_around_edge(draft, group).into_iter();
        let mut sides: Vec<_> = angles
            .zip(group)
            .map(|(angle, &side)| AngledSide {
                angle,
                opens: self.opening[side as usize],
                side,
            })
            .collect();
        sides.sort_by(|a, b| {
            let by_angle = a.angle.total_cmp(&b.angle);
            by_angle.then((a.opens, a.side).cmp(&(b.opens, b.side)))
        });
        sides
    }
}

/// A side on a crowded edge.
#[derive(Clone, Copy, Debug)]
struct AngledSide {
    /// Of its face around the edge, in radians.
    angle: f64,
    opens: bool,
    side: u32,
}

/// Matches each opening side with the closing one that ends the same solid, like brackets around a
/// circle.
fn pair_around_solids(sides: &[AngledSide]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    let mut open = Vec::new();
    let mut unmatched = VecDeque::new();
    for &AngledSide { opens, side, .. } in sides {
        if opens {
            open.push(side);
        } else if let Some(partner) = open.pop() {
            pairs.push([partner, side]);
        } else {
            unmatched.push_back(side);
        }
    }
    while let (Some(partner), Some(side)) = (open.pop(), unmatched.pop_front()) {
        pairs.push([partner, side]);
    }
    pairs
}

/// Matches opening with closing sides, the pair that makes the flattest edge first.
fn pair_flattest(sides: &[AngledSide]) -> Vec<[u32; 2]> {
    let (open, close): (Vec<AngledSide>, Vec<_>) = sides.iter().partition(|side| side.opens);
    let mut candidates = Vec::new();
    for from in &open {
        for to in &close {
            let fold = ((from.angle - to.angle).abs() - PI).abs();
            candidates.push((fold, from.side, to.side));
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut taken = Vec::new();
    for (_, from, to) in candidates {
        if !taken
            .as_flattened()
            .iter()
            .any(|&side| side == from || side == to)
        {
            taken.push([from, to]);
        }
    }
    taken
}

/// The angle of each face around the edge from its smaller to its larger vertex.
fn angles_around_edge(draft: &Draft, group: &[u32]) -> Vec<f64> {
    let faces = draft.faces();
    let position = |vertex: u32| draft.positions[vertex as usize];
    let [start, end] = faces.edge(group[0]).map(position);
    let unit = |vector: DVec3| {
        let size = length(vector);
        if size > 0.0 { vector / size } else { vector }
    };
    let axis = unit(end - start);
    let across = |side: &u32| {
        let opposite = position(faces.origin(faces.next(faces.next(*side))));
        let arm = unit(opposite - start);
        unit(arm - axis * arm.dot(axis))
    };
    let first = across(&group[0]);
    let left = axis.cross(first);
    group
        .iter()
        .map(across)
        .map(|arm| libm::atan2(arm.dot(left), arm.dot(first)))
        .collect()
}

/// The fans at both ends of a side, the smaller vertex's first.
fn end_fans(draft: &Draft, fans: &[u32], side: u32) -> [u32; 2] {
    let faces = draft.faces();
    let [at_origin, at_destination] = [side, faces.next(side)].map(|c| fans[c as usize]);
    if faces.origin(side) == faces.edge(side)[0] {
        [at_origin, at_destination]
    } else {
        [at_destination, at_origin]
    }
}

/// The sides grouped by the edge they come to lie on.
fn by_new_edge(draft: &Draft, fans: &[u32], group: &[u32]) -> Vec<([u32; 2], u32)> {
    let mut sides: Vec<_> = group
        .iter()
        .map(|&side| (end_fans(draft, fans, side), side))
        .collect();
    sides.sort_unstable();
    sides
}

fn has_clash(draft: &Draft, fans: &[u32], group: &[u32], twins: &[u32]) -> bool {
    by_new_edge(draft, fans, group)
        .chunk_by(|a, b| a.0 == b.0)
        .any(|edge| match *edge {
            [_] => false,
            [(_, side), (_, twin)] => {
                twins[side as usize] != twin && [side, twin].map(|s| twins[s as usize]) != [NONE; 2]
            }
            _ => true,
        })
}

/// Two loose sides with the same new ends lie on one edge, like it or not.
fn glue_what_coincides(draft: &Draft, fans: &[u32], crowded: &[&[u32]], twins: &mut [u32]) {
    for group in crowded {
        for edge in by_new_edge(draft, fans, group).chunk_by(|a, b| a.0 == b.0) {
            if let [(_, side), (_, twin)] = *edge {
                glue(twins, side, twin);
            }
        }
    }
}
