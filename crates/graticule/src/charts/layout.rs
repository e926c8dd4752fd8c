use glam::DVec2;
use serde::Serialize;

use super::arcs::TracedArcs;
use super::layout_borders::Borders;
use super::layout_corners::chart_sides;
use super::layout_unroll::Unrolling;
use super::nodes::ArcGraph;
use super::{ArcId, ChartId, LayoutError};
use crate::geometry::{face_areas, face_shapes};
use crate::mesh::disjoint_sets::{DisjointSets, number_names};
use crate::mesh::{
    Element, HalfedgeId, MeshError, PerCorner, PerEdge, PerFace, PerVertex, RefinedSurface,
    Surface, Topology, TriangleMesh, VertexId,
};
use crate::tolerance::LAYOUT_AREA;

/// What an arc is; of two along the same edge the larger counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum ArcKind {
    /// A line of the map.
    Line,
    /// A cut through a chart that was no disk.
    Cut,
    /// Along a feature of the surface.
    Feature,
    /// Along the boundary.
    Boundary,
}

/// The direction in which a chart passes an arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Direction {
    /// In the order of [`Arc::vertices`].
    Forward,
    /// Against it.
    Backward,
}

/// A border between two charts, or of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// The vertices of the refined surface along it, from node to node; two or more.
    pub vertices: Vec<VertexId>,
    /// What it is.
    pub kind: ArcKind,
}

/// What a chart is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum ChartKind {
    /// Four sides, and the map makes a rectangle of it, with positive triangles.
    Regular,
    /// Four sides, with triangles inside of which the map makes no rectangle.
    Singular,
    /// Another number of sides: three, or five and more.
    Polygonal,
}

/// A disk between arcs.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Its sides from corner to corner, counter-clockwise, each with the arcs along it; where a side
    /// has several, nodes between them are T-junctions.
    pub sides: Vec<Vec<(ArcId, Direction)>>,
    /// What it is.
    pub kind: ChartKind,
}

/// Arcs drawn on the edges of a refined surface: what a [`ChartLayout`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedNet {
    /// The refined surface.
    pub refined: RefinedSurface,
    /// What runs along each edge; the boundary is always an arc.
    pub edges: PerEdge<Option<ArcKind>>,
    /// Vertices that are nodes even where only two arcs meet, if a chart has a corner there.
    pub nodes: PerVertex<bool>,
    /// Coordinates in each triangle that has some, from one to the next the same up to a quarter
    /// turn and a shift. The unit is one chart.
    pub coordinates: PerCorner<Option<DVec2>>,
}

/// A surface cut along arcs into charts.
///
/// Held by construction: every chart is a disk whose border passes no vertex twice; each arc has a
/// chart on both sides, or one and lies on the boundary; nodes less arcs plus charts is the Euler
/// characteristic; no two arcs have the same ends, and none ends where it begins.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartLayout {
    refined: RefinedSurface,
    chart_of: PerFace<ChartId>,
    nodes: Vec<VertexId>,
    arcs: Vec<Arc>,
    charts: Vec<Chart>,
    coordinates: PerCorner<Option<DVec2>>,
}

impl ChartLayout {
    /// Finds nodes, arcs and charts of a net drawn on edges.
    ///
    /// Nodes are where three arcs or more meet, where the kind of an arc changes, the vertices marked
    /// as such where two do and a chart has a corner, and some more where a chart would have less than three or two arcs the
    /// same ends. A node is a corner of a chart where it sees the border turn by an eighth of a circle
    /// or more, in coordinates where there are some, else in space.
    ///
    /// Cost: linear.
    ///
    /// # Errors
    /// [`LayoutError`], but for [`LayoutError::Area`].
    pub fn new(net: EmbeddedNet) -> Result<Self, LayoutError> {
        check_counts(&net)?;
        let mesh = net.refined.surface.mesh();
        let edges = with_boundary(mesh, &net.edges);
        let graph = ArcGraph::of(&net, &edges)?;
        let traced = TracedArcs::of(&graph);
        let (chart_of, count) = flood(mesh, &edges);
        let borders = Borders::of(mesh, &edges, &chart_of, count)?;
        let mut charts: Vec<Chart> = (borders.walks.iter())
            .map(|walk| chart_sides(&net, &graph, &traced, walk))
            .collect();
        let mut unrolling = Unrolling::new(&net, &edges);
        for (index, chart) in charts.iter_mut().enumerate() {
            if chart.kind != ChartKind::Polygonal {
                let walk = corner_walk(&traced.arcs, chart, &borders.walks[index], mesh);
                chart.kind = unrolling.lay_out(&walk);
            }
        }
        let coordinates = unrolling.into_coordinates();
        let layout = Self {
            nodes: graph.nodes(),
            arcs: traced.arcs,
            charts,
            coordinates,
            chart_of,
            refined: net.refined,
        };
        layout.check_euler()?;
        Ok(layout)
    }

    /// The input refined: every arc is a chain of its edges.
    #[must_use]
    pub fn refined(&self) -> &RefinedSurface {
        &self.refined
    }

    /// The surface of [`refined`](Self::refined).
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.refined.surface
    }

    /// The chart of each triangle.
    #[must_use]
    pub fn chart_of(&self) -> &PerFace<ChartId> {
        &self.chart_of
    }

    /// The nodes, in ascending order.
    #[must_use]
    pub fn nodes(&self) -> &[VertexId] {
        &self.nodes
    }

    /// The arcs.
    #[must_use]
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// An arc.
    #[must_use]
    pub fn arc(&self, arc: ArcId) -> &Arc {
        &self.arcs[arc.index()]
    }

    /// The charts.
    #[must_use]
    pub fn charts(&self) -> &[Chart] {
        &self.charts
    }

    /// A chart.
    #[must_use]
    pub fn chart(&self, chart: ChartId) -> &Chart {
        &self.charts[chart.index()]
    }

    /// Coordinates of the corners of all triangles in regular charts; `None` in others.
    ///
    /// Each chart is laid out by itself: its first side runs from the origin along the first axis, the
    /// others follow counter-clockwise round a rectangle. The unit is one chart of the size asked for.
    #[must_use]
    pub fn coordinates(&self) -> &PerCorner<Option<DVec2>> {
        &self.coordinates
    }

    /// The refined vertices along a side of a chart, from corner to corner.
    #[must_use]
    pub fn side_vertices(&self, side: &[(ArcId, Direction)]) -> Vec<VertexId> {
        side_vertices(&self.arcs, side)
    }

    /// The share of charts that are not regular.
    #[must_use]
    pub fn singular_share(&self) -> f64 {
        let others = (self.charts.iter()).filter(|chart| chart.kind != ChartKind::Regular);
        others.count() as f64 / self.charts.len() as f64
    }

    /// Checks that the triangles cover each one of the input once, by their areas.
    ///
    /// # Errors
    /// [`LayoutError::Count`], [`LayoutError::Area`].
    pub fn check_areas(&self, input: &Surface) -> Result<(), LayoutError> {
        let expected = face_areas(&face_shapes(input));
        let found = face_areas(&face_shapes(self.surface()));
        let mut rest = expected.clone();
        for (face, area) in found.enumerate() {
            let origin = self.refined.face_origin[face].index();
            let Some(rest) = rest.as_mut_slice().get_mut(origin) else {
                let (given, needed) = (expected.len(), origin + 1);
                let what = "triangles of the input";
                return Err(LayoutError::Count {
                    what,
                    given,
                    needed,
                });
            };
            *rest -= area;
        }
        let total: f64 = expected.iter().sum();
        let share = rest.iter().map(|rest| rest.abs()).sum::<f64>() / total;
        if share <= LAYOUT_AREA {
            Ok(())
        } else {
            Err(LayoutError::Area { share })
        }
    }

    /// The same layout on a surface with the same triangles as the one refined.
    pub(super) fn carried_to(self, input: &Surface) -> Result<Self, MeshError> {
        Ok(Self {
            refined: self.refined.carried_to(input)?,
            ..self
        })
    }

    fn check_euler(&self) -> Result<(), LayoutError> {
        let whole = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        let expected = Topology::of(self.surface().mesh())
            .total
            .euler_characteristic;
        let found = whole(self.nodes.len()) - whole(self.arcs.len()) + whole(self.charts.len());
        if found == expected {
            Ok(())
        } else {
            Err(LayoutError::EulerCharacteristic { found, expected })
        }
    }
}

fn check_counts(net: &EmbeddedNet) -> Result<(), LayoutError> {
    let mesh = net.refined.surface.mesh();
    let counts = [
        (
            "triangles of the input",
            net.refined.face_origin.len(),
            mesh.face_count(),
        ),
        (
            "places on the input",
            net.refined.vertex_origin.len(),
            mesh.vertex_count(),
        ),
        ("kinds of edges", net.edges.len(), mesh.edge_count()),
        ("marks of nodes", net.nodes.len(), mesh.vertex_count()),
        ("coordinates", net.coordinates.len(), mesh.halfedge_count()),
    ];
    match counts
        .into_iter()
        .find(|(_, given, needed)| given != needed)
    {
        Some((what, given, needed)) => Err(LayoutError::Count {
            what,
            given,
            needed,
        }),
        None => Ok(()),
    }
}

/// The kinds of all edges, with the boundary among them.
fn with_boundary(
    mesh: &TriangleMesh,
    edges: &PerEdge<Option<ArcKind>>,
) -> PerEdge<Option<ArcKind>> {
    PerEdge::from_fn(mesh.edge_count(), |edge| {
        if mesh.is_boundary_edge(edge) {
            Some(ArcKind::Boundary)
        } else {
            edges[edge]
        }
    })
}

/// The chart of each triangle, and how many charts there are.
fn flood(mesh: &TriangleMesh, edges: &PerEdge<Option<ArcKind>>) -> (PerFace<ChartId>, usize) {
    let mut sets = DisjointSets::new(mesh.face_count());
    for edge in mesh.edges().filter(|&edge| edges[edge].is_none()) {
        let side = mesh.edge_halfedge(edge);
        if let Some(twin) = mesh.twin(side) {
            sets.join(side.face().0, twin.face().0);
        }
    }
    let mut names = sets.into_names();
    let count = number_names(&mut names);
    (
        PerFace::new(names.into_iter().map(ChartId).collect()),
        count,
    )
}

fn side_vertices(arcs: &[Arc], side: &[(ArcId, Direction)]) -> Vec<VertexId> {
    let mut vertices: Vec<VertexId> = Vec::new();
    for &(arc, direction) in side {
        let along = &arcs[arc.index()].vertices;
        vertices.pop();
        match direction {
            Direction::Forward => vertices.extend(along),
            Direction::Backward => vertices.extend(along.iter().rev()),
        }
    }
    vertices
}

/// The halfedges along each side of a chart; its border starts anywhere.
fn corner_walk(
    arcs: &[Arc],
    chart: &Chart,
    border: &[HalfedgeId],
    mesh: &TriangleMesh,
) -> Vec<Vec<HalfedgeId>> {
    let lengths = (chart.sides.iter()).map(|side| {
        let pieces = side
            .iter()
            .map(|(arc, _)| arcs[arc.index()].vertices.len() - 1);
        pieces.sum::<usize>()
    });
    let start = side_vertices(arcs, &chart.sides[0])[0];
    let first = (border.iter()).position(|&side| mesh.origin(side) == start);
    let mut rest = (border.iter().cycle()).skip(first.unwrap_or(0)).copied();
    lengths
        .map(|length| rest.by_ref().take(length).collect())
        .collect()
}
