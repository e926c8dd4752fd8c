//! The final shape of a quad mesh: its vertices slide along the surface until its polygons are as
//! rectangular as their connections allow.
//!
//! Each vertex in turn goes to the minimum of the inverse mean ratio of the corners around it
//! (P. Knupp, *Algebraic Mesh Quality Metrics*, 2001), measured against a rectangle with the
//! proportions that the quad was given, so that nets that follow a field stay as they are where
//! they are good; proportions that do not go with right angles give way. With the normals of the polygons held, that energy is a sum of convex functions of the
//! vertex, so that Newton steps find the minimum; inverted corners are smoothed over as in
//! [Escobar et al. 2003]. Then the worst corners are raised by a higher power of the energy and at
//! last by search.
//!
//! Every step is judged by the polygons as they come out on the surface: the energy falls, and no
//! polygon below [`POOR`](crate::tolerance::POOR_QUAD) becomes worse. So the least quality of the
//! mesh never falls.

mod colors;
mod energy;
mod freedom;
mod ground;
mod lines;
mod polygon;
mod proportions;
mod report;
mod run;

#[cfg(test)]
mod tests;

pub(super) use ground::{Ground, Place};
pub(super) use lines::Lines;
pub(super) use polygon::quality;
pub use report::{ShapeQuality, ShapeReport};
pub(super) use run::Run;

use crate::mesh::{EdgeId, Element, Polygons, Surface, SurfacePoint};
use crate::watch::{Stopped, Watch};

/// A polygon mesh over points of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Net<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Edges of the surface along which features run.
    pub features: &'a [EdgeId],
    /// The polygons, as indices into the points.
    pub polygons: &'a Polygons,
    /// Edges of the polygon mesh that lie on features, each by its two vertices.
    pub feature_edges: &'a [[u32; 2]],
}

/// How [`shape()`] works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeOptions {
    /// Most times that each vertex is moved.
    pub sweeps: usize,
    /// How far quads keep the proportions they have, from 0 (all are to become squares) to 1.
    pub keep_proportions: f64,
    /// How far a vertex may go in all, over the mean length of the edges that it begins with, or that
    /// of all edges where that is larger.
    pub reach: f64,
}

impl Default for ShapeOptions {
    fn default() -> Self {
        Self {
            sweeps: 10,
            keep_proportions: 1.0,
            reach: 1.5,
        }
    }
}

/// What [`shape()`] has made.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaped {
    /// For each vertex its point of the surface.
    pub origins: Vec<SurfacePoint>,
    /// Quality before and after.
    pub report: ShapeReport,
}

/// Why a mesh could not be shaped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A vertex of the polygon mesh is not on the surface.
    #[error("vertex {vertex} lies on face {face}, and the surface has {faces}")]
    NoSuchFace {
        /// The vertex of the polygon mesh.
        vertex: usize,
        /// The face it names.
        face: usize,
        /// Faces of the surface.
        faces: usize,
    },
    /// The weights of a point are no barycentric coordinates.
    #[error("the weights of vertex {vertex} are {weights:?}; each is to be in 0..=1, their sum 1")]
    Weights {
        /// The vertex of the polygon mesh.
        vertex: usize,
        /// Its weights.
        weights: [f64; 3],
    },
    /// A number is out of its range.
    #[error("{name} is {value}; it can be {range}")]
    Option {
        /// The name of the option.
        name: &'static str,
        /// The number given.
        value: f64,
        /// The numbers allowed.
        range: &'static str,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl crate::Hint for ShapeError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::NoSuchFace { .. } | Self::Weights { .. } => {
                Some("give points of the surface that the mesh was made on".into())
            }
            Self::Option { .. } => None,
            Self::Stopped(stopped) => stopped.hint(),
        }
    }
}

/// Moves the vertices of a polygon mesh along its surface to improve the shape of its polygons.
///
/// Vertices stay on the surface. Those on the boundary of the mesh slide along the boundary of the
/// surface, those on feature edges along the features; where lines end, meet or bend sharply, and
/// where such a vertex does not lie on a line of the surface, it is fixed. No vertex goes farther
/// than [`ShapeOptions::reach`]. The least scaled Jacobian does not fall; polygons that are not
/// quads take part with the angles of the regular polygon.
///
/// Deterministic for any number of threads. Cost: near-linear; some ten thousand quads on a hundred
/// thousand triangles in a few tenths of a second.
///
/// # Errors
/// [`ShapeError`]: a point that is none of the surface, an option out of range, or stopped.
pub fn shape(
    net: &Net<'_>,
    origins: &[SurfacePoint],
    options: &ShapeOptions,
    watch: &Watch,
) -> Result<Shaped, ShapeError> {
    let _stage = watch.stage("shape quads");
    options.check()?;
    check_origins(net.surface, origins)?;
    let ground = Ground::of(net.surface, net.features);
    Run::new(&ground, net, origins, *options, |_| false).shape(watch)
}

impl ShapeOptions {
    fn check(&self) -> Result<(), ShapeError> {
        for (name, value, is_good, range) in [
            (
                "the share of proportions kept",
                self.keep_proportions,
                (0.0..=1.0).contains(&self.keep_proportions),
                "0 to 1",
            ),
            (
                "the reach of vertices",
                self.reach,
                (0.0..=f64::MAX).contains(&self.reach),
                "0 and above, finite",
            ),
        ] {
            if !is_good {
                return Err(ShapeError::Option { name, value, range });
            }
        }
        Ok(())
    }
}

fn check_origins(surface: &Surface, origins: &[SurfacePoint]) -> Result<(), ShapeError> {
    let faces = surface.mesh().face_count();
    for (vertex, origin) in origins.iter().enumerate() {
        let weights = origin.barycentric;
        if origin.face.index() >= faces {
            let face = origin.face.index();
            return Err(ShapeError::NoSuchFace {
                vertex,
                face,
                faces,
            });
        }
        let sum: f64 = weights.iter().sum();
        let in_range = weights.iter().all(|weight| (0.0..=1.0).contains(weight));
        if !in_range || (sum - 1.0).abs() > crate::tolerance::BARYCENTRIC_SUM {
            return Err(ShapeError::Weights { vertex, weights });
        }
    }
    Ok(())
}
