use glam::{DVec2, DVec3};
use graticule::mesh::{Element, FaceId, HalfedgeId, PerCorner, PerFace, Surface};

use crate::checker::{finite_faces, layout_box};
use crate::scene::in_plane;
use crate::surface::{faint_lines, is_seam};
use crate::{
    CheckerStyle, Color, DrawError, Eye, Figure, Legend, Lines, Paint, Panel, Points, Shading,
    Squares, Triangles,
};

/// Flipped triangles are ringed if there are no more than this; beyond, they are seen anyway.
const MOST_RINGS: usize = 200;

/// How a layout in the plane is drawn.
#[derive(Clone, Debug)]
pub struct LayoutStyle<'a> {
    /// Numbers shown as colours.
    pub figure: Option<Figure<'a>>,
    /// Squares of texture space, over the colours.
    pub checker: Option<Squares>,
    /// The colour without a figure.
    pub color: Color,
    /// Whether the edges of the triangles are drawn, where they are not too dense to be seen.
    pub edges: bool,
    /// Whether boundary and seams are drawn.
    pub boundary: bool,
    /// Whether flipped triangles are red and ringed, whatever their figure.
    pub flips: bool,
    /// Which triangles count as flipped; by default those whose corners run clockwise. A measure
    /// tells them from islands that are mirrored as a whole.
    pub flipped: Option<&'a PerFace<bool>>,
    /// Triangles that overlap others, drawn in orange unless they are flipped.
    pub overlapping: Option<&'a PerFace<bool>>,
}

impl Default for LayoutStyle<'_> {
    fn default() -> Self {
        Self {
            figure: None,
            checker: None,
            color: Color::CLAY,
            edges: true,
            boundary: true,
            flips: true,
            flipped: None,
            overlapping: None,
        }
    }
}

/// The triangles of a surface by their texture coordinates, u to the right and v up.
///
/// Triangles without finite coordinates are left out; a note tells how many, and how many are
/// flipped.
///
/// # Errors
/// [`DrawError`] if values or coordinates do not fit the surface, or the coordinates make no
/// layout: none finite, all equal, or overflowing.
pub fn uv_layout(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
    style: &LayoutStyle<'_>,
) -> Result<Panel, DrawError> {
    layout_box(surface, uvs)?;
    let faces = SortedFaces::of(surface, uvs, style);
    let (fill, legend) = filled(surface, uvs, style, &faces.sound)?;
    let orange = Paint::Uniform(Color::OVERLAPPING);
    let red = Paint::Uniform(Color::FLIPPED);
    // Flipped triangles come last, so that nothing covers them.
    let mut layers = vec![
        fill.into(),
        loose_triangles(uvs, &faces.overlapping, orange).into(),
        loose_triangles(uvs, &faces.flipped, red).into(),
    ];
    if style.edges {
        layers.push(edge_lines(surface, uvs).into());
    }
    if style.boundary {
        layers.push(outline(surface, uvs).into());
    }
    if !faces.flipped.is_empty() && faces.flipped.len() <= MOST_RINGS {
        layers.push(rings(uvs, &faces.flipped).into());
    }
    Ok(Panel {
        eye: Eye::Plane,
        layers,
        legend,
        caption: None,
        notes: faces.notes(),
    })
}

/// The triangles of a layout by how they are drawn.
struct SortedFaces {
    sound: Vec<FaceId>,
    overlapping: Vec<FaceId>,
    flipped: Vec<FaceId>,
    left_out: usize,
}

impl SortedFaces {
    fn of(surface: &Surface, uvs: &PerCorner<DVec2>, style: &LayoutStyle<'_>) -> Self {
        let flag = |flags: Option<&PerFace<bool>>, face: FaceId| {
            flags.and_then(|flags| flags.as_slice().get(face.index()).copied())
        };
        let is_flipped = |&face: &FaceId| {
            let given = flag(style.flipped, face);
            style.flips && given.unwrap_or_else(|| doubled_area(uvs, face) < 0.0)
        };
        let is_overlapping = |&face: &FaceId| flag(style.overlapping, face).unwrap_or_default();
        let (flipped, upright): (Vec<_>, Vec<_>) = finite_faces(surface, uvs).partition(is_flipped);
        let (overlapping, sound): (Vec<_>, Vec<_>) = upright.into_iter().partition(is_overlapping);
        let drawn = flipped.len() + overlapping.len() + sound.len();
        Self {
            left_out: surface.mesh().face_count() - drawn,
            sound,
            overlapping,
            flipped,
        }
    }

    fn notes(&self) -> Vec<String> {
        let note = |count: usize, kind: &str, more: &str| match count {
            0 => None,
            1 => Some(format!("1 {kind}triangle{more}")),
            _ => Some(format!("{count} {kind}triangles{more}")),
        };
        let notes = [
            note(self.flipped.len(), "flipped ", ""),
            note(self.overlapping.len(), "overlapping ", ""),
            note(self.left_out, "", " without coordinates"),
        ];
        notes.into_iter().flatten().collect()
    }
}

/// The triangles that have nothing to be marked for, in the colours of the style.
fn filled(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
    style: &LayoutStyle<'_>,
    faces: &[FaceId],
) -> Result<(Triangles, Option<Legend>), DrawError> {
    let (paint, legend) = match &style.figure {
        Some(figure) => figure
            .paint(surface)
            .map(|(paint, legend)| (paint, Some(legend)))?,
        None => (Paint::Uniform(style.color), None),
    };
    let mut fill = loose_triangles(uvs, faces, of_faces(paint, surface, faces));
    if let Some(squares) = style.checker {
        let mut checker = CheckerStyle { uvs, squares }.checker(surface)?;
        let corners = faces.iter().map(|face| checker.corners[face.index()]);
        checker.corners = corners.collect();
        fill.checker = Some(checker);
    }
    Ok((fill, legend))
}

/// Twice the signed area of a triangle in the layout.
fn doubled_area(uvs: &PerCorner<DVec2>, face: FaceId) -> f64 {
    let [a, b, c] = face.halfedges().map(|corner| uvs[corner]);
    // In units of the triangle, so that the product of two small sides does not vanish.
    let size = (b - a).abs().max((c - a).abs()).max_element();
    if size > 0.0 {
        ((b - a) / size).perp_dot((c - a) / size)
    } else {
        0.0
    }
}

/// These faces in the layout, each with vertices of its own.
fn loose_triangles(uvs: &PerCorner<DVec2>, faces: &[FaceId], paint: Paint) -> Triangles {
    let corners = faces.iter().flat_map(|face| face.halfedges());
    Triangles {
        positions: corners.map(|corner| in_plane(uvs[corner])).collect(),
        triangles: (0..faces.len() as u32)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        paint,
        checker: None,
        shading: Shading::Unlit,
    }
}

/// The paint of a surface for some of its faces, each with vertices of its own.
fn of_faces(paint: Paint, surface: &Surface, faces: &[FaceId]) -> Paint {
    match paint {
        Paint::Uniform(color) => Paint::Uniform(color),
        Paint::PerFace(colors) => {
            Paint::PerFace(faces.iter().map(|face| colors[face.index()]).collect())
        }
        Paint::PerVertex(values, map) => {
            let corners = faces.iter().flat_map(|face| face.halfedges());
            let value = |corner| values[surface.mesh().origin(corner).index()];
            Paint::PerVertex(corners.map(value).collect(), map)
        }
    }
}

/// The ends of a halfedge in the layout.
fn ends(uvs: &PerCorner<DVec2>, halfedge: HalfedgeId) -> [DVec3; 2] {
    [halfedge, halfedge.next()].map(|corner| in_plane(uvs[corner]))
}

fn is_drawn(uvs: &PerCorner<DVec2>, halfedge: HalfedgeId) -> bool {
    let corners = halfedge.face().halfedges();
    corners.iter().all(|&corner| uvs[corner].is_finite())
}

/// Edges inside the charts.
fn edge_lines(surface: &Surface, uvs: &PerCorner<DVec2>) -> Lines {
    let mesh = surface.mesh();
    let mut lines = faint_lines();
    for edge in mesh.edges() {
        let halfedge = mesh.edge_halfedge(edge);
        let inside = mesh
            .twin(halfedge)
            .is_some_and(|twin| !is_seam(uvs, halfedge, twin));
        if inside && is_drawn(uvs, halfedge) {
            lines.push(ends(uvs, halfedge));
        }
    }
    lines
}

/// The sides of triangles along the boundary, seams and triangles left out, joined to polylines.
fn outline(surface: &Surface, uvs: &PerCorner<DVec2>) -> Lines {
    let mesh = surface.mesh();
    let is_outline = |halfedge: HalfedgeId| {
        let inside = mesh
            .twin(halfedge)
            .is_some_and(|twin| is_drawn(uvs, twin) && !is_seam(uvs, halfedge, twin));
        is_drawn(uvs, halfedge) && !inside
    };
    let mut lines = Lines::new(Color::INK, 1.6);
    let mut drawn = vec![false; mesh.halfedge_count()];
    for first in mesh.halfedges() {
        if drawn[first.index()] || !is_outline(first) {
            continue;
        }
        let mut polyline = vec![in_plane(uvs[first])];
        let mut halfedge = first;
        while !drawn[halfedge.index()] {
            drawn[halfedge.index()] = true;
            polyline.push(in_plane(uvs[halfedge.next()]));
            // Round the vertex at the end, through the triangles of this chart.
            let mut following = halfedge.next();
            while let Some(twin) = mesh.twin(following).filter(|_| !is_outline(following)) {
                following = twin.next();
            }
            halfedge = following;
        }
        lines.push(polyline);
    }
    lines
}

fn rings(uvs: &PerCorner<DVec2>, faces: &[FaceId]) -> Points {
    let middle = |face: &FaceId| {
        let corners = face.halfedges().map(|corner| in_plane(uvs[corner]) / 3.0);
        corners.iter().sum()
    };
    Points {
        positions: faces.iter().map(middle).collect(),
        color: Color::FLIPPED,
        radius: 9.0,
        ring: true,
    }
}
