//! Soups for the tests of defects and repair.

use glam::DVec3;
use graticule_fixtures::Fixture;

use super::PolygonSoup;

pub(super) fn soup(positions: &[[f64; 3]], polygons: &[&[u32]]) -> PolygonSoup {
    PolygonSoup {
        positions: positions.iter().map(|&p| DVec3::from_array(p)).collect(),
        polygons: polygons.iter().copied().collect(),
        ..PolygonSoup::default()
    }
}

pub(super) fn soup_of(fixture: &Fixture) -> PolygonSoup {
    PolygonSoup {
        positions: fixture.positions.clone(),
        polygons: fixture.triangles.iter().map(|t| &t[..]).collect(),
        ..PolygonSoup::default()
    }
}

/// Three triangles on the edge between vertices 0 and 1.
pub(super) fn fin() -> PolygonSoup {
    soup(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., -1., 0.2],
            [0.2, 0., 1.],
        ],
        &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]],
    )
}
