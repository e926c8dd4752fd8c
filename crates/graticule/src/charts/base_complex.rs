use glam::DVec2;
use serde::Serialize;

use super::layout_transition::ChartTransition;
use super::{ArcId, ArcKind, ChartId, ChartLayout, Direction};
use crate::mesh::{Element, HalfedgeId, Polygons, VertexId};
use crate::quads::PolygonMesh;

/// What lies beyond one arc of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChartNeighbor {
    /// The arc, by its number.
    #[serde(serialize_with = "arc_number")]
    pub arc: ArcId,
    /// How the chart passes it.
    pub direction: Direction,
    /// The side of the chart that it is part of.
    pub side: usize,
    /// The chart beyond; `None` on the boundary.
    #[serde(serialize_with = "chart_number")]
    pub chart: Option<ChartId>,
    /// How coordinates of the chart become those of the chart beyond; `None` unless both are regular.
    pub transition: Option<ChartTransition>,
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn arc_number<S: serde::Serializer>(arc: &ArcId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(arc.0)
}

#[allow(
    clippy::ref_option,
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn chart_number<S: serde::Serializer>(
    chart: &Option<ChartId>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    chart.map(|chart| chart.0).serialize(serializer)
}

/// The polygon mesh of the charts of a layout, and how they meet ([PGP06] Fig. 1F).
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Debug, PartialEq)]
pub struct BaseComplex {
    /// Nodes as vertices, charts as polygons, both in the order of the layout; T-junctions are corners
    /// of polygons too.
    pub mesh: PolygonMesh,
    /// What lies beyond the arcs of each chart, counter-clockwise: the arc number `i` leads from vertex
    /// `i` of the polygon to the next.
    pub neighbors: Vec<Vec<ChartNeighbor>>,
    /// The number of arcs.
    pub arcs: usize,
}

impl BaseComplex {
    /// Vertices less arcs plus polygons.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let counts = [
            self.mesh.positions.len(),
            self.arcs,
            self.mesh.polygons.len(),
        ];
        let [nodes, arcs, charts] = counts.map(|count| i64::try_from(count).unwrap_or(i64::MAX));
        nodes - arcs + charts
    }

    /// How many arcs meet at each vertex.
    #[must_use]
    pub fn valences(&self) -> Vec<u32> {
        let mut valences = vec![0; self.mesh.positions.len()];
        for (polygon, neighbors) in self.neighbors.iter().enumerate() {
            let vertices = self.mesh.polygons.vertices(polygon);
            for (index, neighbor) in neighbors.iter().enumerate() {
                valences[vertices[index] as usize] += 1;
                if neighbor.chart.is_none() {
                    valences[vertices[(index + 1) % vertices.len()] as usize] += 1;
                }
            }
        }
        valences
    }
}

/// The base complex of a layout. Linear.
#[must_use]
pub fn base_complex(layout: &ChartLayout) -> BaseComplex {
    let mut numbers = vec![0_u32; layout.surface().mesh().vertex_count()];
    for (number, node) in (0_u32..).zip(layout.nodes()) {
        numbers[node.index()] = number;
    }
    let number = |vertex: VertexId| numbers[vertex.index()];
    let beside = sides_of_arcs(layout);
    let mut polygons = Polygons::default();
    let mut neighbors = Vec::with_capacity(layout.charts().len());
    let mut corners = Vec::new();
    for chart in layout.charts() {
        corners.clear();
        let mut around = Vec::new();
        for (side, arcs) in chart.sides.iter().enumerate() {
            for &(arc, direction) in arcs {
                corners.push(number(first_vertex(layout, arc, direction)));
                around.push(neighbor(layout, &beside, [side, arc.index()], direction));
            }
        }
        polygons.push(&corners);
        neighbors.push(around);
    }
    let ends = |vertices: &[VertexId]| {
        let [from, to] = [vertices[0], vertices[vertices.len() - 1]].map(number);
        [from.min(to), from.max(to)]
    };
    let features = layout
        .arcs()
        .iter()
        .filter(|arc| arc.kind == ArcKind::Feature);
    let mut feature_edges: Vec<_> = features.map(|arc| ends(&arc.vertices)).collect();
    feature_edges.sort_unstable();
    let nodes = layout.nodes().iter();
    BaseComplex {
        mesh: PolygonMesh {
            positions: nodes
                .clone()
                .map(|&node| layout.surface().position(node))
                .collect(),
            polygons,
            origins: nodes
                .map(|&node| layout.refined().vertex_origin[node])
                .collect(),
            feature_edges,
        },
        neighbors,
        arcs: layout.arcs().len(),
    }
}

fn first_vertex(layout: &ChartLayout, arc: ArcId, direction: Direction) -> VertexId {
    let vertices = &layout.arc(arc).vertices;
    match direction {
        Direction::Forward => vertices[0],
        Direction::Backward => vertices[vertices.len() - 1],
    }
}

/// For each arc the first halfedge on its left, and on its right.
type Beside = Vec<[Option<HalfedgeId>; 2]>;

fn sides_of_arcs(layout: &ChartLayout) -> Beside {
    let mesh = layout.surface().mesh();
    let left = |from: VertexId, to: VertexId| {
        mesh.outgoing(from)
            .find(|&halfedge| mesh.destination(halfedge) == to)
    };
    layout
        .arcs()
        .iter()
        .map(|arc| {
            let [from, to] = [arc.vertices[0], arc.vertices[1]];
            [left(from, to), left(to, from)]
        })
        .collect()
}

fn neighbor(
    layout: &ChartLayout,
    beside: &Beside,
    [side, arc]: [usize; 2],
    direction: Direction,
) -> ChartNeighbor {
    let [left, right] = beside[arc];
    let [own, other] = match direction {
        Direction::Forward => [left, right],
        Direction::Backward => [right, left],
    };
    let points = |halfedge: HalfedgeId| -> Option<[DVec2; 2]> {
        let [from, to] = [halfedge, halfedge.next()].map(|c| layout.coordinates()[c]);
        Some([from?, to?])
    };
    let transition = own.zip(other).and_then(|(own, other)| {
        let [to, from] = points(other)?;
        Some(ChartTransition::between(points(own)?, [from, to]).rounded())
    });
    ChartNeighbor {
        arc: ArcId::from_index(arc),
        direction,
        side,
        chart: other.map(|halfedge| layout.chart_of()[halfedge.face()]),
        transition,
    }
}
