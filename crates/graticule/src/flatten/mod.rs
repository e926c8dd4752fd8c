//! Planar coordinates for a patch: [DMA02] §3 to §5.
//!
//! A [`Patch`] is a connected piece of surface of genus 0 with a boundary. A [`FlatMap`] gives each
//! of its vertices a point in the plane.
//!
//! | map | boundary | free of flips |
//! |---|---|---|
//! | [`fixed_map`], [`Weights::Uniform`], [`Weights::MeanValue`] | on a convex curve | yes, with holes closed |
//! | [`fixed_map`], [`Weights::Cotangent`] | on a convex curve | if no weight is negative |
//! | [`fixed_map`], [`Weights::DelaunayCotangent`] | on a circle | among the intrinsic triangles |
//! | [`fixed_map`], [`Weights::Intrinsic`]: authalic, and every [`Mix`] | on a convex curve | if no weight is negative |
//! | [`near_optimal_map`]: the best combination of two maps | on a curve | not promised |
//! | [`boundary_optimal_map`] | moved until a [`Functional`] is least | no more than at the start |
//! | [`natural_map`], [`spectral_map`] | free | not promised |
//! | [`target_map`]: told boundary lengths or angles, cones | as told | not promised |
//! | [`injective_map`] | free | yes |
//! | [`convex_map`] | on a convex polygon | yes |
//!
//! Every map tells its flips, counted exactly, whatever theory says. [`constrained_fixed_map`] and
//! [`constrained_natural_map`] lay given points at given places; a [`BoundaryEditor`] moves boundary
//! points by hand, the map following at once.
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

mod atlas;
mod boundary;
mod boundary_optimal;
mod collapse_time;
mod conformal;
mod constraints;
mod corners;
mod curve;
mod diameter;
mod domain;
mod editor;
mod energy;
mod equations;
mod error;
mod fixed;
mod flat_map;
mod functional;
mod injective;
mod lanczos;
mod least_squares;
mod limited_memory;
mod natural;
mod optimal;
mod packing;
mod patch;
mod polynomial;
mod rounding;
mod seam;
mod seam_search;
mod shape_guard;
mod spectral;
mod surface_line;
mod target;

pub use atlas::{Atlas, AtlasIsland, AtlasOptions, lay_flat};
pub use boundary::{BoundaryError, BoundaryPositions};
pub use boundary_optimal::{
    BoundaryOptimalMap, BoundaryOptimalOptions, DescentStep, boundary_optimal_map,
};
pub use conformal::Triangulation;
pub use constraints::{
    ConstrainedMap, PointConstraint, Strength, constrained_fixed_map, constrained_natural_map,
};
pub use corners::Corners;
pub use curve::{BoundaryCurve, boundary_on_curve};
pub use editor::{BoundaryEditor, EditError, EditorOptions};
pub use energy::MapEnergy;
pub use equations::{Mix, Weights};
pub use error::{FlattenError, PatchPointError};
pub use fixed::{FixedOptions, FixedSystem, Holes, fixed_map};
pub use flat_map::{FlatMap, FlipCount, Method};
pub use functional::Functional;
pub use injective::{
    BoundaryFreedom, Descent, DistortionEnergy, InjectiveMap, InjectiveOptions, NewtonStep,
    Overlap, convex_map, improve_map, injective_map,
};
pub use natural::{NaturalOptions, Pins, natural_map};
pub use optimal::{LambdaValue, NearOptimalMap, NearOptimalOptions, near_optimal_map};
pub use packing::{IslandShape, Motion, Packing, PackingOptions, pack};
pub use patch::{NotAPatch, Patch};
pub use rounding::hold_rounding;
pub use seam_search::{Seam, SeamOptions, find_seam};
pub use spectral::spectral_map;
pub use surface_line::{line_constraints, surface_line};
pub use target::{BoundaryTarget, Extension, TargetMap, TargetOptions, target_map};
