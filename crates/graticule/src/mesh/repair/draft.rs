use glam::DVec3;

use super::{RepairChanges, RepairError};
use crate::mesh::faces::{Faces, TriangleFaces};
use crate::mesh::gluing::{EdgeUses, FanVertices};
use crate::mesh::usable::UsablePolygons;
use crate::mesh::{HalfedgeId, MeshError, PolygonSoup, triangulate_polygon};
use crate::watch::Watch;

/// Triangles on their way to a sound surface.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// Of each vertex; before the first renumbering the soup's own.
    pub(super) positions: Vec<DVec3>,
    /// The soup vertex of each vertex.
    pub(super) vertex_sources: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The soup corner of each corner.
    pub(super) corner_sources: Vec<[u32; 3]>,
    /// The soup polygon of each triangle.
    pub(super) polygons: Vec<u32>,
    /// See [`Repaired`](super::Repaired).
    pub(super) stand_ins: Vec<[u32; 2]>,
}

impl Draft {
    /// Cuts the usable polygons into triangles, each kind of duplicate dropped before.
    pub(super) fn of(
        soup: &PolygonSoup,
        usable: &UsablePolygons,
        changes: &mut RepairChanges,
        watch: &Watch,
    ) -> Result<Self, RepairError> {
        let faces = &usable.faces;
        let count = faces.corner_count() - 2 * faces.face_count();
        check_count(count)?;
        let mut draft = Self {
            positions: soup.positions.clone(),
            vertex_sources: (0..soup.positions.len() as u32).collect(),
            triangles: Vec::with_capacity(count),
            corner_sources: Vec::with_capacity(count),
            polygons: Vec::with_capacity(count),
            stand_ins: Vec::new(),
        };
        let surplus = super::duplicates::find_surplus(faces);
        let mut places = Vec::new();
        for face in 0..faces.face_count() as u32 {
            if face % 4096 == 0 {
                watch.check()?;
            }
            match surplus.get(face as usize).copied().flatten() {
                Some(kept) => draft.record_surplus(usable, [face, kept], changes),
                None => draft.add_polygon(usable, face, &mut places),
            }
        }
        if count > faces.face_count() {
            draft.part_diagonals(usable);
        }
        Ok(draft)
    }

    pub(super) fn faces(&self) -> TriangleFaces<'_> {
        TriangleFaces(&self.triangles)
    }

    /// The side glued to each side, as [`EdgeUses::twins`] has it.
    pub(super) fn twins(&self) -> Vec<u32> {
        EdgeUses::of(&self.faces(), self.positions.len()).twins()
    }

    /// The soup vertices of an edge.
    pub(super) fn source_edge(&self, side: u32) -> [u32; 2] {
        let ends = self.faces().edge(side);
        ends.map(|vertex| self.vertex_sources[vertex as usize])
    }

    fn add_polygon(&mut self, usable: &UsablePolygons, face: u32, places: &mut Vec<DVec3>) {
        let corners = usable.faces.corners(face);
        let polygon = usable.polygon_sources[face as usize];
        places.clear();
        let vertices = usable.faces.vertices(face);
        if vertices.len() == 3 {
            return self.add_triangle(
                usable,
                [0, 1, 2].map(|place| corners.start + place),
                polygon,
            );
        }
        places.extend(
            vertices
                .iter()
                .map(|&vertex| self.positions[vertex as usize]),
        );
        for triangle in triangulate_polygon(places) {
            self.add_triangle(usable, triangle.map(|place| corners.start + place), polygon);
        }
    }

    /// A polygon that passes a vertex twice may yield a triangle with that vertex at two corners:
    /// it has no area and is left out.
    fn add_triangle(&mut self, usable: &UsablePolygons, corners: [u32; 3], polygon: u32) {
        let [a, b, c] = corners.map(|corner| usable.faces.origin(corner));
        if a != b && b != c && c != a {
            self.triangles.push([a, b, c]);
            self.corner_sources
                .push(corners.map(|corner| usable.corner_sources[corner as usize]));
            self.polygons.push(polygon);
        }
    }

    /// Lets the corners of a surplus polygon follow the one that is kept.
    fn record_surplus(
        &mut self,
        usable: &UsablePolygons,
        [face, kept]: [u32; 2],
        changes: &mut RepairChanges,
    ) {
        changes
            .duplicate_polygons_dropped
            .push(usable.polygon_sources[face as usize]);
        let faces = &usable.faces;
        let mut bearers: Vec<_> = faces
            .corners(kept)
            .map(|corner| (faces.origin(corner), corner))
            .collect();
        bearers.sort_unstable();
        for corner in faces.corners(face) {
            let vertex = faces.origin(corner);
            let place = bearers.partition_point(|&(bearer, _)| bearer < vertex);
            if let Some(&(_, bearer)) = bearers.get(place) {
                let pair = [corner, bearer].map(|corner| usable.corner_sources[corner as usize]);
                self.stand_ins.push(pair);
            }
        }
    }

    /// Two polygons that share two corners without a side between them may both have been cut
    /// there; then one of them is cut along another diagonal, so that no edge gets four faces.
    fn part_diagonals(&mut self, usable: &UsablePolygons) {
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            let uses = EdgeUses::of(&self.faces(), self.positions.len());
            let crowded = uses.iter().filter(|group| group.len() > 2);
            let pairs: Vec<_> = crowded
                .flat_map(|group| self.surplus_diagonals(usable, group))
                .collect();
            if pairs.is_empty() {
                return;
            }
            let mut touched = vec![false; self.triangles.len()];
            for pair in pairs {
                let triangles = pair.map(|side| side as usize / 3);
                let [left, right] =
                    pair.map(|side| self.faces().origin(HalfedgeId(side).previous().0));
                if left != right && triangles.iter().all(|&triangle| !touched[triangle]) {
                    self.exchange(pair);
                    for triangle in triangles {
                        touched[triangle] = true;
                    }
                }
            }
        }
    }

    /// The diagonals among the sides on one edge, without the first if nothing else is there.
    fn surplus_diagonals(&self, usable: &UsablePolygons, group: &[u32]) -> Vec<[u32; 2]> {
        let polygon = |side: u32| self.polygons[side as usize / 3];
        let mut diagonals: Vec<_> = group
            .iter()
            .copied()
            .filter(|&side| !self.is_polygon_side(usable, side))
            .collect();
        diagonals.sort_unstable_by_key(|&side| (polygon(side), side));
        let pairs = diagonals
            .chunk_by(|&a, &b| polygon(a) == polygon(b))
            .filter_map(|pair| <[u32; 2]>::try_from(pair).ok());
        let keep = usize::from(diagonals.len() == group.len());
        pairs.skip(keep).collect()
    }

    /// Whether a side of a triangle is a side of its polygon.
    fn is_polygon_side(&self, usable: &UsablePolygons, side: u32) -> bool {
        let corner = |side: u32| self.corner_sources.as_flattened()[side as usize];
        let source = |corner: u32| usable.corner_sources.partition_point(|&c| c < corner) as u32;
        let next = HalfedgeId(side).next().0;
        usable.faces.next(source(corner(side))) == source(corner(next))
    }

    /// Replaces the edge of two triangles that run along it in opposite directions by the other
    /// diagonal of their quad: (from, right, left) and (right, to, left). The ends of the old edge
    /// are carried on from the second triangle.
    pub(super) fn exchange(&mut self, [side, twin]: [u32; 2]) {
        let [side, twin] = [HalfedgeId(side), HalfedgeId(twin)];
        let quad = [twin.next(), twin.previous(), twin, side.previous()];
        let [first, second] = [side.face().0 as usize, twin.face().0 as usize];
        for table in [&mut self.triangles, &mut self.corner_sources] {
            let [from, right, to, left] = quad.map(|c| table.as_flattened()[c.0 as usize]);
            table[first] = [from, right, left];
            table[second] = [right, to, left];
        }
    }

    /// Gives the corners the vertices that their fans became.
    pub(super) fn renumber(&mut self, vertices: &FanVertices) {
        let corners = vertices.corner_vertices.chunks_exact(3);
        for (triangle, corners) in self.triangles.iter_mut().zip(corners) {
            triangle.copy_from_slice(corners);
        }
        let sources = vertices.sources.iter().map(|&source| source as usize);
        self.positions = sources
            .clone()
            .map(|source| self.positions[source])
            .collect();
        self.vertex_sources = sources.map(|source| self.vertex_sources[source]).collect();
    }

    /// Keeps the marked triangles.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
            let mut keep = keep.iter();
            values.retain(|_| keep.next().is_some_and(|&keep| keep));
        }
        retain(&mut self.triangles, keep);
        retain(&mut self.corner_sources, keep);
        retain(&mut self.polygons, keep);
    }

    /// Drops surplus triangles over the same vertices; returns whether there were any.
    pub(super) fn drop_duplicates(&mut self, changes: &mut RepairChanges) -> bool {
        let surplus = super::duplicates::find_surplus(&self.faces());
        if surplus.is_empty() {
            return false;
        }
        for (triangle, kept) in surplus.iter().enumerate() {
            if kept.is_some() {
                let polygon = self.polygons[triangle];
                if changes.duplicate_polygons_dropped.all().last() != Some(&polygon) {
                    changes.duplicate_polygons_dropped.push(polygon);
                }
            }
        }
        self.retain(&surplus.iter().map(Option::is_none).collect::<Vec<_>>());
        true
    }
}

fn check_count(triangles: usize) -> Result<(), MeshError> {
    let limit = u32::MAX as usize - 1;
    if triangles > limit / 3 {
        let corners = 3 * triangles;
        return Err(MeshError::TooLarge { corners, limit });
    }
    Ok(())
}
