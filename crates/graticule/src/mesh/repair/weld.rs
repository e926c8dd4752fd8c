use std::ops::ControlFlow;

use glam::DVec3;

use super::{RepairChanges, Weld};
use crate::mesh::PolygonSoup;
use crate::mesh::coincidence::first_at_same_position;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::faces::{Faces, PolygonFaces};
use crate::mesh::gluing::{EdgeUses, edge_components, same_direction};
use crate::mesh::point_tree::PointTree;
use crate::mesh::seams::{Seam, find_seams};
use crate::mesh::usable::UsablePolygons;

/// Gives vertices that become one the name of the first of them; returns whether there are any.
pub(super) fn weld(
    soup: &PolygonSoup,
    usable: &UsablePolygons,
    policy: Weld,
    names: &mut Vec<u32>,
    changes: &mut RepairChanges,
) -> bool {
    if policy == Weld::Never {
        return false;
    }
    let mut used = vec![false; soup.positions.len()];
    for corner in 0..usable.faces.corner_count() as u32 {
        used[usable.faces.origin(corner) as usize] = true;
    }
    let firsts = first_at_same_position(&soup.positions, &used);
    if is_identity(&firsts) {
        return false;
    }
    *names = match policy {
        Weld::Auto => close_seams(soup, usable, &firsts, changes),
        _ => firsts,
    };
    let numbered = (0_u32..).zip(&*names);
    changes.vertices_welded = numbered
        .filter(|&(vertex, &name)| vertex != name)
        .map(|(vertex, _)| vertex)
        .collect();
    !changes.vertices_welded.is_empty()
}

/// Gives vertices of open edges within this distance of an earlier one its name; returns whether
/// there are any. Distances are those to the vertex that keeps its name, so that no chain forms.
pub(super) fn join_nearby(
    soup: &PolygonSoup,
    usable: &UsablePolygons,
    distance: f64,
    names: &mut [u32],
    changes: &mut RepairChanges,
) -> bool {
    let is_some = distance > 0.0;
    if !is_some {
        return false;
    }
    let vertices = open_vertices(&usable.faces, names.len());
    let points = vertices.iter().map(|&v| soup.positions[v as usize]);
    let tree = PointTree::new(points.collect());
    let mut leaders: Vec<Option<u32>> = vec![None; vertices.len()];
    for point in 0..vertices.len() as u32 {
        if leaders[point as usize].is_some() {
            continue;
        }
        let place = tree.point(point);
        let may_hold = |low: DVec3, high: DVec3| place.clamp(low, high).distance(place) <= distance;
        let _ = tree.search(may_hold, |other| {
            let near = tree.point(other).distance(place) <= distance;
            if near && leaders[other as usize].is_none() {
                leaders[other as usize] = Some(point);
            }
            ControlFlow::<()>::Continue(())
        });
    }
    let mut joined: Vec<u32> = (0..names.len() as u32).collect();
    for (&vertex, leader) in vertices.iter().zip(leaders) {
        joined[vertex as usize] = leader.map_or(vertex, |leader| vertices[leader as usize]);
    }
    let moved = vertices.iter().filter(|&&v| joined[v as usize] != v);
    changes.vertices_joined = moved.copied().collect();
    for name in names {
        *name = joined[*name as usize];
    }
    !changes.vertices_joined.is_empty()
}

/// The vertices of sides that have no other side on their edge, ascending.
fn open_vertices(faces: &PolygonFaces, vertex_count: usize) -> Vec<u32> {
    let mut is_open = vec![false; vertex_count];
    for group in EdgeUses::of(faces, vertex_count).iter() {
        if let &[side] = group {
            is_open[faces.origin(side) as usize] = true;
            is_open[faces.destination(side) as usize] = true;
        }
    }
    let numbered = (0_u32..).zip(is_open);
    numbered.filter_map(|(v, open)| open.then_some(v)).collect()
}

fn is_identity(names: &[u32]) -> bool {
    (0_u32..).zip(names).all(|(vertex, &name)| vertex == name)
}

fn close_seams(
    soup: &PolygonSoup,
    usable: &UsablePolygons,
    firsts: &[u32],
    changes: &mut RepairChanges,
) -> Vec<u32> {
    let faces = &usable.faces;
    let uses = EdgeUses::of(faces, firsts.len());
    let seams = find_seams(faces, &uses.twins(), firsts);
    let joined = components_joined_to_others(faces, &uses, &seams);
    let textures = VertexTextures::of(soup);
    let mut sets = DisjointSets::new(firsts.len());
    for &seam in &seams {
        let [side, twin] = seam;
        let [component, other] = seam.map(|side| joined[faces.face(side) as usize]);
        let between = component.component != other.component;
        let itself = !same_direction_at(faces, firsts, seam)
            && (component.is_joined || textures.differ(faces, firsts, seam));
        if between || itself {
            join_vertices(&mut sets, faces, firsts, [side, twin]);
        } else {
            changes.seams_left_open.push(faces.edge(side));
        }
    }
    sets.into_names()
}

/// The component of a face, and whether a seam joins that component to another one.
#[derive(Clone, Copy, Debug)]
struct Membership {
    component: u32,
    is_joined: bool,
}

fn components_joined_to_others(
    faces: &PolygonFaces,
    uses: &EdgeUses,
    seams: &[Seam],
) -> Vec<Membership> {
    let (components, count) = edge_components(faces, uses);
    let mut is_joined = vec![false; count];
    for seam in seams {
        let [component, other] = seam.map(|side| components[faces.face(side) as usize]);
        if component != other {
            is_joined[component as usize] = true;
            is_joined[other as usize] = true;
        }
    }
    let membership = |component: u32| Membership {
        component,
        is_joined: is_joined[component as usize],
    };
    components.into_iter().map(membership).collect()
}

fn same_direction_at(faces: &PolygonFaces, firsts: &[u32], [side, twin]: Seam) -> bool {
    let place = |corner: u32| firsts[faces.origin(corner) as usize];
    same_direction(faces, side, twin) || place(side) == place(twin)
}

/// The vertices of both sides, paired by position.
fn facing_vertices(faces: &PolygonFaces, firsts: &[u32], [side, twin]: Seam) -> [[u32; 2]; 2] {
    let [from, to] = [faces.origin(side), faces.destination(side)];
    let [twin_from, twin_to] = [faces.origin(twin), faces.destination(twin)];
    if firsts[from as usize] == firsts[twin_from as usize] {
        [[from, twin_from], [to, twin_to]]
    } else {
        [[from, twin_to], [to, twin_from]]
    }
}

fn join_vertices(sets: &mut DisjointSets, faces: &PolygonFaces, firsts: &[u32], seam: Seam) {
    for [vertex, other] in facing_vertices(faces, firsts, seam) {
        sets.join(vertex, other);
    }
}

/// Texture coordinates of a file that keeps one for each vertex, so that it had to double the
/// vertices along the seams of the texture.
struct VertexTextures<'a> {
    soup: &'a PolygonSoup,
    sets: Vec<usize>,
}

impl<'a> VertexTextures<'a> {
    fn of(soup: &'a PolygonSoup) -> Self {
        let one_per_vertex = |set: &usize| {
            soup.attributes.uv_sets[*set].corner_values == soup.polygons.corner_vertices()
        };
        let sets = (0..soup.attributes.uv_sets.len())
            .filter(one_per_vertex)
            .collect();
        Self { soup, sets }
    }

    fn differ(&self, faces: &PolygonFaces, firsts: &[u32], seam: Seam) -> bool {
        let pairs = facing_vertices(faces, firsts, seam);
        self.sets.iter().any(|&set| {
            let values = &self.soup.attributes.uv_sets[set].values;
            let value = |vertex: u32| values.get(vertex as usize);
            pairs
                .iter()
                .any(|&[vertex, other]| value(vertex) != value(other))
        })
    }
}
