//! Meshes that use what formats can hold, and their comparison.
#![allow(dead_code, reason = "each test crate uses a part")]

use glam::{DVec2, DVec3};
use graticule::mesh::{CornerAttribute, NO_VALUE, PolygonLabels, PolygonSoup};
use graticule_fixtures::{Fixture, cube, torus};

/// Triangles without attributes.
pub(crate) fn plain_cube() -> PolygonSoup {
    soup_of(cube())
}

fn soup_of(fixture: Fixture) -> PolygonSoup {
    PolygonSoup {
        positions: fixture.positions,
        polygons: fixture
            .triangles
            .iter()
            .map(|triangle| &triangle[..])
            .collect(),
        ..PolygonSoup::default()
    }
}

/// A torus of 4 × 3 quadrilaterals with coordinates that end at two seams, colours and polylines.
pub(crate) fn seamed_quads() -> PolygonSoup {
    let (around, across) = (4_u32, 3_u32);
    let mut soup = PolygonSoup::default();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (f64::from(i) * 1.6, f64::from(j) * 2.1);
            let radius = 2.0 + b.cos();
            soup.positions
                .push(DVec3::new(radius * a.cos(), radius * a.sin(), b.sin()));
        }
    }
    let mut uvs = CornerAttribute::default();
    for i in 0..=around {
        for j in 0..=across {
            let uv = DVec2::new(f64::from(i) / f64::from(around), f64::from(j) / 8.0);
            uvs.values.push(uv);
        }
    }
    for i in 0..around {
        for j in 0..across {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            soup.polygons
                .push(&corners.map(|(i, j)| (i % around) * across + j % across));
            uvs.corner_values
                .extend(corners.map(|(i, j)| i * (across + 1) + j));
        }
    }
    soup.attributes.uv_sets.push(uvs);
    soup.attributes.vertex_colors = Some(
        (0..soup.positions.len())
            .map(|k| [k as f32 / 255.0, 0.0, 1.0, 0.2])
            .collect(),
    );
    soup.polylines = vec![vec![0, 3, 6], vec![1, 2]];
    soup
}

/// Two objects of triangles, with groups, materials, smoothing groups, normals, two sets of
/// coordinates of which the second covers a part only.
pub(crate) fn named_cubes() -> PolygonSoup {
    let moved = torus(2.0, 0.5, 5, 4).map(|position| position + DVec3::new(7.0, 0.0, 0.0));
    let mut soup = soup_of(cube().joined(&moved));
    let (polygons, corners) = (soup.polygons.len(), soup.polygons.corner_count());
    let attributes = &mut soup.attributes;
    let labels = |names: &[&str], of_polygon: &dyn Fn(usize) -> u32| {
        Some(PolygonLabels {
            names: names.iter().map(|&name| name.to_owned()).collect(),
            polygon_names: (0..polygons).map(of_polygon).collect(),
        })
    };
    attributes.objects = labels(&["cube", "torus 2"], &|k| u32::from(k >= 12));
    attributes.groups = labels(&["a b", "ß"], &|k| [NO_VALUE, 0, 1][k / 4 % 3]);
    attributes.materials = labels(&["stone", "glass"], &|k| u32::from(k / 3 % 2 == 1));
    attributes.smoothing_groups = labels(&["off", "1"], &|k| u32::from(k > 5));
    attributes.material_libraries = vec!["my stones.mtl".to_owned(), "b.mtl".to_owned()];
    attributes.normals = Some(CornerAttribute {
        name: String::new(),
        values: vec![DVec3::X, DVec3::Y, DVec3::NEG_Z],
        corner_values: (0..corners as u32).map(|k| k / 3 % 3).collect(),
    });
    attributes.uv_sets.push(CornerAttribute {
        name: String::new(),
        values: (0..corners)
            .map(|k| DVec2::new(k as f64 / 64.0, 0.5))
            .collect(),
        corner_values: (0..corners as u32).collect(),
    });
    attributes.uv_sets.push(CornerAttribute {
        name: String::new(),
        values: vec![DVec2::new(0.25, 0.75)],
        corner_values: (0..corners)
            .map(|k| if k < 18 { 0 } else { NO_VALUE })
            .collect(),
    });
    soup
}

/// The same mesh with positions and coordinates rounded to single precision.
pub(crate) fn single_precision(mut soup: PolygonSoup) -> PolygonSoup {
    for position in &mut soup.positions {
        *position = position.as_vec3().as_dvec3();
    }
    for set in &mut soup.attributes.uv_sets {
        for value in &mut set.values {
            *value = value.as_vec2().as_dvec2();
        }
    }
    soup
}

/// Both meshes are the same, whatever the order in which values and names are kept; `found` may
/// lack all but the first set of coordinates.
pub(crate) fn assert_same(expected: &PolygonSoup, found: &PolygonSoup) {
    assert_eq!(expected.positions, found.positions);
    assert_eq!(expected.polygons, found.polygons);
    assert_eq!(expected.polylines, found.polylines);

    let (before, after) = (&expected.attributes, &found.attributes);
    assert_eq!(before.uv_sets.is_empty(), after.uv_sets.is_empty());
    for corner in 0..expected.polygons.corner_count() {
        for (before, after) in before.uv_sets.iter().zip(&after.uv_sets) {
            assert_eq!(before.get(corner), after.get(corner), "corner {corner}");
        }
        let normal =
            |set: &Option<CornerAttribute<DVec3>>| set.as_ref().and_then(|set| set.get(corner));
        assert_eq!(normal(&before.normals), normal(&after.normals));
    }
    assert_eq!(before.vertex_colors, after.vertex_colors);
    for (before, after) in [
        (&before.objects, &after.objects),
        (&before.groups, &after.groups),
        (&before.materials, &after.materials),
        (&before.smoothing_groups, &after.smoothing_groups),
    ] {
        for polygon in 0..expected.polygons.len() {
            let name = |labels: &Option<PolygonLabels>| {
                labels
                    .as_ref()
                    .and_then(|labels| labels.get(polygon))
                    .map(str::to_owned)
            };
            assert_eq!(name(before), name(after), "polygon {polygon}");
        }
    }
    assert_eq!(before.material_libraries, after.material_libraries);
}

/// The corner positions of each polygon.
pub(crate) fn outlines(soup: &PolygonSoup) -> Vec<Vec<DVec3>> {
    let position = |&vertex: &u32| soup.positions[vertex as usize];
    soup.polygons
        .iter()
        .map(|corners| corners.iter().map(position).collect())
        .collect()
}
