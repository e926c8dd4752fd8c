//! Seams: edges along which a surface is cut so that it can be laid flat.
//!
//! Handles are opened along the shortest loops through a vertex that generate the surface's
//! topology ([`handles`]); a closed surface of genus 0 from the tip of one protrusion to that of
//! another. Then the seam grows to the tips and to the other loops of the boundary ([`rims`]) that would
//! be distorted most: where the best conformal map would change lengths by more than a given factor
//! ([`tips`]).

mod handles;
mod paths;
mod rims;
mod tips;

use serde::Serialize;

pub(super) use self::paths::EdgeGraph;
use self::rims::Rims;
use self::tips::Tips;
use super::FlattenError;
use crate::mesh::{EdgeId, PerEdge, Surface, Topology, VertexId};
use crate::watch::Watch;

/// How a seam is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SeamOptions {
    /// The factor by which a conformal map may change lengths before the seam is led to the place:
    /// above 1.
    pub length_factor: f64,
    /// Most tips that the seam is led to, beside what topology asks for.
    pub tips: usize,
}

impl Default for SeamOptions {
    fn default() -> Self {
        Self {
            length_factor: 3.0,
            tips: 16,
        }
    }
}

/// Edges to cut along, so that a connected surface becomes a disk, perhaps with holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// The edges, ascending; none of them on the boundary.
    pub edges: Vec<EdgeId>,
    /// Their length in space.
    pub length: f64,
    /// The tips that it was led to.
    pub tips: Vec<VertexId>,
}

/// Finds a short seam that makes a connected surface of any genus, closed or not, a patch with
/// little distortion. A surface that is a patch already may need none.
///
/// Edges that `may_cut` denies, such as diagonals inside polygons, are left alone; the others must
/// join all vertices.
///
/// Cost: near-linear; one factorisation of the Laplacian for each few tips.
///
/// # Errors
/// [`FlattenError`].
pub fn find_seam(
    surface: &Surface,
    may_cut: &PerEdge<bool>,
    options: &SeamOptions,
    watch: &Watch,
) -> Result<Seam, FlattenError> {
    let _stage = watch.stage("find seam");
    let mesh = surface.mesh();
    let graph = EdgeGraph::new(surface, may_cut);
    let topology = Topology::of(mesh).total;
    let mut draft = Draft {
        graph: &graph,
        is_open: PerEdge::from_fn(mesh.edge_count(), |edge| mesh.is_boundary_edge(edge)),
        tips: Vec::new(),
    };
    if topology.genus > 0 {
        for edge in handles::cut_graph(surface, &graph) {
            draft.is_open[edge] = true;
        }
    }
    let tips = Tips::new(surface, watch)?;
    if topology.genus == 0 && topology.is_closed() {
        draft.open_sphere(&tips)?;
    }
    draft.grow(&tips, options, watch)?;
    Ok(draft.finish())
}

/// A seam that grows.
struct Draft<'a> {
    graph: &'a EdgeGraph<'a>,
    /// Edges on the seam or the boundary.
    is_open: PerEdge<bool>,
    tips: Vec<VertexId>,
}

impl Draft<'_> {
    fn rims(&self) -> Rims {
        Rims::of(self.graph.mesh(), |edge| self.is_open[edge])
    }

    /// Joins the two tips that are farthest apart in the sense of conformal maps.
    fn open_sphere(&mut self, tips: &Tips<'_>) -> Result<(), FlattenError> {
        let first = tips.farthest(VertexId(0))?;
        let second = tips.farthest(first)?;
        self.tips.push(first);
        self.lead(|vertex| vertex == first, second);
        if self.open_edges().count() == 1 {
            // A slit of one edge cannot open: it goes on to where most is left.
            let rims = self.rims();
            let third = tips.strongest(&rims, rims.node(first))?;
            self.lead(|vertex| rims.node(vertex) == rims.node(first), third);
        }
        Ok(())
    }

    /// Leads the seam from some vertices to another by the shortest way.
    fn lead(&mut self, is_source: impl Fn(VertexId) -> bool, tip: VertexId) {
        let paths = self.graph.shortest_paths(is_source);
        for edge in paths.path_to(tip) {
            self.is_open[edge] = true;
        }
        self.tips.push(tip);
    }

    /// Leads the seam from the outer rim to tips, and to other rims, until none is left that
    /// distorts too much.
    fn grow(
        &mut self,
        tips: &Tips<'_>,
        options: &SeamOptions,
        watch: &Watch,
    ) -> Result<(), FlattenError> {
        let threshold = libm::log(options.length_factor);
        let mut rims = self.rims();
        let start = tips.on_outer(&rims)?;
        let mut left = options.tips;
        while left > 0 {
            watch.check()?;
            let found = tips.above(&rims, rims.node(start), threshold)?;
            if found.is_empty() {
                break;
            }
            for &tip in found.iter().take(left) {
                if rims.node(tip) != rims.node(start) {
                    self.lead(|vertex| rims.node(vertex) == rims.node(start), tip);
                    rims = self.rims();
                }
            }
            left -= found.len().min(left);
        }
        Ok(())
    }

    /// The edges of the seam, ascending.
    fn open_edges(&self) -> impl Iterator<Item = EdgeId> + '_ {
        let mesh = self.graph.mesh();
        let is_seam = move |edge: &EdgeId| self.is_open[*edge] && !mesh.is_boundary_edge(*edge);
        mesh.edges().filter(is_seam)
    }

    fn finish(self) -> Seam {
        let edges: Vec<EdgeId> = self.open_edges().collect();
        Seam {
            length: edges.iter().map(|&edge| self.graph.length(edge)).sum(),
            edges,
            tips: self.tips,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriangleMesh, cut_along};
    use graticule_fixtures::{
        Fixture, annulus, block_with_holes, cylinder_closed, cylinder_patch, icosphere,
        tetrahedron, torus,
    };

    fn surface(fixture: &Fixture) -> Surface {
        Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
    }

    fn seam(surface: &Surface, options: &SeamOptions) -> Seam {
        let all = PerEdge::filled(surface.mesh().edge_count(), true);
        find_seam(surface, &all, options, &Watch::new()).unwrap()
    }

    fn cut(surface: &Surface, seam: &Seam) -> TriangleMesh {
        let cut = cut_along(surface, seam.edges.iter().copied()).unwrap();
        cut.surface.mesh().clone()
    }

    #[test]
    fn closed_surfaces_of_any_genus_become_disks() {
        let mut pierced = torus(2.0, 0.5, 24, 12);
        pierced.triangles.remove(40);
        let fixtures = [
            icosphere(3),
            torus(2.0, 0.5, 24, 12),
            pierced,
            block_with_holes(2),
            block_with_holes(5),
            // All its vertices are neighbours.
            tetrahedron(),
        ];
        for fixture in &fixtures {
            let surface = surface(fixture);
            let seam = seam(&surface, &SeamOptions::default());
            assert!(Topology::of(&cut(&surface, &seam)).total.is_disk());
            assert!(seam.length > 0.0);
        }
    }

    #[test]
    fn a_ring_with_windows_at_equal_distances_stays_in_one_piece() {
        let mut ring = torus(2.0, 0.5, 24, 12);
        let windows = [3, 7, 11, 15, 19, 23].map(|column| 24 * column);
        let mut face = 0;
        ring.triangles.retain(|_| {
            face += 1;
            !windows
                .iter()
                .any(|&first| (first..first + 2).contains(&(face - 1)))
        });
        let ring = surface(&ring);
        let opened = cut(&ring, &seam(&ring, &SeamOptions::default()));
        let topology = Topology::of(&opened);
        assert_eq!(topology.components.len(), 1);
        assert_eq!(topology.total.genus, 0);
    }

    #[test]
    fn a_flat_patch_needs_no_seam() {
        let ring = surface(&annulus(0.5, 1.0, 24, 4));
        assert_eq!(seam(&ring, &SeamOptions::default()).edges, []);
    }

    #[test]
    fn an_open_tube_is_cut_from_end_to_end() {
        let tube = surface(&cylinder_patch(0.2, 2.0, 16, 30));
        let found = seam(&tube, &SeamOptions::default());
        assert!(Topology::of(&cut(&tube, &found)).total.is_disk());
        assert!((found.length - 2.0).abs() < 1e-9, "{}", found.length);
    }

    #[test]
    fn a_low_band_needs_no_seam_and_a_window_in_a_tube_none_of_its_own() {
        let band = surface(&cylinder_patch(1.0, 0.5, 32, 4));
        assert_eq!(seam(&band, &SeamOptions::default()).edges, []);
        let mut windowed = cylinder_patch(0.2, 2.0, 16, 30);
        windowed.triangles.remove(16 * 30);
        let windowed = surface(&windowed);
        assert_eq!(windowed.mesh().boundary_loop_count(), 3);
        let found = seam(&windowed, &SeamOptions::default());
        // One way from end to end, shorter through the window.
        assert_eq!(found.tips.len(), 1);
        assert!(found.length < 2.0 - 1e-3, "{}", found.length);
    }

    #[test]
    fn a_torus_is_cut_along_its_two_shortest_loops() {
        let surface = surface(&torus(2.0, 0.5, 48, 16));
        let found = seam(
            &surface,
            &SeamOptions {
                tips: 0,
                ..SeamOptions::default()
            },
        );
        let shortest = std::f64::consts::TAU * (1.5 + 0.5);
        assert!(
            found.length < 1.15 * shortest,
            "{} {shortest}",
            found.length
        );
    }

    #[test]
    fn edges_that_may_not_be_cut_are_not() {
        let surface = surface(&torus(2.0, 0.5, 24, 12));
        let mesh = surface.mesh();
        let own = PerEdge::from_fn(mesh.edge_count(), |edge| {
            // Triangles come in pairs that share the diagonal of a quadrilateral.
            let side = mesh.edge_halfedge(edge);
            mesh.twin(side)
                .is_none_or(|twin| side.face().0 / 2 != twin.face().0 / 2)
        });
        let found = find_seam(&surface, &own, &SeamOptions::default(), &Watch::new()).unwrap();
        assert!(found.edges.iter().all(|&edge| own[edge]));
        assert!(Topology::of(&cut(&surface, &found)).total.is_disk());
    }

    #[test]
    fn a_long_finger_draws_the_seam_to_its_tip() {
        let finger = surface(&cylinder_closed(0.2, 4.0, 12, 40));
        let found = seam(&finger, &SeamOptions::default());
        let height = |v: &VertexId| finger.position(*v).z;
        let highest = found.tips.iter().map(height).fold(f64::MIN, f64::max);
        let lowest = found.tips.iter().map(height).fold(f64::MAX, f64::min);
        assert!(highest - lowest > 3.9, "{lowest} {highest}");
    }
}
