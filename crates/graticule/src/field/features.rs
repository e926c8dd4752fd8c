use std::collections::BTreeMap;

use crate::geometry::dihedral_angles;
use crate::mesh::{EdgeId, Surface, VertexId};

/// The edges whose triangles meet at an angle of at least `dihedral`, in radians between their
/// normals, in lines of at least `least_edges` edges that hang together.
///
/// Shorter lines are left out: on scans they are noise, and a field held to them would have a pair
/// of singularities at each.
#[must_use]
pub fn feature_edges(surface: &Surface, dihedral: f64, least_edges: usize) -> Vec<EdgeId> {
    let angles = dihedral_angles(surface);
    let sharp: Vec<EdgeId> = surface
        .mesh()
        .edges()
        .filter(|&edge| angles[edge].abs() >= dihedral)
        .collect();
    let sizes = line_sizes(surface, &sharp);
    let long = sharp.into_iter().zip(sizes);
    long.filter(|(_, size)| *size >= least_edges)
        .map(|(edge, _)| edge)
        .collect()
}

/// For each of the edges the number of those that it hangs together with, itself included.
fn line_sizes(surface: &Surface, edges: &[EdgeId]) -> Vec<usize> {
    let mesh = surface.mesh();
    let ends = |place: usize| mesh.ends(mesh.edge_halfedge(edges[place]));
    let mut at_vertex = BTreeMap::<VertexId, Vec<usize>>::new();
    for place in 0..edges.len() {
        for vertex in ends(place) {
            at_vertex.entry(vertex).or_default().push(place);
        }
    }
    let mut sizes = vec![0; edges.len()];
    for start in 0..edges.len() {
        if sizes[start] > 0 {
            continue;
        }
        // A size of 1 marks the edges of the line while it grows.
        sizes[start] = 1;
        let mut line = vec![start];
        let mut next = 0;
        while next < line.len() {
            for beside in ends(line[next])
                .iter()
                .flat_map(|vertex| &at_vertex[vertex])
            {
                if sizes[*beside] == 0 {
                    sizes[*beside] = 1;
                    line.push(*beside);
                }
            }
            next += 1;
        }
        for &place in &line {
            sizes[place] = line.len();
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::{cube, icosphere};

    fn surface(fixture: graticule_fixtures::Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    #[test]
    fn the_features_of_a_box_are_its_edges() {
        let cube = surface(cube().subdivided().subdivided());
        assert_eq!(feature_edges(&cube, 1.0, 5).len(), 12 * 4);
        assert_eq!(feature_edges(&cube, 1.0, 49).len(), 0);
        assert_eq!(feature_edges(&cube, 1.6, 1).len(), 0);
    }

    #[test]
    fn a_sphere_has_no_features() {
        assert!(feature_edges(&surface(icosphere(3)), 0.7, 1).is_empty());
    }

    #[test]
    fn short_lines_are_left_out() {
        let both = cube().joined(&cube().subdivided().map(|p| p + 3.0));
        assert_eq!(feature_edges(&surface(both), 1.0, 13).len(), 24);
    }
}
