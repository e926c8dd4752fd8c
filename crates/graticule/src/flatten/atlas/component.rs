//! A component of a surface laid flat: cut so that its maps have little distortion and, on demand, no
//! overlaps.

use glam::DVec2;

use super::parting::way_apart;
use super::piece::{NotLaid, Parts, Piece, Sheet};
use crate::flatten::injective::{Patience, boundary_meetings, laid, strains};
use crate::flatten::seam::cut_to;
use crate::flatten::seam_search::{Seam, SeamOptions, find_seam};
use crate::flatten::{
    BoundaryFreedom, FlattenError, InjectiveMap, InjectiveOptions, Overlap, improve_map,
    injective_map,
};
use crate::geometry::normalized;
use crate::mesh::{EdgeId, PerCorner, PerEdge, PerVertex, Submesh, VertexId, cut_along};
use crate::tolerance::{JAMMED_COARSE_ENERGY, JAMMED_ENERGY, SHORTER_SEAMS, STRAINED_ENERGY};
use crate::watch::Watch;

/// The share of the length of a seam that another has at most to be worth a try in its place.
const SHORTER: f64 = 0.9;

/// Who cuts components and lays them flat.
pub(super) struct Tailor<'a> {
    /// Whether no cut may run along the edge of each side of the whole surface.
    pub(super) uncut: PerCorner<bool>,
    /// How seams are found; `None` if nothing may be cut.
    pub(super) cut: Option<SeamOptions>,
    pub(super) injective: InjectiveOptions,
    pub(super) watch: &'a Watch,
}

impl Tailor<'_> {
    /// The component laid flat, in one sheet if it can be.
    ///
    /// Without overlaps a map may jam between the sides of a long seam. It is then made again along
    /// shorter ones. If they do not help either, the map with overlaps is divided.
    pub(super) fn lay(&self, part: Submesh) -> Result<Vec<Sheet>, NotLaid> {
        let Some(cut) = self.cut else {
            let piece = Piece::new(part.surface, part.corner_sources, self.watch)?;
            let map = injective_map(&piece.patch, &self.injective, self.watch)?;
            return Ok(vec![Sheet { piece, map }]);
        };
        let seam = self.seam(&part, &cut)?;
        let free = self.relieved(self.opened(&part, &seam.edges)?, cut.tips)?;
        if self.will_do(&free) {
            return Ok(vec![free]);
        }
        if let Some(map) = self.apart(&free.piece)? {
            return Ok(vec![Sheet { map, ..free }]);
        }
        if let Some(sheet) = self.along_shorter_seam(&part, cut, seam)? {
            return Ok(vec![sheet]);
        }
        self.divided(free)
    }

    /// The edges to cut along.
    fn seam(&self, part: &Submesh, options: &SeamOptions) -> Result<Seam, FlattenError> {
        let mesh = part.surface.mesh();
        let may_cut = PerEdge::from_fn(mesh.edge_count(), |edge| {
            !self.uncut[part.corner_sources[mesh.edge_halfedge(edge)]]
        });
        let unit = normalized(&part.surface).0;
        find_seam(&unit, &may_cut, options, self.watch)
    }

    /// The component cut open.
    fn opened(&self, part: &Submesh, seam: &[EdgeId]) -> Result<Piece, NotLaid> {
        let opened = cut_along(&part.surface, seam.iter().copied()).map_err(FlattenError::from)?;
        Ok(Piece::new(
            opened.surface,
            part.corner_sources.clone(),
            self.watch,
        )?)
    }

    /// The edges of a piece along which no cut may run.
    fn uncut(&self, piece: &Piece) -> Vec<EdgeId> {
        let mesh = piece.patch.mesh();
        let is_uncut = |edge: &EdgeId| self.uncut[piece.sources[mesh.edge_halfedge(*edge)]];
        mesh.edges().filter(is_uncut).collect()
    }

    fn free(&self) -> InjectiveOptions {
        InjectiveOptions {
            overlap: Overlap::Allowed,
            ..self.injective
        }
    }

    fn is_above(&self, energy: f64, bound: f64) -> bool {
        energy > bound * self.injective.energy.least()
    }

    /// Whether a map that may overlap is all that is asked for.
    fn will_do(&self, free: &Sheet) -> bool {
        self.injective.overlap == Overlap::Allowed || free.is_one_to_one()
    }

    /// The map that may overlap. Where it is strained, the seam is led on to the vertex around which it
    /// is strained most, at most `tips` times; the best map counts.
    fn relieved(&self, piece: Piece, tips: usize) -> Result<Sheet, NotLaid> {
        let map = laid(&piece.patch, &self.free(), Patience::ENDLESS, self.watch)?;
        let mut best = Sheet { piece, map };
        let mut last: Option<Sheet> = None;
        for _ in 0..tips {
            if !self.is_above(best.map.energy, STRAINED_ENERGY) {
                break;
            }
            let Some(longer) = self.led_on(last.as_ref().unwrap_or(&best))? else {
                break;
            };
            let map = laid(&longer.patch, &self.free(), Patience::ENDLESS, self.watch)?;
            let sheet = Sheet { piece: longer, map };
            if sheet.map.energy < best.map.energy {
                (best, last) = (sheet, None);
            } else {
                last = Some(sheet);
            }
        }
        Ok(best)
    }

    /// The piece cut open to the vertex around which its map is strained most; nothing if there is no
    /// way to it or no vertex inside.
    fn led_on(&self, sheet: &Sheet) -> Result<Option<Piece>, NotLaid> {
        let Sheet { piece, map } = sheet;
        let Some(tip) = self.most_strained(piece, map)? else {
            return Ok(None);
        };
        let opened = match cut_to(&piece.patch, &[tip], &self.uncut(piece), self.watch) {
            Ok((patch, _)) => Piece {
                sources: piece.sources.clone(),
                patch,
            },
            Err(FlattenError::BadTarget { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        Ok(Some(opened))
    }

    fn most_strained(
        &self,
        piece: &Piece,
        map: &InjectiveMap,
    ) -> Result<Option<VertexId>, FlattenError> {
        let mesh = piece.patch.mesh();
        let strains = strains(&piece.patch, &map.map.uv, self.injective.energy, self.watch)?;
        let mut around = PerVertex::filled(mesh.vertex_count(), 0.0);
        for (face, &strain) in strains.enumerate() {
            for vertex in mesh.triangle(face) {
                around[vertex] += strain;
            }
        }
        let inner = mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v));
        Ok(inner.reduce(|best, next| {
            if around[next] > around[best] {
                next
            } else {
                best
            }
        }))
    }

    /// The map without overlaps, unless it jams.
    fn apart(&self, piece: &Piece) -> Result<Option<InjectiveMap>, FlattenError> {
        let least = self.injective.energy.least();
        let patience = Patience {
            coarse: JAMMED_COARSE_ENERGY * least,
            whole: JAMMED_ENERGY * least,
        };
        match laid(&piece.patch, &self.injective, patience, self.watch) {
            Ok(map) => Ok(Some(map)),
            Err(FlattenError::Jammed { .. } | FlattenError::NoRoom { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn along_shorter_seam(
        &self,
        part: &Submesh,
        mut options: SeamOptions,
        mut seam: Seam,
    ) -> Result<Option<Sheet>, NotLaid> {
        for _ in 0..SHORTER_SEAMS {
            options.length_factor *= 2.0;
            let shorter = self.seam(part, &options)?;
            if shorter.length > SHORTER * seam.length {
                continue;
            }
            let message = "a map without overlaps jams along its seam: a shorter one is tried";
            self.watch.warn("jammed", message);
            let piece = self.opened(part, &shorter.edges)?;
            let map = laid(&piece.patch, &self.free(), Patience::ENDLESS, self.watch)?;
            let sheet = Sheet { piece, map };
            if sheet.is_one_to_one() && !self.is_above(sheet.map.energy, JAMMED_ENERGY) {
                return Ok(Some(sheet));
            }
            if let Some(map) = self.apart(&sheet.piece)? {
                return Ok(Some(Sheet { map, ..sheet }));
            }
            seam = shorter;
        }
        Ok(None)
    }

    /// A map with overlaps divided until each part has one without them that does not jam.
    ///
    /// That is tried only of parts with at most half as many meetings of the boundary as the last one
    /// that jammed, of which they are a part: each try costs as much as many cuts.
    fn divided(&self, free: Sheet) -> Result<Vec<Sheet>, NotLaid> {
        let (piece, uv) = (free.piece, free.map.map.uv);
        let meetings = boundary_meetings(&piece.patch, &uv).len();
        let mut open = vec![((piece, uv), meetings)];
        let mut sheets = Vec::new();
        while let Some(((piece, uv), mut jammed_with)) = open.pop() {
            self.watch.check().map_err(FlattenError::from)?;
            let meetings = boundary_meetings(&piece.patch, &uv);
            if meetings.is_empty() {
                let free = BoundaryFreedom::Free;
                let map = improve_map(&piece.patch, &uv, free, &self.injective, self.watch)?;
                sheets.push(Sheet { piece, map });
                continue;
            }
            if meetings.len() <= jammed_with / 2 {
                if let Some(map) = self.apart(&piece)? {
                    sheets.push(Sheet { piece, map });
                    continue;
                }
                jammed_with = meetings.len();
            }
            match self.parts(&piece, &uv, &meetings)? {
                Some(parts) => open.extend(parts.into_iter().map(|part| (part, jammed_with))),
                None => sheets.push(self.patient(piece)?),
            }
        }
        Ok(sheets)
    }

    /// The piece in one sheet, however distorted.
    fn patient(&self, piece: Piece) -> Result<Sheet, FlattenError> {
        let map = laid(&piece.patch, &self.injective, Patience::ENDLESS, self.watch)?;
        Ok(Sheet { piece, map })
    }

    /// The parts of an overlapping map on both sides of a cut; nothing if there is no such cut.
    fn parts(
        &self,
        piece: &Piece,
        uv: &PerVertex<DVec2>,
        meetings: &[[[VertexId; 2]; 2]],
    ) -> Result<Option<Parts>, FlattenError> {
        let mut may_cut = PerEdge::filled(piece.patch.mesh().edge_count(), true);
        for edge in self.uncut(piece) {
            may_cut[edge] = false;
        }
        let Some(way) = way_apart(&piece.patch, meetings, may_cut) else {
            return Ok(None);
        };
        piece.divided(way, uv, self.watch)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec3;
    use graticule_fixtures::grid;

    use super::*;
    use crate::mesh::{Element, HalfedgeId, Surface};

    /// Three turns of a ramp, which laid flat lie on each other; no cut may run across the last ones of
    /// its triangles.
    #[test]
    fn a_map_that_overlaps_is_divided_into_parts_that_do_not() {
        let strip = grid(0.7, 3.0 * TAU, 6, 72);
        let low = strip.positions[0];
        let strip = strip.map(|p| {
            let (sin, cos) = libm::sincos(p.y - low.y);
            let radius = 1.0 - (p.x - low.x);
            DVec3::new(radius * cos, radius * sin, 0.05 * (p.y - low.y))
        });
        let ramp = Surface::from_triangles(strip.positions, &strip.triangles).unwrap();
        let sides = ramp.mesh().halfedge_count();
        let is_uncut = |side: HalfedgeId| 10 * side.index() > 9 * sides;
        let watch = Watch::new();
        let tailor = Tailor {
            uncut: PerCorner::from_fn(sides, is_uncut),
            cut: Some(SeamOptions::default()),
            injective: InjectiveOptions {
                overlap: Overlap::Forbidden,
                ..InjectiveOptions::default()
            },
            watch: &watch,
        };
        let sources = PerCorner::from_fn(sides, |side: HalfedgeId| side);
        let piece = Piece::new(ramp.clone(), sources, &watch).unwrap();
        let free = tailor.relieved(piece, 0).unwrap();
        assert!(!free.is_one_to_one());
        let sheets = tailor.divided(free).unwrap();
        assert!((2..=4).contains(&sheets.len()), "{}", sheets.len());
        let mut seen = PerCorner::filled(sides, 0);
        for Sheet { piece, map } in &sheets {
            assert!(map.energy < 4.3, "{}", map.energy);
            for &source in &piece.sources {
                seen[source] += 1;
            }
            for &side in piece.patch.mesh().boundary_loop(piece.patch.outer_loop()) {
                let source = piece.sources[side];
                assert!(ramp.mesh().twin(source).is_none() || !is_uncut(source));
            }
        }
        assert!(sheets.iter().all(Sheet::is_one_to_one));
        assert!(seen.iter().all(|&count| count == 1));
    }
}
