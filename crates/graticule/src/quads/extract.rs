use super::QuadsError;
use super::cells::Cells;
use super::complex::Complex;
use super::overlay::{ArcKind, NONE, Overlay, arc};
use super::polygon_mesh::PolygonMesh;
use super::regular::{Contracted, make_distinct, make_regular};
use crate::geometry::{face_areas, face_shapes};
use crate::mesh::{PerEdge, Polygons, Surface};
use crate::periodic::GridMap;
use crate::tolerance::FEWEST_PARTS;
use crate::watch::Watch;

/// A polygon mesh read off a map, and what had to be done to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Extraction {
    /// The polygons: quads, except round what the map leaves out and along boundaries that no line
    /// follows.
    pub mesh: PolygonMesh,
    /// Pieces of lines that ended inside a cell and were taken away.
    pub pruned_pieces: usize,
    /// Cells that were no disks, or stood out of the net, and were cut up.
    pub split_cells: usize,
    /// Arcs between images of the same lattice point, where the map folds, that were contracted.
    pub folds: usize,
    /// Short arcs to or along features and the boundary that were contracted.
    pub snapped: usize,
}

/// Reads the polygon mesh off the lines of a map ([PGP06] §5 and Algorithm 2, by combinatorics alone).
///
/// The triangles are cut along all lines with whole coordinates, exactly: where a line meets an edge
/// is found once per edge, and two lines cross in a triangle where a lattice point lies inside. The
/// pieces between lines are the polygons. As they come from a partition of the surface itself, they
/// have its components, genus and boundary loops, whatever the map, once each cell is a disk:
///
/// - lines that end inside a cell, beside triangles left out, are taken back to the last crossing;
/// - cells that are no disks, touch themselves, or stand out of the net by more than their width are
///   cut along edges of the triangles;
/// - where the map folds, the images of one lattice point become one vertex;
/// - crossings of lines close to a feature or the boundary that no line follows are drawn onto it.
///
/// The boundary, and edges marked in `features`, become chains of edges.
///
/// Cost: linear in triangles and pieces, up to sorting.
///
/// # Errors
/// [`QuadsError::OtherMesh`], [`QuadsError::TooFine`]; the result is checked, so that
/// [`QuadsError::Unsound`] and [`QuadsError::Topology`] would be faults of the program.
///
/// [PGP06]: crate::papers::PGP06
pub fn extract_polygons(
    surface: &Surface,
    map: &GridMap,
    features: Option<&PerEdge<bool>>,
    watch: &Watch,
) -> Result<Extraction, QuadsError> {
    let (given, needed) = (map.coordinates().len(), surface.mesh().halfedge_count());
    if given != needed {
        return Err(QuadsError::OtherMesh { given, needed });
    }
    let _stage = watch.stage("extraction");
    let mut overlay = Overlay::of(surface, map, features, watch)?;
    let cell_area = usual_cell_area(surface, map);
    let cells = Cells::settle(&mut overlay, cell_area, watch)?;
    let mut complex = Complex::of(&overlay, &cells);
    let mut contracted = make_regular(&mut complex, &overlay, cell_area.sqrt());
    let mut mesh = polygons(&complex, &overlay);
    if mesh.check(surface).is_err() {
        let message =
            "the map folds so that vertices could not be joined; polygons are left as cut";
        watch.warn("folds-kept", message);
        contracted = Contracted::default();
        complex = Complex::of(&overlay, &cells);
        make_distinct(&mut complex);
        mesh = polygons(&complex, &overlay);
        mesh.check(surface)?;
    }
    Ok(Extraction {
        mesh,
        pruned_pieces: cells.pruned,
        split_cells: cells.split,
        folds: contracted.folds,
        snapped: contracted.snapped,
    })
}

/// The area in space of a cell with the area 1 in coordinates, on average.
pub(super) fn usual_cell_area(surface: &Surface, map: &GridMap) -> f64 {
    let areas = face_areas(&face_shapes(surface));
    let total: f64 = areas.iter().sum();
    let (mut in_space, mut in_plane) = (0.0, 0.0);
    for face in surface
        .mesh()
        .faces()
        .filter(|&face| !map.is_left_out(face))
    {
        let [a, b, c] = map.face_coordinates(face);
        in_space += areas[face];
        in_plane += (b - a).perp_dot(c - a).abs() / 2.0;
    }
    // A map with less than four cells says nothing about their size.
    if in_plane < 4.0 {
        total / FEWEST_PARTS
    } else {
        in_space / in_plane
    }
}

/// Writes the cells down as polygons.
fn polygons(complex: &Complex, overlay: &Overlay) -> PolygonMesh {
    let mut numbers = vec![NONE; overlay.points.len()];
    let mut mesh = PolygonMesh::default();
    let alive = || (0..complex.dart_count()).filter(|&dart| complex.is_alive(dart));
    for dart in alive() {
        numbers[complex.origin(dart) as usize] = 0;
    }
    for (node, number) in numbers.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
        *number = mesh.positions.len() as u32;
        mesh.positions.push(overlay.positions[node]);
        mesh.origins.push(overlay.points[node]);
    }
    let vertex = |dart: u32| numbers[complex.origin(dart) as usize];
    let mut visited = vec![false; complex.dart_count() as usize];
    mesh.polygons = Polygons::with_capacity(mesh.positions.len(), visited.len());
    let mut corners = Vec::new();
    for first in alive().filter(|&dart| !complex.is_outside(dart)) {
        if !visited[first as usize] {
            corners.clear();
            for dart in complex.around_cell(first) {
                visited[dart as usize] = true;
                corners.push(vertex(dart));
            }
            mesh.polygons.push(&corners);
        }
    }
    let is_feature = |dart: &u32| complex.kinds[arc(*dart)] == ArcKind::Feature;
    mesh.feature_edges = alive()
        .filter(|dart| dart.is_multiple_of(2))
        .filter(is_feature)
        .map(|dart| [vertex(dart), vertex(dart + 1)])
        .map(|[from, to]| [from.min(to), from.max(to)])
        .collect();
    mesh.feature_edges.sort_unstable();
    mesh
}
