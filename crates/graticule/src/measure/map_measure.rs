use std::fmt;

use glam::DVec2;
use serde::Serialize;

use super::MeasureError;
use super::coverage::{self, Coverage};
use super::distortion::{self, Distortion};
use super::face::{self, FaceDistortion, FaceState};
use super::islands::{Island, IslandLoop, Islands, NO_ISLAND};
use super::overlap::{self, Crossings};
use super::statistics;
use super::uv_map::UvMap;
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, Surface, VertexId};
use crate::watch::Watch;

/// What can be said of a map from a surface to the plane. Made by [`measure_map`].
///
/// Serialized without [`elements`](Self::elements); keys are the names of the fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapMeasure {
    /// Whether the map is one to one, decided exactly: every triangle has coordinates and an area
    /// in the map, none is flipped, no vertex is folded, and no two triangles overlap, of the same
    /// or of different islands. Islands may touch and may be mirrored.
    pub bijective: bool,
    /// Triangles by what is wrong with them.
    pub faces: FaceCounts,
    /// Islands, their boundaries, seams.
    pub islands: IslandCounts,
    /// Overlaps.
    pub overlap: Overlap,
    /// Use of the plane; `None` where no triangle has an area in the map.
    pub packing: Option<Packing>,
    /// Distortion; `None` where no triangle can be measured.
    pub distortion: Option<Distortion>,
    /// What holds for single elements, for drawing.
    #[serde(skip)]
    pub elements: MapElements,
}

/// Triangles by what is wrong with them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaceCounts {
    /// All triangles.
    pub total: usize,
    /// Those with a corner without texture coordinates.
    pub without_uv: usize,
    /// Those with a texture coordinate that is not a finite number.
    pub non_finite_uv: usize,
    /// Those of zero area in space, for which there is no distortion; see
    /// [`tolerance::FLAT_TRIANGLE`](crate::tolerance::FLAT_TRIANGLE).
    pub flat_in_space: usize,
    /// Those oriented against most triangles of their island, by the exact sign of their area.
    pub flipped: usize,
    /// Share of the surface's area that flipped triangles hold, in `0.0..=1.0`.
    pub flipped_area_share: f64,
    /// Those that have an area in space and none in the map, or next to none; see
    /// [`tolerance::DEGENERATE_MAP_AREA`](crate::tolerance::DEGENERATE_MAP_AREA).
    pub degenerate: usize,
    /// Those whose area in the map is exactly zero.
    pub zero_uv_area: usize,
    /// Those that the distortion figures leave out: without usable coordinates, flat in space, or
    /// degenerate.
    pub left_out: usize,
    /// Share of the surface's area that the distortion figures leave out, in `0.0..=1.0`.
    pub left_out_area_share: f64,
    /// Area of the surface in squared units of the surface.
    pub surface_area: f64,
    /// Sum of the areas of the triangles in the map, in squared units of the map.
    pub uv_area: f64,
}

/// Islands, their boundaries, seams.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IslandCounts {
    /// The number of islands: parts joined by edges with equal coordinates on both sides.
    pub count: usize,
    /// Those most of whose triangles are turned over: seen from behind, not flipped.
    pub mirrored: usize,
    /// Those with the Euler characteristic of a disk.
    pub disks: usize,
    /// Boundary loops of all islands together.
    pub boundary_loops: usize,
    /// Edges along these loops; an edge on a seam counts once for each side.
    pub boundary_edges: usize,
    /// Length in space of the edges along which the surface is whole and the map is cut, each
    /// counted once, over the root of the surface's area.
    pub seam_length: f64,
    /// Vertices inside islands around which the map is not one to one: the triangles there have
    /// different orientations, or their angles in the map do not sum to 2π. Exact; a vertex of a
    /// triangle with zero area in the map is not judged.
    pub folded_vertices: usize,
}

/// Overlaps of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overlap {
    /// Whether two triangles share more than boundary points in the map. Exact on the numbers
    /// given: seams that met before a file was written with six digits may overlap by the
    /// rounding, and then [`area_share`](Self::area_share) tells that it is next to nothing.
    pub any: bool,
    /// Pairs of boundary edges of islands whose interiors meet in one point. Exact.
    pub boundary_crossings: u64,
    /// Whether all pairs were counted; else there are more.
    pub boundary_crossings_complete: bool,
    /// Share of the covered area that is covered more than once, by other islands or by folds, in
    /// `0.0..=1.0`; exactly 0 where [`any`](Self::any) is false, else an estimate along
    /// [`scan_lines`](Self::scan_lines).
    pub area_share: f64,
    /// The covers beyond the first, integrated, over the covered area: 1 where everything is
    /// covered twice. An estimate likewise.
    pub excess: f64,
    /// The number of evenly spaced lines across the map on which the covered lengths were
    /// measured; 0 where [`any`](Self::any) is false. A region of perimeter P is known to within P
    /// times half their distance.
    pub scan_lines: usize,
}

/// Use of the plane by a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Packing {
    /// The box around all coordinates: lowest u, lowest v, highest u, highest v.
    pub bounding_box: [f64; 4],
    /// The area covered, overlaps counted once, in squared units of the map. An estimate where
    /// triangles overlap.
    pub covered_area: f64,
    /// The covered area over that of the box; 0 where the box overflows.
    pub box_share: f64,
    /// The covered area over that of the square on the longer side of the box.
    pub square_share: f64,
    /// Whether all coordinates lie in the unit square.
    pub in_unit_square: bool,
}

/// What holds for single elements of a measured map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapElements {
    /// The distortion of each triangle.
    pub distortion: PerFace<FaceDistortion>,
    /// The island of each triangle, as an index into [`islands`](Self::islands); `None` without
    /// usable coordinates.
    pub face_islands: PerFace<Option<u32>>,
    /// The islands, in the order of their smallest triangle.
    pub islands: Vec<Island>,
    /// The boundary loops of the islands, in the order of their smallest halfedge.
    pub boundary_loops: Vec<IslandLoop>,
    /// The vertices counted in [`IslandCounts::folded_vertices`].
    pub folded_vertices: Vec<VertexId>,
    /// Two triangles that overlap, if there are any.
    pub overlapping_faces: Option<[FaceId; 2]>,
}

/// Measures a map given by the texture coordinates of each corner.
///
/// Coordinates that are not finite are counted and their triangles left out. Flips, folded
/// vertices, crossings and the existence of overlaps are decided exactly on the numbers given;
/// distortion is computed from singular values that are accurate on needles and at any scale.
/// Nothing depends on units, the same bytes come out for any number of threads.
///
/// Cost: near-linear time, some 200 bytes per triangle. Searching overlaps takes longer where the
/// boxes of many triangles or edges overlap without the shapes doing so.
///
/// # Errors
/// [`MeasureError`]: not one pair for each corner, extents beyond 1e±140, or stopped.
pub fn measure_map(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
    watch: &Watch,
) -> Result<MapMeasure, MeasureError> {
    check_count(surface, uvs.len())?;
    measure(surface, |corner| Some(uvs[corner]), watch)
}

/// Measures a map that may lack texture coordinates at some corners, as [`measure_map`].
///
/// Triangles with such a corner are counted apart, and no island reaches over them.
///
/// # Errors
/// As [`measure_map`].
pub fn measure_partial_map(
    surface: &Surface,
    uvs: &PerCorner<Option<DVec2>>,
    watch: &Watch,
) -> Result<MapMeasure, MeasureError> {
    check_count(surface, uvs.len())?;
    measure(surface, |corner| uvs[corner], watch)
}

/// The triangles that overlap another one in a map, for drawing (exact); triangles without usable
/// coordinates or without area do not count.
///
/// Cost: near-linear where few boxes of triangles overlap, or most triangles overlap others.
///
/// # Errors
/// As [`measure_map`].
pub fn overlapping_faces(
    surface: &Surface,
    uvs: &PerCorner<DVec2>,
    watch: &Watch,
) -> Result<PerFace<bool>, MeasureError> {
    check_count(surface, uvs.len())?;
    let map = UvMap::new(surface, |corner| Some(uvs[corner]))?;
    overlap::overlapping(&map, watch)
}

fn check_count(surface: &Surface, uvs: usize) -> Result<(), MeasureError> {
    let corners = surface.mesh().halfedge_count();
    if uvs == corners {
        Ok(())
    } else {
        Err(MeasureError::CornerCount { uvs, corners })
    }
}

fn measure(
    surface: &Surface,
    uv: impl Fn(HalfedgeId) -> Option<DVec2> + Sync,
    watch: &Watch,
) -> Result<MapMeasure, MeasureError> {
    let _stage = watch.stage("measure");
    let map = UvMap::new(surface, uv)?;
    watch.check()?;
    let mut islands = Islands::find(&map);
    watch.check()?;
    let faces = face::measure_faces(&map, &islands);
    let distortion = distortion::summarize(&map, &faces);
    watch.check()?;
    let (overlap, coverage, overlapping_faces) = measure_overlap(&map, &islands, &faces, watch)?;
    let packing = measure_packing(&map, &coverage);
    let distortion_of_faces = face::in_given_units(&map, faces);
    let counts = count_faces(&distortion_of_faces);
    add_areas(&mut islands, &distortion_of_faces);
    let usable = counts.without_uv == 0 && counts.non_finite_uv == 0 && counts.zero_uv_area == 0;
    Ok(MapMeasure {
        bijective: usable
            && counts.flipped == 0
            && islands.folded_vertices.is_empty()
            && !overlap.any,
        faces: counts,
        islands: count_islands(&map, &islands, &distortion_of_faces),
        overlap,
        packing,
        distortion,
        elements: MapElements {
            face_islands: PerFace::new(
                islands
                    .of_face
                    .iter()
                    .map(|&i| (i != NO_ISLAND).then_some(i))
                    .collect(),
            ),
            distortion: distortion_of_faces,
            islands: islands.all,
            boundary_loops: islands.loops,
            folded_vertices: islands.folded_vertices,
            overlapping_faces,
        },
    })
}

type OverlapFound = (Overlap, Coverage, Option<[FaceId; 2]>);

fn measure_overlap(
    map: &UvMap<'_>,
    islands: &Islands,
    faces: &[FaceDistortion],
    watch: &Watch,
) -> Result<OverlapFound, MeasureError> {
    let overlapping_faces = overlap::find_overlap(map, islands, watch)?;
    let is_apart = overlapping_faces.is_none();
    // Where two border edges cross, the triangles at them overlap, if they have an area.
    let crossings = if is_apart && map.has_area_everywhere() {
        Crossings::NONE
    } else {
        overlap::count_crossings(map, watch)?
    };
    let coverage = if is_apart {
        // Nothing is covered twice: the areas of the triangles are the covered area.
        Coverage {
            covered: statistics::sum(faces, |face| face.uv_area),
            ..Coverage::default()
        }
    } else {
        coverage::scan(map, watch)?
    };
    let share = |area: f64| {
        if coverage.covered > 0.0 {
            area / coverage.covered
        } else {
            0.0
        }
    };
    let overlap = Overlap {
        any: overlapping_faces.is_some(),
        boundary_crossings: crossings.count,
        boundary_crossings_complete: crossings.complete,
        area_share: share(coverage.overlapped),
        excess: share(coverage.excess),
        scan_lines: coverage.lines,
    };
    Ok((overlap, coverage, overlapping_faces))
}

fn measure_packing(map: &UvMap<'_>, coverage: &Coverage) -> Option<Packing> {
    let known = map
        .surface
        .mesh()
        .halfedges()
        .filter(|corner| map.is_known(corner.face()));
    let [low, high] = super::uv_map::box_around(known.map(|corner| map.uvs[corner]));
    let size = high - low;
    if coverage
        .covered
        .partial_cmp(&0.0)
        .is_none_or(std::cmp::Ordering::is_le)
    {
        return None;
    }
    let [low, high] = [low / map.uv_scale, high / map.uv_scale];
    Some(Packing {
        bounding_box: [low.x, low.y, high.x, high.y],
        covered_area: coverage.covered / map.uv_scale / map.uv_scale,
        box_share: coverage.covered / (size.x * size.y),
        square_share: coverage.covered / size.max_element().powi(2),
        in_unit_square: low.cmpge(DVec2::ZERO).all() && high.cmple(DVec2::ONE).all(),
    })
}

/// Sums over triangles.
#[derive(Clone, Copy, Default)]
struct FaceSums {
    without_uv: usize,
    non_finite_uv: usize,
    flat_in_space: usize,
    degenerate: usize,
    measured: usize,
    flipped: usize,
    zero_uv_area: usize,
    area: f64,
    flipped_area: f64,
    left_out_area: f64,
    uv_area: f64,
}

impl FaceSums {
    fn with(mut self, face: &FaceDistortion) -> Self {
        let in_state = match face.state {
            FaceState::WithoutUv => &mut self.without_uv,
            FaceState::NonFiniteUv => &mut self.non_finite_uv,
            FaceState::FlatInSpace => &mut self.flat_in_space,
            FaceState::Degenerate => &mut self.degenerate,
            FaceState::Measured => &mut self.measured,
        };
        *in_state += 1;
        let is_known = !matches!(face.state, FaceState::WithoutUv | FaceState::NonFiniteUv);
        self.zero_uv_area += usize::from(is_known && face.sign == 0);
        self.area += face.area;
        self.uv_area += face.uv_area;
        if face.flipped {
            self.flipped += 1;
            self.flipped_area += face.area;
        }
        if !face.measured() {
            self.left_out_area += face.area;
        }
        self
    }

    fn join(self, other: Self) -> Self {
        Self {
            without_uv: self.without_uv + other.without_uv,
            non_finite_uv: self.non_finite_uv + other.non_finite_uv,
            flat_in_space: self.flat_in_space + other.flat_in_space,
            degenerate: self.degenerate + other.degenerate,
            measured: self.measured + other.measured,
            flipped: self.flipped + other.flipped,
            zero_uv_area: self.zero_uv_area + other.zero_uv_area,
            area: self.area + other.area,
            flipped_area: self.flipped_area + other.flipped_area,
            left_out_area: self.left_out_area + other.left_out_area,
            uv_area: self.uv_area + other.uv_area,
        }
    }
}

fn count_faces(faces: &PerFace<FaceDistortion>) -> FaceCounts {
    let faces = faces.as_slice();
    let parts = statistics::by_chunks(faces, |chunk| {
        chunk.iter().fold(FaceSums::default(), FaceSums::with)
    });
    let sums = parts.into_iter().fold(FaceSums::default(), FaceSums::join);
    let share = |area: f64| {
        if sums.area > 0.0 {
            area / sums.area
        } else {
            0.0
        }
    };
    FaceCounts {
        total: faces.len(),
        without_uv: sums.without_uv,
        non_finite_uv: sums.non_finite_uv,
        flat_in_space: sums.flat_in_space,
        flipped: sums.flipped,
        flipped_area_share: share(sums.flipped_area),
        degenerate: sums.degenerate,
        zero_uv_area: sums.zero_uv_area,
        left_out: faces.len() - sums.measured,
        left_out_area_share: share(sums.left_out_area),
        surface_area: sums.area,
        uv_area: sums.uv_area,
    }
}

fn count_islands(
    map: &UvMap<'_>,
    islands: &Islands,
    faces: &PerFace<FaceDistortion>,
) -> IslandCounts {
    let area = statistics::sum(faces.as_slice(), |face| face.area).sqrt() * map.surface_scale;
    let all = &islands.all;
    IslandCounts {
        count: all.len(),
        mirrored: all.iter().filter(|island| island.mirrored).count(),
        disks: all
            .iter()
            .filter(|island| island.euler_characteristic == 1)
            .count(),
        boundary_loops: islands.loops.len(),
        boundary_edges: islands.border_edges,
        seam_length: if area > 0.0 {
            islands.seam_length / area
        } else {
            0.0
        },
        folded_vertices: islands.folded_vertices.len(),
    }
}

fn add_areas(islands: &mut Islands, faces: &PerFace<FaceDistortion>) {
    for (&island, face) in islands.of_face.iter().zip(faces) {
        if let Some(island) = islands.all.get_mut(island as usize) {
            island.surface_area += face.area;
            island.uv_area += face.uv_area;
        }
    }
}

impl fmt::Display for MapMeasure {
    /// A table of a few lines.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (faces, islands, overlap) = (&self.faces, &self.islands, &self.overlap);
        let bijective = if self.bijective { "yes" } else { "no" };
        let at_least = if overlap.boundary_crossings_complete {
            ""
        } else {
            "at least "
        };
        writeln!(f, "one to one           {bijective}")?;
        writeln!(
            f,
            "triangles            {} ({} flipped, {} degenerate, {} without coordinates)",
            faces.total,
            faces.flipped,
            faces.degenerate,
            faces.without_uv + faces.non_finite_uv
        )?;
        writeln!(
            f,
            "islands              {} ({} mirrored), {} boundary loops, {} folded vertices",
            islands.count, islands.mirrored, islands.boundary_loops, islands.folded_vertices
        )?;
        write!(f, "overlap              ")?;
        match self.elements.overlapping_faces {
            None => write!(f, "none")?,
            Some([a, b]) => {
                let percent = 100.0 * overlap.area_share;
                write!(f, "{percent:.4} % of the area, first {a} and {b}")?;
            }
        }
        writeln!(
            f,
            ", {at_least}{} boundary crossings",
            overlap.boundary_crossings
        )?;
        match &self.distortion {
            Some(distortion) => write_distortion(f, distortion)?,
            None => writeln!(f, "distortion           not measurable")?,
        }
        write!(
            f,
            "left out above       {} triangles, {:.4} % of the surface",
            faces.left_out,
            100.0 * faces.left_out_area_share
        )
    }
}

fn write_distortion(f: &mut fmt::Formatter<'_>, distortion: &Distortion) -> fmt::Result {
    let ratio = &distortion.quasi_conformal_error;
    let area = &distortion.area_scale;
    writeln!(
        f,
        "quasi-conformal      mean {:.5}, 95 % below {:.5}, max {:.5}",
        ratio.mean, ratio.p95, ratio.max
    )?;
    writeln!(
        f,
        "angle change         mean {:.4} degrees",
        distortion.angle_change_mean
    )?;
    writeln!(
        f,
        "area scale           mean |log| {:.5}, from {:.5} to {:.5}",
        area.log_mean, area.min, area.max
    )?;
    writeln!(
        f,
        "stretch              L2 {:.5}, Linf {:.5}",
        distortion.l2_stretch, distortion.linf_stretch
    )?;
    write!(f, "shear {:.5}", distortion.shear_mean)?;
    match distortion.symmetric_dirichlet {
        Some(energy) => writeln!(f, ", symmetric Dirichlet {energy:.5}"),
        None => writeln!(f),
    }
}
