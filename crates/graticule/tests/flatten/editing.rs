//! Boundary points moved by hand.

use glam::DVec2;
use graticule::Hint;
use graticule::flatten::{
    BoundaryCurve, BoundaryEditor, EditError, EditorOptions, FixedOptions, Mix, Patch, Weights,
    boundary_on_curve, fixed_map,
};
use graticule::mesh::VertexId;
use graticule::watch::Watch;
use graticule_fixtures::{Noise, annulus, bumpy_patch};

use crate::support::{distance, patch};

fn editor(patch: &Patch, options: &EditorOptions) -> BoundaryEditor {
    let boundary = boundary_on_curve(patch, &BoundaryCurve::Circle, &Watch::new()).unwrap();
    BoundaryEditor::new(patch, &boundary, options, &Watch::new()).unwrap()
}

fn with(weights: Weights) -> EditorOptions {
    EditorOptions {
        fixed: FixedOptions {
            weights,
            ..FixedOptions::default()
        },
        ..EditorOptions::default()
    }
}

#[test]
fn green_functions_give_the_map_of_the_direct_solve() {
    let watch = Watch::new();
    let all = [
        Weights::Cotangent,
        Weights::Intrinsic(Mix::AUTHALIC),
        Weights::Intrinsic(Mix::new(1.0, 0.5).unwrap()),
        Weights::MeanValue,
    ];
    let mut noise = Noise::new(8);
    for fixture in [bumpy_patch(8, 2), annulus(0.3, 1.0, 20, 6)] {
        let patch = patch(&fixture);
        for weights in all {
            let options = with(weights);
            let mut editor = editor(&patch, &options);
            for _ in 0..3 {
                let handles: Vec<_> = editor.movable().iter().copied().step_by(4).collect();
                editor.begin(&handles, &watch).unwrap();
                for _ in 0..20 {
                    let moved: Vec<_> = handles
                        .iter()
                        .map(|&h| {
                            editor.uv()[h] + DVec2::new(noise.signed(), noise.signed()) * 0.02
                        })
                        .collect();
                    editor.move_to(&moved).unwrap();
                }
                let dragged = editor.uv().clone();
                editor.commit().unwrap();
                assert!(distance(&dragged, editor.uv()) < 1e-12);
                let direct = editor.map(&watch).unwrap();
                assert!(distance(editor.uv(), &direct.uv) < 1e-9);
                let boundary = editor.boundary().unwrap();
                let anew = fixed_map(&patch, &boundary, &options.fixed, &watch).unwrap();
                assert!(distance(editor.uv(), &anew.uv) < 1e-9);
            }
        }
    }
}

#[test]
fn a_cancelled_edit_leaves_no_trace() {
    let patch = patch(&bumpy_patch(6, 1));
    let mut editor = editor(&patch, &EditorOptions::default());
    let before = (editor.uv().clone(), editor.boundary().unwrap());
    let handles: Vec<_> = editor.movable()[..3].to_vec();
    editor.begin(&handles, &Watch::new()).unwrap();
    assert!(editor.is_editing());
    editor.move_to(&[DVec2::X, DVec2::Y, DVec2::ZERO]).unwrap();
    assert!(*editor.uv() != before.0);
    editor.cancel().unwrap();
    assert!(!editor.is_editing());
    assert_eq!((editor.uv().clone(), editor.boundary().unwrap()), before);
}

#[test]
fn moving_all_boundary_points_alike_moves_the_map() {
    let patch = patch(&bumpy_patch(6, 1));
    let mut editor = editor(&patch, &EditorOptions::default());
    let before = editor.uv().clone();
    let handles = editor.movable().to_vec();
    editor.begin(&handles, &Watch::new()).unwrap();
    let shift = DVec2::new(3.0, -1.0);
    let moved: Vec<_> = handles.iter().map(|&h| before[h] + shift).collect();
    let after = editor.move_to(&moved).unwrap();
    assert!(distance(after, &before.map(|p| *p + shift)) < 1e-13);
}

#[test]
fn responses_stay_within_the_memory_allowed() {
    let patch = patch(&bumpy_patch(6, 1));
    let bytes = patch.mesh().vertex_count() * size_of::<f64>();
    let options = EditorOptions {
        most_bytes: 5 * bytes,
        ..EditorOptions::default()
    };
    let mut editor = editor(&patch, &options);
    let handles = editor.movable().to_vec();
    let watch = Watch::new();
    for three in handles.chunks(3) {
        editor.begin(three, &watch).unwrap();
        let places: Vec<_> = three.iter().map(|&h| editor.uv()[h] * 1.01).collect();
        editor.move_to(&places).unwrap();
        editor.commit().unwrap();
        assert!(editor.response_bytes() <= 5 * bytes);
    }
    let direct = editor.map(&watch).unwrap();
    assert!(distance(editor.uv(), &direct.uv) < 1e-11);
    let refusal = editor.begin(&handles[..6], &watch).unwrap_err();
    assert!(matches!(refusal, EditError::Memory { handles: 6, .. }));
    assert!(refusal.hint().is_some());
}

#[test]
fn edits_that_cannot_be_are_refused_by_name() {
    let patch = patch(&bumpy_patch(4, 1));
    let mut editor = editor(&patch, &EditorOptions::default());
    let watch = Watch::new();
    assert_eq!(editor.move_to(&[]).unwrap_err(), EditError::NotEditing);
    assert_eq!(editor.commit().unwrap_err(), EditError::NotEditing);
    assert_eq!(editor.cancel().unwrap_err(), EditError::NotEditing);
    let mesh = patch.mesh();
    let inside = mesh
        .vertices()
        .find(|&v| !mesh.is_boundary_vertex(v))
        .unwrap();
    for vertex in [inside, VertexId(9999)] {
        let refusal = editor.begin(&[vertex], &watch).unwrap_err();
        assert_eq!(refusal, EditError::NotPlaced { vertex });
    }
    let vertex = editor.movable()[0];
    let refusal = editor.begin(&[vertex, vertex], &watch).unwrap_err();
    assert_eq!(refusal, EditError::Repeated { vertex });
    editor.begin(&[vertex], &watch).unwrap();
    let refusal = editor.begin(&[vertex], &watch).unwrap_err();
    assert_eq!(refusal, EditError::Editing { handles: 1 });
    let before = editor.uv().clone();
    let refusal = editor.move_to(&[DVec2::new(f64::NAN, 0.0)]).unwrap_err();
    assert!(matches!(refusal, EditError::NonFinite { .. }));
    let refusal = editor.move_to(&[DVec2::ZERO; 2]).unwrap_err();
    assert_eq!(
        refusal,
        EditError::PlaceCount {
            handles: 1,
            given: 2
        }
    );
    assert_eq!(*editor.uv(), before);
}
