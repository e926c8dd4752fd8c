//! The built-in closed surface of `graticule demo`: a teapot with handle, spout and lid.
//!
//! It has what makes a net of lines worth a picture: a handle that no map of a disk covers, thin
//! parts, and parts of every curvature. Its points are those where a function vanishes; only roots,
//! products and sums are taken, so that every machine gets the same bytes.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use graticule::mesh::{MeshError, Surface, TriangleMesh, VertexId};

/// Rounds of smoothing that even out the triangles.
const SMOOTHING_ROUNDS: usize = 12;

/// Steps onto the surface after each round; each squares the distance.
const NEWTON_STEPS: usize = 2;

/// The box that holds the teapot.
const BOX: [DVec3; 2] = [DVec3::new(-1.75, -0.95, -1.1), DVec3::new(1.85, 1.25, 1.1)];

/// A ball stretched along the axes: centre and half-axes.
struct Ellipsoid(DVec3, DVec3);

/// A tube in the plane of the handle: the control points of a cubic curve, and the radius at its ends.
struct Tube([DVec2; 4], [f64; 2]);

/// Straight pieces that a tube is made of.
const PIECES: u32 = 32;

/// The ends of the pieces, with the radius there.
type Pieces = Vec<(DVec3, f64)>;

const BODY: Ellipsoid = Ellipsoid(DVec3::ZERO, DVec3::new(1.0, 0.78, 1.0));
const FOOT: Ellipsoid = Ellipsoid(DVec3::new(0.0, -0.72, 0.0), DVec3::new(0.6, 0.13, 0.6));
const LID: Ellipsoid = Ellipsoid(DVec3::new(0.0, 0.66, 0.0), DVec3::new(0.56, 0.24, 0.56));
const KNOB: Ellipsoid = Ellipsoid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.15, 0.13, 0.15));

const SPOUT: Tube = Tube(
    [
        DVec2::new(0.60, -0.32),
        DVec2::new(1.25, -0.35),
        DVec2::new(1.15, 0.25),
        DVec2::new(1.60, 0.52),
    ],
    [0.30, 0.12],
);

const HANDLE: Tube = Tube(
    [
        DVec2::new(-0.72, 0.42),
        DVec2::new(-1.75, 0.75),
        DVec2::new(-1.75, -0.50),
        DVec2::new(-0.80, -0.40),
    ],
    [0.115, 0.115],
);

/// The teapot from a grid of `cells` cells along its longest side; about `4 cells²` triangles.
pub(crate) fn teapot(cells: u32) -> Result<Surface, MeshError> {
    let shape = Shape::new();
    let (mut points, triangles) = Grid::new(&shape, cells).surface();
    let mesh = TriangleMesh::new(points.len(), &triangles)?;
    for _ in 0..SMOOTHING_ROUNDS {
        points = mesh
            .vertices()
            .map(|vertex| shape.relaxed(&mesh, &points, vertex))
            .collect();
    }
    Surface::from_triangles(points, &triangles)
}

/// The function whose zeros the teapot is.
struct Shape {
    spout: Pieces,
    handle: Pieces,
}

impl Shape {
    fn new() -> Self {
        Self {
            spout: SPOUT.pieces(),
            handle: HANDLE.pieces(),
        }
    }

    /// Below 0 inside the teapot, above outside; near its surface about the distance.
    fn level(&self, point: DVec3) -> f64 {
        let vessel = blended(BODY.level(point), FOOT.level(point), 0.12);
        let lid = blended(LID.level(point), KNOB.level(point), 0.1);
        let pot = blended(vessel, lid, 0.06);
        let pot = blended(pot, level_of_pieces(&self.spout, point), 0.3);
        blended(pot, level_of_pieces(&self.handle, point), 0.16)
    }

    /// The direction in which the level grows, by differences; of about unit length.
    fn slope(&self, point: DVec3) -> DVec3 {
        const STEP: f64 = 1e-4;
        let change = |axis: DVec3| {
            let ends = [1.0, -1.0].map(|side| self.level(point + axis * (side * STEP)));
            (ends[0] - ends[1]) / (2.0 * STEP)
        };
        DVec3::new(change(DVec3::X), change(DVec3::Y), change(DVec3::Z))
    }

    /// The point of the surface that the slope leads to.
    fn dropped(&self, mut point: DVec3) -> DVec3 {
        for _ in 0..NEWTON_STEPS {
            let slope = self.slope(point);
            point -= slope * (self.level(point) / slope.length_squared());
        }
        point
    }

    /// The middle of a vertex's neighbours, dropped onto the surface.
    fn relaxed(&self, mesh: &TriangleMesh, points: &[DVec3], vertex: VertexId) -> DVec3 {
        let neighbors: Vec<DVec3> = mesh
            .neighbors(vertex)
            .map(|v| points[v.0 as usize])
            .collect();
        self.dropped(neighbors.iter().sum::<DVec3>() / neighbors.len() as f64)
    }
}

/// The lesser of two levels, with a round transition where they differ by less than `width`.
fn blended(a: f64, b: f64, width: f64) -> f64 {
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - near * near * width / 4.0
}

impl Ellipsoid {
    fn level(&self, point: DVec3) -> f64 {
        let Self(center, half_axes) = self;
        let unit = (point - *center) / *half_axes;
        let steepness = (unit / *half_axes).length();
        if steepness == 0.0 {
            return -half_axes.min_element();
        }
        unit.length() * (unit.length() - 1.0) / steepness
    }
}

impl Tube {
    /// The point of the middle line at a parameter, and the radius there.
    fn at(&self, share: f64) -> (DVec3, f64) {
        let Self([a, b, c, d], [start, end]) = *self;
        let [ab, bc, cd] = [a.lerp(b, share), b.lerp(c, share), c.lerp(d, share)];
        let middle = ab.lerp(bc, share).lerp(bc.lerp(cd, share), share);
        (middle.extend(0.0), start + (end - start) * share)
    }

    fn pieces(&self) -> Pieces {
        let share = |end: u32| f64::from(end) / f64::from(PIECES);
        (0..=PIECES).map(|end| self.at(share(end))).collect()
    }
}

/// The least level of cones.
fn level_of_pieces(pieces: &[(DVec3, f64)], point: DVec3) -> f64 {
    let levels = pieces.windows(2).map(|piece| {
        let [(from, start), (to, end)] = [piece[0], piece[1]];
        let along = to - from;
        let offset = point - from;
        let share = (offset.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (offset - along * share).length() - (start + (end - start) * share)
    });
    levels.fold(f64::INFINITY, f64::min)
}

/// A grid of cubes around the teapot, with the level at its points.
struct Grid<'a> {
    shape: &'a Shape,
    side: f64,
    counts: [u32; 3],
    levels: Vec<f64>,
}

impl<'a> Grid<'a> {
    fn new(shape: &'a Shape, cells: u32) -> Self {
        let extent = BOX[1] - BOX[0];
        let side = extent.max_element() / f64::from(cells);
        // Whole cells over the longest side, as many as are needed over the others.
        let counts = extent.to_array().map(|length| {
            let mut count = 1;
            while f64::from(count) * side < length {
                count += 1;
            }
            count + 1
        });
        let mut grid = Self {
            shape,
            side,
            counts,
            levels: Vec::new(),
        };
        let [x, y, z] = counts;
        let places = (0..x).flat_map(|i| (0..y).flat_map(move |j| (0..z).map(move |k| [i, j, k])));
        grid.levels = places.map(|at| shape.level(grid.point(at))).collect();
        grid
    }

    fn point(&self, at: [u32; 3]) -> DVec3 {
        BOX[0] + DVec3::from(at.map(f64::from)) * self.side
    }

    fn index(&self, [i, j, k]: [u32; 3]) -> usize {
        let [_, y, z] = self.counts.map(|count| count as usize);
        (i as usize * y + j as usize) * z + k as usize
    }

    fn is_inside(&self, at: [u32; 3]) -> bool {
        self.levels[self.index(at)] < 0.0
    }

    /// A point in each cube that the surface crosses, and two triangles around each edge of the grid
    /// that it crosses.
    fn surface(&self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut numbers = BTreeMap::new();
        let mut points = Vec::new();
        let mut number = |cell: [u32; 3]| {
            *numbers.entry(cell).or_insert_with(|| {
                points.push(
                    self.shape
                        .dropped(self.point(cell) + DVec3::splat(0.5 * self.side)),
                );
                points.len() as u32 - 1
            })
        };
        let mut quads = Vec::new();
        let [x, y, z] = self.counts;
        for (i, j) in (1..x - 1).flat_map(|i| (1..y - 1).map(move |j| (i, j))) {
            for k in 1..z - 1 {
                for axis in 0..3 {
                    let at = [i, j, k];
                    let mut next = at;
                    next[axis] += 1;
                    let inside = [at, next].map(|end| self.is_inside(end));
                    if inside[0] != inside[1] {
                        let mut quad = cells_around(at, axis).map(&mut number);
                        if inside[1] {
                            quad.reverse();
                        }
                        quads.push(quad);
                    }
                }
            }
        }
        let triangles = quads.iter().flat_map(|&quad| halved(quad, &points));
        let triangles = triangles.collect();
        (points, triangles)
    }
}

/// The four cells around an edge of the grid along an axis, counterclockwise seen against it.
fn cells_around(at: [u32; 3], axis: usize) -> [[u32; 3]; 4] {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    [[1, 1], [0, 1], [0, 0], [1, 0]].map(|back| {
        let mut cell = at;
        cell[u] -= back[0];
        cell[v] -= back[1];
        cell
    })
}

/// A quad cut along its shorter diagonal.
fn halved([a, b, c, d]: [u32; 4], points: &[DVec3]) -> [[u32; 3]; 2] {
    let length = |from: u32, to: u32| points[from as usize].distance_squared(points[to as usize]);
    if length(a, c) < length(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule::mesh::Topology;

    #[test]
    fn the_teapot_is_closed_has_one_handle_and_faces_outward() {
        for cells in [48, 60] {
            let surface = teapot(cells).unwrap();
            let topology = Topology::of(surface.mesh());
            assert_eq!(topology.components.len(), 1);
            assert_eq!(topology.total.boundary_loops, 0);
            assert_eq!(topology.total.euler_characteristic, 0, "{cells} cells");
            let mesh = surface.mesh();
            let volumes = mesh.faces().map(|face| {
                let [a, b, c] = surface.corner_positions(face);
                a.dot(b.cross(c)) / 6.0
            });
            let volume: f64 = volumes.sum();
            assert!((3.0..5.0).contains(&volume), "{volume}");
        }
    }

    #[test]
    fn its_vertices_lie_where_the_function_vanishes() {
        let (surface, shape) = (teapot(48).unwrap(), Shape::new());
        let levels = surface.positions().iter();
        let levels = levels.map(|&point| shape.level(point).abs());
        let worst = levels.fold(0.0, f64::max);
        assert!(worst < 1e-4, "{worst}");
    }
}
