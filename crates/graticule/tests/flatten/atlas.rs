//! Whole surfaces laid flat.

use glam::DVec3;
use graticule::flatten::{
    Atlas, AtlasOptions, FlattenError, InjectiveOptions, Overlap, PackingOptions, SeamOptions,
    lay_flat,
};
use graticule::measure::measure_map;
use graticule::mesh::{EdgeId, Surface};
use graticule::watch::Watch;
use graticule_fixtures::{
    Fixture, block_with_holes, cone_closed, cube, cylinder_closed, disk, grid, icosphere,
    tetrahedron, torus,
};

fn surface(fixture: &Fixture) -> Surface {
    Surface::from_triangles(fixture.positions.clone(), &fixture.triangles).unwrap()
}

fn options() -> AtlasOptions {
    AtlasOptions {
        seam: Vec::new(),
        cut: Some(SeamOptions::default()),
        uncut: Vec::new(),
        injective: InjectiveOptions::default(),
        packing: PackingOptions::default(),
    }
}

fn laid(surface: &Surface, options: &AtlasOptions) -> Atlas {
    lay_flat(surface, options, &Watch::new()).unwrap()
}

#[test]
fn surfaces_of_any_genus_and_several_at_once_are_laid_flat_one_to_one() {
    let several = torus(2.0, 0.5, 16, 8)
        .joined(&icosphere(2).map(|p| p + DVec3::X * 9.0))
        .joined(&disk(4).map(|p| p + DVec3::Y * 9.0));
    for (fixture, islands) in [(icosphere(3), 1), (block_with_holes(2), 1), (several, 3)] {
        let surface = surface(&fixture);
        let atlas = laid(&surface, &options());
        assert_eq!(atlas.islands.len(), islands);
        let measure = measure_map(&surface, &atlas.corner_uv(), &Watch::new()).unwrap();
        assert_eq!(measure.faces.flipped + measure.faces.zero_uv_area, 0);
        assert_eq!(measure.islands.count, islands);
        let inside = |p: &glam::DVec2| p.min_element() >= 0.0 && p.max_element() <= atlas.side;
        assert!(atlas.places.iter().all(inside));
        let drawn = measure.islands.seam_length * measure.faces.surface_area.sqrt();
        assert!((drawn - atlas.seam_length).abs() < 1e-9 * drawn.max(1.0));
    }
}

#[test]
fn a_given_seam_is_used() {
    let box_of_six = surface(&cube());
    let mesh = box_of_six.mesh();
    let is_corner_edge = |edge: &EdgeId| {
        let [from, to] = mesh.ends(mesh.edge_halfedge(*edge));
        let along = box_of_six.position(to) - box_of_six.position(from);
        along.abs().to_array().iter().filter(|x| **x > 1e-9).count() == 1
    };
    let seam: Vec<EdgeId> = mesh.edges().filter(is_corner_edge).collect();
    let given = AtlasOptions {
        seam: seam.clone(),
        cut: None,
        ..options()
    };
    let atlas = laid(&box_of_six, &given);
    assert_eq!(atlas.islands.len(), 6);
    assert_eq!(atlas.seam, seam);
    let measure = measure_map(&box_of_six, &atlas.corner_uv(), &Watch::new()).unwrap();
    assert!(measure.bijective);
    assert!((measure.distortion.unwrap().symmetric_dirichlet.unwrap() - 4.0).abs() < 1e-6);
    assert!(measure.packing.unwrap().square_share > 0.6);
}

#[test]
fn what_is_no_patch_is_named_where_cutting_is_not_allowed() {
    let two = disk(2).joined(&cube().map(|p| p + DVec3::Z * 5.0));
    let uncut = AtlasOptions {
        cut: None,
        ..options()
    };
    let refusal = lay_flat(&surface(&two), &uncut, &Watch::new()).unwrap_err();
    assert!(matches!(refusal, FlattenError::Component { component, .. } if component.0 == 1));
}

#[test]
fn a_component_without_area_becomes_a_point() {
    let mut fixture = disk(3);
    let first = fixture.positions.len() as u32;
    fixture
        .positions
        .extend([0.0, 1.0, 3.0].map(|x| DVec3::new(x, 9.0, 0.0)));
    fixture.triangles.push([first, first + 1, first + 2]);
    let watch = Watch::new();
    let atlas = lay_flat(&surface(&fixture), &options(), &watch).unwrap();
    assert_eq!(atlas.islands[1].energy, None);
    assert!(
        watch
            .warnings()
            .iter()
            .any(|warning| warning.code == "component-without-area")
    );
    assert!(atlas.places.iter().all(|place| place.is_finite()));
}

/// A ramp of so many turns, its inner edge at the radius 0.3 and its outer at 1.
fn ramp(turns: u32) -> Surface {
    let length = f64::from(turns) * std::f64::consts::TAU;
    let strip = grid(0.7, length, 6, 24 * turns);
    let low = strip.positions[0];
    surface(&strip.map(|p| {
        let (sin, cos) = libm::sincos(p.y - low.y);
        let radius = 1.0 - (p.x - low.x);
        DVec3::new(radius * cos, radius * sin, 0.05 * (p.y - low.y))
    }))
}

#[test]
fn a_ramp_that_overlaps_itself_is_unrolled_in_one_piece() {
    let ramp = ramp(3);
    let mut options = options();
    let free = laid(&ramp, &options);
    let measure = measure_map(&ramp, &free.corner_uv(), &Watch::new()).unwrap();
    assert!(free.islands.len() == 1 && !measure.bijective);
    options.injective.overlap = Overlap::Forbidden;
    let atlas = laid(&ramp, &options);
    let measure = measure_map(&ramp, &atlas.corner_uv(), &Watch::new()).unwrap();
    assert!(atlas.islands.len() == 1 && measure.bijective);
    assert!(atlas.islands[0].energy.unwrap() < 4.2);
}

#[test]
fn seams_of_coarse_surfaces_go_on_to_where_they_are_strained() {
    let coarse = [
        cube(),
        tetrahedron(),
        icosphere(0),
        cylinder_closed(0.2, 2.0, 6, 2),
        cylinder_closed(1.0, 0.3, 9, 1),
        cone_closed(3.0, 7, 1),
    ];
    for fixture in coarse {
        let surface = surface(&fixture);
        let atlas = laid(&surface, &options());
        assert_eq!(atlas.islands.len(), 1);
        let energy = atlas.islands[0].energy.unwrap();
        assert!(
            energy < 5.0,
            "{} triangles: {energy}",
            fixture.triangles.len()
        );
    }
}
