//! The squares of one chart: its triangles cut out of the layout, split, and laid down.

use glam::DVec2;

use super::chart_map::SeamKey;
use super::chart_map_polygon::{
    ChartMethod, PolygonSide, corner_places, polygon_map, sides_along, square_energy, square_map,
};
use super::split::{ChartPlan, PlannedShape};
use super::split_arcs::{
    ArcStop, ArcUse, OutlinePlace, ParameterizedArc, border_halfedges, shares_of_length,
};
use super::split_mesh::{ChartDisk, NONE, TriangleOrigin, VertexName};
use super::split_spokes::{Spokes, cut_spokes};
use super::{ChartId, ChartLayout, ChartMapError, Direction};
use crate::mesh::{Element, FaceId, HalfedgeId, PerFace, Surface};
use crate::tolerance::SQUEEZED_CHART;
use crate::watch::Watch;

/// A chart, or a part of one, on the unit square.
#[derive(Clone, Debug)]
pub(super) struct MappedSquare {
    pub(super) disk: ChartDisk,
    /// For each vertex of the disk its place in the unit square.
    pub(super) places: Vec<DVec2>,
    pub(super) method: ChartMethod,
    /// Width and height in spacings of the net.
    pub(super) size: DVec2,
    /// What each side is made of, counter-clockwise from the origin of the square.
    pub(super) sides: [Vec<SidePiece>; 4],
}

/// A piece of a side of a square: a whole seam.
#[derive(Clone, Debug)]
pub(super) struct SidePiece {
    pub(super) key: SeamKey,
    /// Whether the side passes the seam from its end to its start.
    pub(super) is_reversed: bool,
    /// Where along the side it begins and ends.
    pub(super) shares: [f64; 2],
    /// Its vertices, in the order of the side.
    pub(super) vertices: Vec<u32>,
}

/// What all charts of a layout read.
pub(super) struct Layouted<'a> {
    pub(super) input: &'a Surface,
    pub(super) layout: &'a ChartLayout,
    pub(super) arcs: &'a [ParameterizedArc],
    /// The triangles of each chart, ascending.
    pub(super) faces: Vec<Vec<FaceId>>,
    /// The number of each triangle within its chart.
    pub(super) numbers: PerFace<u32>,
    /// Steps to less distortion, at most, for each square without the net's coordinates.
    steps: u32,
}

/// A vertex on the outline of a chart.
#[derive(Clone, Copy, Debug)]
struct OutlineVertex {
    vertex: u32,
    /// The length of the outline up to here.
    length: f64,
    /// On the arc that leads on from here.
    place: OutlinePlace,
    break_number: Option<u32>,
}

/// Triangles of one chart with the vertices of its outline.
#[derive(Clone)]
pub(super) struct OutlinedChart<'a> {
    chart: ChartId,
    /// Steps to less distortion, at most, for each square without the net's coordinates.
    steps: u32,
    plan: &'a ChartPlan,
    disk: ChartDisk,
    outline: Vec<OutlineVertex>,
}

impl<'a> Layouted<'a> {
    /// Finds the triangles of each chart.
    pub(super) fn new(
        input: &'a Surface,
        layout: &'a ChartLayout,
        arcs: &'a [ParameterizedArc],
        steps: u32,
    ) -> Self {
        let mut faces = vec![Vec::new(); layout.charts().len()];
        let numbers = layout.chart_of().enumerate().map(|(face, chart)| {
            let of_chart: &mut Vec<FaceId> = &mut faces[chart.index()];
            of_chart.push(face);
            of_chart.len() as u32 - 1
        });
        let numbers = PerFace::new(numbers.collect());
        Self {
            input,
            layout,
            arcs,
            faces,
            numbers,
            steps,
        }
    }

    /// The squares of a chart.
    pub(super) fn squares(
        &self,
        chart: ChartId,
        plan: &ChartPlan,
        watch: &Watch,
    ) -> Result<Vec<MappedSquare>, ChartMapError> {
        let outlined = self.outlined(chart, plan)?;
        match &plan.shape {
            PlannedShape::Net { size } => {
                let corners = corner_places_of(plan);
                Ok(vec![outlined.net_square(
                    &corners,
                    *size,
                    &self.net_places(chart),
                    watch,
                )?])
            }
            PlannedShape::Square { corners, size } => {
                let corners = outlined.corners(corners);
                Ok(vec![outlined.square(&corners, *size, watch)?])
            }
            PlannedShape::Split {
                corners,
                middles,
                side,
            } => match outlined.clone().split([corners, middles], *side, watch)? {
                Some(squares) => Ok(squares),
                None => Ok(vec![outlined.unsplit(*side, watch)?]),
            },
        }
    }

    /// A chart with the vertices of its outline.
    pub(super) fn outlined<'b>(
        &self,
        chart: ChartId,
        plan: &'b ChartPlan,
    ) -> Result<OutlinedChart<'b>, ChartMapError> {
        let mut disk = self.disk(chart)?;
        let outline = self.outline(&mut disk, chart, plan)?;
        Ok(OutlinedChart {
            chart,
            steps: self.steps,
            plan,
            disk,
            outline,
        })
    }

    /// The triangles of a chart.
    fn disk(&self, chart: ChartId) -> Result<ChartDisk, ChartMapError> {
        let (layout, mesh) = (self.layout, self.layout.surface().mesh());
        let halfedges = || {
            self.faces[chart.index()]
                .iter()
                .flat_map(|face| face.halfedges())
        };
        let corners = halfedges().map(|h| {
            let vertex = mesh.origin(h);
            (
                VertexName::Shared(vertex.0),
                layout.surface().position(vertex),
            )
        });
        let twins = halfedges().map(|h| {
            let twin = mesh
                .twin(h)
                .filter(|twin| layout.chart_of()[twin.face()] == chart);
            twin.map_or(NONE, |twin| self.number(twin))
        });
        let origins = self.faces[chart.index()]
            .iter()
            .map(|&face| self.origin(face));
        let origins: Vec<_> = origins
            .collect::<Option<_>>()
            .ok_or(ChartMapError::OtherInput)?;
        let corners: Vec<_> = corners.collect();
        Ok(ChartDisk::new(&corners, twins.collect(), origins, 0))
    }

    /// The number of a halfedge within its chart.
    fn number(&self, halfedge: HalfedgeId) -> u32 {
        3 * self.numbers[halfedge.face()] + halfedge.side() as u32
    }

    /// Where a triangle of the layout lies on the input.
    fn origin(&self, face: FaceId) -> Option<TriangleOrigin> {
        let refined = self.layout.refined();
        Some(TriangleOrigin {
            face: refined.face_origin[face],
            corners: refined.corner_weights(self.input.mesh(), face)?,
        })
    }

    /// Splits the border where arcs have new vertices and returns the outline.
    fn outline(
        &self,
        disk: &mut ChartDisk,
        chart: ChartId,
        plan: &ChartPlan,
    ) -> Result<Vec<OutlineVertex>, ChartMapError> {
        // All before the first split, which gives halfedges other numbers.
        let firsts = (plan.outline.passages.iter()).map(|arc| self.first_vertex(disk, *arc));
        let firsts: Option<Vec<u32>> = firsts.collect();
        let firsts = firsts.ok_or(ChartMapError::Border { chart })?;
        let mut outline = Vec::new();
        let passages = plan.outline.passages.iter().zip(firsts);
        for (passage, (arc, first)) in passages.enumerate() {
            let stops = self.arcs[arc.arc.index()].passed(arc.direction);
            let vertices = split_border(disk, first, &stops);
            let ends = stops.len() - 1;
            outline.extend(stops.iter().zip(vertices).take(ends).map(|(stop, vertex)| {
                let place = OutlinePlace {
                    passage,
                    share: stop.parameter,
                };
                OutlineVertex {
                    vertex,
                    length: plan.outline.length_at(place),
                    place,
                    break_number: stop.break_number,
                }
            }));
        }
        Ok(outline)
    }

    /// The vertex at which a chart begins to pass an arc.
    fn first_vertex(&self, disk: &ChartDisk, passage: ArcUse) -> Option<u32> {
        let mut chain = self.layout.arc(passage.arc).vertices.clone();
        if passage.direction == Direction::Backward {
            chain.reverse();
        }
        let sides = border_halfedges(self.layout, &chain)?;
        Some(disk.origin(self.number(sides[0])))
    }

    /// The coordinates of the net in a regular chart, by the numbers of its corners.
    fn net_places(&self, chart: ChartId) -> Vec<Option<DVec2>> {
        let corners = self.faces[chart.index()]
            .iter()
            .flat_map(|face| face.halfedges());
        corners
            .map(|corner| self.layout.coordinates()[corner])
            .collect()
    }
}

/// The places of a plan's four corners on its outline.
fn corner_places_of(plan: &ChartPlan) -> Vec<OutlinePlace> {
    let corners = &plan.outline.corners[..4];
    corners
        .iter()
        .map(|&length| plan.outline.place_at(length))
        .collect()
}

/// Puts the new vertices of an arc on the border from a vertex on; returns the vertices of all stops.
fn split_border(disk: &mut ChartDisk, first: u32, stops: &[ArcStop]) -> Vec<u32> {
    let mut vertices = vec![first];
    let mut at = first;
    // How much of the step of the chain lies behind.
    let mut behind = 0.0;
    for stop in &stops[1..] {
        let Some(halfedge) = disk.border_halfedge(at) else {
            break;
        };
        if let Some((_, share)) = stop.on_step {
            let rest = (share - behind) / (1.0 - behind);
            let onward = disk.split_edge(halfedge, rest, VertexName::Shared(stop.vertex));
            at = disk.origin(onward);
            behind = share;
        } else {
            at = disk.destination(halfedge);
            behind = 0.0;
        }
        vertices.push(at);
    }
    vertices
}

impl OutlinedChart<'_> {
    /// The number in the outline of the vertex at a place.
    ///
    /// By arc, not by length along the whole outline: beside long arcs there are some so short that
    /// lengths do not tell their ends apart.
    fn at(&self, place: OutlinePlace) -> usize {
        let next = (place.passage + 1) % self.plan.outline.passages.len();
        let distance = |&index: &usize| {
            let OutlinePlace { passage, share } = self.outline[index].place;
            if passage == place.passage {
                (share - place.share).abs()
            } else if passage == next {
                share + 1.0 - place.share
            } else {
                f64::INFINITY
            }
        };
        let order = |a: &usize, b: &usize| distance(a).total_cmp(&distance(b));
        // Corners of squares are marked, whatever lies next to them.
        self.marked().min_by(order).unwrap_or(0)
    }

    /// The numbers in the outline of the vertices where squares may have corners.
    fn marked(&self) -> impl Iterator<Item = usize> + '_ {
        let vertices = self.outline.iter().enumerate();
        let marked = vertices.filter(|(_, vertex)| vertex.break_number.is_some());
        marked.map(|(index, _)| index)
    }

    /// The vertices of the outline from one on to another, both included, with the length of the
    /// outline on from the first.
    fn stretch(&self, from: usize, to: usize) -> Vec<(OutlineVertex, f64)> {
        let count = self.outline.len();
        let steps = (to + count - from - 1) % count + 2;
        let whole = self.plan.outline.length();
        let start = self.outline[from].length;
        let vertices = (0..steps).map(|step| {
            let vertex = self.outline[(from + step) % count];
            let passed = if from + step >= count { whole } else { 0.0 };
            (vertex, vertex.length + passed - start)
        });
        vertices.collect()
    }

    /// A side of a polygon along the outline: each vertex with its share of the side, the last one
    /// too.
    fn shares(&self, from: usize, to: usize) -> Vec<(u32, f64)> {
        let stretch = self.stretch(from, to);
        let length = stretch.last().map_or(1.0, |&(_, length)| length);
        stretch
            .iter()
            .map(|(vertex, passed)| (vertex.vertex, passed / length))
            .collect()
    }

    /// The seams along the outline, with their shares of that part of the side from `start` to `end`.
    fn pieces(&self, from: usize, to: usize) -> Vec<SidePiece> {
        let stretch = self.stretch(from, to);
        let length = stretch.last().map_or(1.0, |&(_, length)| length);
        let mut pieces = Vec::new();
        let mut first = 0;
        for last in 1..stretch.len() {
            if stretch[last].0.break_number.is_none() {
                continue;
            }
            let part = &stretch[first..=last];
            let shares = [part[0].1 / length, part[last - first].1 / length];
            pieces.push(self.piece(part, shares));
            first = last;
        }
        pieces
    }

    fn piece(&self, part: &[(OutlineVertex, f64)], shares: [f64; 2]) -> SidePiece {
        let start = part[0].0;
        let passage = self.plan.outline.passages[start.place.passage];
        let is_reversed = passage.direction == Direction::Backward;
        // Counted along the arc; at the end of an arc passed backwards that is 0.
        let last = part[part.len() - 1].0;
        let first = match (is_reversed, last.place.passage == start.place.passage) {
            (false, _) => start.break_number,
            (true, true) => last.break_number,
            (true, false) => Some(0),
        };
        SidePiece {
            key: SeamKey::Arc(passage.arc, first.unwrap_or(0)),
            is_reversed,
            shares,
            vertices: part.iter().map(|(vertex, _)| vertex.vertex).collect(),
        }
    }

    /// The corners as numbers in the outline.
    fn corners(&self, places: &[OutlinePlace]) -> Vec<usize> {
        places.iter().map(|&place| self.at(place)).collect()
    }

    /// Sides of a polygon between corners, each without its last vertex.
    fn polygon_sides(&self, corners: &[usize]) -> Vec<PolygonSide> {
        let side = |k: usize| {
            let mut side = self.shares(corners[k], corners[(k + 1) % corners.len()]);
            side.pop();
            side
        };
        let sides: Vec<_> = (0..corners.len()).map(side).collect();
        sides_along(&corner_places(corners.len()), &sides)
    }

    fn side_pieces(&self, corners: &[usize]) -> [Vec<SidePiece>; 4] {
        [0, 1, 2, 3].map(|k| self.pieces(corners[k], corners[(k + 1) % 4]))
    }

    /// The chart with the coordinates of the net, unless these squeeze it and it is better off laid
    /// anew.
    fn net_square(
        self,
        corners: &[OutlinePlace],
        size: DVec2,
        net: &[Option<DVec2>],
        watch: &Watch,
    ) -> Result<MappedSquare, ChartMapError> {
        let numbers = self.corners(corners);
        let sides = self.polygon_sides(&numbers);
        let mut places = vec![DVec2::ZERO; self.disk.positions.len()];
        let given = net.len() / 3;
        // Triangles split along the border keep their inner corners.
        for (triangle, net) in self.disk.triangles[..given].iter().zip(net.chunks(3)) {
            for (&vertex, place) in triangle.iter().zip(net) {
                if let Some(place) = place {
                    places[vertex as usize] = *place / size;
                }
            }
        }
        for &(vertex, place) in sides.iter().flatten() {
            places[vertex as usize] = place;
        }
        let energy = square_energy(&self.disk, &sides, &places);
        if energy > SQUEEZED_CHART {
            let anew = self.clone().square(&numbers, size, watch);
            let is_better =
                |anew: &MappedSquare| square_energy(&anew.disk, &sides, &anew.places) < energy;
            if energy.is_infinite() || anew.as_ref().is_ok_and(is_better) {
                return anew;
            }
            watch.check()?;
        }
        Ok(MappedSquare {
            sides: self.side_pieces(&numbers),
            disk: self.disk,
            places,
            method: ChartMethod::Net,
            size,
        })
    }

    /// The chart laid onto the square.
    fn square(
        mut self,
        corners: &[usize],
        size: DVec2,
        watch: &Watch,
    ) -> Result<MappedSquare, ChartMapError> {
        let sides = self.polygon_sides(corners);
        let steps = self.steps;
        let (places, method) = square_map(&mut self.disk, &sides, self.chart, steps, watch)?;
        Ok(MappedSquare {
            sides: self.side_pieces(corners),
            disk: self.disk,
            places,
            method,
            size,
        })
    }

    /// The whole chart on one square, with four corners of those that it would have as several.
    pub(super) fn unsplit(self, side: f64, watch: &Watch) -> Result<MappedSquare, ChartMapError> {
        let marked: Vec<usize> = self.marked().collect();
        let corners = [0, 1, 2, 3].map(|k| marked[k * marked.len() / 4]);
        self.square(&corners, DVec2::splat(2.0 * side), watch)
    }

    /// The chart split from its centre to the middles of its sides, each part on a square; `None` where
    /// double precision does not suffice for that.
    fn split(
        mut self,
        corners_and_middles: [&[OutlinePlace]; 2],
        side: f64,
        watch: &Watch,
    ) -> Result<Option<Vec<MappedSquare>>, ChartMapError> {
        let [corners, middles] = corners_and_middles.map(|places| self.corners(places));
        let sides = self.polygon_sides(&corners);
        let (places, _) = polygon_map(&mut self.disk, &sides, self.chart, watch)?;
        let ends: Vec<u32> = middles.iter().map(|&m| self.outline[m].vertex).collect();
        let Some(spokes) = cut_spokes(&mut self.disk, &places, &ends) else {
            return Ok(None);
        };
        let mut made = self.disk.made_count();
        let mut squares = Vec::new();
        for (sector, &corner) in corners.iter().enumerate() {
            let before = (sector + corners.len() - 1) % corners.len();
            let sector = Sector {
                chart: &self,
                spokes: &spokes,
                numbers: [sector, before],
                border: [middles[before], corner, middles[sector]],
                side,
            };
            let Some(square) = sector.square(made, watch)? else {
                return Ok(None);
            };
            made = square.disk.made_count();
            squares.push(square);
        }
        Ok(Some(squares))
    }
}

/// What lies between two spokes: from a corner along the border to the middle of a side, to the
/// centre, to the middle of the side before, and back.
struct Sector<'a> {
    chart: &'a OutlinedChart<'a>,
    spokes: &'a Spokes,
    /// The spokes at its end and at its beginning.
    numbers: [usize; 2],
    /// Middle, corner and middle in the outline.
    border: [usize; 3],
    /// Width and height in spacings of the net.
    side: f64,
}

impl Sector<'_> {
    /// `None` if spokes between triangles without area part the chart elsewhere than at its sides.
    fn square(&self, made: u32, watch: &Watch) -> Result<Option<MappedSquare>, ChartMapError> {
        let [end, start] = self.numbers;
        let [before, corner, after] = self.border;
        let (mut disk, vertices) = self.chart.disk.part(&self.spokes.sectors[end]);
        disk.count_made_from(made);
        let in_part = |side: Vec<(u32, f64)>| -> Vec<(u32, f64)> {
            side.into_iter()
                .map(|(vertex, share)| (vertices[vertex as usize], share))
                .collect()
        };
        let inward = in_part(self.inward_shares(end));
        let outward = in_part(self.spoke_shares(start));
        let ahead = in_part(self.chart.shares(corner, after));
        let back = in_part(self.chart.shares(before, corner));
        let open = [&ahead, &inward, &outward, &back].map(|side| side[..side.len() - 1].to_vec());
        let OutlinedChart { chart, steps, .. } = *self.chart;
        let polygon = sides_along(&corner_places(4), &open);
        if polygon.iter().flatten().any(|&(vertex, _)| vertex == NONE) {
            return Ok(None);
        }
        let (places, method) = square_map(&mut disk, &polygon, chart, steps, watch)?;
        let border = |from, to| -> Vec<SidePiece> {
            let mut pieces = self.chart.pieces(from, to);
            for piece in &mut pieces {
                for vertex in &mut piece.vertices {
                    *vertex = vertices[*vertex as usize];
                }
            }
            pieces
        };
        Ok(Some(MappedSquare {
            sides: [
                border(corner, after),
                vec![self.spoke(end, inward, true)],
                vec![self.spoke(start, outward, false)],
                border(before, corner),
            ],
            disk,
            places,
            method,
            size: DVec2::splat(self.side),
        }))
    }

    /// The vertices of a spoke towards the centre, with their shares of its length from there on.
    fn inward_shares(&self, spoke: usize) -> Vec<(u32, f64)> {
        let outward = self.spoke_shares(spoke).into_iter().rev();
        outward
            .map(|(vertex, share)| (vertex, 1.0 - share))
            .collect()
    }

    /// The vertices of a spoke from the centre, with their shares of its length.
    fn spoke_shares(&self, spoke: usize) -> Vec<(u32, f64)> {
        let path = &self.spokes.paths[spoke];
        let at = |vertex: u32| self.chart.disk.positions[vertex as usize];
        let steps: Vec<f64> = path
            .windows(2)
            .map(|e| at(e[0]).distance(at(e[1])))
            .collect();
        let shares = shares_of_length(&steps);
        path.iter().copied().zip(shares).collect()
    }

    fn spoke(&self, spoke: usize, shares: Vec<(u32, f64)>, is_reversed: bool) -> SidePiece {
        SidePiece {
            key: SeamKey::Spoke(self.chart.chart, spoke as u32),
            is_reversed,
            shares: [0.0, 1.0],
            vertices: shares.into_iter().map(|(vertex, _)| vertex).collect(),
        }
    }
}
