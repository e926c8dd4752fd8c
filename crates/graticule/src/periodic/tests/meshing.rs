//! What numbering, meshing and sizes of charts do to coordinates.

use super::*;
use crate::field::{CurvatureOptions, principal_curvatures};
use crate::mesh::HalfedgeId;
use graticule_fixtures::ellipsoid;

/// The same field on the surface with other numbers, whose first halfedges are others, and with other
/// axes of the crosses first.
fn renumbered_field(
    old: &Surface,
    field: &CrossField,
    new: &Surface,
    new_of_old: &[u32],
) -> CrossField {
    let triangulation = IntrinsicTriangulation::of(old).unwrap();
    let mut old_of_new = vec![0; new_of_old.len()];
    for (old, &new) in new_of_old.iter().enumerate() {
        old_of_new[new as usize] = old as u32;
    }
    let mut noise = Noise::new(9);
    let angles = PerVertex::from_fn(new_of_old.len(), |vertex: VertexId| {
        let first = new.mesh().vertex_halfedge(vertex);
        let destination = old_of_new[new.mesh().destination(first).index()];
        let own = VertexId(old_of_new[vertex.index()]);
        let mut outgoing = old.mesh().outgoing(own);
        let same = |h: &HalfedgeId| old.mesh().destination(*h).0 == destination;
        let first = triangulation.direction(outgoing.find(same).unwrap());
        field.angle(own) - first + noise.below(4) as f64 * FRAC_PI_2
    });
    CrossField::from_angles(Symmetry::Cross, angles)
}

#[test]
fn the_numbers_of_vertices_change_nothing() {
    let mut noise = Noise::new(12);
    let mut off = || 0.01 * noise.signed();
    // Without symmetry, so that no two phases are equally good.
    let shape = ellipsoid(glam::DVec3::new(1.0, 1.3, 1.9), 4);
    let shape = shape.map(|p| p + glam::DVec3::new(0.2 * p.y * p.y, 0.1 * p.x, 0.3 * p.x * p.y));
    let offsets: Vec<_> = shape
        .positions
        .iter()
        .map(|_| glam::DVec3::new(off(), off(), off()))
        .collect();
    let mut shape = shape;
    for (place, offset) in shape.positions.iter_mut().zip(offsets) {
        *place += offset;
    }
    let old = surface(shape.clone());
    let field = field_of(&old, false).field;
    let options = edges(6.0);
    let reference = parameterize(&old, &field, None, &options, &Watch::new())
        .unwrap()
        .report;
    for seed in [1, 2] {
        let (fixture, new_of_old) = shape.renumbered(seed);
        let new = surface(fixture);
        let field = renumbered_field(&old, &field, &new, &new_of_old);
        let found = parameterize(&new, &field, None, &options, &Watch::new())
            .unwrap()
            .report;
        let counts = |report: &ParameterizationReport| {
            [
                report.field_singular_faces,
                report.phase_singular_faces,
                report.inverted_faces,
                report.singular_vertices,
            ]
        };
        assert_eq!(counts(&found), counts(&reference));
        let [energy, expected] = [&found, &reference].map(|report| report.minimization.energy);
        assert!(
            (energy / expected - 1.0).abs() < 1e-6,
            "{energy} {expected}"
        );
        let [stretch, expected] = [&found, &reference].map(|report| report.distortion.stretch);
        assert!(
            (stretch / expected - 1.0).abs() < 1e-3,
            "{stretch} {expected}"
        );
    }
}

/// How much wider the coordinates are on one side of a square than on the other, where the field
/// asks for `exp(x)` and cannot have it ([PGP06] Fig. 16 in small).
fn growth(columns: u32, rows: u32, energy: EnergyKind) -> f64 {
    let patch = surface(grid(1.0, 1.0, columns, rows));
    let field = straight_field(&patch, 0.0);
    let scale = patch.positions().map(|p| libm::exp(p.x));
    let options = ParameterizeOptions {
        chart_size: ChartSize::Length(8.0),
        energy,
        triangles: EnergyTriangles::Own,
        follow_boundary: false,
        relaxations: 0,
        untangle: false,
        ..ParameterizeOptions::default()
    };
    let map = parameterize(&patch, &field, Some(&scale), &options, &Watch::new()).unwrap();
    assert_eq!(map.singular.face_count(), 0);
    let at = |x: f64, y: f64| {
        let same = |p: &glam::DVec3| p.x == x && p.y == y;
        let vertex = patch.positions().iter().position(same).unwrap();
        let mesh = patch.mesh();
        let vertex = VertexId::from_index(vertex);
        map.layout.coordinates[mesh.vertex_halfedge(vertex)]
    };
    at(1.0, 0.0).distance(at(1.0, 1.0)) / at(0.0, 0.0).distance(at(0.0, 1.0))
}

#[test]
fn only_coordinates_of_the_triangle_energy_do_not_depend_on_the_meshing() {
    let change = |energy| {
        let [regular, anisotropic] = [(32, 32), (32, 4)].map(|(c, r)| growth(c, r, energy));
        (anisotropic / regular - 1.0).abs()
    };
    let [triangle, edge] = [EnergyKind::Triangle, EnergyKind::Edge].map(change);
    assert!(
        triangle < 0.06 && edge > 8.0 * triangle,
        "{triangle} {edge}"
    );
}

#[test]
fn a_limb_thinner_than_half_a_chart_gets_smaller_charts() {
    let limb = surface(cylinder_patch(0.06, 3.0, 12, 90));
    let field = field_of(&limb, false);
    let run = |halvings| {
        let watch = Watch::new();
        let options = ParameterizeOptions {
            chart_size: ChartSize::Length(1.0),
            halvings,
            ..ParameterizeOptions::default()
        };
        let map = parameterize(&limb, &field.field, None, &options, &watch).unwrap();
        let codes: Vec<_> = watch
            .warnings()
            .iter()
            .map(|warning| warning.code)
            .collect();
        (map.report, codes)
    };
    let (collapsed, warnings) = run(0);
    assert!(collapsed.inverted_faces > 0 && warnings.contains(&"inverted-triangles"));
    let (report, warnings) = run(4);
    assert!(
        report.halvings > 0 && warnings.contains(&"charts-halved"),
        "{report:?}"
    );
    assert_eq!(report.inverted_faces, 0);
}

#[test]
fn slivers_are_turned_over_too() {
    // Rows of triangles a thousand times as wide as high between ordinary ones.
    let flat = |p: glam::DVec3| {
        let y = if p.y <= 1.0 { p.y } else { p.y - 0.999 };
        glam::DVec3::new(p.x + 0.2 * p.y.sin(), y, 0.3 * (2.0 * p.x).sin())
    };
    let patch = surface(grid(6.0, 3.0, 12, 3).map(flat));
    let map = covered(&patch, &field_of(&patch, false), &edges(6.0));
    assert_eq!(map.report.inverted_faces, 0, "{:?}", map.report);
}

#[test]
fn charts_on_a_sphere_are_as_small_as_its_bend_asks_and_no_smaller_than_the_range() {
    for exponent in [0, -40, 40] {
        let factor = 2.0_f64.powi(exponent);
        let sphere = surface(icosphere(4).map(|p| p * factor));
        let own = IntrinsicTriangulation::of(&sphere).unwrap();
        let wanted = CurvatureOptions::default();
        let curvatures = principal_curvatures(&sphere, &own, &wanted, &Watch::new()).unwrap();
        let mut sizing = CurvatureSizing {
            chart_size: 0.8 * factor,
            angle: 0.4,
            range: 4.0,
        };
        let density = |sizing: &CurvatureSizing| {
            curvature_density(&sphere, &curvatures, sizing, &Watch::new()).unwrap()
        };
        assert!(
            density(&sizing)
                .iter()
                .all(|d| (d / 2.0 - 1.0).abs() < 0.05)
        );
        sizing.angle = 0.01;
        assert!(
            density(&sizing)
                .iter()
                .all(|d| (d / 4.0 - 1.0).abs() < 1e-3)
        );
        sizing.angle = 1.0;
        assert!(density(&sizing).iter().all(|d| (d - 1.0).abs() < 1e-3));
        sizing.range = 0.5;
        let refused = curvature_density(&sphere, &curvatures, &sizing, &Watch::new());
        assert!(matches!(
            refused,
            Err(PeriodicError::Option { name: "range", .. })
        ));
    }
}

#[test]
fn relaxation_lessens_the_shear_that_a_field_with_curl_causes() {
    let patch = surface(grid(6.0, 6.0, 40, 40));
    let straight = straight_field(&patch, 0.0);
    let bent = straight.angles().enumerate().map(|(vertex, angle)| {
        let place = patch.position(vertex);
        angle + 0.3 * (2.0 * place.x).sin() * (2.0 * place.y).cos()
    });
    let field = CrossField::from_angles(Symmetry::Cross, PerVertex::new(bent.collect()));
    let report = |relaxations| {
        let options = ParameterizeOptions {
            chart_size: ChartSize::Length(2.0),
            follow_boundary: false,
            relaxations,
            ..ParameterizeOptions::default()
        };
        let map = parameterize(&patch, &field, None, &options, &Watch::new()).unwrap();
        map.report
    };
    let [before, after] = [0, 4].map(report);
    assert!(
        after.distortion.shear < 0.8 * before.distortion.shear,
        "{before:?} {after:?}"
    );
    assert!(after.distortion.stretch < before.distortion.stretch);
}
