//! How large squares are in space.

use glam::DVec2;

use super::chart_map::ChartMaps;
use super::chart_map_polygon::rectangle;
use crate::geometry::{face_areas, face_shapes};
use crate::mesh::{Element, HalfedgeId};

/// For each square the sides of the rectangle with its area in space, in the ratio that the lengths of
/// its sides have; in the unit of the mesh.
pub(super) fn sizes_in_space(maps: &ChartMaps) -> Vec<DVec2> {
    let mut areas = vec![0.0; maps.squares().len()];
    let mut sides = vec![DVec2::ZERO; maps.squares().len()];
    for (face, area) in face_areas(&face_shapes(maps.surface())).enumerate() {
        let square = maps.square_of()[face].index();
        areas[square] += area;
        for halfedge in face.halfedges() {
            sides[square] += length_along_sides(maps, halfedge);
        }
    }
    let size = |(&area, sides): (&f64, &DVec2)| rectangle(area, sides.x / sides.y);
    areas.iter().zip(&sides).map(size).collect()
}

/// The length in space of a halfedge on a side of its square, by the direction of the side; 0 inside.
fn length_along_sides(maps: &ChartMaps, halfedge: HalfedgeId) -> DVec2 {
    let [from, to] = [halfedge, halfedge.next()].map(|corner| maps.coordinates()[corner]);
    let on_side = (from.cmpeq(DVec2::ZERO) & to.cmpeq(DVec2::ZERO))
        | (from.cmpeq(DVec2::ONE) & to.cmpeq(DVec2::ONE));
    let [vertical, horizontal]: [bool; 2] = on_side.into();
    if !vertical && !horizontal {
        return DVec2::ZERO;
    }
    let [start, end] = maps.surface().mesh().ends(halfedge);
    let length = (maps.surface().position(start)).distance(maps.surface().position(end));
    DVec2::new(
        if horizontal { length } else { 0.0 },
        if vertical { length } else { 0.0 },
    )
}
