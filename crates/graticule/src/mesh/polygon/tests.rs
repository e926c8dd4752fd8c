use std::f64::consts::TAU;

use super::*;

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

fn area_of(positions: &[DVec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|corner| positions[corner as usize]);
    (b - a).cross(c - a) / 2.0
}

/// Sum of the areas; fails if there are not n - 2 triangles or one turns against the polygon.
fn checked_area(positions: &[DVec3]) -> f64 {
    let triangles = triangulate_polygon(positions);
    assert_eq!(triangles.len(), positions.len() - 2);
    let areas: Vec<_> = triangles.iter().map(|&t| area_of(positions, t)).collect();
    let whole: DVec3 = areas.iter().sum();
    for area in &areas {
        assert!(area.dot(whole) >= 0.0, "a triangle is turned over: {area}");
    }
    areas.iter().map(|area| area.length()).sum()
}

#[test]
fn a_concave_pentagon_keeps_its_area() {
    let pentagon = flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]]);
    assert!((checked_area(&pentagon) - 10.0).abs() < 1e-12);
}

#[test]
fn the_cut_follows_the_polygon_when_it_is_turned_over_moved_and_scaled() {
    let pentagon = flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]]);
    for exponent in [-660, -40, 40, 500] {
        let scaled: Vec<_> = pentagon
            .iter()
            .map(|&p| p * 2.0_f64.powi(exponent))
            .collect();
        assert_eq!(triangulate_polygon(&scaled), triangulate_polygon(&pentagon));
    }
    let mut backward = pentagon.clone();
    backward.reverse();
    assert!((checked_area(&backward) - 10.0).abs() < 1e-12);
    let turned: Vec<_> = pentagon.iter().map(|p| DVec3::new(p.y, 0.0, p.x)).collect();
    assert!((checked_area(&turned) - 10.0).abs() < 1e-12);
}

#[test]
fn a_quad_is_cut_along_the_better_diagonal() {
    let kite = flat(&[[0.0, 0.0], [3.0, -1.0], [6.0, 0.0], [3.0, 1.0]]);
    assert_eq!(triangulate_polygon(&kite), [[1, 2, 3], [1, 3, 0]]);
    let dart = flat(&[[0.0, 0.0], [3.0, -2.0], [1.0, 0.0], [3.0, 2.0]]);
    assert_eq!(triangulate_polygon(&dart), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn a_polygon_with_a_bridged_hole_leaves_the_hole_open() {
    let ring = flat(&[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ]);
    assert!((checked_area(&ring) - 8.0).abs() < 1e-12);
}

#[test]
fn collinear_corners_on_the_sides_are_kept_without_flat_triangles() {
    let side = |from: [f64; 2], to: [f64; 2]| {
        (0..5).map(move |i| {
            let t = f64::from(i) / 5.0;
            [
                from[0] * (1.0 - t) + to[0] * t,
                from[1] * (1.0 - t) + to[1] * t,
            ]
        })
    };
    let square: Vec<_> = side([0.0, 0.0], [1.0, 0.0])
        .chain(side([1.0, 0.0], [1.0, 1.0]))
        .chain(side([1.0, 1.0], [0.0, 1.0]))
        .chain(side([0.0, 1.0], [0.0, 0.0]))
        .collect();
    let positions = flat(&square);
    assert!((checked_area(&positions) - 1.0).abs() < 1e-12);
    for triangle in triangulate_polygon(&positions) {
        assert!(area_of(&positions, triangle).length() > 1e-3);
    }
}

fn star(corners: u32) -> Vec<DVec3> {
    let corner = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(corners);
        let radius = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
        [radius * angle.cos(), radius * angle.sin()]
    };
    flat(&(0..corners).map(corner).collect::<Vec<_>>())
}

fn comb(teeth: u32) -> Vec<DVec3> {
    let mut points = vec![[f64::from(teeth), -1.0], [0.0, -1.0]];
    points.reverse();
    for tooth in (0..teeth).rev() {
        let x = f64::from(tooth);
        points.extend([
            [x + 0.9, 0.0],
            [x + 0.7, 1e4],
            [x + 0.3, 1e4],
            [x + 0.1, 0.0],
        ]);
    }
    flat(&points)
}

fn spiral(turns: u32) -> Vec<DVec3> {
    let arm = |offset: f64| {
        (0..turns * 50).map(move |i| {
            let angle = f64::from(i) * TAU / 50.0;
            let radius = 1.0 + angle + offset;
            [radius * angle.cos(), radius * angle.sin()]
        })
    };
    let mut points: Vec<_> = arm(2.0).collect();
    let mut inner: Vec<_> = arm(0.0).collect();
    inner.reverse();
    points.append(&mut inner);
    flat(&points)
}

fn shoelace(positions: &[DVec3]) -> f64 {
    let next = positions.iter().cycle().skip(1);
    let cross = positions
        .iter()
        .zip(next)
        .map(|(a, b)| a.x * b.y - a.y * b.x);
    cross.sum::<f64>().abs() / 2.0
}

#[test]
fn stars_combs_spirals_and_circles_with_thousands_of_corners_are_covered_exactly() {
    let circle: Vec<_> = (0..2000)
        .map(|i| TAU * f64::from(i) / 2000.0)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    for polygon in [star(3000), comb(1000), spiral(40), flat(&circle)] {
        let area = shoelace(&polygon);
        assert!((checked_area(&polygon) - area).abs() <= 1e-9 * area);
    }
}

#[test]
fn polygons_without_a_plane_are_cut_all_the_same() {
    let line = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.5, 0.0]]);
    let point = vec![DVec3::ONE; 7];
    let mut nan = star(10);
    nan[3].x = f64::NAN;
    let eight = flat(&[
        [0.0, 0.0],
        [1.0, 1.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 0.0],
        [0.0, 1.0],
    ]);
    for polygon in [line, point, nan, eight] {
        let triangles = triangulate_polygon(&polygon);
        assert_eq!(triangles.len(), polygon.len() - 2);
        let mut used: Vec<_> = triangles.into_iter().flatten().collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), polygon.len());
    }
    assert!(triangulate_polygon(&[DVec3::ZERO; 2]).is_empty());
}

#[test]
fn fifty_thousand_corners_are_no_burden() {
    for polygon in [star(50_000), comb(12_500), spiral(500)] {
        let area = shoelace(&polygon);
        assert!((checked_area(&polygon) - area).abs() <= 1e-9 * area);
    }
}
