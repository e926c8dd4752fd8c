//! Planar coordinates for a patch: [DMA02] §3.2, §4.1 and §4.2.
//!
//! A [`Patch`] is a connected piece of surface of genus 0 with a boundary. A [`FlatMap`] gives each
//! of its vertices a point in the plane.
//!
//! | map | boundary | free of flips |
//! |---|---|---|
//! | [`fixed_map`], [`Weights::Uniform`], [`Weights::MeanValue`] | on a convex curve | yes, with holes closed |
//! | [`fixed_map`], [`Weights::Cotangent`] | on a convex curve | if no weight is negative |
//! | [`fixed_map`], [`Weights::DelaunayCotangent`] | on a circle | among the intrinsic triangles |
//! | [`natural_map`], [`spectral_map`] | free | not promised |
//!
//! Every map tells its flips, counted exactly, whatever theory says.
//!
//! ```
//! use graticule::flatten::{BoundaryCurve, FixedOptions, Patch, boundary_on_curve, fixed_map};
//! use graticule::mesh::Surface;
//! use graticule::watch::Watch;
//! use glam::DVec3;
//!
//! // A pyramid without its base.
//! let mut positions = vec![DVec3::Z];
//! positions.extend([DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y]);
//! let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
//! let watch = Watch::new();
//! let patch = Patch::new(Surface::from_triangles(positions, &triangles)?, &watch)?;
//! let circle = boundary_on_curve(&patch, &BoundaryCurve::Circle, &watch)?;
//! let map = fixed_map(&patch, &circle, &FixedOptions::default(), &watch)?;
//! assert!(map.uv.as_slice()[0].length() < 1e-15);
//! assert!(map.flips.is_zero());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [DMA02]: crate::papers::DMA02

mod boundary;
mod conformal;
mod corners;
mod curve;
mod diameter;
mod domain;
mod energy;
mod error;
mod fixed;
mod flat_map;
mod lanczos;
mod least_squares;
mod natural;
mod patch;
mod spectral;

pub use boundary::{BoundaryError, BoundaryPositions};
pub use conformal::Triangulation;
pub use corners::Corners;
pub use curve::{BoundaryCurve, boundary_on_curve};
pub use energy::MapEnergy;
pub use error::FlattenError;
pub use fixed::{FixedOptions, FixedSystem, Holes, Weights, fixed_map};
pub use flat_map::{FlatMap, FlipCount, Method};
pub use natural::{NaturalOptions, Pins, natural_map};
pub use patch::{NotAPatch, Patch};
pub use spectral::spectral_map;
