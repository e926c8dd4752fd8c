//! Normals in the frame of texture coordinates.

use glam::{DVec2, DVec3};

use super::atlas::ChartAtlas;
use super::chart_map::ChartMaps;
use super::texture::SourceTexture;
use crate::mesh::FaceId;

/// How the directions of one set of texture coordinates turn into those of another, in the plane of
/// a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TangentTurn {
    /// The source's first and second direction in the target's.
    first: DVec2,
    second: DVec2,
}

impl TangentTurn {
    /// The turn from the source's directions in a triangle of the input to the atlas's in a triangle
    /// that is part of it; `None` where one has no directions.
    pub(super) fn between(
        source: &SourceTexture<'_>,
        input_face: FaceId,
        maps: &ChartMaps,
        atlas: &ChartAtlas,
        face: FaceId,
    ) -> Option<Self> {
        let corners = input_face.halfedges().map(|corner| source.uvs[corner]);
        let [Some(a), Some(b), Some(c)] = corners else {
            return None;
        };
        let positions = source.input.corner_positions(input_face);
        let (tangent, mirror) = tangent(positions, [a, b, c])?;
        let target = face.halfedges().map(|corner| atlas.corner_uv[corner]);
        let (along, _) = self::tangent(maps.surface().corner_positions(face), target)?;
        let normal = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
        let across = normal.normalize_or_zero().cross(along);
        let first = DVec2::new(tangent.dot(along), tangent.dot(across)).try_normalize()?;
        Some(Self {
            first,
            second: first.perp() * mirror,
        })
    }

    /// The colour of a normal, turned.
    pub(super) fn apply(&self, [red, green, blue, alpha]: [f32; 4]) -> [f32; 4] {
        let [x, y] = [red, green].map(|part| 2.0 * f64::from(part) - 1.0);
        let turned = self.first * x + self.second * y;
        let [red, green] = turned.to_array().map(|part| (0.5 + 0.5 * part) as f32);
        [red, green, blue, alpha]
    }
}

/// The direction in space in which the first texture coordinate grows along a triangle, and -1 if
/// the coordinates mirror it, else 1.
fn tangent([a, b, c]: [DVec3; 3], uvs: [DVec2; 3]) -> Option<(DVec3, f64)> {
    let [p, q] = [uvs[1] - uvs[0], uvs[2] - uvs[0]];
    let area = p.perp_dot(q);
    let direction = ((b - a) * q.y - (c - a) * p.y) * area.signum();
    Some((direction.try_normalize()?, area.signum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tangent_follows_the_first_coordinate_whatever_the_mirror() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let straight = [DVec2::ZERO, DVec2::X, DVec2::Y];
        assert_eq!(tangent(corners, straight), Some((DVec3::X, 1.0)));
        let mirrored = straight.map(|uv| DVec2::new(-uv.x, uv.y));
        assert_eq!(tangent(corners, mirrored), Some((-DVec3::X, -1.0)));
        let turned = straight.map(DVec2::perp);
        let (direction, mirror) = tangent(corners, turned).unwrap();
        assert!(direction.distance(-DVec3::Y) < 1e-15 && mirror > 0.0);
    }

    #[test]
    fn a_normal_turned_by_a_quarter_changes_its_coordinates() {
        let turn = TangentTurn {
            first: DVec2::Y,
            second: DVec2::NEG_X,
        };
        let turned = turn.apply([1.0, 0.5, 0.75, 1.0]);
        assert!((turned[0] - 0.5).abs() < 1e-6 && (turned[1] - 1.0).abs() < 1e-6);
        assert!((turned[2] - 0.75).abs() < 1e-6);
    }
}
