use std::ops::ControlFlow;

use glam::DVec3;

use super::Defects;
use crate::mesh::PolygonSoup;
use crate::mesh::coincidence::{first_at_same_position, first_over_same_vertices};
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::faces::{Faces, PolygonFaces};
use crate::mesh::gluing::{
    EdgeUses, NONE, Patches, boundary_loops, edge_components, fans, join_ends, same_direction,
};
use crate::mesh::measures::{Bounds, component_bounds, component_volumes, face_shape, length};
use crate::mesh::point_tree::PointTree;
use crate::mesh::seams::find_seams;
use crate::mesh::usable::UsablePolygons;
use crate::tolerance;

pub(super) fn find(soup: &PolygonSoup) -> Defects {
    let identity: Vec<u32> = (0..soup.positions.len() as u32).collect();
    let mut usable = UsablePolygons::of(soup, &identity);
    let mut defects = Defects {
        vertices: soup.positions.len(),
        polygons: soup.polygons.len(),
        ..Defects::default()
    };
    for polygon in soup.polygons.iter() {
        *defects.polygon_sizes.entry(polygon.len()).or_default() += 1;
    }
    find_vertex_defects(soup, &mut defects);
    set_duplicates_aside(&mut usable, &mut defects);
    find_shape_defects(soup, &usable, &mut defects);
    find_connection_defects(soup, &usable, &mut defects);
    defects.out_of_range = usable.out_of_range.into();
    defects.non_finite_polygons = usable.non_finite.into();
    defects.too_few_corners = usable.too_few_corners.into();
    defects.repeated_corners = usable.repeated.into();
    defects.collapsed = usable.collapsed.into();
    defects
}

fn find_vertex_defects(soup: &PolygonSoup, defects: &mut Defects) {
    let mut used = vec![false; soup.positions.len()];
    for &vertex in soup.polygons.corner_vertices() {
        if let Some(used) = used.get_mut(vertex as usize) {
            *used = true;
        }
    }
    for (vertex, position) in soup.positions.iter().enumerate() {
        let list = match (used[vertex], position.is_finite()) {
            (true, true) => continue,
            (true, false) => &mut defects.non_finite_vertices,
            (false, true) => &mut defects.isolated_vertices,
            (false, false) => {
                defects.isolated_vertices.push(vertex as u32);
                &mut defects.non_finite_unused_vertices
            }
        };
        list.push(vertex as u32);
    }
    let firsts = first_at_same_position(&soup.positions, &used);
    let numbered = firsts.iter().zip(0_u32..);
    defects.duplicate_vertices = numbered
        .filter(|&(&first, vertex)| first != vertex)
        .map(|(_, vertex)| vertex)
        .collect();
}

fn set_duplicates_aside(usable: &mut UsablePolygons, defects: &mut Defects) {
    let firsts = first_over_same_vertices(&usable.faces);
    if firsts.iter().all(|&first| first == NONE) {
        return;
    }
    let mut kept = PolygonFaces::with_capacity(firsts.len(), usable.faces.corner_count());
    let mut sources = Vec::with_capacity(firsts.len());
    for (face, &first) in firsts.iter().enumerate() {
        let polygon = usable.polygon_sources[face];
        if first == NONE {
            kept.push(usable.faces.vertices(face as u32).iter().copied());
            sources.push(polygon);
        } else {
            defects.duplicate_polygons.push(polygon);
        }
    }
    usable.faces = kept;
    usable.polygon_sources = sources;
}

fn find_shape_defects(soup: &PolygonSoup, usable: &UsablePolygons, defects: &mut Defects) {
    for (face, &polygon) in usable.polygon_sources.iter().enumerate() {
        let vertices = usable.faces.vertices(face as u32).iter();
        let shape = face_shape(
            vertices
                .clone()
                .map(|&vertex| soup.positions[vertex as usize]),
        );
        if shape.has_zero_side {
            defects.zero_length_edges.push(polygon);
        }
        if shape.height <= tolerance::COLLINEAR_HEIGHT {
            defects.zero_area.push(polygon);
        } else if shape.height < tolerance::SLIVER_HEIGHT && vertices.len() == 3 {
            defects.slivers.push(polygon);
        }
    }
}

fn find_connection_defects(soup: &PolygonSoup, usable: &UsablePolygons, defects: &mut Defects) {
    let faces = &usable.faces;
    let uses = EdgeUses::of(faces, soup.positions.len());
    let twins = uses.twins();
    find_edge_defects(faces, &uses, defects);
    let fans = fans(faces, &twins);
    find_bow_ties(faces, &uses, &fans, soup.positions.len(), defects);
    defects.boundary_loops = boundary_loops(faces, &twins, &fans).1;
    let patches = Patches::of(faces, &twins);
    let mut unorientable = vec![false; patches.count];
    for &side in &patches.conflicts {
        let patch = patches.patch_of_face[faces.face(side) as usize];
        unorientable[patch as usize] = true;
    }
    defects.non_orientable = first_faces(&patches.patch_of_face, patches.count)
        .filter(|&(patch, _)| unorientable[patch])
        .map(|(_, face)| usable.polygon_sources[face])
        .collect();
    let components = if uses.is_crowded() {
        edge_components(faces, &uses)
    } else {
        (patches.patch_of_face, patches.count)
    };
    find_component_defects(soup, usable, &uses, components, defects);
    find_cracks(soup, faces, &twins, defects);
}

fn find_edge_defects(faces: &PolygonFaces, uses: &EdgeUses, defects: &mut Defects) {
    for group in uses.iter() {
        match *group {
            [] => {}
            [_] => defects.boundary_edges += 1,
            [side, twin] => {
                if same_direction(faces, side, twin) {
                    defects.inconsistent_edges.push(faces.edge(side));
                }
            }
            [side, ..] => defects.non_manifold_edges.push(faces.edge(side)),
        }
    }
}

/// Vertices whose faces fall apart into fans even if all faces at an edge hold together.
fn find_bow_ties(
    faces: &PolygonFaces,
    uses: &EdgeUses,
    fans: &[u32],
    vertices: usize,
    defects: &mut Defects,
) {
    let joined = uses.is_crowded().then(|| {
        let mut sets = DisjointSets::new(faces.corner_count());
        for group in uses.iter() {
            for pair in group.windows(2) {
                join_ends(&mut sets, faces, pair[0], pair[1]);
            }
        }
        sets.into_names()
    });
    let mut fans_at = vec![0_u32; vertices];
    for (corner, &fan) in (0_u32..).zip(joined.as_deref().unwrap_or(fans)) {
        fans_at[faces.origin(corner) as usize] += u32::from(fan == corner);
    }
    let numbered = (0_u32..).zip(fans_at);
    defects.non_manifold_vertices = numbered
        .filter(|&(_, fans)| fans > 1)
        .map(|(vertex, _)| vertex)
        .collect();
}

/// Each component with its first face.
fn first_faces(components: &[u32], count: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut firsts = vec![usize::MAX; count];
    for (face, &component) in components.iter().enumerate().rev() {
        firsts[component as usize] = face;
    }
    firsts.into_iter().enumerate()
}

fn find_component_defects(
    soup: &PolygonSoup,
    usable: &UsablePolygons,
    uses: &EdgeUses,
    (components, count): (Vec<u32>, usize),
    defects: &mut Defects,
) {
    let faces = &usable.faces;
    let bounds = component_bounds(faces, &soup.positions, &components, count);
    let as_given = vec![false; faces.face_count()];
    let volumes = component_volumes(faces, &soup.positions, &components, &bounds, &as_given);
    let mut consistent_and_closed = vec![true; count];
    for group in uses.iter() {
        let forward = group
            .iter()
            .filter(|&&side| faces.origin(side) == faces.edge(side)[0]);
        if 2 * forward.count() != group.len() {
            consistent_and_closed[components[faces.face(group[0]) as usize] as usize] = false;
        }
    }
    let mut whole = Bounds::EMPTY;
    for corner in 0..faces.corner_count() as u32 {
        whole.add(soup.positions[faces.origin(corner) as usize]);
    }
    for (component, face) in first_faces(&components, count) {
        let polygon = usable.polygon_sources[face];
        if consistent_and_closed[component] && volumes[component] < -tolerance::FLAT_VOLUME {
            defects.inside_out.push(polygon);
        }
        if bounds[component].extent() < tolerance::TINY_COMPONENT * whole.extent() {
            defects.tiny_components.push(polygon);
        }
    }
    defects.components = count;
}

/// Seams between boundary edges that coincide, and T-junctions among the other boundary edges.
fn find_cracks(soup: &PolygonSoup, faces: &PolygonFaces, twins: &[u32], defects: &mut Defects) {
    let on_seam = find_open_seams(soup, faces, twins, defects);
    let open = (0..faces.corner_count() as u32)
        .filter(|&side| twins[side as usize] == NONE && !on_seam[side as usize]);
    let mut vertices: Vec<_> = open
        .clone()
        .flat_map(|side| [faces.origin(side), faces.destination(side)])
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    let position = |vertex: u32| soup.positions[vertex as usize];
    let tree = PointTree::new(vertices.iter().map(|&vertex| position(vertex)).collect());
    let mut junctions = vec![false; vertices.len()];
    for side in open {
        let ends = [faces.origin(side), faces.destination(side)].map(position);
        mark_points_on(&tree, ends, &mut junctions);
    }
    let marked = vertices.iter().zip(junctions);
    defects.t_junctions = marked
        .filter(|&(_, junction)| junction)
        .map(|(&vertex, _)| vertex)
        .collect();
}

fn find_open_seams(
    soup: &PolygonSoup,
    faces: &PolygonFaces,
    twins: &[u32],
    defects: &mut Defects,
) -> Vec<bool> {
    let mut on_seam = vec![false; faces.corner_count()];
    if defects.duplicate_vertices.is_empty() {
        return on_seam;
    }
    let names = first_at_same_position(&soup.positions, &vec![true; soup.positions.len()]);
    for seam in find_seams(faces, twins, &names) {
        defects.open_seams.push(faces.edge(seam[0]));
        for side in seam {
            on_seam[side as usize] = true;
        }
    }
    on_seam
}

/// Marks the points inside a segment, away from its ends.
fn mark_points_on(tree: &PointTree, [from, to]: [DVec3; 2], marks: &mut [bool]) {
    let along = to - from;
    let size = length(along);
    let reach = DVec3::splat(tolerance::ON_EDGE * size);
    let [low, high] = [from.min(to) - reach, from.max(to) + reach];
    let on_segment = |point: DVec3| {
        let [offset, direction] = [(point - from) / size, along / size];
        let share = offset.dot(direction);
        let inside = tolerance::ON_EDGE < share && share < 1.0 - tolerance::ON_EDGE;
        inside && (offset - direction * share).length() <= tolerance::ON_EDGE
    };
    tree.search::<()>(
        |box_low, box_high| box_low.cmple(high).all() && box_high.cmpge(low).all(),
        |point| {
            if on_segment(tree.point(point)) {
                marks[point as usize] = true;
            }
            ControlFlow::Continue(())
        },
    );
}
