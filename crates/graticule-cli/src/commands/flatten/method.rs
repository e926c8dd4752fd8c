//! From the options to the library's methods.

use glam::DVec2;
use graticule::flatten::{
    BoundaryCurve, BoundaryPositions, Corners, FixedOptions, FlatMap, Holes, NaturalOptions, Patch,
    Pins, Triangulation, Weights, boundary_on_curve, fixed_map, natural_map, spectral_map,
};
use graticule::mesh::{NO_VALUE, PolygonSoup, Repaired, VertexId};
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
        piece,
    };
    match options.method {
        Method::Natural => Ok(natural_map(
            &patch,
            &natural_options(options, &file)?,
            watch,
        )?),
        Method::Spectral => Ok(spectral_map(&patch, triangulation(options), watch)?),
        Method::Fixed => {
            let boundary = match options.boundary {
                Some(Boundary::Given) => given_boundary(options, &patch, soup, repaired, piece)?,
                _ => boundary_on_curve(&patch, &curve(options, &patch, &file)?, watch)?,
            };
            Ok(fixed_map(
                &patch,
                &boundary,
                &fixed_options(options),
                watch,
            )?)
        }
    }
}

/// The way from the numbers of vertices in the file to the patch.
struct FileVertices<'a> {
    of_surface: Vec<u32>,
    piece: &'a Piece,
}

impl FileVertices<'_> {
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

/// The boundary where the file's own texture coordinates put it: the outer loop, and the holes if
/// the options fix them.
fn given_boundary(
    options: &Options,
    patch: &Patch,
    soup: &PolygonSoup,
    repaired: &Repaired,
    piece: &Piece,
) -> Result<BoundaryPositions, Failure> {
    let Some(set) = soup.attributes.uv_sets.first() else {
        return Err(Failure::new(
            "the mesh has no texture coordinates to take the boundary from",
            "choose a curve: --boundary circle, square or rectangle",
        ));
    };
    let mut places: Vec<Option<DVec2>> = vec![None; patch.mesh().vertex_count()];
    for (corner, &source) in repaired.corner_sources.enumerate() {
        let vertex = piece.vertex(repaired.surface.mesh().origin(corner));
        if let (Some(vertex), Some(place)) = (vertex, set.get(source as usize)) {
            places[vertex.0 as usize].get_or_insert(place);
        }
    }
    let holes = patch.holes().flat_map(|hole| patch.loop_vertices(hole));
    let holes = holes.filter(|_| options.holes == Some(HolesArgument::Fixed));
    let vertices = patch.loop_vertices(patch.outer_loop()).chain(holes);
    let placed = vertices.filter_map(|vertex| Some((vertex, places[vertex.0 as usize]?)));
    Ok(BoundaryPositions::new(patch, placed)?)
}
