use glam::DVec2;

use super::edge_nodes::EdgeNodes;
use super::line::{Lines, NO_LINE, Ratio, Steps, corner_steps, lines_through};
use super::overlay::{Overlay, border_darts, orientation_sign, twin};
use crate::mesh::{Element, FaceId, SurfacePoint, TriangleMesh};
use crate::periodic::GridMap;

/// A node on the border of a triangle.
#[derive(Clone, Copy, Debug)]
struct BorderNode {
    node: u32,
    /// The dart along the border that leaves it.
    dart: u32,
    lines: Lines,
    /// The corner that the side leaves from on which it lies.
    side: usize,
    /// Its coordinates, rounded.
    place: DVec2,
}

/// A piece of a line inside a triangle, from border to border, in the direction in which the other
/// coordinate grows.
#[derive(Clone, Copy, Debug)]
struct Chord {
    line: i32,
    /// Indices into the border.
    ends: [usize; 2],
}

/// The darts that leave a lattice point inside a triangle along +x, +y, -x, -y.
type Crossroads = [u32; 4];

/// Where a piece of a chord ends: the node, the coordinate along the chord, the lattice point.
type Stop = (u32, f64, Option<usize>);

/// The lines across one triangle: two lines cross inside it exactly where a lattice point lies
/// inside.
#[derive(Default)]
pub(super) struct TriangleCut {
    face: u32,
    corners: [Steps; 3],
    sign: f64,
    border: Vec<BorderNode>,
    /// Where on the border the corners lie.
    corner_places: [usize; 3],
    chords: [Vec<Chord>; 2],
    /// Darts into the triangle from the border: border node, family, dart, whether it leads towards
    /// larger coordinates.
    spokes: Vec<(usize, usize, u32, bool)>,
    crossings: Vec<Lines>,
    order: Vec<usize>,
    crossroads: Vec<Crossroads>,
    labels: Vec<(i32, usize)>,
}

impl TriangleCut {
    /// Collects the nodes on the border of the triangle and the lines between them.
    pub(super) fn gather(
        &mut self,
        mesh: &TriangleMesh,
        map: &GridMap,
        edge_nodes: &EdgeNodes,
        face: FaceId,
    ) {
        self.face = face.0;
        self.corners = face.halfedges().map(|corner| corner_steps(map, corner));
        self.sign = orientation_sign(map, face);
        self.gather_border(mesh, map, edge_nodes, face);
        for axis in 0..2 {
            self.find_chords(axis, map.is_left_out(face));
        }
        if self.sign == 0.0 {
            let [first, second] = &mut self.chords;
            second.retain(|chord| {
                let [a, b] = chord.ends;
                !(first.iter()).any(|other| other.ends == [a, b] || other.ends == [b, a])
            });
        }
    }

    fn gather_border(
        &mut self,
        mesh: &TriangleMesh,
        map: &GridMap,
        edge_nodes: &EdgeNodes,
        face: FaceId,
    ) {
        self.border.clear();
        let left_out = map.is_left_out(face);
        for (side, halfedge) in face.halfedges().into_iter().enumerate() {
            self.corner_places[side] = self.border.len();
            let corner = (
                mesh.origin(halfedge).0,
                0.0,
                lines_through(self.corners[side]),
            );
            let inner =
                (edge_nodes.along_halfedge(mesh, map, halfedge)).map(|(number, share, lines)| {
                    ((mesh.vertex_count() + number) as u32, share, lines)
                });
            let nodes = std::iter::once(corner).chain(inner);
            let [from, to] = [halfedge, halfedge.next()].map(|corner| map.coordinate(corner));
            let darts = border_darts(mesh, edge_nodes, halfedge);
            (self.border).extend(
                nodes
                    .zip(darts)
                    .map(|((node, share, lines), dart)| BorderNode {
                        node,
                        dart,
                        lines: if left_out { [NO_LINE; 2] } else { lines },
                        side,
                        place: from.lerp(to, share),
                    }),
            );
        }
    }

    fn find_chords(&mut self, axis: usize, left_out: bool) {
        self.chords[axis].clear();
        let [a, b, c] = self.corners.map(|corner| corner[axis]);
        if left_out || (a == b && b == c) {
            return;
        }
        self.labels.clear();
        let lines = self.border.iter().map(|node| node.lines[axis]);
        let on_lines = lines.enumerate().filter(|&(_, line)| line != NO_LINE);
        self.labels
            .extend(on_lines.map(|(index, line)| (line, index)));
        self.labels.sort_unstable();
        // A line along a side has no other point in the triangle.
        let side = match (a == b, b == c, c == a) {
            (true, ..) => lines_through(self.corners[0])[axis],
            (_, true, _) => lines_through(self.corners[1])[axis],
            (.., true) => lines_through(self.corners[2])[axis],
            _ => NO_LINE,
        };
        for group in self.labels.chunk_by(|a, b| a.0 == b.0) {
            if let &[(line, first), (_, second)] = group
                && line != side
            {
                let between = first + 1..second;
                let corner = (0..3).find(|&corner| between.contains(&self.corner_places[corner]));
                let grows = corner.is_some_and(|corner| {
                    self.corners[corner][axis] > i64::from(line) * super::line::STEPS
                });
                // What lies to the right of a line along which y grows has the larger x; along which
                // x grows, the smaller y; and the other way round in a triangle turned over.
                let forward = (grows == (axis == 0)) == (self.sign >= 0.0);
                let ends = if forward {
                    [first, second]
                } else {
                    [second, first]
                };
                self.chords[axis].push(Chord { line, ends });
            }
        }
    }

    /// Adds the triangle's lines, lattice points and faces to the overlay.
    pub(super) fn lay_down(&mut self, overlay: &mut Overlay) {
        let first_dart = overlay.origins.len() as u32;
        let first_node = overlay.points.len() as u32;
        self.add_lattice_points(overlay);
        self.spokes.clear();
        for axis in 0..2 {
            self.lay_chords(axis, first_node, overlay);
        }
        self.link(overlay);
        for node in &self.border {
            if node.lines.iter().all(|&line| line != NO_LINE) {
                overlay.lattice[node.node as usize] = true;
            }
            overlay.number_face(node.dart);
        }
        for dart in first_dart..overlay.origins.len() as u32 {
            overlay.number_face(dart);
        }
    }

    /// The other coordinate where a chord ends, exactly.
    fn end_of(&self, axis: usize, chord: &Chord, end: usize) -> Ratio {
        let index = chord.ends[end];
        let side = self.border[index].side;
        if self.corner_places[side] == index {
            return Ratio::of_steps(self.corners[side][1 - axis]);
        }
        let ends = [self.corners[side], self.corners[(side + 1) % 3]];
        Ratio::across(axis, chord.line, ends)
    }

    fn add_lattice_points(&mut self, overlay: &mut Overlay) {
        self.crossings.clear();
        self.crossroads.clear();
        if self.sign == 0.0 || self.chords.iter().any(Vec::is_empty) {
            return;
        }
        for chord in &self.chords[0] {
            let [from, to] = [0, 1].map(|end| self.end_of(0, chord, end));
            for other in from.wholes_between(to) {
                self.crossings.push([chord.line, other]);
                overlay.add_node(self.inner_point([chord.line, other]), true);
            }
        }
        self.crossroads
            .resize(self.crossings.len(), Crossroads::default());
    }

    fn inner_point(&self, lines: Lines) -> SurfacePoint {
        let wide = |[x, y]: Steps| DVec2::new(x as f64, y as f64);
        let point = wide(lines.map(|line| i64::from(line) * super::line::STEPS));
        let corners = self.corners.map(|corner| wide(corner) - point);
        let weights = [0, 1, 2].map(|corner| {
            let [next, last] = [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
            (next.perp_dot(last) * self.sign).max(0.0)
        });
        let sum: f64 = weights.iter().sum();
        SurfacePoint {
            face: FaceId::from_index(self.face as usize),
            barycentric: weights.map(|weight| weight / sum),
        }
    }

    /// Lays the pieces of a family's chords between the lattice points on them.
    fn lay_chords(&mut self, axis: usize, first_node: u32, overlay: &mut Overlay) {
        let crossings = &self.crossings;
        self.order.clear();
        self.order.extend(0..crossings.len());
        self.order
            .sort_by_key(|&crossing| [crossings[crossing][axis], crossings[crossing][1 - axis]]);
        let mut rest = 0;
        for chord in std::mem::take(&mut self.chords[axis]) {
            let [start, end] = chord.ends.map(|index| self.border[index]);
            let mut before = (start.node, start.place[1 - axis], None);
            while let Some(&crossing) = self.order.get(rest)
                && self.crossings[crossing][axis] == chord.line
            {
                rest += 1;
                let place = f64::from(self.crossings[crossing][1 - axis]);
                let stop = (first_node + crossing as u32, place, Some(crossing));
                self.lay_piece(axis, &chord, [before, stop], overlay);
                before = stop;
            }
            let stop = (end.node, end.place[1 - axis], None);
            self.lay_piece(axis, &chord, [before, stop], overlay);
        }
    }

    fn lay_piece(
        &mut self,
        axis: usize,
        chord: &Chord,
        [from, to]: [Stop; 2],
        overlay: &mut Overlay,
    ) {
        let advance = (to.1 - from.1).abs() * self.sign;
        let dart = overlay.add_line([from.0, to.0], advance);
        match from.2 {
            Some(crossing) => self.crossroads[crossing][1 - axis] = dart,
            None => self.spokes.push((chord.ends[0], axis, dart, true)),
        }
        match to.2 {
            Some(crossing) => self.crossroads[crossing][3 - axis] = twin(dart),
            None => (self.spokes).push((chord.ends[1], axis, twin(dart), false)),
        }
    }

    /// Sets for each dart in the triangle which dart follows along its face.
    fn link(&mut self, overlay: &mut Overlay) {
        for roads in &self.crossroads {
            let [right, up, left, down] = *roads;
            let turned = if self.sign > 0.0 {
                [right, up, left, down]
            } else {
                [right, down, left, up]
            };
            for index in 0..4 {
                overlay.next[twin(turned[index]) as usize] = turned[(index + 3) % 4];
            }
        }
        self.order_spokes();
        let mut spokes = self.spokes.iter().peekable();
        let mut incoming = self.border[self.border.len() - 1].dart;
        for (index, node) in self.border.iter().enumerate() {
            let mut last = node.dart;
            while let Some(&(_, _, dart, _)) = spokes.next_if(|spoke| spoke.0 == index) {
                overlay.next[twin(dart) as usize] = last;
                last = dart;
            }
            overlay.next[incoming as usize] = last;
            incoming = node.dart;
        }
    }

    /// Sorts the darts into the triangle along the border, and counter-clockwise at each node.
    fn order_spokes(&mut self) {
        self.spokes
            .sort_unstable_by_key(|&(index, axis, ..)| (index, axis));
        for pair in 1..self.spokes.len() {
            let [(one, _, _, up), (other, _, _, right)] =
                [self.spokes[pair - 1], self.spokes[pair]];
            // A line of the first family runs along y, one of the second along x.
            let clockwise = (up == right) == (self.sign > 0.0);
            if one == other && clockwise {
                self.spokes.swap(pair - 1, pair);
            }
        }
    }
}
