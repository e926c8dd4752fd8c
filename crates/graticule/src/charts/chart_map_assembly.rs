//! The squares of all charts put together to one surface.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::chart_map::{ChartMaps, ChartSquare, Seam, SeamKey, SeamSide};
use super::chart_map_squares::{MappedSquare, SidePiece};
use super::split::{ChartPlan, PlannedShape};
use super::split_mesh::{TriangleOrigin, VertexName};
use super::{ChartId, ChartLayout, ChartMapError, SquareId};
use crate::mesh::{
    Element, PerCorner, PerFace, PerVertex, RefinedSurface, Surface, SurfacePoint, VertexId,
};
use crate::watch::Watch;

/// A surface that squares are added to.
#[derive(Default)]
pub(super) struct Assembly {
    /// The vertices that charts share come first; each is known once a square with it was added.
    vertices: Vec<Option<(DVec3, SurfacePoint)>>,
    triangles: Vec<[u32; 3]>,
    origins: Vec<TriangleOrigin>,
    square_of: Vec<SquareId>,
    coordinates: Vec<DVec2>,
    squares: Vec<ChartSquare>,
    seams: BTreeMap<SeamKey, Seam>,
    /// Charts that were to be split and were not.
    unsplit: usize,
}

impl Assembly {
    /// Nothing yet, with the number of vertices that charts share.
    pub(super) fn new(shared: usize) -> Self {
        Self {
            vertices: vec![None; shared],
            ..Self::default()
        }
    }

    /// Adds the squares of a chart, as many as planned or the whole chart on one.
    pub(super) fn add(&mut self, chart: ChartId, squares: Vec<MappedSquare>, plan: &ChartPlan) {
        let is_unsplit = matches!(plan.shape, PlannedShape::Split { .. }) && squares.len() == 1;
        self.unsplit += usize::from(is_unsplit);
        let keeps_net = plan.keeps_net && !is_unsplit;
        let first_made = self.vertices.len() as u32;
        let made = squares
            .iter()
            .map(|square| square.disk.made_count())
            .max()
            .unwrap_or(0);
        self.vertices
            .resize(self.vertices.len() + made as usize, None);
        let number = |name: VertexName| match name {
            VertexName::Shared(vertex) => vertex,
            VertexName::Made(count) => first_made + count,
        };
        for square in squares {
            let numbers: Vec<u32> = square.disk.names.iter().map(|&name| number(name)).collect();
            self.add_square(chart, &square, &numbers, keeps_net);
        }
    }

    fn add_square(
        &mut self,
        chart: ChartId,
        square: &MappedSquare,
        numbers: &[u32],
        keeps_net: bool,
    ) {
        let id = SquareId::from_index(self.squares.len());
        let first = self.triangles.len() as u32;
        for (triangle, origin) in square.disk.triangles.iter().zip(&square.disk.origins) {
            for (&vertex, &barycentric) in triangle.iter().zip(&origin.corners) {
                let vertex = vertex as usize;
                let point = SurfacePoint {
                    face: origin.face,
                    barycentric,
                };
                let position = square.disk.positions[vertex];
                self.vertices[numbers[vertex] as usize].get_or_insert((position, point));
                self.coordinates.push(square.places[vertex]);
            }
            self.triangles
                .push(triangle.map(|vertex| numbers[vertex as usize]));
            self.origins.push(*origin);
            self.square_of.push(id);
        }
        self.squares.push(ChartSquare {
            chart,
            method: square.method,
            size: square.size,
            faces: first..self.triangles.len() as u32,
            keeps_net,
        });
        for (side, pieces) in (0_u8..).zip(&square.sides) {
            for piece in pieces {
                self.add_seam(id, side, piece, numbers);
            }
        }
    }

    fn add_seam(&mut self, square: SquareId, side: u8, piece: &SidePiece, numbers: &[u32]) {
        let mut vertices: Vec<VertexId> = piece
            .vertices
            .iter()
            .map(|&v| VertexId(numbers[v as usize]))
            .collect();
        let mut shares = piece.shares;
        if piece.is_reversed {
            vertices.reverse();
            shares.reverse();
        }
        let seam = self.seams.entry(piece.key).or_insert(Seam {
            vertices,
            sides: [None; 2],
        });
        seam.sides[usize::from(piece.is_reversed)] = Some(SeamSide {
            square,
            side,
            shares,
        });
    }

    /// Tells of charts that were not split.
    pub(super) fn warn(&self, watch: &Watch) {
        if self.unsplit > 0 {
            let message = format!(
                "double precision does not suffice to split {} charts from their centres: each was laid on \
                 one square",
                self.unsplit
            );
            watch.warn("charts-not-split", message);
        }
    }

    /// The maps, with the places of the layout's own vertices as it has them.
    pub(super) fn finish(self, layout: &ChartLayout) -> Result<ChartMaps, ChartMapError> {
        let (positions, mut points): (Vec<_>, Vec<_>) = self.vertices.into_iter().flatten().unzip();
        for (point, known) in points.iter_mut().zip(&layout.refined().vertex_origin) {
            *point = *known;
        }
        Ok(ChartMaps {
            refined: RefinedSurface {
                surface: Surface::from_triangles(positions, &self.triangles)?,
                face_origin: PerFace::new(self.origins.iter().map(|origin| origin.face).collect()),
                vertex_origin: PerVertex::new(points),
            },
            square_of: PerFace::new(self.square_of),
            coordinates: PerCorner::new(self.coordinates),
            squares: self.squares,
            seams: self.seams.into_values().collect(),
        })
    }
}
