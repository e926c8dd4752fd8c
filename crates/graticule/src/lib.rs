//! Graticule lays coordinate nets on triangle meshes: it flattens patches ([`DMA02`]), covers
//! whole surfaces with a periodic global parameterization ([`PGP06`]), and turns the net into
//! chart layouts and quad meshes.
//!
//! The modules stand in the order of the data's journey; each uses only those above it:
//!
//! | module | turns | into |
//! |---|---|---|
//! | [`mesh`] | a polygon soup | named defects, a repaired, oriented, manifold [`mesh::Surface`] |
//! | [`geometry`] | a surface | lengths, angles, areas, operators, an intrinsic Delaunay triangulation |
//! | [`solve`] | sparse matrices | factorisations held for reuse, checked solutions |
//! | [`measure`] | a map | flips, overlaps, distortion, a report |
//! | [`flatten`] | a patch | planar coordinates |
//! | [`field`] | a surface | a smooth field of crosses, its singularities, a scale without curl |
//! | [`periodic`] | a cross field | coordinates whose whole numbers form a net |
//! | [`quads`] | such coordinates | a quad mesh in its final shape |
//! | [`charts`] | such coordinates | a layout of charts, mostly squares |
//! | [`journey`] | the polygons of a file | all of this, as one would tell it |
//!
//! The library opens no files, prints nothing and starts no threads beyond rayon's pool.
//!
//! [`DMA02`]: papers::DMA02
//! [`PGP06`]: papers::PGP06
#![forbid(unsafe_code)]

pub mod charts;
pub mod field;
pub mod flatten;
pub mod geometry;
pub mod journey;
pub mod measure;
pub mod mesh;
pub mod papers;
pub mod periodic;
pub mod quads;
pub mod solve;
pub mod tolerance;
pub mod watch;

mod hint;

pub use hint::Hint;
