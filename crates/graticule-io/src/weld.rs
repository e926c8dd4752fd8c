use std::collections::HashMap;
use std::hash::Hash;

use foldhash::fast::RandomState;
use glam::{DVec2, DVec3};
use graticule::mesh::{CornerAttribute, NO_VALUE};

/// Numbers distinct values in the order of their first appearance.
///
/// The hash is seeded by chance against files made to collide; the numbering does not depend on
/// it.
pub(crate) struct Numbering<K> {
    numbers: HashMap<K, u32, RandomState>,
}

impl<K: Hash + Eq> Default for Numbering<K> {
    fn default() -> Self {
        Self {
            numbers: HashMap::default(),
        }
    }
}

impl<K: Hash + Eq> Numbering<K> {
    /// The number of `key`, and whether it is new.
    #[inline]
    pub(crate) fn number(&mut self, key: K) -> (u32, bool) {
        let next = self.numbers.len() as u32;
        let number = *self.numbers.entry(key).or_insert(next);
        (number, number == next)
    }
}

/// Values that can be told apart by their bits, with -0 equal to +0 and all NaN alike.
pub(crate) trait Bits: Copy {
    /// What is compared.
    type Key: Hash + Eq;
    /// The bits.
    fn bits(self) -> Self::Key;
}

fn float_bits(value: f64) -> u64 {
    if value.is_nan() {
        return f64::NAN.to_bits();
    }
    (value + 0.0).to_bits()
}

impl Bits for DVec2 {
    type Key = [u64; 2];
    fn bits(self) -> Self::Key {
        self.to_array().map(float_bits)
    }
}

impl Bits for DVec3 {
    type Key = [u64; 3];
    fn bits(self) -> Self::Key {
        self.to_array().map(float_bits)
    }
}

/// Collects one value for each corner, held once for each vertex where it is the same.
pub(crate) struct CornerCollector<T: Bits> {
    attribute: CornerAttribute<T>,
    numbering: Numbering<(u32, T::Key)>,
}

impl<T: Bits> Default for CornerCollector<T> {
    fn default() -> Self {
        Self {
            attribute: CornerAttribute {
                name: String::new(),
                values: Vec::new(),
                corner_values: Vec::new(),
            },
            numbering: Numbering::default(),
        }
    }
}

impl<T: Bits> CornerCollector<T> {
    /// Gives the corner after the last one a value; its vertex is `vertex`.
    pub(crate) fn push(&mut self, vertex: u32, value: T) {
        let (number, new) = self.numbering.number((vertex, value.bits()));
        if new {
            self.attribute.values.push(value);
        }
        self.attribute.corner_values.push(number);
    }

    /// Leaves all corners before `corner` that have no value yet without one.
    pub(crate) fn skip_to(&mut self, corner: usize) {
        self.attribute.corner_values.resize(corner, NO_VALUE);
    }

    /// The attribute of `corners` corners, or `None` if no corner has a value.
    pub(crate) fn finish(mut self, corners: usize) -> Option<CornerAttribute<T>> {
        self.skip_to(corners);
        (!self.attribute.values.is_empty()).then_some(self.attribute)
    }
}

/// An attribute with one value for each vertex.
pub(crate) fn vertex_attribute<T>(values: Vec<T>, corner_vertices: &[u32]) -> CornerAttribute<T> {
    CornerAttribute {
        name: String::new(),
        values,
        corner_values: corner_vertices.to_vec(),
    }
}

/// Joins segments that follow one another into polylines.
pub(crate) fn chain_segments(segments: impl IntoIterator<Item = [u32; 2]>) -> Vec<Vec<u32>> {
    let mut polylines: Vec<Vec<u32>> = Vec::new();
    for [start, end] in segments {
        match polylines.last_mut() {
            Some(line) if line.last() == Some(&start) => line.push(end),
            _ => polylines.push(vec![start, end]),
        }
    }
    polylines
}

/// The triangles of a strip, all turned like the first one. Triangles with a repeated vertex only
/// steer the strip and are left out.
pub(crate) fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    strip
        .windows(3)
        .enumerate()
        .filter_map(|(number, corners)| {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            let turned = if number % 2 == 0 {
                [a, b, c]
            } else {
                [b, a, c]
            };
            (a != b && b != c && c != a).then_some(turned)
        })
}
