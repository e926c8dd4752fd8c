//! A whole surface laid flat: cut into patches, each laid down without flips, all packed.

use glam::DVec2;
use serde::Serialize;

use super::injective::{InjectiveMap, InjectiveOptions, injective_map};
use super::packing::{IslandShape, Packing, PackingOptions, pack};
use super::seam_search::{SeamOptions, find_seam};
use super::{Descent, FlattenError, NotAPatch, Overlap, Patch};
use crate::geometry::normalized;
use crate::mesh::{
    ComponentId, Components, EdgeId, Element, FaceId, HalfedgeId, PerCorner, PerEdge, Submesh,
    Surface, Topology, cut_along,
};
use crate::tolerance::{JAMMED_ENERGY, SHORTER_SEAMS};
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
/// # Errors
/// [`FlattenError::Component`] names a component that is no patch and may not be cut.
pub fn lay_flat(
    surface: &Surface,
    options: &AtlasOptions,
    watch: &Watch,
) -> Result<Atlas, FlattenError> {
    let cut = cut_along(surface, options.seam.iter().copied())?.surface;
    let topology = Topology::of(cut.mesh());
    let mut draft = Draft {
        uncut: PerEdge::filled(surface.mesh().edge_count(), false),
        corners: PerCorner::filled(surface.mesh().halfedge_count(), 0),
        surface,
        options,
        charts: Vec::new(),
        place_count: 0,
    };
    for &edge in &options.uncut {
        draft.uncut[edge] = true;
    }
    let mut parts = Components::new(&cut, &topology);
    for component in (0..topology.components.len()).map(ComponentId::from_index) {
        watch.check()?;
        draft.add(&mut parts, &topology, component, watch)?;
    }
    draft.finish(watch)
}

/// A patch laid down, not yet packed.
struct Chart {
    places: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    island: AtlasIsland,
}

impl Chart {
    fn energy(&self) -> f64 {
        self.island.energy.unwrap_or(0.0)
    }
}

struct Draft<'a> {
    surface: &'a Surface,
    options: &'a AtlasOptions,
    uncut: PerEdge<bool>,
    charts: Vec<Chart>,
    /// Places of all charts.
    place_count: u32,
    /// The place of each corner among those of all charts.
    corners: PerCorner<u32>,
}

impl Draft<'_> {
    /// Lays one component down.
    fn add(
        &mut self,
        parts: &mut Components<'_>,
        topology: &Topology,
        component: ComponentId,
        watch: &Watch,
    ) -> Result<(), FlattenError> {
        let Ok(part) = parts.extract(component) else {
            self.add_point(parts.faces(component), topology, component, watch);
            return Ok(());
        };
        let chart = match self.laid(&part, watch) {
            Ok(chart) => chart,
            Err(NotLaid::NoPatch(NotAPatch::NoArea)) => {
                self.add_point(parts.faces(component), topology, component, watch);
                return Ok(());
            }
            Err(NotLaid::NoPatch(reason)) => {
                return Err(FlattenError::Component { component, reason });
            }
            Err(NotLaid::Error(error)) => return Err(error),
        };
        let first = self.place_count;
        self.place_count += chart.places.len() as u32;
        for (face, triangle) in chart.triangles.iter().enumerate() {
            for (side, vertex) in triangle.iter().enumerate() {
                let corner = HalfedgeId::from_index(3 * face + side);
                self.corners[part.corner_sources[corner]] = first + vertex;
            }
        }
        self.charts.push(chart);
        Ok(())
    }

    /// The component as a chart.
    ///
    /// Without overlaps a map may jam between the sides of a long seam. It is then made again along
    /// shorter ones, and the best is taken.
    fn laid(&self, part: &Submesh, watch: &Watch) -> Result<Chart, NotLaid> {
        let options = &self.options.injective;
        let Some(mut cut) = self.options.cut else {
            return chart(&Patch::new(part.surface.clone(), watch)?, options, watch);
        };
        let laid = |cut: &SeamOptions| -> Result<Chart, NotLaid> {
            chart(
                &Patch::new(self.opened(part, cut, watch)?, watch)?,
                options,
                watch,
            )
        };
        let mut best = laid(&cut)?;
        for _ in 0..SHORTER_SEAMS {
            let jammed = best.energy() > JAMMED_ENERGY * options.energy.least();
            if options.overlap == Overlap::Allowed || !jammed || cut.tips == 0 {
                break;
            }
            let message = format!(
                "a map without overlaps jams at the energy {:.3} along its seam: a shorter one is tried",
                best.energy()
            );
            watch.warn("jammed", message);
            cut.length_factor *= 2.0;
            let other = laid(&cut)?;
            if other.energy() < best.energy() {
                best = other;
            }
        }
        Ok(best)
    }

    /// The component cut open; its triangles keep their numbers.
    fn opened(
        &self,
        part: &Submesh,
        options: &SeamOptions,
        watch: &Watch,
    ) -> Result<Surface, FlattenError> {
        let (mesh, whole) = (part.surface.mesh(), self.surface.mesh());
        let source = |edge: EdgeId| whole.edge(part.corner_sources[mesh.edge_halfedge(edge)]);
        let may_cut = PerEdge::from_fn(mesh.edge_count(), |edge| !self.uncut[source(edge)]);
        let seam = find_seam(&normalized(&part.surface).0, &may_cut, options, watch)?;
        Ok(cut_along(&part.surface, seam.edges)?.surface)
    }

    /// Lays a component without area into one point.
    fn add_point(
        &mut self,
        faces: &[FaceId],
        topology: &Topology,
        component: ComponentId,
        watch: &Watch,
    ) {
        let message = format!("{component} has no area: it is laid into one point");
        watch.warn("component-without-area", message);
        let first = self.place_count;
        self.place_count += 1;
        for corner in faces.iter().flat_map(|face| face.halfedges()) {
            self.corners[corner] = first;
        }
        let counts = &topology.components[component];
        self.charts.push(Chart {
            places: vec![DVec2::ZERO],
            triangles: Vec::new(),
            island: AtlasIsland {
                faces: counts.faces,
                vertices: counts.vertices,
                boundary_loops: counts.boundary_loops,
                energy: None,
                descent: Descent::default(),
            },
        });
    }

    /// Whether the sides of an edge have different places.
    fn is_seam(&self, edge: EdgeId) -> bool {
        let mesh = self.surface.mesh();
        let side = mesh.edge_halfedge(edge);
        mesh.twin(side).is_some_and(|twin| {
            self.corners[side] != self.corners[twin.next()]
                || self.corners[side.next()] != self.corners[twin]
        })
    }

    fn finish(self, watch: &Watch) -> Result<Atlas, FlattenError> {
        let shapes: Vec<_> = self
            .charts
            .iter()
            .map(|chart| IslandShape {
                places: &chart.places,
                triangles: &chart.triangles,
            })
            .collect();
        let Packing { motions, side } = pack(&shapes, &self.options.packing, watch)?;
        let moved = self.charts.iter().zip(motions);
        let places = moved
            .flat_map(|(chart, motion)| chart.places.iter().map(move |&place| motion.apply(place)));
        let mesh = self.surface.mesh();
        let seam: Vec<EdgeId> = mesh.edges().filter(|&edge| self.is_seam(edge)).collect();
        let length = |&edge: &EdgeId| {
            self.surface
                .halfedge_vector(mesh.edge_halfedge(edge))
                .length()
        };
        Ok(Atlas {
            places: places.collect(),
            corners: self.corners,
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
}

/// Why a component was not laid down.
#[derive(Debug, thiserror::Error)]
enum NotLaid {
    #[error(transparent)]
    NoPatch(#[from] NotAPatch),
    #[error(transparent)]
    Error(#[from] FlattenError),
}

fn chart(patch: &Patch, options: &InjectiveOptions, watch: &Watch) -> Result<Chart, NotLaid> {
    let InjectiveMap {
        map,
        energy,
        descent,
    } = injective_map(patch, options, watch)?;
    let mesh = patch.mesh();
    Ok(Chart {
        places: map.uv.into_vec(),
        triangles: mesh
            .faces()
            .map(|face| mesh.triangle(face).map(|v| v.0))
            .collect(),
        island: AtlasIsland {
            faces: mesh.face_count(),
            vertices: mesh.vertex_count(),
            boundary_loops: mesh.boundary_loop_count(),
            energy: Some(energy),
            descent,
        },
    })
}
