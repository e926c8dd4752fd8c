use glam::DVec3;
use graticule_fixtures::grid;

use super::*;

/// A grid of 2 × 36 triangles with fins of the height on so many inner edges, and a triangle that
/// stands apart.
fn finned(height: f64, fins: usize) -> PolygonSoup {
    let mut soup = soup_of(&grid(1.0, 1.0, 6, 6));
    for first in [16, 17, 23, 24, 30, 31].into_iter().take(fins) {
        let ends = [first, first + 1].map(|vertex: u32| soup.positions[vertex as usize]);
        let tip = 0.5 * (ends[0] + ends[1]) + DVec3::new(0.0, 0.0, height);
        let last = soup.positions.len() as u32;
        soup.positions.push(tip);
        soup.polygons.push(&[first, first + 1, last]);
    }
    let apart = soup.positions.len() as u32;
    for place in [DVec3::ZERO, 1e-3 * DVec3::X, 1e-3 * DVec3::Y] {
        soup.positions.push(place + DVec3::new(0.0, 0.0, 5.0));
    }
    soup.polygons.push(&[apart, apart + 1, apart + 2]);
    soup
}

fn without_fins(soup: &PolygonSoup, fins: Fins) -> Repaired {
    let options = RepairOptions {
        fins,
        ..RepairOptions::default()
    };
    repaired_with(soup, options)
}

#[test]
fn small_fins_are_dropped_on_demand_and_pieces_that_hang_on_nothing_stay() {
    let soup = finned(0.01, 6);
    assert_eq!(components(&repaired(&soup)), 8);
    // One has the area of 1/1200.
    for fins in [Fins::DropBelowShare(1e-3), Fins::DropBelowArea(1e-3)] {
        let repaired = without_fins(&soup, fins);
        assert_eq!(components(&repaired), 2);
        assert_eq!(repaired.changes.fins_dropped.count(), 6);
        assert_eq!(repaired.surface.mesh().vertex_count(), 49 + 3);
        assert!(!repaired.changes.keep_polygons());
    }
}

#[test]
fn fins_stay_that_are_large_or_much_of_the_surface_together() {
    let of_one = 0.5 * 0.12 / 6.0;
    let soup = finned(0.12, 1);
    let small = without_fins(&soup, Fins::DropBelowArea(0.9 * of_one));
    assert_eq!(components(&small), 3);
    let large = without_fins(&soup, Fins::DropBelowArea(1.1 * of_one));
    assert_eq!(components(&large), 2);
    let many = without_fins(&finned(0.12, 6), Fins::DropBelowArea(1.1 * of_one));
    assert_eq!(components(&many), 8);
    assert!(many.changes.fins_dropped.is_empty());
}
