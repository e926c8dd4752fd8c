//! A whole surface laid flat: cut into patches, each laid down without flips, all packed.

mod component;
mod parting;
mod piece;

use glam::DVec2;
use serde::Serialize;

use self::component::Tailor;
use self::piece::{NotLaid, Sheet};
use super::injective::InjectiveOptions;
use super::packing::{IslandShape, Packing, PackingOptions, pack};
use super::seam_search::SeamOptions;
use super::{Descent, FlattenError, NotAPatch};
use crate::mesh::{
    ComponentId, ComponentTopology, Components, EdgeId, Element, FaceId, HalfedgeId, PerCorner,
    PerEdge, Surface, Topology, cut_along,
};
use crate::watch::Watch;

/// How a whole surface is laid flat.
#[derive(Clone, Debug, PartialEq)]
pub struct AtlasOptions {
    /// Edges to cut along in any case.
    pub seam: Vec<EdgeId>,
    /// How pieces that are no patches, or would be distorted much, are cut further; `None` refuses
    /// the former and leaves the latter.
    pub cut: Option<SeamOptions>,
    /// Edges along which no further cut may run, such as diagonals of polygons.
    pub uncut: Vec<EdgeId>,
    /// How each patch is laid down.
    pub injective: InjectiveOptions,
    /// How the patches are packed.
    pub packing: PackingOptions,
}

/// A surface laid flat, at one scale: each patch at that at which its energy is least, which is near
/// that of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Atlas {
    /// Points of the plane, from the origin upwards and to the right, in the surface's unit.
    pub places: Vec<DVec2>,
    /// The point of each corner.
    pub corners: PerCorner<u32>,
    /// The edges inside the surface that were cut, ascending.
    pub seam: Vec<EdgeId>,
    /// Their length in space.
    pub seam_length: f64,
    /// The islands, in the order of their smallest triangle.
    pub islands: Vec<AtlasIsland>,
    /// The side of the square from the origin that holds all.
    pub side: f64,
}

/// A patch of an atlas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtlasIsland {
    /// Triangles.
    pub faces: usize,
    /// Vertices, those along the seam as often as it doubles them.
    pub vertices: usize,
    /// Boundary loops: one, and one for each hole.
    pub boundary_loops: usize,
    /// Mean energy by area; `None` where the patch has no area and was laid into one point.
    pub energy: Option<f64>,
    /// How the map was found.
    pub descent: Descent,
}

impl Atlas {
    /// The point of each corner.
    #[must_use]
    pub fn corner_uv(&self) -> PerCorner<DVec2> {
        self.corners.map(|&place| self.places[place as usize])
    }
}

/// Cuts, flattens and packs a surface of any number of components.
///
/// Where overlaps are forbidden and a piece has no map without them that is little distorted, such as
/// one with many handles, it is cut into several islands, if cutting is allowed.
///
/// # Errors
/// [`FlattenError::Component`] names a component that is no patch and may not be cut.
pub fn lay_flat(
    surface: &Surface,
    options: &AtlasOptions,
    watch: &Watch,
) -> Result<Atlas, FlattenError> {
    let cut = cut_along(surface, options.seam.iter().copied())?.surface;
    let topology = Topology::of(cut.mesh());
    let mut uncut = PerEdge::filled(surface.mesh().edge_count(), false);
    for &edge in &options.uncut {
        uncut[edge] = true;
    }
    let mut draft = Draft {
        tailor: Tailor {
            uncut: PerCorner::from_fn(surface.mesh().halfedge_count(), |side| {
                uncut[surface.mesh().edge(side)]
            }),
            cut: options.cut,
            injective: options.injective,
            watch,
        },
        surface,
        charts: Vec::new(),
    };
    let mut parts = Components::new(&cut, &topology);
    for component in (0..topology.components.len()).map(ComponentId::from_index) {
        watch.check()?;
        draft.add(&mut parts, &topology.components[component], component)?;
    }
    draft.finish(&options.packing)
}

/// A patch laid down, not yet packed.
struct Chart {
    places: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    /// The corners of the surface with their places.
    corners: Vec<(HalfedgeId, u32)>,
    island: AtlasIsland,
}

impl Chart {
    fn of(sheet: Sheet) -> Self {
        let Sheet { piece, map } = sheet;
        let mesh = piece.patch.mesh();
        let corners = piece.sources.enumerate();
        Self {
            triangles: mesh
                .faces()
                .map(|face| mesh.triangle(face).map(|v| v.0))
                .collect(),
            corners: corners
                .map(|(corner, &source)| (source, mesh.origin(corner).0))
                .collect(),
            island: AtlasIsland {
                faces: mesh.face_count(),
                vertices: mesh.vertex_count(),
                boundary_loops: mesh.boundary_loop_count(),
                energy: Some(map.energy),
                descent: map.descent,
            },
            places: map.map.uv.into_vec(),
        }
    }
}

struct Draft<'a> {
    surface: &'a Surface,
    tailor: Tailor<'a>,
    charts: Vec<Chart>,
}

impl Draft<'_> {
    /// Lays one component down.
    fn add(
        &mut self,
        parts: &mut Components<'_>,
        counts: &ComponentTopology,
        component: ComponentId,
    ) -> Result<(), FlattenError> {
        let Ok(part) = parts.extract(component) else {
            self.add_point(parts.faces(component), counts, component);
            return Ok(());
        };
        match self.tailor.lay(part) {
            Ok(sheets) => {
                if sheets.len() > 1 {
                    let message = format!(
                        "{component} has no map without overlaps along one seam that does not jam: it is laid into {} islands",
                        sheets.len()
                    );
                    self.tailor.watch.warn("divided", message);
                }
                self.charts.extend(sheets.into_iter().map(Chart::of));
            }
            Err(NotLaid::NoPatch(NotAPatch::NoArea)) => {
                self.add_point(parts.faces(component), counts, component);
            }
            Err(NotLaid::NoPatch(reason)) => {
                return Err(FlattenError::Component { component, reason });
            }
            Err(NotLaid::Error(error)) => return Err(error),
        }
        Ok(())
    }

    /// Lays a component without area into one point.
    fn add_point(&mut self, faces: &[FaceId], counts: &ComponentTopology, component: ComponentId) {
        let message = format!("{component} has no area: it is laid into one point");
        self.tailor.watch.warn("component-without-area", message);
        let corners = faces.iter().flat_map(|face| face.halfedges());
        self.charts.push(Chart {
            places: vec![DVec2::ZERO],
            triangles: Vec::new(),
            corners: corners.map(|corner| (corner, 0)).collect(),
            island: AtlasIsland {
                faces: counts.faces,
                vertices: counts.vertices,
                boundary_loops: counts.boundary_loops,
                energy: None,
                descent: Descent::default(),
            },
        });
    }

    /// Packs the charts.
    fn finish(mut self, packing: &PackingOptions) -> Result<Atlas, FlattenError> {
        self.charts
            .sort_by_key(|chart| chart.corners.iter().map(|&(corner, _)| corner).min());
        let shapes: Vec<_> = self
            .charts
            .iter()
            .map(|chart| IslandShape {
                places: &chart.places,
                triangles: &chart.triangles,
            })
            .collect();
        let Packing { motions, side } = pack(&shapes, packing, self.tailor.watch)?;
        let moved = self.charts.iter().zip(motions);
        let places = moved
            .flat_map(|(chart, motion)| chart.places.iter().map(move |&place| motion.apply(place)));
        let corners = self.corners();
        let mesh = self.surface.mesh();
        let is_seam = |edge: &EdgeId| {
            let side = mesh.edge_halfedge(*edge);
            mesh.twin(side).is_some_and(|twin| {
                corners[side] != corners[twin.next()] || corners[side.next()] != corners[twin]
            })
        };
        let seam: Vec<EdgeId> = mesh.edges().filter(is_seam).collect();
        let length = |&edge: &EdgeId| {
            self.surface
                .halfedge_vector(mesh.edge_halfedge(edge))
                .length()
        };
        Ok(Atlas {
            places: places.collect(),
            corners,
            // From 0: the sum of nothing would be -0.
            seam_length: seam
                .iter()
                .map(length)
                .fold(0.0, |sum, length| sum + length),
            seam,
            islands: self.charts.into_iter().map(|chart| chart.island).collect(),
            side,
        })
    }

    /// The place of each corner of the surface among those of all charts.
    fn corners(&self) -> PerCorner<u32> {
        let mut corners = PerCorner::filled(self.surface.mesh().halfedge_count(), 0);
        let mut first = 0;
        for chart in &self.charts {
            for &(corner, place) in &chart.corners {
                corners[corner] = first + place;
            }
            first += chart.places.len() as u32;
        }
        corners
    }
}
