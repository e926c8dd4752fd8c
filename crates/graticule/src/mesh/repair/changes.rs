use std::fmt::{self, Display};

use serde::Serialize;

use crate::mesh::ElementList;
use crate::mesh::sentence::{Sentence, of_components, of_edges, of_polygons, of_vertices};

/// What [`repair`](super::repair) changed, by element.
///
/// Vertices, polygons and edges (by their two vertices) go by their numbers in the soup.
/// `Display` gives one sentence per line.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RepairChanges {
    /// Number of polygons with more than three corners, cut into triangles.
    pub polygons_triangulated: usize,
    /// Vertices without usable polygon, dropped.
    pub unused_vertices_dropped: ElementList<u32>,
    /// Polygons dropped because a position is not finite.
    pub non_finite_polygons_dropped: ElementList<u32>,
    /// Polygons with less than three different corners, dropped.
    pub collapsed_polygons_dropped: ElementList<u32>,
    /// Polygons of which repeated corners were dropped.
    pub repeated_corners_dropped: ElementList<u32>,
    /// Vertices replaced by an earlier one at the same position.
    pub vertices_welded: ElementList<u32>,
    /// Vertices of open edges replaced by an earlier one within the distance asked for.
    pub vertices_joined: ElementList<u32>,
    /// Pairs of boundary edges at the same place left open as a cut; one edge of each.
    pub seams_left_open: ElementList<[u32; 2]>,
    /// Polygons dropped because another one has the same vertices.
    pub duplicate_polygons_dropped: ElementList<u32>,
    /// Edges with more than two faces, split.
    pub edges_split: ElementList<[u32; 2]>,
    /// Vertices split so that each copy has one fan of faces.
    pub vertices_split: ElementList<u32>,
    /// Edges along which a non-orientable piece was cut open.
    pub edges_cut: ElementList<[u32; 2]>,
    /// Polygons turned round to agree with their component.
    pub polygons_turned: ElementList<u32>,
    /// The first polygon of each closed component turned as a whole, to face outward.
    pub components_turned: ElementList<u32>,
    /// The first polygon of each closed component of negative volume inside another, left as it
    /// is: a cavity.
    pub cavities: ElementList<u32>,
    /// Sides of triangles that vertices in their middle lay along, without hanging together with them:
    /// the triangle was cut at these, which closed a hole without width.
    pub cracks_closed: ElementList<[u32; 2]>,
    /// Edges without length, collapsed.
    pub edges_collapsed: ElementList<[u32; 2]>,
    /// Polygons without area whose longest edge was exchanged.
    pub edges_exchanged: ElementList<u32>,
    /// Polygons without area dropped: at the boundary, or in a component without area.
    pub zero_area_dropped: ElementList<u32>,
    /// Polygons without area left in place, because every way out would change the topology.
    pub zero_area_left: ElementList<u32>,
    /// Polygons dropped because the small piece that they form only hung on a larger one.
    pub fins_dropped: ElementList<u32>,
}

impl RepairChanges {
    /// Whether the soup was a sound surface as it was. That polygons stand for triangles is no
    /// change, and notes ([`seams_left_open`](Self::seams_left_open), [`cavities`](Self::cavities),
    /// [`zero_area_left`](Self::zero_area_left)) are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let noted = Self {
            polygons_triangulated: self.polygons_triangulated,
            seams_left_open: self.seams_left_open.clone(),
            cavities: self.cavities.clone(),
            zero_area_left: self.zero_area_left.clone(),
            ..Self::default()
        };
        *self == noted
    }

    /// What is left of the changes without those that do not touch the surface: polygons cut into
    /// triangles, vertices without polygon, and notes.
    #[must_use]
    pub fn of_surface(&self) -> Self {
        Self {
            polygons_triangulated: 0,
            unused_vertices_dropped: ElementList::default(),
            seams_left_open: ElementList::default(),
            cavities: ElementList::default(),
            zero_area_left: ElementList::default(),
            ..self.clone()
        }
    }

    /// Whether the soup's own polygons still describe the surface, up to which of their vertices
    /// are one and which are several.
    #[must_use]
    pub fn keep_polygons(&self) -> bool {
        let joined_or_split = Self {
            vertices_welded: self.vertices_welded.clone(),
            vertices_joined: self.vertices_joined.clone(),
            edges_split: self.edges_split.clone(),
            vertices_split: self.vertices_split.clone(),
            edges_cut: self.edges_cut.clone(),
            ..Self::default()
        };
        self.of_surface() == joined_or_split
    }

    /// One sentence for each kind of change.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let triangulated = match self.polygons_triangulated {
            0 => None,
            1 => Some("1 polygon cut into triangles".into()),
            count => Some(format!("{count} polygons cut into triangles")),
        };
        let rows = self
            .cleaning()
            .into_iter()
            .chain(self.topology())
            .chain(self.orientation())
            .chain(self.degenerate());
        let sentences = rows.flatten().map(|sentence| sentence.text);
        triangulated.into_iter().chain(sentences).collect()
    }

    fn cleaning(&self) -> [Option<Sentence>; 6] {
        [
            of_vertices(
                &self.unused_vertices_dropped,
                "unused vertex dropped|unused vertices dropped",
            ),
            of_polygons(
                &self.non_finite_polygons_dropped,
                "polygon with a position that is not finite dropped|polygons with positions that are not finite dropped",
            ),
            of_polygons(
                &self.collapsed_polygons_dropped,
                "polygon with less than three different corners dropped|polygons with less than three different corners dropped",
            ),
            of_polygons(
                &self.repeated_corners_dropped,
                "polygon relieved of repeated corners|polygons relieved of repeated corners",
            ),
            of_vertices(
                &self.vertices_welded,
                "vertex welded to an earlier one at the same position|vertices welded to earlier ones at the same positions",
            ),
            of_vertices(
                &self.vertices_joined,
                "vertex of an open edge joined to an earlier one nearby|vertices of open edges joined to earlier ones nearby",
            ),
        ]
    }

    fn topology(&self) -> [Option<Sentence>; 5] {
        [
            of_edges(
                &self.seams_left_open,
                "pair of boundary edges at the same place left open as a cut|pairs of boundary edges at the same places left open as cuts",
            ),
            of_polygons(
                &self.duplicate_polygons_dropped,
                "duplicate polygon dropped|duplicate polygons dropped",
            ),
            of_edges(
                &self.edges_split,
                "edge with more than two faces split|edges with more than two faces split",
            ),
            of_vertices(
                &self.vertices_split,
                "vertex split into one for each fan of faces|vertices split into one for each fan of faces",
            ),
            of_edges(
                &self.edges_cut,
                "edge of a non-orientable piece cut|edges of non-orientable pieces cut",
            ),
        ]
    }

    fn orientation(&self) -> [Option<Sentence>; 3] {
        [
            of_polygons(
                &self.polygons_turned,
                "polygon turned to agree with its neighbours|polygons turned to agree with their neighbours",
            ),
            of_components(
                &self.components_turned,
                "closed component turned to face outward|closed components turned to face outward",
            ),
            of_components(
                &self.cavities,
                "closed component inside another left facing inward, as a cavity|closed components inside others left facing inward, as cavities",
            ),
        ]
    }

    fn degenerate(&self) -> [Option<Sentence>; 6] {
        [
            of_edges(
                &self.cracks_closed,
                "crack along an edge closed|cracks along edges closed",
            ),
            of_edges(
                &self.edges_collapsed,
                "edge without length collapsed|edges without length collapsed",
            ),
            of_polygons(
                &self.edges_exchanged,
                "polygon without area removed by exchanging an edge|polygons without area removed by exchanging an edge",
            ),
            of_polygons(
                &self.zero_area_dropped,
                "polygon without area dropped|polygons without area dropped",
            ),
            of_polygons(
                &self.zero_area_left,
                "polygon without area left in place|polygons without area left in place",
            ),
            of_polygons(
                &self.fins_dropped,
                "polygon of a small fin dropped|polygons of small fins dropped",
            ),
        ]
    }
}

impl Display for RepairChanges {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.sentences().join("\n"))
    }
}
