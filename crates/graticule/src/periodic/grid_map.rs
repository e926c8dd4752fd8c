use glam::DVec2;
use serde::Serialize;

use super::{GridMapError, Transition};
use crate::mesh::{FaceId, HalfedgeId, PerCorner, PerFace, TriangleMesh, VertexId};
use crate::tolerance::GRID_AGREEMENT;

/// Coordinates of a [`GridMap`] are multiples of 1 / `GRID_STEPS`.
pub const GRID_STEPS: f64 = (1_u64 << 32) as f64;

/// Coordinates of a [`GridMap`] are smaller than this: with [`GRID_STEPS`] as divisor they have 52
/// bits, so that `f64` holds them, their turns and their shifts without rounding.
pub const GRID_EXTENT: f64 = (1_u64 << 20) as f64;

/// Coordinates on a surface whose whole numbers are the lines of a net: per corner of each
/// triangle, the same on both sides of an edge up to a [`Transition`] ([PGP06] Eqs. 3, 16).
///
/// The unit is one line spacing. Held by construction, without rounding:
/// - both ends of an edge between two triangles go over by the transition of the edge;
/// - coordinates are multiples of 1 / [`GRID_STEPS`], smaller than [`GRID_EXTENT`];
/// - a vertex round which the coordinates turn sits at the fixed point of that turn.
///
/// Triangles may be left out: they have no coordinates, and no transition leads to them. A regular
/// map turns every triangle counter-clockwise; this is not held, as maps computed may flip some.
///
/// [PGP06]: crate::papers::PGP06
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridMap {
    coordinates: PerCorner<DVec2>,
    transitions: PerCorner<Option<Transition>>,
    left_out: PerFace<bool>,
}

impl GridMap {
    /// Makes approximate coordinates exact.
    ///
    /// `transitions` has for each halfedge how coordinates of its triangle become those of its
    /// twin's; `None` on the boundary and between triangles of which one is left out. Coordinates
    /// move by half a step of 1 / [`GRID_STEPS`] and by what the corners round a vertex disagree.
    /// Whoever wants a vertex on a line gives it a whole number.
    ///
    /// Linear in the size of the mesh.
    ///
    /// # Errors
    /// [`GridMapError::Count`] for arrays of another size than the mesh;
    /// [`GridMapError::NonFinite`] and [`GridMapError::TooLarge`] for coordinates;
    /// [`GridMapError::Transition`] where a transition is missing, is too many, or is not the inverse
    /// of the one back; [`GridMapError::Disagreement`] where coordinates miss their transition by
    /// more than [`GRID_AGREEMENT`]; [`GridMapError::Dislocation`] for a vertex round which the
    /// transitions compose to a shift.
    pub fn new(
        mesh: &TriangleMesh,
        coordinates: PerCorner<DVec2>,
        transitions: PerCorner<Option<Transition>>,
        left_out: PerFace<bool>,
    ) -> Result<Self, GridMapError> {
        let mut map = Self {
            coordinates,
            transitions,
            left_out,
        };
        map.check_counts(mesh)?;
        map.check_coordinates(mesh)?;
        for halfedge in mesh.halfedges() {
            map.check_transition(mesh, halfedge)?;
        }
        for vertex in mesh.vertices() {
            map.make_exact(mesh, vertex)?;
        }
        map.check_coordinates(mesh)?;
        Ok(map)
    }

    /// The coordinates of the origin of the halfedge in its triangle.
    #[inline]
    #[must_use]
    pub fn coordinate(&self, corner: HalfedgeId) -> DVec2 {
        self.coordinates[corner]
    }

    /// The coordinates of all corners; zero in triangles left out.
    #[must_use]
    pub fn coordinates(&self) -> &PerCorner<DVec2> {
        &self.coordinates
    }

    /// The coordinates of the three corners of a triangle.
    #[inline]
    #[must_use]
    pub fn face_coordinates(&self, face: FaceId) -> [DVec2; 3] {
        face.halfedges().map(|corner| self.coordinates[corner])
    }

    /// How coordinates of the halfedge's triangle become those of its twin's; `None` on the
    /// boundary and between triangles of which one is left out.
    #[inline]
    #[must_use]
    pub fn transition(&self, halfedge: HalfedgeId) -> Option<Transition> {
        self.transitions[halfedge]
    }

    /// Whether a line runs along the halfedge: a coordinate has the same whole number at both ends.
    #[must_use]
    pub fn has_line_along(&self, halfedge: HalfedgeId) -> bool {
        let [from, to] = [halfedge, halfedge.next()].map(|corner| self.coordinates[corner]);
        let on_line = from.cmpeq(to) & from.cmpeq(from.round());
        on_line.any() && !self.left_out[halfedge.face()]
    }

    /// Whether the triangle has no coordinates.
    #[inline]
    #[must_use]
    pub fn is_left_out(&self, face: FaceId) -> bool {
        self.left_out[face]
    }

    /// The triangles that have no coordinates.
    #[must_use]
    pub fn left_out(&self) -> &PerFace<bool> {
        &self.left_out
    }

    /// The same map with `factor` lines for each one.
    ///
    /// # Errors
    /// [`GridMapError::TooLarge`], or [`GridMapError::Subdivision`] for a factor of 0.
    pub fn subdivided(&self, mesh: &TriangleMesh, factor: u32) -> Result<Self, GridMapError> {
        if factor == 0 {
            return Err(GridMapError::Subdivision);
        }
        let map = Self {
            coordinates: self.coordinates.map(|&point| point * f64::from(factor)),
            transitions: self.transitions.map(|transition| {
                transition.map(|Transition { turn, shift }| Transition {
                    turn,
                    // Held in range by the check of the coordinates that follows.
                    shift: shift.map(|whole| whole.wrapping_mul(factor.cast_signed())),
                })
            }),
            left_out: self.left_out.clone(),
        };
        map.check_coordinates(mesh)?;
        Ok(map)
    }

    fn check_counts(&self, mesh: &TriangleMesh) -> Result<(), GridMapError> {
        let counts = [
            ("coordinates", self.coordinates.len(), mesh.halfedge_count()),
            ("transitions", self.transitions.len(), mesh.halfedge_count()),
            ("marks", self.left_out.len(), mesh.face_count()),
        ];
        match counts
            .into_iter()
            .find(|(_, given, needed)| given != needed)
        {
            Some((what, given, needed)) => Err(GridMapError::Count {
                what,
                given,
                needed,
            }),
            None => Ok(()),
        }
    }

    fn check_coordinates(&self, mesh: &TriangleMesh) -> Result<(), GridMapError> {
        for corner in mesh.halfedges() {
            if self.left_out[corner.face()] {
                continue;
            }
            let point = self.coordinates[corner];
            let (face, vertex) = (corner.face(), mesh.origin(corner));
            if !point.is_finite() {
                return Err(GridMapError::NonFinite { face, vertex });
            }
            let coordinate = point.abs().max_element();
            if coordinate >= GRID_EXTENT {
                return Err(GridMapError::TooLarge {
                    face,
                    vertex,
                    coordinate,
                });
            }
        }
        Ok(())
    }

    fn check_transition(
        &self,
        mesh: &TriangleMesh,
        halfedge: HalfedgeId,
    ) -> Result<(), GridMapError> {
        let broken = |rule| {
            let (face, ends) = (halfedge.face(), mesh.ends(halfedge));
            Err(GridMapError::Transition { face, ends, rule })
        };
        let other = mesh
            .twin(halfedge)
            .filter(|twin| !self.left_out[twin.face()] && !self.left_out[halfedge.face()]);
        match (self.transitions[halfedge], other) {
            (None, Some(_)) => broken("is missing"),
            (Some(_), None) => broken("leads nowhere"),
            (Some(there), Some(twin)) if self.transitions[twin] != Some(there.inverse()) => {
                broken("is not the inverse of the one back")
            }
            (None, None) | (Some(_), Some(_)) => Ok(()),
        }
    }

    /// Rounds one corner in each unbroken part of the fan of triangles round the vertex and carries
    /// it on to the others.
    fn make_exact(&mut self, mesh: &TriangleMesh, vertex: VertexId) -> Result<(), GridMapError> {
        let mut fan: Vec<_> = mesh.outgoing(vertex).collect();
        let step_after = |corner: &HalfedgeId| self.transitions[corner.previous()];
        let mut place = None;
        if let Some(last) = fan.iter().rposition(|corner| step_after(corner).is_none()) {
            fan.rotate_left(last);
            fan.rotate_left(1);
        } else {
            let round = fan.iter().filter_map(step_after);
            let round = round.fold(Transition::identity(), Transition::then);
            place = round.fixed_point();
            if place.is_none() && !round.is_identity() {
                let shift = round.shift;
                return Err(GridMapError::Dislocation { vertex, shift });
            }
        }
        let mut before = fan[0].face();
        for corner in fan {
            let face = corner.face();
            if self.left_out[face] {
                self.coordinates[corner] = DVec2::ZERO;
                continue;
            }
            let given = self.coordinates[corner];
            let point = place.unwrap_or_else(|| rounded(given));
            let distance = point.distance(given);
            if distance > GRID_AGREEMENT {
                return Err(GridMapError::Disagreement {
                    faces: [before, face],
                    vertex,
                    distance,
                });
            }
            self.coordinates[corner] = point;
            place = self.transitions[corner.previous()].map(|step| step.apply(point));
            before = face;
        }
        Ok(())
    }
}

/// The nearest multiple of 1 / [`GRID_STEPS`].
fn rounded(point: DVec2) -> DVec2 {
    (point * GRID_STEPS).round() / GRID_STEPS
}

#[cfg(test)]
mod tests {
    use super::super::QuarterTurn;
    use super::*;
    use crate::mesh::Element;
    use graticule_fixtures::{Noise, disk, grid, torus};

    type Arrays = (
        TriangleMesh,
        PerCorner<DVec2>,
        PerCorner<Option<Transition>>,
        PerFace<bool>,
    );

    /// The arrays of a map by `point`, with no transition but the identity.
    fn plain(mesh: TriangleMesh, point: impl Fn(HalfedgeId, VertexId) -> DVec2) -> Arrays {
        let count = mesh.halfedge_count();
        let coordinates = PerCorner::from_fn(count, |corner| point(corner, mesh.origin(corner)));
        let transitions = PerCorner::from_fn(count, |halfedge| {
            mesh.twin(halfedge).map(|_| Transition::identity())
        });
        let left_out = PerFace::filled(mesh.face_count(), false);
        (mesh, coordinates, transitions, left_out)
    }

    fn flat(noise: f64) -> Arrays {
        let fixture = grid(4.0, 3.0, 8, 6);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let mut random = Noise::new(3);
        let wobble: Vec<_> = (0..mesh.halfedge_count())
            .map(|_| DVec2::new(random.signed(), random.signed()) * noise)
            .collect();
        plain(mesh, |corner, vertex| {
            fixture.positions[vertex.index()].truncate() / 3.0 + wobble[corner.index()]
        })
    }

    fn build((mesh, coordinates, transitions, left_out): Arrays) -> Result<GridMap, GridMapError> {
        GridMap::new(&mesh, coordinates, transitions, left_out)
    }

    /// The largest disagreement of the two sides of an edge.
    fn gap(mesh: &TriangleMesh, map: &GridMap) -> f64 {
        let gaps = mesh.halfedges().filter_map(|halfedge| {
            let (twin, step) = (mesh.twin(halfedge)?, map.transition(halfedge)?);
            let other = map.coordinate(twin.next());
            Some(step.apply(map.coordinate(halfedge)).distance(other))
        });
        gaps.fold(0.0, f64::max)
    }

    /// A torus unrolled to `[0, 8) × [0, 5)`, with shifts where it closes.
    fn unrolled_torus() -> Arrays {
        let (columns, rows) = (16, 10);
        let fixture = torus(2.0, 0.7, columns, rows);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let angles = |vertex: VertexId| {
            let p = fixture.positions[vertex.index()];
            let around = f64::atan2(p.y, p.x);
            let across = f64::atan2(p.z, DVec2::new(p.x, p.y).length() - 2.0);
            DVec2::new(around * 8.0, across * 5.0) / std::f64::consts::TAU
        };
        let period = DVec2::new(8.0, 5.0);
        let coordinates = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let first = angles(mesh.origin(corner.face().halfedges()[0]));
            let mine = angles(mesh.origin(corner));
            mine - ((mine - first) / period).round() * period
        });
        let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            let twin = mesh.twin(halfedge)?;
            let shift = coordinates[twin.next()] - coordinates[halfedge];
            Some(Transition {
                turn: QuarterTurn::NONE,
                shift: [shift.x.round() as i32, shift.y.round() as i32],
            })
        });
        let left_out = PerFace::filled(mesh.face_count(), false);
        (mesh, coordinates, transitions, left_out)
    }

    #[test]
    fn corners_that_disagree_by_rounding_become_equal_bit_for_bit() {
        for arrays in [flat(1e-7), unrolled_torus()] {
            let (mesh, given) = (arrays.0.clone(), arrays.1.clone());
            let map = build(arrays).unwrap();
            assert!(gap(&mesh, &map).to_bits() == 0);
            for (corner, point) in given.enumerate() {
                let [from, to] = [corner, corner.next()].map(|end| map.coordinate(end));
                let is_whole = |a: f64, b: f64| a.to_bits() == b.to_bits() && a.round() - a == 0.0;
                let shared = is_whole(from.x, to.x) || is_whole(from.y, to.y);
                assert_eq!(map.has_line_along(corner), shared);
                assert!(point.distance(map.coordinate(corner)) < 3e-7);
                let steps = map.coordinate(corner) * GRID_STEPS;
                assert_eq!(steps, steps.round());
            }
        }
    }

    #[test]
    fn twice_the_lines_are_the_same_map_at_twice_the_size() {
        let arrays = unrolled_torus();
        let mesh = arrays.0.clone();
        let map = build(arrays).unwrap();
        let finer = map.subdivided(&mesh, 2).unwrap();
        assert!(gap(&mesh, &finer).to_bits() == 0);
        assert_eq!(
            finer.coordinate(HalfedgeId(7)),
            2.0 * map.coordinate(HalfedgeId(7))
        );
        assert!(matches!(
            map.subdivided(&mesh, 1 << 20),
            Err(GridMapError::TooLarge { .. })
        ));
        assert_eq!(map.subdivided(&mesh, 0), Err(GridMapError::Subdivision));
    }

    /// A disk with a quarter of the plane missing, closed by one quarter turn at its centre.
    fn cone(centre: DVec2) -> Arrays {
        let fixture = disk(3);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let middle = VertexId(0);
        let angle = |vertex: VertexId| {
            let p = fixture.positions[vertex.index()];
            f64::atan2(p.y, p.x) * 0.75
        };
        let turn = std::f64::consts::TAU * 0.75;
        let coordinates = PerCorner::from_fn(mesh.halfedge_count(), |corner: HalfedgeId| {
            let face = corner.face().halfedges();
            let first = face
                .map(|h| mesh.origin(h))
                .into_iter()
                .find(|&v| v != middle);
            let first = angle(first.unwrap());
            let vertex = mesh.origin(corner);
            let mine = angle(vertex);
            let mine = mine - ((mine - first) / turn).round() * turn;
            let radius = fixture.positions[vertex.index()].length() * 3.0;
            centre + DVec2::from_angle(mine) * radius
        });
        let transitions = PerCorner::from_fn(mesh.halfedge_count(), |halfedge: HalfedgeId| {
            let twin = mesh.twin(halfedge)?;
            let steps = (0..4).map(|quarters| {
                let turn = QuarterTurn::of_quarters(quarters);
                let shift = coordinates[twin] - turn.apply(coordinates[halfedge.next()]);
                let shift = [shift.x.round() as i32, shift.y.round() as i32];
                Transition { turn, shift }
            });
            steps.min_by(|a, b| {
                let miss = |t: &Transition| {
                    t.apply(coordinates[halfedge])
                        .distance(coordinates[twin.next()])
                        + t.apply(coordinates[halfedge.next()])
                            .distance(coordinates[twin])
                };
                miss(a).total_cmp(&miss(b))
            })
        });
        let left_out = PerFace::filled(mesh.face_count(), false);
        (mesh, coordinates, transitions, left_out)
    }

    #[test]
    fn a_vertex_round_which_the_map_turns_sits_at_the_fixed_point() {
        let centre = DVec2::new(2.0, -1.0);
        let arrays = cone(centre + DVec2::new(1e-7, -2e-7));
        let mesh = arrays.0.clone();
        let map = build(arrays).unwrap();
        assert!(gap(&mesh, &map).to_bits() == 0);
        for corner in mesh.outgoing(VertexId(0)) {
            assert_eq!(map.coordinate(corner), map.coordinate(corner).round());
        }
        assert!(matches!(
            build(cone(centre + DVec2::new(1e-2, 0.0))),
            Err(GridMapError::Disagreement { .. })
        ));
    }

    #[test]
    fn each_broken_rule_of_a_map_is_named() {
        let (mesh, coordinates, transitions, left_out) = flat(0.0);
        let refusal = |change: &dyn Fn(&mut Arrays)| {
            let mut arrays = (
                mesh.clone(),
                coordinates.clone(),
                transitions.clone(),
                left_out.clone(),
            );
            change(&mut arrays);
            build(arrays).unwrap_err()
        };
        let inner = mesh.halfedges().find(|&h| mesh.twin(h).is_some()).unwrap();
        let nan = refusal(&|arrays| arrays.1[inner].x = f64::NAN);
        assert!(matches!(nan, GridMapError::NonFinite { .. }));
        let large = refusal(&|arrays| arrays.1[inner].x = GRID_EXTENT);
        assert!(matches!(large, GridMapError::TooLarge { .. }));
        let torn = refusal(&|arrays| arrays.1[inner].x += 0.01);
        assert!(matches!(torn, GridMapError::Disagreement { .. }));
        let missing = refusal(&|arrays| arrays.2[inner] = None);
        assert!(matches!(missing, GridMapError::Transition { .. }));
        let one_sided = refusal(&|arrays| {
            arrays.2[inner] = Some(Transition {
                turn: QuarterTurn::NONE,
                shift: [1, 0],
            });
        });
        assert!(matches!(one_sided, GridMapError::Transition { .. }));
        let short = refusal(&|arrays| arrays.3 = PerFace::filled(1, false));
        assert!(matches!(short, GridMapError::Count { .. }));
    }

    /// A flat disk whose coordinates gain one line on the way round its middle vertex.
    fn dislocated(left_out: Option<FaceId>) -> Arrays {
        let fixture = disk(4);
        let mesh = TriangleMesh::new(fixture.positions.len(), &fixture.triangles).unwrap();
        let middle = VertexId(0);
        let turns = |vertex: VertexId| {
            let p = fixture.positions[vertex.index()];
            f64::atan2(p.y, p.x) / std::f64::consts::TAU
        };
        let crossed = |from: VertexId, to: VertexId| {
            let step = turns(to) - turns(from);
            if from == middle || to == middle {
                0.0
            } else {
                step.round()
            }
        };
        let mut arrays = plain(mesh.clone(), |corner, vertex| {
            let face = corner.face().halfedges().map(|h| mesh.origin(h));
            let first = face.into_iter().find(|&v| v != middle).unwrap();
            let gained = if vertex == middle {
                turns(first)
            } else {
                turns(vertex) - crossed(first, vertex)
            };
            fixture.positions[vertex.index()].truncate() + DVec2::X * gained
        });
        let steps = PerCorner::from_fn(mesh.halfedge_count(), |halfedge| {
            let twin = mesh.twin(halfedge)?;
            let outer = if mesh.origin(halfedge) == middle {
                arrays.1[twin] - arrays.1[halfedge.next()]
            } else {
                arrays.1[twin.next()] - arrays.1[halfedge]
            };
            let left_out = |h: HalfedgeId| left_out == Some(h.face());
            (!left_out(halfedge) && !left_out(twin)).then_some(Transition {
                turn: QuarterTurn::NONE,
                shift: [outer.x.round() as i32, 0],
            })
        });
        arrays.2 = steps;
        if let Some(face) = left_out {
            arrays.3[face] = true;
        }
        // The middle has no one place in the net: each triangle of it is moved to agree with the last.
        let mut place = None;
        let fan: Vec<_> = mesh.outgoing(middle).collect();
        let start = left_out.map_or(0, |face| fan.iter().position(|h| h.face() == face).unwrap());
        for index in 0..fan.len() {
            let corner = fan[(start + index) % fan.len()];
            let point = place.unwrap_or(arrays.1[corner]);
            arrays.1[corner] = point;
            place = arrays.2[corner.previous()].map(|step: Transition| step.apply(point));
        }
        arrays
    }

    #[test]
    fn a_dislocation_is_named_and_may_be_left_out() {
        let whole = build(dislocated(None));
        let Err(GridMapError::Dislocation { vertex, shift }) = whole else {
            panic!("{whole:?}");
        };
        assert_eq!((vertex, shift[0].abs(), shift[1]), (VertexId(0), 1, 0));
        let hole = FaceId(0);
        let arrays = dislocated(Some(hole));
        let mesh = arrays.0.clone();
        let map = build(arrays).unwrap();
        assert!(map.is_left_out(hole));
        assert_eq!(map.face_coordinates(hole), [DVec2::ZERO; 3]);
        assert!(gap(&mesh, &map).to_bits() == 0);
    }
}
