//! Lets go of features that leave the net no room.

use super::remesh::{all_features, field_options};
use super::{RemeshError, RemeshOptions};
use crate::field::{FieldOptions, FieldResult, cross_field};
use crate::geometry::{EdgeLengths, dihedral_angles};
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, PerVertex, Surface, VertexId};
use crate::periodic::{IntegerGrid, IntegerGridOptions};
use crate::tolerance::{CRUMPLED_SHARE, HOPELESS_SHARE};
use crate::watch::Watch;

/// Features much closer together than lines of the net, or that wind so that whole numbers would
/// have to be the same at different places, crumple the net far around. What is crumpled tells which
/// features are in the way: first those that weigh least go, up to half of what runs there, then all
/// that do, then every feature there is, and at last the guidance of the field by curvature: a field
/// that turns with every detail has more singularities than a coarse net has room for.
const RELEASES: [Release; 4] = [
    Release::Lighter,
    Release::Crowded,
    Release::All,
    Release::Guidance,
];

/// So many flipped triangles are never too many.
const FEW_CRUMPLED: f64 = 200.0;

/// The one part of so many crumpled triangles that has to go with the lighter features for it to be
/// worth while to keep those elsewhere.
const WORTHWHILE_PART: usize = 4;

/// What is let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Release {
    Lighter,
    Crowded,
    All,
    Guidance,
}

/// What maps of any density are made from.
pub(super) struct Roomy {
    pub(super) grid: IntegerGrid,
    pub(super) field: FieldResult,
    /// The features that leave the net room.
    pub(super) features: Vec<EdgeId>,
}

/// Prepares maps along a field and the features that leave the net room. Letting others go is a
/// warning.
///
/// Cost: up to five times that of [`IntegerGrid::of`].
pub(super) fn roomy_grid(
    surface: &Surface,
    options: &RemeshOptions,
    watch: &Watch,
) -> Result<Roomy, RemeshError> {
    let distances = options.sizing.distances(surface, options, watch)?;
    let mut wishes = field_options(surface, options);
    wishes.sizes.clone_from(&distances);
    let mut field = cross_field(surface, &wishes, watch)?;
    let mut features = all_features(surface, &options.field);
    let wanted = features.len();
    let mut lines = IntegerGridOptions {
        density: options.density,
        sizing: distances.map(|distances| distances.map(|distance| distance.recip())),
        stretch: options.sizing.stretches(surface, &field, watch)?,
        ..IntegerGridOptions::default()
    };
    let mut releases = Releases::default();
    loop {
        lines.features.clone_from(&features);
        let grid = IntegerGrid::of(surface, &field.field, &lines, watch)?;
        let crumpled = grid.crumpled(options.density, watch)?;
        let Some(release) = releases.next(surface, &features, crumpled.len()) else {
            warn(wanted - features.len(), wanted, watch);
            return Ok(Roomy {
                grid,
                field,
                features,
            });
        };
        if release == Release::Guidance {
            field = unguided(surface, &wishes, watch)?;
        } else {
            features = released(surface, &features, &crumpled, release);
        }
    }
}

/// What is let go next, and how much it helped so far.
#[derive(Default)]
struct Releases {
    /// Those that were tried, or passed over.
    tried: usize,
    /// Crumpled triangles before the last one.
    before: Option<usize>,
}

impl Releases {
    /// `None` where the net has room, or nothing is left to be let go.
    fn next(&mut self, surface: &Surface, features: &[EdgeId], crumpled: usize) -> Option<Release> {
        let share = crumpled as f64 / surface.mesh().face_count() as f64;
        if crumpled as f64 <= FEW_CRUMPLED || share <= CRUMPLED_SHARE {
            return None;
        }
        let before = self.before.replace(crumpled);
        let is_worthwhile =
            before.is_none_or(|before| crumpled <= before - before / WORTHWHILE_PART);
        loop {
            let release = *RELEASES.get(self.tried)?;
            self.tried += 1;
            let is_useful = match release {
                Release::Lighter | Release::All => !features.is_empty(),
                Release::Crowded => !features.is_empty() && is_worthwhile,
                Release::Guidance => features.is_empty() && share > HOPELESS_SHARE,
            };
            if is_useful {
                return Some(release);
            }
        }
    }
}

/// The smoothest field along the boundary, with pairs of singularities cancelled from farther away.
fn unguided(
    surface: &Surface,
    wishes: &FieldOptions,
    watch: &Watch,
) -> Result<FieldResult, RemeshError> {
    watch.warn(
        "crowded-field",
        "the field follows neither curvature nor features: the net has no room",
    );
    let mut wanted = wishes.clone();
    wanted.curvature = None;
    wanted.features.edges.clear();
    Ok(cross_field(surface, &wanted, watch)?)
}

fn warn(released: usize, wanted: usize, watch: &Watch) {
    if released > 0 {
        let message =
            format!("{released} of {wanted} feature edges are not followed: the net has no room");
        watch.warn("crowded-features", message);
    }
}

/// A line of features between junctions and ends.
#[derive(Clone, Debug, Default)]
struct Chain {
    edges: Vec<EdgeId>,
    /// Length times angle, in all.
    weight: f64,
    /// The length of what runs through crumpled triangles.
    crowded: f64,
}

/// The features left, in order.
fn released(
    surface: &Surface,
    features: &[EdgeId],
    crumpled: &[FaceId],
    release: Release,
) -> Vec<EdgeId> {
    let mut chains = chains(surface, features, crumpled);
    chains.sort_by(|a, b| a.weight.total_cmp(&b.weight).then(a.edges.cmp(&b.edges)));
    let all: f64 = chains.iter().map(|chain| chain.crowded).sum();
    let mut gone = 0.0;
    chains.retain(|chain| {
        let goes = match release {
            Release::All | Release::Guidance => true,
            Release::Crowded => chain.crowded > 0.0,
            Release::Lighter => chain.crowded > 0.0 && gone < all / 2.0,
        };
        gone += if goes { chain.crowded } else { 0.0 };
        !goes
    });
    let mut left: Vec<EdgeId> = chains.into_iter().flat_map(|chain| chain.edges).collect();
    left.sort_unstable();
    left
}

fn chains(surface: &Surface, features: &[EdgeId], crumpled: &[FaceId]) -> Vec<Chain> {
    let mesh = surface.mesh();
    let ends = |edge: EdgeId| mesh.ends(mesh.edge_halfedge(edge));
    let mut at_vertex = PerVertex::filled(mesh.vertex_count(), (0_u32, 0_u32));
    let mut sets = DisjointSets::new(features.len());
    for (number, &edge) in features.iter().enumerate() {
        for vertex in ends(edge) {
            let (count, last) = &mut at_vertex[vertex];
            (*count, *last) = (*count + 1, number as u32);
        }
    }
    for (number, &edge) in features.iter().enumerate() {
        for vertex in ends(edge) {
            if let (2, last) = at_vertex[vertex] {
                sets.join(number as u32, last);
            }
        }
    }
    let is_crumpled = corners_of(surface, crumpled);
    let (lengths, angles) = (EdgeLengths::of(surface), dihedral_angles(surface));
    let mut chains = vec![Chain::default(); features.len()];
    for (&edge, name) in features.iter().zip(sets.into_names()) {
        let chain = &mut chains[name as usize];
        chain.edges.push(edge);
        chain.weight += lengths[edge] * angles[edge].abs();
        if ends(edge).into_iter().any(|vertex| is_crumpled[vertex]) {
            chain.crowded += lengths[edge];
        }
    }
    chains.retain(|chain| !chain.edges.is_empty());
    chains
}

/// Marks the corners of triangles.
fn corners_of(surface: &Surface, faces: &[FaceId]) -> PerVertex<bool> {
    let mesh = surface.mesh();
    let mut marked = PerVertex::filled(mesh.vertex_count(), false);
    let corners = faces.iter().flat_map(|face| face.halfedges());
    for vertex in corners.map(|corner: HalfedgeId| -> VertexId { mesh.origin(corner) }) {
        marked[vertex] = true;
    }
    marked
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_3, TAU};

    use glam::DVec3;
    use graticule_fixtures::{Fixture, cube, grid};

    use super::*;
    use crate::field::feature_edges;
    use crate::periodic::GridDensity;

    fn surface_of(fixture: &Fixture) -> Surface {
        Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
    }

    /// A tube with a sharp thread that winds round it, open at both ends.
    fn thread() -> Surface {
        let (columns, rows) = (48, 96);
        let flat = grid(1.0, 1.0, columns, rows);
        let radius = |u: f64, v: f64| {
            let phase = (u - 8.0 * v).rem_euclid(1.0);
            1.0 + 0.25 * (2.0 * phase - 1.0).abs()
        };
        let place = |p: DVec3| {
            let (sin, cos) = libm::sincos(TAU * p.x);
            let r = radius(p.x, p.y);
            DVec3::new(r * cos, r * sin, 4.0 * p.y)
        };
        surface_of(&flat.map(place))
    }

    #[test]
    fn features_with_room_are_kept() {
        let surface = surface_of(&cube().subdivided().subdivided().subdivided());
        let features = feature_edges(&surface, FRAC_PI_3, 1);
        let watch = Watch::new();
        let mut options = RemeshOptions {
            density: GridDensity::Quads(600),
            ..RemeshOptions::default()
        };
        options.field.features.edges.clone_from(&features);
        let roomy = roomy_grid(&surface, &options, &watch).unwrap();
        assert_eq!(roomy.features, features);
        assert!(watch.warnings().is_empty());
    }

    #[test]
    fn the_lighter_of_two_crowded_chains_goes_first_and_what_is_elsewhere_stays() {
        let surface = thread();
        let mesh = surface.mesh();
        let features = feature_edges(&surface, FRAC_PI_3, 1);
        assert!(!features.is_empty());
        let all: Vec<FaceId> = mesh.faces().collect();
        assert_eq!(
            released(&surface, &features, &[], Release::Crowded),
            features
        );
        assert_eq!(released(&surface, &features, &all, Release::All), []);
        assert_eq!(released(&surface, &features, &all, Release::Crowded), []);
        let whole = chains(&surface, &features, &all);
        let weight = |edges: &[EdgeId]| -> f64 {
            let kept = whole.iter().filter(|chain| edges.contains(&chain.edges[0]));
            kept.map(|chain| chain.weight).fold(f64::INFINITY, f64::min)
        };
        let left = released(&surface, &features, &all, Release::Lighter);
        assert!(left.len() < features.len());
        let gone: Vec<EdgeId> = features
            .iter()
            .copied()
            .filter(|e| !left.contains(e))
            .collect();
        assert!(left.is_empty() || weight(&gone) <= weight(&left));
    }
}
