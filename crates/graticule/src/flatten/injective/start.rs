//! An injective map to start from, whatever the shape of the patch.
//!
//! Convex boundaries and positive weights make a map injective (Tutte 1963, Floater 1997), but in
//! floating point what lies at the end of a tube comes to lie in one point: its image shrinks by
//! e^2π with each circumference of depth. So the patch is made coarse first, by edge collapses that
//! keep it a disk, until the map of what is left is injective by exact predicates; then the
//! vertices come back one by one, each at a place among its neighbours that flips none of its
//! triangles, of which there always is one (next to the vertex it was collapsed to). From time to
//! time the whole map is relaxed, so that every triangle has about the size it has on the surface
//! and there is room for the next ones.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Overlap;
use super::collapse::{Coarsening, Collapse};
use super::contacts::Apart;
use super::energy::DistortionEnergy;
use super::insertion::{Star, first_where};
use super::newton::{Goal, descend};
use super::objective::{Objective, Triangles};
use super::rim::Rim;
use super::system::NewtonSystem;
use crate::flatten::FlattenError;
use crate::measure::SourceTriangle;
use crate::mesh::{BoundaryLoopId, TriangleMesh};
use crate::solve::{DirichletSystem, Placement, SymmetricMatrix};
use crate::tolerance::SHORTEST_SIDE;
use crate::watch::Watch;

/// Vertices of the coarsest map: few enough for its boundary to be near everything.
const COARSEST: usize = 60;

/// By how much the vertices may grow before the map is relaxed again.
const GROWTH: usize = 3;

/// Halvings of the way to the best place of a boundary vertex that is not clear.
const HALVINGS: usize = 6;

/// How far coarse maps are relaxed: their vertices will move again.
const RELAXED: Goal = Goal {
    gain: 1e-3,
    iterations: 40,
    patience: f64::INFINITY,
};

/// A disk in space: triangles over points.
pub(super) struct Disk {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) points: Vec<DVec3>,
    pub(super) on_boundary: Vec<bool>,
    /// How much each triangle counts, per area.
    pub(super) importance: Vec<f64>,
}

/// What is asked of a coarse map.
#[derive(Clone, Copy)]
pub(super) struct Demand {
    pub(super) energy: DistortionEnergy,
    pub(super) overlap: Overlap,
    /// The energy above which a relaxed map is given up.
    pub(super) patience: f64,
}

impl Demand {
    /// No patience is lost.
    pub(super) fn patient(energy: DistortionEnergy, overlap: Overlap) -> Self {
        Self {
            energy,
            overlap,
            patience: f64::INFINITY,
        }
    }
}

/// Lays the disk down without a flip, with its boundary in the given places: on a convex polygon such
/// that no edge inside joins two vertices of one side. The places inside are near a minimum of the
/// energy.
pub(super) fn start_within(
    disk: &Disk,
    outline: Vec<DVec2>,
    energy: DistortionEnergy,
    watch: &Watch,
) -> Result<Vec<DVec2>, FlattenError> {
    let coarse = Coarsening::new(&disk.triangles, &disk.points, disk.on_boundary.clone());
    let outer = disk.on_boundary.iter().filter(|&&is_outer| is_outer);
    let coarsest = outer.count() + COARSEST;
    refined(
        disk,
        Some(outline),
        Demand::patient(energy, Overlap::Allowed),
        (coarse.keeping_boundary(), coarsest),
        watch,
    )
}

/// Lays the disk down without a flip; the places are near a minimum of the energy. With overlap
/// forbidden, the boundary does not meet itself either.
pub(super) fn start(
    disk: &Disk,
    demand: Demand,
    watch: &Watch,
) -> Result<Vec<DVec2>, FlattenError> {
    let coarse = Coarsening::new(&disk.triangles, &disk.points, disk.on_boundary.clone());
    refined(disk, None, demand, (coarse, COARSEST), watch)
}

fn refined(
    disk: &Disk,
    outline: Option<Vec<DVec2>>,
    demand: Demand,
    (mut coarse, coarsest): (Coarsening, usize),
    watch: &Watch,
) -> Result<Vec<DVec2>, FlattenError> {
    let stage = watch.stage("coarsen");
    let mut pauses = coarsen(&mut coarse, coarsest, watch)?;
    drop(stage);
    let _stage = watch.stage("lay down from coarse to fine");
    let mut refinement = Refinement {
        disk,
        demand,
        places: vec![DVec2::ZERO; disk.points.len()],
        rim: None,
        outline,
        coarse,
    };
    while !refinement.lay_coarsest()? {
        let vertices = refinement.coarse.vertex_count();
        pauses.extend(coarsen(&mut refinement.coarse, vertices / 2, watch)?);
        if refinement.coarse.vertex_count() == vertices {
            return Err(FlattenError::NoRoom { vertices });
        }
    }
    refinement.relax(watch)?;
    while let Some(pause) = pauses.pop() {
        refinement.refine_to(pause)?;
        if pause > 0 {
            refinement.relax(watch)?;
        }
    }
    Ok(refinement.places)
}

/// Takes vertices away until `target` are left or none can go; returns after how many collapses
/// the map should be relaxed on the way back.
fn coarsen(
    coarse: &mut Coarsening,
    target: usize,
    watch: &Watch,
) -> Result<Vec<usize>, FlattenError> {
    let mut pauses = vec![coarse.collapse_count()];
    let mut size = coarse.vertex_count();
    while coarse.vertex_count() > target && coarse.round() > 0 {
        watch.check()?;
        if coarse.vertex_count() * GROWTH < size {
            pauses.push(coarse.collapse_count());
            size = coarse.vertex_count();
        }
    }
    Ok(pauses)
}

struct Refinement<'a> {
    disk: &'a Disk,
    demand: Demand,
    /// By vertices of the disk; those that are gone have none worth the name.
    places: Vec<DVec2>,
    coarse: Coarsening,
    /// The boundary, where it must not meet itself.
    rim: Option<Rim>,
    /// Where the boundary stays, by vertices of the disk.
    outline: Option<Vec<DVec2>>,
}

impl Refinement<'_> {
    /// Lays what is left on a circle or its outline, each inner vertex in the middle of its
    /// neighbours. Whether
    /// no triangle is flipped, by exact predicates.
    fn lay_coarsest(&mut self) -> Result<bool, FlattenError> {
        let (vertices, triangles) = self.compact();
        let mesh = TriangleMesh::new(vertices.len(), &triangles)?;
        let rim: Vec<usize> = mesh
            .boundary_loop(BoundaryLoopId(0))
            .iter()
            .map(|&side| mesh.origin(side).0 as usize)
            .collect();
        let angle = |step: usize| TAU * step as f64 / rim.len() as f64;
        let circle: Vec<DVec2> = match &self.outline {
            Some(outline) => rim
                .iter()
                .map(|&index| outline[vertices[index] as usize])
                .collect(),
            None => (0..rim.len())
                .map(|step| DVec2::new(libm::cos(angle(step)), libm::sin(angle(step))))
                .collect(),
        };
        let edges = mesh.edges().map(|edge| {
            let ends = mesh.ends(mesh.edge_halfedge(edge));
            (ends.map(|end| end.0 as usize), 1.0)
        });
        let laplacian = SymmetricMatrix::laplacian(vertices.len(), edges)?;
        let values: Vec<f64> = circle
            .iter()
            .map(|p| p.x)
            .chain(circle.iter().map(|p| p.y))
            .collect();
        if self.demand.overlap == Overlap::Forbidden {
            self.rim = Some(Rim::new(
                rim.iter().map(|&index| vertices[index]),
                self.places.len(),
            ));
        }
        let solution =
            DirichletSystem::new(&laplacian, &rim, Placement::unknown())?.solve(&values)?;
        let [x, y] = [0, 1].map(|column| &solution.values[column * vertices.len()..]);
        for (index, &vertex) in vertices.iter().enumerate() {
            self.places[vertex as usize] = DVec2::new(x[index], y[index]);
        }
        let (triangles, _) = self.objective(&vertices, triangles);
        let places: Vec<DVec2> = vertices.iter().map(|&v| self.places[v as usize]).collect();
        Ok(triangles.value(&places).is_finite() || self.coarse.vertex_count() == 3)
    }

    /// The vertices still there, ascending, and the triangles by their numbers among them.
    fn compact(&self) -> (Vec<u32>, Vec<[u32; 3]>) {
        let corners: Vec<_> = self
            .coarse
            .triangles()
            .map(|t| self.coarse.triangle(t))
            .collect();
        let mut numbers = vec![u32::MAX; self.places.len()];
        for &vertex in corners.iter().flatten() {
            numbers[vertex as usize] = 0;
        }
        let mut vertices = Vec::new();
        for (vertex, number) in (0_u32..).zip(&mut numbers) {
            if *number == 0 {
                *number = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        let triangles = corners
            .into_iter()
            .map(|t| t.map(|vertex| numbers[vertex as usize]));
        (vertices, triangles.collect())
    }

    /// The energy of the triangles still there, and the points of the vertices.
    fn objective(&self, vertices: &[u32], corners: Vec<[u32; 3]>) -> (Triangles, Vec<DVec3>) {
        let points: Vec<DVec3> = vertices
            .iter()
            .map(|&v| self.disk.points[v as usize])
            .collect();
        let importance = self
            .coarse
            .triangles()
            .map(|t| self.disk.importance[t as usize]);
        let shapes = corners
            .iter()
            .map(|t| shape(t.map(|vertex| points[vertex as usize])));
        let (sources, weights): (Vec<_>, Vec<_>) = shapes
            .zip(importance)
            .map(|(source, importance)| (source, source.area() * importance))
            .unzip();
        let triangles = Triangles::new(self.demand.energy, corners, sources, weights);
        (triangles, points)
    }

    /// Relaxes the map of what is there.
    fn relax(&mut self, watch: &Watch) -> Result<(), FlattenError> {
        let (vertices, corners) = self.compact();
        let mut places: Vec<DVec2> = vertices.iter().map(|&v| self.places[v as usize]).collect();
        let (triangles, points) = self.objective(&vertices, corners);
        let is_fixed = |v: &u32| self.outline.is_some() && self.disk.on_boundary[*v as usize];
        let fixed: Vec<bool> = vertices.iter().map(is_fixed).collect();
        if self.outline.is_none() {
            let scale = triangles.best_scale(&places);
            for place in &mut places {
                *place *= scale;
            }
        }
        let mut system = NewtonSystem::new(triangles.corners(), &points, fixed)?;
        let goal = Goal {
            patience: self.demand.patience,
            ..RELAXED
        };
        let descent = match self.demand.overlap {
            Overlap::Allowed => descend(&triangles, &mut system, &mut places, goal, watch)?,
            Overlap::Forbidden => {
                let apart = Apart::new(&triangles, &points);
                descend(&apart, &mut system, &mut places, goal, watch)?
            }
        };
        let energy = descent.history.last().map_or(0.0, |step| step.energy);
        if energy > self.demand.patience {
            return Err(FlattenError::Jammed { energy });
        }
        for (&vertex, place) in vertices.iter().zip(places) {
            self.places[vertex as usize] = place;
        }
        Ok(())
    }

    /// Puts vertices back until `collapses` are left to undo.
    fn refine_to(&mut self, collapses: usize) -> Result<(), FlattenError> {
        if let Some(rim) = &mut self.rim {
            rim.locate(&self.places);
        }
        while self.coarse.collapse_count() > collapses {
            let Some(collapse) = self.coarse.restore() else {
                break;
            };
            let place = self.place(&collapse);
            let vertices = self.coarse.vertex_count();
            let place = place.ok_or(FlattenError::NoRoom { vertices })?;
            self.places[collapse.vertex as usize] = place;
        }
        Ok(())
    }

    fn place(&mut self, collapse: &Collapse) -> Option<DVec2> {
        let link = self.coarse.link(collapse);
        let point = |vertex: u32| self.disk.points[vertex as usize];
        let at = |vertex: u32| self.places[vertex as usize];
        let sources = link
            .iter()
            .map(|&[a, b]| shape([collapse.vertex, a, b].map(point)));
        let sources: Vec<_> = sources.collect();
        let importance = collapse
            .star
            .iter()
            .map(|&t| self.disk.importance[t as usize]);
        let weights: Vec<f64> = sources
            .iter()
            .zip(importance)
            .map(|(s, i)| s.area() * i)
            .collect();
        let star = Star {
            sides: link.iter().map(|side| side.map(at)).collect(),
            sources,
            weights: &weights,
            energy: self.demand.energy,
        };
        if self.coarse.is_on_boundary(collapse.vertex) {
            self.place_on_boundary(collapse, &link, &star)
        } else {
            star.inner_place(at(collapse.target))
                .map(|place| star.improved(place))
        }
    }

    fn place_on_boundary(
        &mut self,
        collapse: &Collapse,
        link: &[[u32; 2]],
        star: &Star<'_>,
    ) -> Option<DVec2> {
        let other = other_end(link, collapse.target)?;
        let ends = [collapse.target, other].map(|vertex| self.places[vertex as usize]);
        let Some(rim) = &mut self.rim else {
            let place = if link.len() == 1 {
                star.outer_place(|_| true)
            } else {
                star.boundary_place(ends, |_| true)
            };
            return place.map(|place| star.improved(place));
        };
        let is_clear = |place| rim.is_clear([collapse.target, other], place, &self.places);
        let place = if link.len() == 1 {
            star.outer_place(is_clear)
        } else {
            star.boundary_place(ends, is_clear)
        }?;
        // Towards the best place half as far as the boundary lets it, where that is not all the way:
        // the nearer to something else, the more it will be pushed.
        let improved = star.improved(place);
        let towards = |share| place.lerp(improved, share);
        let will_do = |place| star.admits(place) && is_clear(place);
        let place = if is_clear(improved) {
            improved
        } else {
            let farthest = first_where(towards, HALVINGS, will_do).unwrap_or(place);
            let halfway = place.midpoint(farthest);
            if will_do(halfway) { halfway } else { place }
        };
        self.places[collapse.vertex as usize] = place;
        rim.insert(collapse.vertex, [collapse.target, other], &self.places);
        Some(place)
    }
}

/// The boundary neighbour other than `target`: the links of a boundary vertex form a path.
fn other_end(link: &[[u32; 2]], target: u32) -> Option<u32> {
    let once = |vertex: &u32| link.iter().flatten().filter(|v| *v == vertex).count() == 1;
    link.iter()
        .flatten()
        .copied()
        .find(|vertex| *vertex != target && once(vertex))
}

/// The shape of a triangle in space at unit extent. Where coarsening left it none, any will do: it
/// will be gone when the map is finished.
fn shape(corners: [DVec3; 3]) -> SourceTriangle {
    let [a, b, c] = corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let regular = |side: f64| SourceTriangle::from_lengths([side; 3]);
    SourceTriangle::from_positions(corners)
        .or_else(|| regular(longest))
        .or_else(|| regular(SHORTEST_SIDE))
        .expect("a regular triangle has a shape")
}
