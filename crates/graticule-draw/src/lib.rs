//! Pictures of surfaces, figures on them, and their layouts in the plane; on the CPU, as PNG or
//! SVG.
//!
//! A [`Picture`] is made of [`Panel`]s, each a list of [`Layer`]s seen by one [`Eye`].
//! [`surface()`] and [`uv_layout()`] make the usual panels; further layers (lines, dots, triangles)
//! can be put on top. Nothing here opens a file.
//!
//! ```
//! use graticule::mesh::{PerCorner, Surface};
//! use graticule_draw::{CheckerStyle, LayoutStyle, SurfaceStyle, side_by_side, surface, uv_layout};
//!
//! let fixture = graticule_fixtures::bumpy_patch(6, 1);
//! let patch = Surface::from_triangles(fixture.positions, &fixture.triangles)?;
//! let mesh = patch.mesh();
//! let uvs = PerCorner::from_fn(mesh.halfedge_count(), |corner| {
//!     patch.position(mesh.origin(corner)).truncate()
//! });
//! let style = SurfaceStyle {
//!     checker: Some(CheckerStyle::fitting(&uvs)),
//!     ..SurfaceStyle::default()
//! };
//! let picture = side_by_side(vec![
//!     surface(&patch, &style)?.with_caption("the patch"),
//!     uv_layout(&patch, &uvs, &LayoutStyle::default())?.with_caption("its layout"),
//! ]);
//! assert!(picture.to_png().starts_with(b"\x89PNG"));
//! assert!(picture.to_svg().starts_with("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
// Pixels and samples are counted below 2^17 each way, and numbers are rounded or clamped to be
// non-negative before they become one.
#![allow(clippy::cast_sign_loss, clippy::cast_possible_wrap)]

mod camera;
mod checker;
mod color;
mod error;
mod figure;
mod iso_lines;
mod legend;
mod normals;
mod painter;
mod png_file;
mod raster;
mod scale;
mod scene;
mod sheet;
mod surface;
mod svg_file;
mod text;
mod uv_layout;
mod view;

pub use checker::{CheckerStyle, Squares, fitting_checker_side};
pub use color::{Color, ColorMap};
pub use error::{DrawError, MAX_SIDE};
pub use figure::{Figure, Values};
pub use iso_lines::{IsoLineStyle, iso_lines};
pub use scale::{ColorScale, Range};
pub use scene::{
    Checker, Eye, Layer, Legend, Lines, Paint, Panel, Picture, Points, Shading, Triangles,
    side_by_side,
};
pub use surface::{Projection, SurfaceStyle, surface};
pub use uv_layout::{LayoutStyle, uv_layout};
pub use view::{Frame, View};
