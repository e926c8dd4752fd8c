//! Charts as images of positions and normals (Gu, Gortler, Hoppe 2002).

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::SquareId;
use super::chart_map::ChartMaps;
use super::texture_raster::TriangleRaster;
use crate::geometry::{face_areas, face_normals, face_shapes};
use crate::mesh::{Element, PerFace, PerVertex};
use crate::watch::{Stopped, Watch};

/// Points of a square at whole steps, those on its border included, so that images of neighbours
/// have the same values along their seams.
#[derive(Clone, Debug, PartialEq)]
pub struct GeometryImage {
    /// Points along each side, 2 or more.
    pub side: u32,
    /// Positions, row by row from the top left corner (0, 1) of the square.
    pub positions: Vec<DVec3>,
    /// Unit normals, in the same order.
    pub normals: Vec<DVec3>,
}

/// The image of each square with `side` points along its sides, at least 2.
///
/// Cost: linear in triangles and points; squares are sampled in parallel.
///
/// # Errors
/// [`Stopped`].
pub fn geometry_images(
    maps: &ChartMaps,
    side: u32,
    watch: &Watch,
) -> Result<Vec<GeometryImage>, Stopped> {
    let _stage = watch.stage("geometry images");
    let normals = surface_normals(maps);
    let squares = (0..maps.squares().len()).into_par_iter().map(|square| {
        watch.check()?;
        Ok(image(
            maps,
            SquareId::from_index(square),
            &normals,
            side.max(2),
        ))
    });
    squares.collect()
}

/// The unit normal of each vertex, weighted by angles.
///
/// Cutting leaves needles, the normals of which are rounding: parts of one triangle of the input
/// have its normal, the mean of theirs by area.
fn surface_normals(maps: &ChartMaps) -> PerVertex<DVec3> {
    let (surface, origins) = (maps.surface(), &maps.refined().face_origin);
    let mesh = surface.mesh();
    let shapes = face_shapes(surface);
    let count = origins.iter().map(|face| face.index() + 1).max();
    let mut of_input = PerFace::filled(count.unwrap_or(0), DVec3::ZERO);
    let areas = face_areas(&shapes);
    for (face, &normal) in face_normals(surface).enumerate() {
        of_input[origins[face]] += normal * areas[face];
    }
    let of_input = of_input.map(|sum| sum.normalize_or_zero());
    let mut sums = PerVertex::filled(mesh.vertex_count(), DVec3::ZERO);
    for (face, shape) in shapes.enumerate() {
        for (vertex, angle) in mesh.triangle(face).into_iter().zip(shape.angles()) {
            sums[vertex] += of_input[origins[face]] * angle;
        }
    }
    sums.map(|sum| sum.normalize_or_zero())
}

fn image(
    maps: &ChartMaps,
    square: SquareId,
    normals: &PerVertex<DVec3>,
    side: u32,
) -> GeometryImage {
    let mut raster = TriangleRaster::new(side, side);
    let steps = f64::from(side - 1);
    for face in maps.faces_of(square) {
        // Rows go down while the square's second axis goes up: corners keep their turn when the
        // second and third change places.
        let [a, b, c] = face.halfedges().map(|corner| maps.coordinates()[corner]);
        let point = |place: DVec2| DVec2::new(place.x, 1.0 - place.y) * steps;
        raster.draw(face, [a, c, b].map(point));
    }
    let mut image = GeometryImage {
        side,
        positions: Vec::new(),
        normals: Vec::new(),
    };
    let mut last = (DVec3::ZERO, DVec3::Z);
    for point in raster.into_points() {
        // The triangles cover the square, so that each point lies on one.
        if let Some(point) = point {
            let [a, c, b] = point.weights;
            let weights = [a, b, c];
            let corners = maps.surface().mesh().triangle(point.face);
            let mean = |values: &PerVertex<DVec3>| -> DVec3 {
                corners
                    .iter()
                    .zip(weights)
                    .map(|(&v, weight)| values[v] * weight)
                    .sum()
            };
            last = (
                mean(maps.surface().positions()),
                mean(normals).normalize_or(last.1),
            );
        }
        image.positions.push(last.0);
        image.normals.push(last.1);
    }
    image
}
