//! Quad meshes as plain arrays.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::Noise;

/// A quad mesh as plain arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadFixture {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Quads, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
}

impl QuadFixture {
    /// The same mesh with every position changed by `change`.
    #[must_use]
    pub fn map(mut self, mut change: impl FnMut(DVec3) -> DVec3) -> Self {
        for position in &mut self.positions {
            *position = change(*position);
        }
        self
    }

    /// The same mesh with every coordinate moved at random by up to `most`.
    #[must_use]
    pub fn jittered(self, most: f64, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        self.map(|p| p + most * DVec3::new(noise.signed(), noise.signed(), noise.signed()))
    }
}

/// The surface of the cube `-1.0..=1.0` in each coordinate, each face cut into `cells` by `cells`
/// quads.
#[must_use]
pub fn quad_cube(cells: u32) -> QuadFixture {
    let mut numbers = BTreeMap::new();
    let mut positions = Vec::new();
    let mut number = |place: [u32; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            let place = DVec3::from_array(place.map(f64::from));
            positions.push(place * (2.0 / f64::from(cells)) - 1.0);
            positions.len() as u32 - 1
        })
    };
    let mut quads = Vec::new();
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, cells)]) {
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let mut quad = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                let mut place = [0; 3];
                place[axis] = end;
                place[(axis + 1) % 3] = i;
                place[(axis + 2) % 3] = j;
                number(place)
            });
            if end == 0 {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    QuadFixture { positions, quads }
}

/// The torus of [`torus`](crate::torus) in quads.
#[must_use]
pub fn quad_torus(major_radius: f64, minor_radius: f64, around: u32, across: u32) -> QuadFixture {
    let point = |i: u32, j: u32| {
        let [sine, cosine] = sine_and_cosine(i, around);
        let [height, out] = sine_and_cosine(j, across);
        let radius = major_radius + minor_radius * out;
        DVec3::new(radius * cosine, radius * sine, minor_radius * height)
    };
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let cells = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    QuadFixture {
        positions: cells().map(|(i, j)| point(i, j)).collect(),
        quads: cells()
            .map(|(i, j)| {
                [
                    number(i, j),
                    number(i + 1, j),
                    number(i + 1, j + 1),
                    number(i, j + 1),
                ]
            })
            .collect(),
    }
}

fn sine_and_cosine(step: u32, steps: u32) -> [f64; 2] {
    let (sine, cosine) = (TAU * f64::from(step) / f64::from(steps)).sin_cos();
    [sine, cosine]
}

/// A flat rectangle from the origin in the plane z = 0, in `columns` by `rows` quads.
#[must_use]
pub fn quad_grid(size: DVec2, columns: u32, rows: u32) -> QuadFixture {
    let step = size / DVec2::new(f64::from(columns), f64::from(rows));
    let places = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
    let position = |(i, j)| (DVec2::new(f64::from(i), f64::from(j)) * step).extend(0.0);
    let number = |i: u32, j: u32| j * (columns + 1) + i;
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    QuadFixture {
        positions: places.map(position).collect(),
        quads: cells
            .map(|(i, j)| {
                [
                    number(i, j),
                    number(i + 1, j),
                    number(i + 1, j + 1),
                    number(i, j + 1),
                ]
            })
            .collect(),
    }
}
