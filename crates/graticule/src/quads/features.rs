//! Which sharp edges of a surface become edges of its quads.

use serde::Serialize;

use super::RemeshOptions;
use super::remesh::side_length;
use crate::field::feature_edges;
use crate::geometry::{EdgeLengths, dihedral_angles};
use crate::mesh::{DisjointSets, EdgeId, Element, PerVertex, Surface, VertexId};
use crate::tolerance::{
    CLEAR_FEATURE, FOLD_BESIDE_FEATURE, LONG_FEATURE_IN_QUADS, SHORTEST_FEATURE_IN_QUADS,
};
use crate::watch::Watch;

/// What was taken for features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FeatureReport {
    /// Edges as sharp as features have to be.
    pub sharp: usize,
    /// Those of lines that are shorter than a few quads.
    pub short: usize,
    /// Those of lines that do not stand out from what is around them.
    pub unclear: usize,
    /// Edges that are held to as features, those named by the caller among them.
    pub kept: usize,
}

/// A line of sharp edges that hang together.
#[derive(Clone, Copy, Default)]
struct Line {
    edges: usize,
    length: f64,
    /// The length of the edges that touch it and are half as sharp.
    folded_beside: f64,
}

/// The edges that the quads are to follow: those given, and the sharp ones that make lines which are
/// longer than a few quads, and which stand out. On a surface with few triangles, or a rough one,
/// edges are sharp by chance: beside them lie others that are nearly as sharp.
pub(super) fn clear_features(
    surface: &Surface,
    options: &RemeshOptions,
    watch: &Watch,
) -> (Vec<EdgeId>, FeatureReport) {
    let given = &options.field.features;
    let mut features = given.edges.clone();
    let mut report = FeatureReport::default();
    if let Some(dihedral) = given.dihedral {
        let sharp = feature_edges(surface, dihedral, 1);
        let side = side_length(surface, options.density);
        report.sharp = sharp.len();
        for (edge, line) in sharp.iter().zip(lines(surface, &sharp, dihedral)) {
            let is_long =
                line.edges >= given.least_edges || line.length >= LONG_FEATURE_IN_QUADS * side;
            if !is_long || line.length < SHORTEST_FEATURE_IN_QUADS * side {
                report.short += 1;
            } else if line.length < CLEAR_FEATURE * (line.length + line.folded_beside) {
                report.unclear += 1;
            } else {
                features.push(*edge);
            }
        }
    }
    features.sort_unstable();
    features.dedup();
    report.kept = features.len();
    report.warn(watch);
    (features, report)
}

impl FeatureReport {
    fn warn(&self, watch: &Watch) {
        if self.unclear > 0 {
            let message = format!(
                "{} of {} sharp edges are not followed: edges beside them are nearly as sharp",
                self.unclear, self.sharp
            );
            watch.warn("unclear-features", message);
        }
    }
}

/// For each of the sharp edges the line that it belongs to.
fn lines(surface: &Surface, sharp: &[EdgeId], dihedral: f64) -> Vec<Line> {
    let mesh = surface.mesh();
    let ends = |edge: EdgeId| mesh.ends(mesh.edge_halfedge(edge));
    let mut sets = DisjointSets::new(mesh.vertex_count());
    let mut on_line = PerVertex::filled(mesh.vertex_count(), false);
    for [from, to] in sharp.iter().map(|&edge| ends(edge)) {
        sets.join(from.0, to.0);
        on_line[from] = true;
        on_line[to] = true;
    }
    let names = sets.into_names();
    let name = |vertex: VertexId| names[vertex.index()] as usize;
    let (lengths, angles) = (EdgeLengths::of(surface), dihedral_angles(surface));
    let mut lines = vec![Line::default(); mesh.vertex_count()];
    for edge in mesh.edges() {
        let (length, angle) = (lengths[edge], angles[edge].abs());
        let [from, to] = ends(edge);
        if angle >= dihedral {
            let line = &mut lines[name(from)];
            line.edges += 1;
            line.length += length;
        } else if angle >= FOLD_BESIDE_FEATURE * dihedral {
            if on_line[from] {
                lines[name(from)].folded_beside += length;
            }
            if on_line[to] && (!on_line[from] || name(from) != name(to)) {
                lines[name(to)].folded_beside += length;
            }
        }
    }
    sharp
        .iter()
        .map(|&edge| lines[name(ends(edge)[0])])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{FeatureOptions, FieldOptions};
    use crate::periodic::GridDensity;
    use glam::DVec3;
    use graticule_fixtures::{Fixture, cube, icosphere};
    use std::f64::consts::FRAC_PI_3;

    fn features(fixture: &Fixture, quads: usize) -> FeatureReport {
        let surface =
            Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap();
        let options = RemeshOptions {
            density: GridDensity::Quads(quads),
            field: FieldOptions {
                features: FeatureOptions {
                    dihedral: Some(FRAC_PI_3),
                    ..FeatureOptions::default()
                },
                ..FieldOptions::default()
            },
            ..RemeshOptions::default()
        };
        clear_features(&surface, &options, &Watch::new()).1
    }

    #[test]
    fn the_edges_of_a_box_are_features_however_few_they_are() {
        for fixture in [cube(), cube().subdivided().subdivided()] {
            let found = features(&fixture, 600);
            assert!(found.kept > 0 && found.kept == found.sharp, "{found:?}");
        }
    }

    #[test]
    fn a_box_smaller_than_the_quads_has_none() {
        let small = cube().subdivided().map(|p| 0.02 * p + 3.0);
        let found = features(&cube().subdivided().joined(&small), 600);
        assert_eq!((found.short, found.kept), (24, 24));
    }

    #[test]
    fn edges_that_are_sharp_by_chance_are_none() {
        // A sphere whose vertices are moved in and out: sharp edges among nearly as sharp ones.
        let mut rough = icosphere(2);
        for (index, position) in rough.positions.iter_mut().enumerate() {
            let turn = (index * 7 % 11) as f64 / 11.0;
            *position *= DVec3::splat(0.8 + 0.35 * turn);
        }
        let found = features(&rough, 2000);
        assert!(found.sharp > 20 && found.unclear > 0, "{found:?}");
        assert_eq!(found.kept, 0);
    }
}
