//! Vertices by their numbers in the file, in what the user tells and in what errors tell.

use graticule::flatten::{BoundaryError, FlattenError, Patch};
use graticule::mesh::{
    FaceId, HalfedgeId, NO_VALUE, PerVertex, PolygonSoup, Repaired, SurfacePoint, VertexId,
};
use graticule::solve::SolveError;

use super::piece::Piece;
use super::told::Point;
use crate::failure::Failure;

/// Why there is no map: not yet in the words of the command where it comes from the library.
pub(super) enum Refusal {
    Map(FlattenError),
    Boundary(BoundaryError),
    Told(Failure),
}

impl From<FlattenError> for Refusal {
    fn from(error: FlattenError) -> Self {
        Self::Map(error)
    }
}

impl From<BoundaryError> for Refusal {
    fn from(error: BoundaryError) -> Self {
        Self::Boundary(error)
    }
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        Self::Told(failure)
    }
}

/// The way from the numbers of vertices in the file to the patch.
pub(super) struct FileVertices<'a> {
    of_surface: Vec<u32>,
    of_file: &'a PerVertex<u32>,
    piece: &'a Piece,
}

impl<'a> FileVertices<'a> {
    pub(super) fn of(soup: &PolygonSoup, repaired: &'a Repaired, piece: &'a Piece) -> Self {
        Self {
            of_surface: repaired.mesh_vertices(soup),
            of_file: &repaired.vertex_sources,
            piece,
        }
    }

    /// The number in the file of a vertex of the patch.
    fn number(&self, vertex: VertexId) -> u32 {
        self.of_file[self.piece.source(vertex)]
    }

    /// The error in the words of the command: vertices by their numbers in the file, methods by
    /// their options.
    pub(super) fn told(&self, refusal: Refusal) -> Failure {
        match refusal {
            Refusal::Map(error) => self.map_told(error),
            Refusal::Boundary(error) => self.boundary_told(error),
            Refusal::Told(failure) => failure,
        }
    }

    fn map_told(&self, error: FlattenError) -> Failure {
        let hint = match error {
            FlattenError::SamePin { vertex } => {
                return Failure::new(
                    format!("both pins are vertex {} of the file", self.number(vertex)),
                    "they lie at one place and were welded: pin another, or see --weld",
                );
            }
            FlattenError::Undetermined { .. } | FlattenError::Collapsed { .. } => {
                "name other vertices with --pin, or use --method spectral"
            }
            FlattenError::TooThin { .. } => {
                "take no more than 60000 vertices, or use --method fixed"
            }
            FlattenError::Geometry(_) => "use --intrinsic-delaunay",
            FlattenError::Solve(ref reason @ SolveError::OutOfMemory { .. }) => {
                return reason.clone().into();
            }
            FlattenError::Solve(reason) => {
                return Failure::new(
                    format!("the equations of the map could not be solved: {reason}"),
                    "try --intrinsic-delaunay, or --method fixed --weights mean-value",
                );
            }
            other => return other.into(),
        };
        Failure::new(error.to_string(), hint)
    }

    fn boundary_told(&self, error: BoundaryError) -> Failure {
        match error {
            BoundaryError::Missing { vertex } => Failure::new(
                format!(
                    "vertex {} of the file lies on the outer boundary and has no texture coordinates",
                    self.number(vertex)
                ),
                "give all of the boundary texture coordinates, or choose a curve: --boundary circle",
            ),
            BoundaryError::BadCorner { vertex, reason, .. } => Failure::new(
                format!("vertex {} of the file {reason}", self.number(vertex)),
                "name four different vertices of the outer boundary with --corner",
            ),
            BoundaryError::TooFewVertices { .. } => {
                Failure::new(error.to_string(), "use --boundary circle")
            }
            other => other.into(),
        }
    }

    /// The vertex of the patch with a number in the file.
    pub(super) fn find(&self, number: u32) -> Result<VertexId, Failure> {
        let vertices = self.of_surface.len();
        let Some(&vertex) = self.of_surface.get(number as usize) else {
            return Err(Failure::new(
                format!("there is no vertex {number}: the file has {vertices}, from 0 on"),
                "vertices are numbered from 0 in the order of the file",
            ));
        };
        let on_patch = (vertex != NO_VALUE)
            .then(|| self.piece.vertex(VertexId(vertex)))
            .flatten();
        on_patch.ok_or_else(|| {
            Failure::new(
                format!("vertex {number} of the file is no part of the patch"),
                "choose a vertex of a polygon of the patch; 'graticule info' tells what repair drops",
            )
        })
    }

    /// The point of the patch that is a mean of vertices of the file.
    pub(super) fn point(&self, point: &Point, patch: &Patch) -> Result<SurfacePoint, Failure> {
        let mesh = patch.mesh();
        let terms = point.0.iter();
        let terms = terms.map(|&(number, weight)| Ok((self.find(number)?, weight)));
        let terms: Vec<(VertexId, f64)> = terms.collect::<Result<_, Failure>>()?;
        let Some(&(first, _)) = terms.first() else {
            return Err(Failure::new(
                "a point has no vertex",
                "name one to three vertices",
            ));
        };
        let mut faces = mesh.outgoing(first).map(HalfedgeId::face);
        let holds = |face: &FaceId| {
            let corners = mesh.triangle(*face);
            terms.iter().all(|(vertex, _)| corners.contains(vertex))
        };
        let Some(face) = faces.find(holds) else {
            let numbers: Vec<u32> = point.0.iter().map(|term| term.0).collect();
            return Err(Failure::new(
                format!("no triangle has all of the vertices {numbers:?} of the file"),
                "name vertices of one triangle",
            ));
        };
        let weight = |corner: VertexId| -> f64 {
            let own = terms.iter().filter(|(vertex, _)| *vertex == corner);
            own.map(|(_, weight)| weight).sum()
        };
        Ok(SurfacePoint {
            face,
            barycentric: mesh.triangle(face).map(weight),
        })
    }
}
