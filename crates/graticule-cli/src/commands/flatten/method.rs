//! From the options to the library's methods.

use glam::DVec2;
use graticule::flatten::{
    BoundaryCurve, BoundaryError, BoundaryPositions, Corners, FixedOptions, FlatMap, FlattenError,
    Holes, NaturalOptions, Patch, Pins, Triangulation, Weights, boundary_on_curve, fixed_map,
    natural_map, spectral_map,
};
use graticule::mesh::{NO_VALUE, PerVertex, PolygonSoup, Repaired, VertexId};
use graticule::solve::SolveError;
use graticule::watch::Watch;

use super::options::{Boundary, HolesArgument, Method, Options, WeightsArgument};
use super::piece::Piece;
use crate::failure::Failure;

/// The map that the options ask for.
pub(super) fn flat_map(
    options: &Options,
    soup: &PolygonSoup,
    repaired: &Repaired,
    piece: &Piece,
    watch: &Watch,
) -> Result<FlatMap, Failure> {
    let patch = Patch::new(piece.surface.clone(), watch)?;
    let file = FileVertices {
        of_surface: repaired.mesh_vertices(soup),
        of_file: &repaired.vertex_sources,
        piece,
    };
    let told = |error| file.told(error);
    match options.method {
        Method::Natural => {
            natural_map(&patch, &natural_options(options, &file)?, watch).map_err(told)
        }
        Method::Spectral => spectral_map(&patch, triangulation(options), watch).map_err(told),
        Method::Fixed => {
            let boundary = match options.boundary {
                Some(Boundary::Given) => {
                    let places = given_places(options, &patch, soup, repaired, piece, watch)?;
                    BoundaryPositions::new(&patch, places)
                }
                _ => boundary_on_curve(&patch, &curve(options, &patch, &file)?, watch),
            };
            let boundary = boundary.map_err(|error| file.boundary_told(error))?;
            fixed_map(&patch, &boundary, &fixed_options(options), watch).map_err(told)
        }
    }
}

/// The way from the numbers of vertices in the file to the patch.
struct FileVertices<'a> {
    of_surface: Vec<u32>,
    of_file: &'a PerVertex<u32>,
    piece: &'a Piece,
}

impl FileVertices<'_> {
    /// The number in the file of a vertex of the patch.
    fn number(&self, vertex: VertexId) -> u32 {
        self.of_file[self.piece.source(vertex)]
    }

    /// The error in the words of the command: vertices by their numbers in the file, methods by
    /// their options.
    fn told(&self, error: FlattenError) -> Failure {
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
                "use --method natural with up to 60000 vertices, or --method fixed"
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

    fn find(&self, number: u32) -> Result<VertexId, Failure> {
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
}

fn triangulation(options: &Options) -> Triangulation {
    if options.intrinsic_delaunay {
        Triangulation::IntrinsicDelaunay
    } else {
        Triangulation::Given
    }
}

fn natural_options(options: &Options, file: &FileVertices<'_>) -> Result<NaturalOptions, Failure> {
    let pins = match options.pin[..] {
        [first, second] => Pins::At([
            (file.find(first.vertex)?, first.place),
            (file.find(second.vertex)?, second.place),
        ]),
        _ => Pins::Farthest,
    };
    Ok(NaturalOptions {
        pins,
        triangulation: triangulation(options),
    })
}

fn fixed_options(options: &Options) -> FixedOptions {
    FixedOptions {
        weights: match options.weights {
            Some(WeightsArgument::MeanValue) => Weights::MeanValue,
            Some(WeightsArgument::Uniform) => Weights::Uniform,
            _ if options.intrinsic_delaunay => Weights::DelaunayCotangent,
            _ => Weights::Cotangent,
        },
        holes: match options.holes {
            Some(HolesArgument::Natural) => Holes::Natural,
            Some(HolesArgument::Filled) => Holes::Closed,
            Some(HolesArgument::Fixed) | None => Holes::default(),
        },
    }
}

fn curve(
    options: &Options,
    patch: &Patch,
    file: &FileVertices<'_>,
) -> Result<BoundaryCurve, Failure> {
    let corners = match options.corner[..] {
        [a, b, c, d] => Corners::At([
            corner(a, patch, file)?,
            corner(b, patch, file)?,
            corner(c, patch, file)?,
            corner(d, patch, file)?,
        ]),
        _ => Corners::Automatic,
    };
    Ok(match options.boundary {
        Some(Boundary::Square) => BoundaryCurve::Square(corners),
        Some(Boundary::Rectangle) => BoundaryCurve::Rectangle {
            aspect: options.aspect,
            corners,
        },
        _ => BoundaryCurve::Circle,
    })
}

/// A corner by its number in the file, which an error must name rather than that in the patch.
fn corner(number: u32, patch: &Patch, file: &FileVertices<'_>) -> Result<VertexId, Failure> {
    let vertex = file.find(number)?;
    let mut outer = patch.loop_vertices(patch.outer_loop());
    if outer.any(|on_loop| on_loop == vertex) {
        return Ok(vertex);
    }
    Err(Failure::new(
        format!("vertex {number} of the file is not on the outer boundary loop"),
        "choose four different vertices of the outer boundary",
    ))
}

/// Where the file's own texture coordinates put the boundary: the outer loop, and the holes if the
/// options fix them.
fn given_places(
    options: &Options,
    patch: &Patch,
    soup: &PolygonSoup,
    repaired: &Repaired,
    piece: &Piece,
    watch: &Watch,
) -> Result<Vec<(VertexId, DVec2)>, Failure> {
    let Some(set) = soup.attributes.uv_sets.first() else {
        return Err(Failure::new(
            "the mesh has no texture coordinates to take the boundary from",
            "choose a curve: --boundary circle, square or rectangle",
        ));
    };
    let mut places = PerVertex::filled(patch.mesh().vertex_count(), None);
    let mut has_several = PerVertex::filled(patch.mesh().vertex_count(), false);
    for (corner, &source) in repaired.corner_sources.enumerate() {
        let vertex = piece.vertex(repaired.surface.mesh().origin(corner));
        if let (Some(vertex), Some(place)) = (vertex, set.get(source as usize)) {
            has_several[vertex] |= *places[vertex].get_or_insert(place) != place;
        }
    }
    let holes = patch.holes().flat_map(|hole| patch.loop_vertices(hole));
    let holes = holes.filter(|_| options.holes == Some(HolesArgument::Fixed));
    let outer = patch.loop_vertices(patch.outer_loop());
    let vertices: Vec<_> = outer.chain(holes).collect();
    let several = vertices.iter().filter(|&&v| has_several[v]).count();
    if several > 0 {
        let message = format!(
            "boundary vertices with several texture coordinates: {several}; the first is taken"
        );
        watch.warn("several-coordinates", message);
    }
    let vertices = vertices.into_iter();
    Ok(vertices
        .filter_map(|vertex| Some((vertex, places[vertex]?)))
        .collect())
}
