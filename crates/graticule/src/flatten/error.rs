use crate::Hint;
use crate::geometry::GeometryError;
use crate::mesh::{ComponentId, FaceId, MeshError, VertexId};
use crate::solve::SolveError;
use crate::watch::Stopped;

use super::{Functional, NotAPatch};

/// Why a patch could not be flattened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlattenError {
    /// A pin is no vertex of the patch.
    #[error("{vertex} was to be pinned; the patch has {vertices} vertices, counted from 0")]
    NoSuchPin {
        /// The vertex asked for.
        vertex: VertexId,
        /// Vertices of the patch.
        vertices: usize,
    },
    /// Two pins are one.
    #[error("{vertex} was to be pinned twice; two different vertices are needed")]
    SamePin {
        /// The vertex.
        vertex: VertexId,
    },
    /// Pins without a distance, or with an infinite one, do not fix the scale.
    #[error("the pins' places are {distance:e} apart")]
    PinDistance {
        /// Distance of the places.
        distance: f64,
    },
    /// Rounding errors alone change the map.
    #[error("the pins do not determine the map: refining moves it by {change:e} of its size")]
    Undetermined {
        /// The last correction over the size of the map.
        change: f64,
    },
    /// The conformal energy of a very thin patch has lost all digits.
    #[error(
        "the patch is too thin for the precision of numbers: its area is {area:.1e} of its squared \
         extent"
    )]
    TooThin {
        /// Area over the square of the largest extent.
        area: f64,
    },
    /// A system made for some fixed vertices is given places of others.
    #[error(
        "places of {given} boundary vertices were given; the system was made for {expected}, not all the same"
    )]
    OtherBoundary {
        /// Fixed vertices of the system.
        expected: usize,
        /// Places given.
        given: usize,
    },
    /// Factors of the two intrinsic energies that make no mix.
    #[error("the mix λ = {lambda}, μ = {mu} is none: both must be finite, and one not zero")]
    BadMix {
        /// Factor of the conformal energy.
        lambda: f64,
        /// Factor of the authalic energy.
        mu: f64,
    },
    /// A constraint names no point of the patch, or no place, or no weight.
    #[error("constraint {constraint}: {reason}")]
    BadPoint {
        /// The constraint, counted from 0.
        constraint: usize,
        /// What is wrong with it.
        reason: PatchPointError,
    },
    /// A hard constraint contradicts the ones before it or the boundary.
    #[error(
        "constraint {constraint} contradicts the ones before it or the boundary: with them its \
         point lies {distance:e} beside its place"
    )]
    ContradictoryConstraint {
        /// The constraint, counted from 0.
        constraint: usize,
        /// How far apart the two places are along one coordinate.
        distance: f64,
    },
    /// Nothing fixes rotation and scale of a natural map.
    #[error("{different} different points have places; a natural map needs two")]
    TooFewConstraints {
        /// Constraints that do not follow from others.
        different: usize,
    },
    /// No line over the surface joins two points.
    #[error("no plane section of the patch leads from a point of {from} to one of {to}")]
    NoLine {
        /// Triangle of the first point.
        from: FaceId,
        /// Triangle of the second point.
        to: FaceId,
    },
    /// A vertex cannot be told a scale, a turning angle or a cone, or not this one.
    #[error("{vertex} {reason}")]
    BadTarget {
        /// The vertex.
        vertex: VertexId,
        /// What is wrong.
        reason: &'static str,
    },
    /// All turning angles are told and do not make the turn that the cones leave.
    #[error("the turning angles sum to {told} radians; with these cones they must to {needed}")]
    AngleSum {
        /// Their sum.
        told: f64,
        /// What it has to be.
        needed: f64,
    },
    /// No lengths close a curve with these turning angles.
    #[error("no boundary lengths close a curve with these turning angles")]
    Unclosable,
    /// A patch cut open is none.
    #[error(transparent)]
    Patch(#[from] NotAPatch),
    /// A functional that is infinite on collapsed triangles has no finite value to begin with.
    #[error("{functional:?} is infinite on every map tried: triangles are flipped or collapsed")]
    NoFiniteValue {
        /// The functional.
        functional: Functional,
    },
    /// The solution lies on a line or in a point.
    #[error("the map collapses: it has an area of {area:e} of its energy")]
    Collapsed {
        /// Area of the map over its Dirichlet energy.
        area: f64,
    },
    /// The map to improve has flips.
    #[error("the map to start from has {flipped} triangles turned over or collapsed")]
    StartFlipped {
        /// Number of such triangles.
        flipped: usize,
    },
    /// A map without overlaps has no way to little distortion.
    #[error("a map without overlaps jams at the energy {energy:e}")]
    Jammed {
        /// Its mean energy.
        energy: f64,
    },
    /// The map to improve without overlaps has some.
    #[error("the boundary of the map to start from meets itself")]
    StartOverlaps,
    /// A component of a surface is no patch.
    #[error("{component}: {reason}")]
    Component {
        /// The component.
        component: ComponentId,
        /// What is in the way.
        reason: NotAPatch,
    },
    /// Double precision has no place for a vertex among its neighbours.
    #[error("no place is left for one more vertex in a map of {vertices}, to double precision")]
    NoRoom {
        /// Vertices laid down so far.
        vertices: usize,
    },
    /// Triangles are too thin to compute with.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The patch with its holes closed is not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The linear system was not solved.
    #[error(transparent)]
    Solve(SolveError),
    /// The computation was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<SolveError> for FlattenError {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Solve(error),
        }
    }
}

impl Hint for FlattenError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::NoSuchPin { .. } | Self::SamePin { .. } => {
                "name two different vertices of the patch, or let the pins be chosen"
            }
            Self::PinDistance { .. } => "give the pins finite places apart from each other",
            Self::BadMix { .. } => "λ = 1, μ = 0 is conformal, λ = 0, μ = 1 authalic",
            Self::BadTarget { .. } => {
                "tell scales and angles to vertices of the outer boundary, cones to inner ones"
            }
            Self::AngleSum { .. } => "leave some angles untold: they share the rest",
            Self::Unclosable => "tell smaller turning angles, or none",
            Self::Patch(error) => return error.hint(),
            Self::BadPoint { .. } => {
                "give a triangle of the patch, weights of its corners with the sum 1, and a \
                 finite place"
            }
            Self::ContradictoryConstraint { .. } => {
                "remove this constraint, make it soft, or give it a place that agrees"
            }
            Self::TooFewConstraints { .. } => "give places to two different points at least",
            Self::NoLine { .. } => "constrain single points along the line instead",
            Self::NoFiniteValue { .. } => "use edge lengths or areas, or weights that flip nothing",
            Self::TooThin { .. } => {
                "use the natural method with fewer vertices, which keeps twice the digits, or fix the \
                 boundary"
            }
            Self::OtherBoundary { .. } => "make a new system for these vertices",
            Self::Undetermined { .. } | Self::Collapsed { .. } => {
                "choose other pins, or use the spectral method"
            }
            Self::StartOverlaps => "start from a convex boundary, or let the start be made",
            Self::Component { reason, .. } => return reason.hint(),
            Self::StartFlipped { .. } => {
                "start from mean value weights on a convex curve, or let the start be made"
            }
            Self::Jammed { .. } => "allow overlaps, or cut the surface into several pieces",
            Self::NoRoom { .. } => "remesh the thinnest parts of the patch more evenly",
            Self::Geometry(error) => return error.hint(),
            Self::Mesh(error) => return error.hint(),
            Self::Solve(error) => return error.hint(),
            Self::Stopped(stopped) => return stopped.hint(),
        };
        Some(text.into())
    }
}

/// What is wrong with a constrained point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PatchPointError {
    /// There is no such triangle.
    #[error("{face} was named; the patch has {faces} triangles, counted from 0")]
    NoSuchTriangle {
        /// The triangle.
        face: FaceId,
        /// Triangles of the patch.
        faces: usize,
    },
    /// The weights of the corners have another sum than 1.
    #[error("{barycentric:?} are no barycentric coordinates")]
    NotBarycentric {
        /// The weights.
        barycentric: [f64; 3],
    },
    /// The place is not finite.
    #[error("its place is ({}, {})", .place[0], .place[1])]
    NonFinitePlace {
        /// The place.
        place: [f64; 2],
    },
    /// The weight of a soft constraint is not positive.
    #[error("its weight is {weight}")]
    BadWeight {
        /// The weight.
        weight: f64,
    },
}
