use glam::{DVec2, DVec3};

use super::*;
use crate::mesh::{Attributes, CornerAttribute, PolygonLabels};

#[test]
fn polygons_are_cut_and_come_back_whole() {
    let mut quads = joined_cubes(&[DVec3::ZERO]);
    let corners = quads.polygons.corner_count() as u32;
    let uvs = (0..corners).map(|corner| DVec2::splat(f64::from(corner)));
    quads.attributes = Attributes {
        uv_sets: vec![CornerAttribute {
            name: "uv".into(),
            values: uvs.collect(),
            corner_values: (0..corners).collect(),
        }],
        materials: Some(PolygonLabels {
            names: vec!["wood".into()],
            polygon_names: vec![0, NO_VALUE, 0, 0, 0, 0],
        }),
        ..Attributes::default()
    };
    let whole = repaired(&quads);
    assert_eq!(whole.surface.mesh().face_count(), 12);
    assert_eq!(whole.changes.polygons_triangulated, 6);
    assert_eq!(whole.to_soup(&quads), quads);
    assert!(
        whole
            .mesh_corners(&quads)
            .iter()
            .all(|&corner| corner != NO_VALUE)
    );
    // One polygon inside out: it comes back turned, with its own attributes.
    let mut turned = quads.clone();
    turned.polygons = quads
        .polygons
        .iter()
        .enumerate()
        .map(|(i, polygon)| {
            if i == 2 {
                reversed(polygon)
            } else {
                polygon.to_vec()
            }
        })
        .collect::<Vec<_>>()
        .to_polygons();
    let back = repaired(&turned).to_soup(&turned);
    assert_eq!(back.polygons.len(), 6);
    let same_corner = |corner: usize| turned.attributes.uv_sets[0].get(corner);
    for corner in turned.polygons.corner_range(2) {
        let vertex = turned.polygons.corner_vertices()[corner];
        let there = back
            .polygons
            .corner_range(2)
            .find(|&c| back.polygons.corner_vertices()[c] == vertex);
        assert_eq!(
            back.attributes.uv_sets[0].get(there.unwrap()),
            same_corner(corner)
        );
    }
}

#[test]
fn a_result_goes_back_onto_the_polygons_of_the_soup() {
    let quads = joined_cubes(&[DVec3::ZERO]);
    let repaired = repaired(&quads);
    let mesh = repaired.surface.mesh();
    let places = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
        repaired.surface.position(mesh.origin(corner))
    });
    let attribute = repaired.to_soup_corners(&quads, "place", &places);
    for (corner, &vertex) in quads.polygons.corner_vertices().iter().enumerate() {
        assert_eq!(
            attribute.get(corner),
            Some(quads.positions[vertex as usize])
        );
    }
}
