//! Points and lines with told places.

use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DVec2, DVec3};
use graticule::Hint;
use graticule::flatten::{
    BoundaryCurve, BoundaryPositions, ConstrainedMap, FixedOptions, FlattenError, Mix,
    NaturalOptions, Patch, PatchPointError, Pins, PointConstraint, Strength, Triangulation,
    Weights, boundary_on_curve, constrained_fixed_map, constrained_natural_map, fixed_map,
    line_constraints, natural_map, surface_line,
};
use graticule::geometry::{IntrinsicTriangulation, intrinsic_weights};
use graticule::mesh::{FaceId, PerVertex, SurfacePoint, VertexId};
use graticule::watch::Watch;
use graticule_fixtures::{bumpy_patch, grid, irregular_disk, saddle_patch};

use crate::support::{distance, own_boundary, patch, plane};

const INNER: SurfacePoint = SurfacePoint {
    face: FaceId(7),
    barycentric: [0.2, 0.5, 0.3],
};

fn circle(patch: &Patch) -> BoundaryPositions {
    boundary_on_curve(patch, &BoundaryCurve::Circle, &Watch::new()).unwrap()
}

fn all_weights() -> [Weights; 5] {
    [
        Weights::Cotangent,
        Weights::Intrinsic(Mix::AUTHALIC),
        Weights::Intrinsic(Mix::new(1.0, 1.0).unwrap()),
        Weights::MeanValue,
        Weights::Uniform,
    ]
}

fn with(weights: Weights) -> FixedOptions {
    FixedOptions {
        weights,
        ..FixedOptions::default()
    }
}

fn on_circle(
    patch: &Patch,
    constraints: &[PointConstraint],
    weights: Weights,
) -> Result<ConstrainedMap, FlattenError> {
    let options = with(weights);
    constrained_fixed_map(patch, &circle(patch), constraints, &options, &Watch::new())
}

fn image(patch: &Patch, uv: &PerVertex<DVec2>, point: SurfacePoint) -> DVec2 {
    point.interpolate(patch.mesh().triangle(point.face).map(|v| uv[v]))
}

#[test]
fn hard_points_come_to_their_places_and_soft_ones_near_them() {
    let patch = patch(&bumpy_patch(7, 2));
    let place = DVec2::new(0.1, -0.2);
    for weights in all_weights() {
        let free = fixed_map(&patch, &circle(&patch), &with(weights), &Watch::new()).unwrap();
        let before = image(&patch, &free.uv, INNER).distance(place);
        let hard = PointConstraint::hard(INNER, place);
        let found = on_circle(&patch, &[hard], weights).unwrap();
        assert!(image(&patch, &found.map.uv, INNER).distance(place) < 1e-12);
        assert!(found.misses[0] < 1e-12 && found.redundant.is_empty());
        let mut last = before;
        for weight in [0.01, 1.0, 100.0] {
            let soft = PointConstraint {
                strength: Strength::Soft(weight),
                ..hard
            };
            let found = on_circle(&patch, &[soft], weights).unwrap();
            assert!(found.misses[0] < last, "{weights:?} {weight}");
            last = found.misses[0];
        }
        assert!(last < 0.1 * before);
    }
}

#[test]
fn a_constraint_that_the_map_fulfils_anyhow_changes_nothing() {
    let patch = patch(&bumpy_patch(7, 2));
    for weights in all_weights() {
        let free = fixed_map(&patch, &circle(&patch), &with(weights), &Watch::new()).unwrap();
        let constraint = PointConstraint::hard(INNER, image(&patch, &free.uv, INNER));
        let found = on_circle(&patch, &[constraint], weights).unwrap();
        assert!(distance(&found.map.uv, &free.uv) < 1e-11);
    }
}

#[test]
fn constrained_mixes_solve_the_dense_augmented_system_of_the_paper() {
    let patch = patch(&saddle_patch(6));
    let boundary = circle(&patch);
    let constraints = [
        PointConstraint::hard(INNER, DVec2::new(0.2, 0.1)),
        PointConstraint::hard(
            SurfacePoint {
                face: FaceId(30),
                ..INNER
            },
            DVec2::new(-0.3, 0.0),
        ),
    ];
    let triangulation = IntrinsicTriangulation::of(patch.unit_surface()).unwrap();
    for [lambda, mu] in [[0.0, 1.0], [1.0, 0.3]] {
        let mix = Mix::new(lambda, mu).unwrap();
        let found = on_circle(&patch, &constraints, Weights::Intrinsic(mix)).unwrap();
        let weights = intrinsic_weights(&triangulation, lambda, mu).unwrap();
        let vertices = patch.mesh().vertex_count();
        let order = vertices + constraints.len();
        let mut matrix = Mat::<f64>::zeros(order, order);
        let mut right_side = Mat::<f64>::zeros(order, 2);
        for vertex in patch.mesh().vertices() {
            let row = vertex.0 as usize;
            for (other, weight) in weights
                .neighbors(vertex)
                .iter()
                .zip(weights.weights(vertex))
            {
                matrix[(row, row)] += weight;
                matrix[(row, other.0 as usize)] -= weight;
            }
        }
        for (k, constraint) in constraints.iter().enumerate() {
            let corners = patch.mesh().triangle(constraint.point.face);
            for (corner, weight) in corners.iter().zip(constraint.point.barycentric) {
                matrix[(vertices + k, corner.0 as usize)] += weight;
                matrix[(corner.0 as usize, vertices + k)] += weight;
            }
            right_side[(vertices + k, 0)] = constraint.place.x;
            right_side[(vertices + k, 1)] = constraint.place.y;
        }
        for &(vertex, place) in boundary.places() {
            let row = vertex.0 as usize;
            for column in 0..order {
                matrix[(row, column)] = f64::from(u8::from(column == row));
            }
            right_side[(row, 0)] = place.x;
            right_side[(row, 1)] = place.y;
        }
        let solved = matrix.partial_piv_lu().solve(&right_side);
        let dense = PerVertex::from_fn(vertices, |v: VertexId| {
            DVec2::new(solved[(v.0 as usize, 0)], solved[(v.0 as usize, 1)])
        });
        let error = distance(&found.map.uv, &dense);
        assert!(error < 1e-10, "{error:e}");
    }
}

#[test]
fn redundant_constraints_are_told_and_contradictory_ones_refused_by_number() {
    let patch = patch(&bumpy_patch(7, 2));
    let boundary = circle(&patch);
    let place = DVec2::new(0.1, 0.2);
    let hard = PointConstraint::hard(INNER, place);
    let (vertex, on_circle_place) = boundary.places()[3];
    let on_boundary = PointConstraint::at_vertex(&patch, vertex, on_circle_place).unwrap();
    for weights in all_weights() {
        let twice = [on_boundary, hard, hard, on_boundary];
        let found = on_circle(&patch, &twice, weights).unwrap();
        assert_eq!(found.redundant, [0, 2, 3]);
        assert!(found.misses.iter().all(|miss| *miss < 1e-12));

        let elsewhere = PointConstraint::hard(INNER, place + DVec2::new(0.25, 0.0));
        let refusal = on_circle(&patch, &[on_boundary, hard, elsewhere], weights).unwrap_err();
        let FlattenError::ContradictoryConstraint {
            constraint: 2,
            distance,
        } = refusal
        else {
            panic!("{refusal}");
        };
        assert!((distance - 0.25).abs() < 1e-9);
        let off = PointConstraint::at_vertex(&patch, vertex, on_circle_place * 1.1).unwrap();
        let refusal = on_circle(&patch, &[hard, off], weights).unwrap_err();
        let contradicts = matches!(
            refusal,
            FlattenError::ContradictoryConstraint { constraint: 1, .. }
        );
        assert!(contradicts);
        assert!(refusal.hint().is_some());
    }
    let natural = |constraints: &[PointConstraint]| {
        constrained_natural_map(&patch, constraints, Triangulation::Given, &Watch::new())
    };
    let found = natural(&[hard, on_boundary, hard]).unwrap();
    assert_eq!(found.redundant, [2]);
    let elsewhere = PointConstraint::hard(INNER, place + DVec2::new(0.0, 0.5));
    let refusal = natural(&[hard, on_boundary, elsewhere]).unwrap_err();
    let contradicts = matches!(
        refusal,
        FlattenError::ContradictoryConstraint { constraint: 2, .. }
    );
    assert!(contradicts, "{refusal}");
    for few in [&[hard][..], &[hard, hard], &[]] {
        let refusal = natural(few).unwrap_err();
        assert!(
            matches!(refusal, FlattenError::TooFewConstraints { .. }),
            "{refusal}"
        );
    }
}

#[test]
fn points_that_are_none_are_refused() {
    let patch = patch(&bumpy_patch(4, 2));
    let refusal = |constraint: PointConstraint| {
        let good = PointConstraint::hard(INNER, DVec2::ZERO);
        match on_circle(&patch, &[good, constraint], Weights::Cotangent).unwrap_err() {
            FlattenError::BadPoint {
                constraint: 1,
                reason,
            } => reason,
            other => panic!("{other}"),
        }
    };
    let good = PointConstraint::hard(INNER, DVec2::ZERO);
    let at =
        |face, barycentric| PointConstraint::hard(SurfacePoint { face, barycentric }, DVec2::ZERO);
    let none = refusal(at(FaceId(99999), [1.0, 0.0, 0.0]));
    assert!(matches!(none, PatchPointError::NoSuchTriangle { .. }));
    for barycentric in [[1.0, 1.0, 0.0], [f64::NAN, 0.0, 1.0]] {
        let none = refusal(at(FaceId(0), barycentric));
        assert!(matches!(none, PatchPointError::NotBarycentric { .. }));
    }
    let place = DVec2::new(f64::INFINITY, 0.0);
    let none = refusal(PointConstraint { place, ..good });
    assert!(matches!(none, PatchPointError::NonFinitePlace { .. }));
    for weight in [0.0, -1.0, f64::NAN] {
        let strength = Strength::Soft(weight);
        let none = refusal(PointConstraint { strength, ..good });
        assert!(matches!(none, PatchPointError::BadWeight { .. }));
    }
}

#[test]
fn two_vertices_told_their_places_are_the_pins_of_the_natural_map() {
    let patch = patch(&bumpy_patch(7, 3));
    let pins = [
        (VertexId(3), DVec2::new(1.0, 2.0)),
        (VertexId(90), DVec2::new(-1.0, 0.5)),
    ];
    let options = NaturalOptions {
        pins: Pins::At(pins),
        ..NaturalOptions::default()
    };
    let natural = natural_map(&patch, &options, &Watch::new()).unwrap();
    let constraints =
        pins.map(|(vertex, place)| PointConstraint::at_vertex(&patch, vertex, place).unwrap());
    let constrained =
        constrained_natural_map(&patch, &constraints, Triangulation::Given, &Watch::new()).unwrap();
    assert!(distance(&constrained.map.uv, &natural.uv) < 1e-9);
}

#[test]
fn soft_points_alone_hold_a_natural_map() {
    let patch = patch(&irregular_disk(7, 3));
    let springs: Vec<_> = [5, 40, 77]
        .map(|face| {
            let point = SurfacePoint {
                face: FaceId(face),
                ..INNER
            };
            PointConstraint {
                point,
                place: point.position(patch.surface()).truncate(),
                strength: Strength::Soft(1.0),
            }
        })
        .into();
    let found =
        constrained_natural_map(&patch, &springs, Triangulation::Given, &Watch::new()).unwrap();
    assert!(distance(&found.map.uv, &plane(&patch)) < 1e-9);
}

#[test]
fn a_line_over_a_flat_patch_is_straight_and_ends_where_it_should() {
    let patch = patch(&irregular_disk(9, 3));
    let surface = patch.surface();
    let [from, to] = [
        SurfacePoint {
            face: FaceId(3),
            ..INNER
        },
        SurfacePoint {
            face: FaceId(200),
            ..INNER
        },
    ];
    for [from, to] in [[from, to], [to, from]] {
        let line = surface_line(&patch, from, to).unwrap();
        assert_eq!((line[0], line[line.len() - 1]), (from, to));
        assert!(line.len() > 5);
        let [a, b] = [from, to].map(|point| point.position(surface).truncate());
        let mut last = -1e-9;
        for point in &line {
            let p = point.position(surface).truncate() - a;
            assert!(p.perp_dot(b - a).abs() < 1e-12);
            let share = p.dot(b - a) / (b - a).length_squared();
            assert!(share > last);
            last = share;
        }
        // Laid down where it is, it leaves the patch its own map.
        let constraints = line_constraints(&patch, [from, to], [a, b], Strength::Hard).unwrap();
        for weights in [Weights::Cotangent, Weights::Intrinsic(Mix::AUTHALIC)] {
            let found = constrained_fixed_map(
                &patch,
                &own_boundary(&patch),
                &constraints,
                &with(weights),
                &Watch::new(),
            );
            let found = found.unwrap();
            assert!(distance(&found.map.uv, &plane(&patch)) < 1e-9);
        }
    }
}

#[test]
fn a_line_becomes_straight_in_the_map() {
    let patch = patch(&bumpy_patch(8, 2));
    let [from, to] = [FaceId(2), FaceId(150)].map(|face| SurfacePoint { face, ..INNER });
    let places = [DVec2::new(-0.3, 0.1), DVec2::new(0.4, 0.2)];
    let constraints = line_constraints(&patch, [from, to], places, Strength::Hard).unwrap();
    for weights in all_weights() {
        let found = on_circle(&patch, &constraints, weights).unwrap();
        for constraint in &constraints {
            let at = image(&patch, &found.map.uv, constraint.point);
            assert!(at.distance(constraint.place) < 1e-11);
        }
    }
    let found = constrained_natural_map(&patch, &constraints, Triangulation::Given, &Watch::new());
    assert!(found.unwrap().misses.iter().all(|miss| *miss < 1e-10));
}

#[test]
fn lines_from_vertices_and_between_neighbours_are_found() {
    let patch = patch(&grid(1.0, 1.0, 6, 6).map(|p| p + DVec3::Z * p.x * p.x));
    let at = |vertex| SurfacePoint::at_corner(patch.mesh().vertex_halfedge(VertexId(vertex)));
    for [from, to] in [[8, 40], [0, 48], [8, 9], [10, 31], [0, 6]] {
        let line = surface_line(&patch, at(from), at(to)).unwrap();
        assert_eq!(line[0], at(from));
        assert_eq!(line[line.len() - 1], at(to));
    }
    let same = surface_line(&patch, at(8), at(8)).unwrap_err();
    assert!(matches!(same, FlattenError::NoLine { .. }));
}

#[test]
fn a_patch_without_interior_has_nothing_left_to_constrain() {
    let patch = patch(&grid(1.0, 1.0, 1, 1));
    let boundary = own_boundary(&patch);
    let place = INNER.barycentric;
    let point = SurfacePoint {
        face: FaceId(0),
        barycentric: place,
    };
    let own = point.position(patch.surface()).truncate();
    for weights in all_weights() {
        let with_place = |place| {
            let constraints = [PointConstraint::hard(point, place)];
            let options = with(weights);
            constrained_fixed_map(&patch, &boundary, &constraints, &options, &Watch::new())
        };
        assert_eq!(with_place(own).unwrap().redundant, [0]);
        let refusal = with_place(own + DVec2::X).unwrap_err();
        let contradicts = matches!(refusal, FlattenError::ContradictoryConstraint { .. });
        assert!(contradicts, "{refusal}");
    }
}
