use super::draft::Draft;
use super::nesting::outermost_containers;
use super::{NonOrientable, RepairChanges, RepairError, RepairOptions};
use crate::mesh::gluing::{NONE, Patches, fans, number_fans};
use crate::mesh::measures::{component_bounds, component_volumes};
use crate::tolerance;

/// Orients each component of a manifold draft; closed ones outward.
pub(super) fn orient(
    draft: &mut Draft,
    mut twins: Vec<u32>,
    options: RepairOptions,
    changes: &mut RepairChanges,
) -> Result<(), RepairError> {
    let mut patches = Patches::of(&draft.faces(), &twins);
    if let Some(&side) = patches.conflicts.first() {
        if options.non_orientable == NonOrientable::Refuse {
            return Err(RepairError::NonOrientable {
                polygon: draft.polygons[side as usize / 3],
                edge: draft.source_edge(side),
            });
        }
        cut_open(draft, &patches.conflicts, &mut twins, changes);
    }
    let turned = patches.reversed.iter().zip(&draft.polygons);
    let turned = turned
        .filter(|(reversed, _)| **reversed)
        .map(|(_, &polygon)| polygon);
    let mut polygons: Vec<_> = turned.collect();
    polygons.dedup();
    changes.polygons_turned = polygons.into();
    turn_outward(draft, &twins, &mut patches, changes);
    for (triangle, _) in patches
        .reversed
        .iter()
        .enumerate()
        .filter(|(_, reversed)| **reversed)
    {
        draft.triangles[triangle].swap(1, 2);
        draft.corner_sources[triangle].swap(1, 2);
    }
    Ok(())
}

/// Lets go where orientations clash. Around a vertex inside the surface the clashes are even in
/// number, so that no cut ends there.
fn cut_open(draft: &mut Draft, conflicts: &[u32], twins: &mut [u32], changes: &mut RepairChanges) {
    for &side in conflicts {
        changes.edges_cut.push(draft.source_edge(side));
        let twin = std::mem::replace(&mut twins[side as usize], NONE);
        twins[twin as usize] = NONE;
    }
    let fans = fans(&draft.faces(), twins);
    let vertices = number_fans(&draft.faces(), &fans, draft.positions.len());
    draft.renumber(&vertices);
}

/// Turns closed components outward, those inside others as the outermost one around them.
fn turn_outward(draft: &Draft, twins: &[u32], patches: &mut Patches, changes: &mut RepairChanges) {
    let faces = draft.faces();
    let components = &patches.patch_of_face;
    let bounds = component_bounds(&faces, &draft.positions, components, patches.count);
    let mut volumes = component_volumes(
        &faces,
        &draft.positions,
        components,
        &bounds,
        &patches.reversed,
    );
    for (side, &twin) in twins.iter().enumerate() {
        if twin == NONE {
            volumes[components[side / 3] as usize] = 0.0;
        }
    }
    if volumes
        .iter()
        .all(|&volume| volume >= -tolerance::FLAT_VOLUME)
    {
        return;
    }
    let is_closed: Vec<_> = volumes
        .iter()
        .map(|volume| volume.abs() > tolerance::FLAT_VOLUME)
        .collect();
    let containers = outermost_containers(draft, components, &is_closed, &bounds);
    let is_inward = |component: usize| volumes[component] < -tolerance::FLAT_VOLUME;
    let is_turned = |component: usize| match containers[component] {
        NONE => is_inward(component),
        container => is_closed[component] && is_inward(container as usize),
    };
    let mut is_new = vec![true; patches.count];
    for (face, &component) in components.iter().enumerate() {
        let component = component as usize;
        let turned = is_turned(component);
        patches.reversed[face] ^= turned;
        if std::mem::replace(&mut is_new[component], false) {
            if turned {
                changes.components_turned.push(draft.polygons[face]);
            }
            if turned != is_inward(component) {
                changes.cavities.push(draft.polygons[face]);
            }
        }
    }
}
