//! What keeps a polygon soup from being a sound surface, and what else is worth knowing of it.

mod find;
mod report;

use std::collections::BTreeMap;

use serde::Serialize;

pub use report::{Finding, Severity};

use super::{ElementList, PolygonSoup};

/// Everything found in a polygon soup, by element.
///
/// Vertices and polygons go by their numbers in the soup, edges by the numbers of their two
/// vertices. What concerns connectivity is found on the polygons that can be used: those named in
/// [`out_of_range`](Self::out_of_range), [`non_finite_polygons`](Self::non_finite_polygons),
/// [`too_few_corners`](Self::too_few_corners), [`collapsed`](Self::collapsed) and
/// [`duplicate_polygons`](Self::duplicate_polygons) are set aside. Vertices are not welded.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Defects {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of polygons.
    pub polygons: usize,
    /// Number of polygons for each number of corners.
    pub polygon_sizes: BTreeMap<usize, usize>,
    /// Number of components: polygons joined by common edges.
    pub components: usize,
    /// Number of boundary loops, with non-manifold edges cut and non-manifold vertices split.
    pub boundary_loops: usize,
    /// Number of edges with one polygon.
    pub boundary_edges: usize,

    /// Polygons with a corner that names no vertex.
    pub out_of_range: ElementList<u32>,
    /// Vertices of polygons whose position is NaN or infinite.
    pub non_finite_vertices: ElementList<u32>,
    /// Polygons with such a vertex.
    pub non_finite_polygons: ElementList<u32>,
    /// Vertices without polygon whose position is NaN or infinite.
    pub non_finite_unused_vertices: ElementList<u32>,
    /// Vertices without polygon.
    pub isolated_vertices: ElementList<u32>,
    /// Vertices of polygons at exactly the position of an earlier one.
    pub duplicate_vertices: ElementList<u32>,

    /// Polygons given with less than three corners.
    pub too_few_corners: ElementList<u32>,
    /// Polygons that have a vertex at two corners in a row, or run to a vertex and straight back.
    pub repeated_corners: ElementList<u32>,
    /// Those of them that have less than three corners otherwise.
    pub collapsed: ElementList<u32>,
    /// Polygons over the same vertices as an earlier one, in whatever order.
    pub duplicate_polygons: ElementList<u32>,
    /// Polygons with two different vertices at one position in a row.
    pub zero_length_edges: ElementList<u32>,
    /// Polygons without area, relative to their longest side
    /// ([`NO_AREA_HEIGHT`](crate::tolerance::NO_AREA_HEIGHT)).
    pub zero_area: ElementList<u32>,
    /// Thin triangles ([`SLIVER_HEIGHT`](crate::tolerance::SLIVER_HEIGHT)) that have an area.
    pub slivers: ElementList<u32>,

    /// Edges with three or more polygons.
    pub non_manifold_edges: ElementList<[u32; 2]>,
    /// Vertices whose polygons hang together only there (bow-ties).
    pub non_manifold_vertices: ElementList<u32>,
    /// Edges whose two polygons run along them in the same direction.
    pub inconsistent_edges: ElementList<[u32; 2]>,
    /// The first polygon of each piece that cannot be oriented (Möbius strip, Klein bottle).
    pub non_orientable: ElementList<u32>,
    /// The first polygon of each closed, consistently oriented component of negative volume.
    pub inside_out: ElementList<u32>,
    /// The first polygon of each component that is tiny beside the whole
    /// ([`TINY_COMPONENT`](crate::tolerance::TINY_COMPONENT)).
    pub tiny_components: ElementList<u32>,
    /// Boundary edges in pairs at the same place: cut, or never welded. One edge of each pair.
    pub open_seams: ElementList<[u32; 2]>,
    /// Boundary vertices that lie inside another boundary edge: a crack.
    pub t_junctions: ElementList<u32>,
}

impl Defects {
    /// Searches a soup for defects.
    ///
    /// Cost: O(n log n); nothing in the soup can make it fail.
    #[must_use]
    pub fn find(soup: &PolygonSoup) -> Self {
        find::find(soup)
    }

    /// Whether the soup needs no repair: its polygons make a sound, oriented, manifold surface.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.findings()
            .iter()
            .all(|finding| finding.severity == Severity::Note)
    }
}

#[cfg(test)]
mod tests;
