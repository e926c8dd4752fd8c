//! Layouts of charts: surfaces cut along the lines of a map into disks, most of them squares of the
//! parameter plane ([PGP06] §3.3).
//!
//! [`chart_layout`] makes one of any surface: a [`ChartLayout`] holds the surface refined so that every
//! arc is a chain of its edges, with nodes, arcs and charts. [`base_complex`] is the polygon mesh of the
//! charts, with how coordinates go over from each to its neighbours.
//!
//! [`chart_maps`] lays each chart on a square, or on several ([PGP06] §3.4); [`chart_atlas`] puts the
//! squares side by side as texture coordinates; [`geometry_images`] and [`transfer_texture`] make images
//! of them.
//!
//! [PGP06]: crate::papers::PGP06
//!
//! ```
//! use graticule::charts::{
//!     Arrangement, ChartMapOptions, LayoutOptions, base_complex, chart_atlas, chart_layout, chart_maps,
//! };
//! use graticule::mesh::Surface;
//! use graticule::watch::Watch;
//!
//! let torus = graticule_fixtures::torus(2.0, 0.8, 60, 30);
//! let surface = Surface::from_triangles(torus.positions, &torus.triangles)?;
//! let watch = Watch::new();
//! let found = chart_layout(&surface, &LayoutOptions::default(), &watch)?;
//! let complex = base_complex(&found.layout);
//! assert_eq!(complex.euler_characteristic(), 0);
//! let maps = chart_maps(&surface, &found.layout, &ChartMapOptions::default(), &watch)?;
//! let atlas = chart_atlas(&maps, &Arrangement::default(), &watch)?;
//! assert_eq!(atlas.flipped, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arcs;
mod atlas;
mod atlas_packing;
mod atlas_sizes;
mod base_complex;
mod chart_map;
mod chart_map_assembly;
mod chart_map_polygon;
mod chart_map_squares;
#[cfg(test)]
mod chart_map_tests;
mod error;
mod geometry_image;
mod id;
mod layout;
mod layout_borders;
mod layout_corners;
#[cfg(test)]
pub(crate) mod layout_examples;
mod layout_map;
mod layout_refine;
mod layout_stage;
#[cfg(test)]
mod layout_surface_tests;
#[cfg(test)]
mod layout_tests;
mod layout_transition;
mod layout_unroll;
mod nodes;
mod relax;
mod split;
mod split_arcs;
mod split_mesh;
mod split_spokes;
mod texture;
mod texture_normals;
mod texture_raster;

pub use atlas::{Arrangement, ChartAtlas, Placement, Tiles, UDIM_COLUMNS, chart_atlas};
pub use base_complex::{BaseComplex, ChartNeighbor, base_complex};
pub use chart_map::{
    ChartMapCounts, ChartMapOptions, ChartMaps, ChartSquare, Seam, SeamSide, chart_maps,
};
pub use chart_map_polygon::ChartMethod;
pub use error::{ChartAtlasError, ChartMapError, LayoutError};
pub use geometry_image::{GeometryImage, geometry_images};
pub use id::{ArcId, ChartId, SquareId};
pub use layout::{Arc, ArcKind, Chart, ChartKind, ChartLayout, Direction, EmbeddedNet};
pub use layout_stage::{
    ChartLines, LaidOut, LayoutMap, LayoutOptions, LayoutReport, chart_layout, layout_from_map,
};
pub use layout_transition::ChartTransition;
pub use texture::{SourceTexture, TextureImage, TextureKind, TextureOptions, transfer_texture};
