//! Fins: small pieces that hang on a larger one by an edge with more than two faces, or by a vertex.

use super::draft::Draft;
use super::{Fins, RepairChanges};
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::gluing::{NONE, Patches};
use crate::tolerance::MOST_FINS;

/// Drops fins as small as the option says; returns whether any was dropped.
///
/// Where all fins together are more than [`MOST_FINS`] of the surface, as the leaves of a tree, they
/// are what it is made of, and stay.
pub(super) fn drop_fins(draft: &mut Draft, fins: Fins, changes: &mut RepairChanges) -> bool {
    let (area, share) = match fins {
        Fins::Keep => return false,
        Fins::DropBelowArea(area) => (area, 0.0),
        Fins::DropBelowShare(share) => (0.0, share),
    };
    let patches = Patches::of(&draft.faces(), &draft.twins());
    let mut areas = vec![0.0; patches.count];
    for (triangle, &patch) in draft.triangles.iter().zip(&patches.patch_of_face) {
        let [a, b, c] = triangle.map(|vertex| draft.positions[vertex as usize]);
        areas[patch as usize] += 0.5 * (b - a).cross(c - a).length();
    }
    let total: f64 = areas.iter().sum();
    // Not their sum: a total that overflows must not reach a limit that is an area.
    let least = if share > 0.0 { share * total } else { area };
    let is_fin = hanging(draft, &patches, |patch| areas[patch] < least);
    let of_fins = areas.iter().zip(&is_fin).filter(|(_, is_fin)| **is_fin);
    let lost: f64 = of_fins.map(|(area, _)| area).sum();
    if !is_fin.contains(&true) || lost > MOST_FINS * total {
        return false;
    }
    let keep: Vec<bool> = (patches.patch_of_face.iter())
        .map(|&patch| !is_fin[patch as usize])
        .collect();
    for (&polygon, _) in draft.polygons.iter().zip(&keep).filter(|(_, keep)| !**keep) {
        changes.fins_dropped.push(polygon);
    }
    draft.retain(&keep);
    true
}

/// The small patches that vertices of the soup join, over others of them or at once, to one that is
/// not small.
fn hanging(draft: &Draft, patches: &Patches, is_small: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut groups = DisjointSets::new(patches.count);
    let last_source = draft.vertex_sources.iter().max();
    let mut first_at = vec![NONE; last_source.map_or(0, |&source| source as usize + 1)];
    for (triangle, &patch) in draft.triangles.iter().zip(&patches.patch_of_face) {
        for &vertex in triangle {
            let source = draft.vertex_sources[vertex as usize] as usize;
            if first_at[source] == NONE {
                first_at[source] = patch;
            }
            groups.join(first_at[source], patch);
        }
    }
    let groups = groups.into_names();
    let mut holds = vec![false; patches.count];
    for (patch, &group) in groups.iter().enumerate() {
        holds[group as usize] |= !is_small(patch);
    }
    let hangs = |(patch, &group): (usize, &u32)| is_small(patch) && holds[group as usize];
    groups.iter().enumerate().map(hangs).collect()
}
