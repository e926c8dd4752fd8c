use glam::DVec2;
use graticule::mesh::{Element, PerCorner, Surface};

use crate::checker::layout_box;
use crate::normals::smooth_shading;
use crate::{
    CheckerStyle, Color, DrawError, Eye, Figure, Lines, Paint, Panel, Shading, Triangles, View,
};

/// How space comes to the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// From a point at four times the extent of the surface: near parts are a little larger.
    #[default]
    Perspective,
    /// Along parallel lines: equal lengths across the view are equal in the picture.
    Orthographic,
}

/// How a surface is drawn in space.
#[derive(Clone, Debug)]
pub struct SurfaceStyle<'a> {
    /// Numbers shown as colours.
    pub figure: Option<Figure<'a>>,
    /// Squares in texture space, over the colours.
    pub checker: Option<CheckerStyle<'a>>,
    /// Texture coordinates whose seams are drawn.
    pub seams: Option<&'a PerCorner<DVec2>>,
    /// The colour without a figure.
    pub color: Color,
    /// From where the surface is seen.
    pub view: View,
    /// Whether near parts are a little larger.
    pub projection: Projection,
    /// Whether normals are averaged at the vertices, except across creases.
    pub smooth: bool,
    /// Whether the edges of the triangles are drawn, where they are not too dense to be seen.
    pub edges: bool,
    /// Whether the boundary is drawn.
    pub boundary: bool,
}

impl Default for SurfaceStyle<'_> {
    fn default() -> Self {
        Self {
            figure: None,
            checker: None,
            seams: None,
            color: Color::CLAY,
            view: View::Automatic,
            projection: Projection::Perspective,
            smooth: true,
            edges: false,
            boundary: true,
        }
    }
}

/// The surface in space, with light and shade.
///
/// The far side of triangles is tinted brown, so that inside-out parts show. Cost: near-linear in
/// the number of triangles.
///
/// # Errors
/// [`DrawError`] if values or coordinates do not fit the surface or make no layout, or the view
/// has no direction.
pub fn surface(surface: &Surface, style: &SurfaceStyle<'_>) -> Result<Panel, DrawError> {
    let frame = style.view.frame(surface)?;
    let (paint, legend) = match &style.figure {
        Some(figure) => figure
            .paint(surface)
            .map(|(paint, legend)| (paint, Some(legend)))?,
        None => (Paint::Uniform(style.color), None),
    };
    let checker = style.checker.map(|checker| checker.checker(surface));
    let triangles = Triangles {
        positions: surface.positions().as_slice().to_vec(),
        triangles: plain_triangles(surface),
        paint,
        checker: checker.transpose()?,
        shading: if style.smooth {
            smooth_shading(surface)
        } else {
            Shading::Flat
        },
    };
    let mut panel = Panel {
        eye: match style.projection {
            Projection::Perspective => Eye::Perspective(frame),
            Projection::Orthographic => Eye::Orthographic(frame),
        },
        layers: vec![triangles.into()],
        legend,
        caption: None,
        notes: Vec::new(),
    };
    if style.edges {
        panel = panel.with_layer(edge_lines(surface));
    }
    if let Some(uvs) = style.seams {
        layout_box(surface, uvs)?;
        panel = panel.with_layer(seam_lines(surface, uvs));
    }
    if style.boundary {
        panel = panel.with_layer(boundary_lines(surface));
    }
    Ok(panel)
}

/// The triangles as vertex numbers.
pub(crate) fn plain_triangles(surface: &Surface) -> Vec<[u32; 3]> {
    let mesh = surface.mesh();
    mesh.faces()
        .map(|face| mesh.triangle(face).map(|vertex| vertex.0))
        .collect()
}

/// A line layer for the edges of triangles: thin, fainter the denser they are.
pub(crate) fn faint_lines() -> Lines {
    let mut lines = Lines::new(Color::INK, 0.8);
    lines.opacity = 0.55;
    lines.fades = true;
    lines
}

fn edge_lines(surface: &Surface) -> Lines {
    let mesh = surface.mesh();
    let mut lines = faint_lines();
    for edge in mesh.edges() {
        lines.push(
            mesh.ends(mesh.edge_halfedge(edge))
                .map(|v| surface.position(v)),
        );
    }
    lines
}

fn boundary_lines(surface: &Surface) -> Lines {
    let mesh = surface.mesh();
    let mut lines = Lines::new(Color::INK, 2.2);
    for boundary_loop in mesh.boundary_loops() {
        let halfedges = mesh.boundary_loop(boundary_loop);
        let closed = halfedges.iter().chain(halfedges.first());
        lines.push(closed.map(|&halfedge| surface.position(mesh.origin(halfedge))));
    }
    lines
}

fn seam_lines(surface: &Surface, uvs: &PerCorner<DVec2>) -> Lines {
    let mesh = surface.mesh();
    let mut lines = Lines::new(Color::SEAM, 2.2);
    for edge in mesh.edges() {
        let halfedge = mesh.edge_halfedge(edge);
        if mesh
            .twin(halfedge)
            .is_some_and(|twin| is_seam(uvs, halfedge, twin))
        {
            lines.push(mesh.ends(halfedge).map(|vertex| surface.position(vertex)));
        }
    }
    lines
}

/// Whether the two triangles of an edge have different coordinates along it. Coordinates that are
/// not finite are equal to each other.
pub(crate) fn is_seam(
    uvs: &PerCorner<DVec2>,
    halfedge: graticule::mesh::HalfedgeId,
    twin: graticule::mesh::HalfedgeId,
) -> bool {
    let same = |a: DVec2, b: DVec2| a == b || !(a.is_finite() || b.is_finite());
    debug_assert!(halfedge.index() < uvs.len() && twin.index() < uvs.len());
    !(same(uvs[halfedge], uvs[twin.next()]) && same(uvs[halfedge.next()], uvs[twin]))
}
