use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::overlay::{NONE, Overlay, arc, twin};

/// Cuts cells that are no disks: joins the faces in them again, smallest first, as long as every
/// part stays a disk whose border passes no node twice, and keeps the arcs between the parts.
pub(super) struct Splitter {
    /// Area above which parts are not joined.
    limit: f64,
    /// For each dart along a part the number of the part.
    owners: Vec<u32>,
    stamps: Vec<u32>,
    stamp: u32,
    parts: Vec<Part>,
}

/// A disk made of faces.
#[derive(Default)]
struct Part {
    /// The darts along it.
    walk: Vec<u32>,
    area: f64,
}

impl Splitter {
    pub(super) fn new(overlay: &Overlay) -> Self {
        Self {
            limit: 0.0,
            owners: vec![NONE; overlay.origins.len()],
            stamps: vec![0; overlay.points.len()],
            stamp: 0,
            parts: Vec::new(),
        }
    }

    /// The arcs inside the cell, given by its faces, that cut it into disks; two parts are joined
    /// up to an area of `limit`.
    pub(super) fn cuts(
        &mut self,
        overlay: &Overlay,
        faces: Vec<Vec<u32>>,
        limit: f64,
    ) -> Vec<usize> {
        self.limit = limit;
        self.parts.clear();
        let mut queue = BinaryHeap::new();
        for walk in faces {
            let area = overlay.area_vector(walk.iter().copied()).length();
            queue.push(self.add(Part { walk, area }));
        }
        while let Some(Reverse((_, part))) = queue.pop() {
            if !self.parts[part].walk.is_empty()
                && let Some(other) = self.partner(overlay, part)
            {
                queue.push(self.join(part, other));
            }
        }
        let mut cuts = Vec::new();
        for part in &self.parts {
            let inner = part.walk.iter().filter(|&&dart| !overlay.is_drawn(dart));
            cuts.extend(inner.map(|&dart| arc(dart)));
            for &dart in &part.walk {
                self.owners[dart as usize] = NONE;
            }
        }
        cuts
    }

    fn add(&mut self, part: Part) -> Reverse<(u64, usize)> {
        let number = self.parts.len();
        for &dart in &part.walk {
            self.owners[dart as usize] = number as u32;
        }
        // Areas are not negative, so that their bits are in their order.
        let key = Reverse((part.area.to_bits(), number));
        self.parts.push(part);
        key
    }

    /// The part of the same cell along the longest common border that can be joined.
    fn partner(&mut self, overlay: &Overlay, part: usize) -> Option<usize> {
        let position = |node: u32| overlay.positions[node as usize];
        let mut shared: Vec<(u32, f64)> = (self.parts[part].walk.iter())
            .filter(|&&dart| !overlay.is_drawn(dart))
            .map(|&dart| {
                let [from, to] = [dart, twin(dart)].map(|d| overlay.origins[d as usize]);
                let owner = self.owners[twin(dart) as usize];
                (owner, position(from).distance(position(to)))
            })
            .collect();
        shared.sort_by_key(|&(owner, _)| owner);
        let mut neighbors: Vec<(u32, f64)> = (shared.chunk_by(|a, b| a.0 == b.0))
            .map(|group| (group[0].0, group.iter().map(|&(_, length)| length).sum()))
            .collect();
        neighbors.sort_by(|a, b| b.1.total_cmp(&a.1));
        let area = self.parts[part].area;
        neighbors
            .into_iter()
            .map(|(other, _)| other as usize)
            .find(|&other| {
                area + self.parts[other].area <= self.limit && self.can_join(overlay, part, other)
            })
    }

    /// Whether two parts meet along one path and nowhere else.
    fn can_join(&mut self, overlay: &Overlay, part: usize, other: usize) -> bool {
        if part == other {
            return false;
        }
        self.stamp += 1;
        let (one, two) = (&self.parts[part].walk, &self.parts[other].walk);
        for &dart in one {
            self.stamps[overlay.origins[dart as usize] as usize] = self.stamp;
        }
        let node_stamp = |dart: &u32| self.stamps[overlay.origins[*dart as usize] as usize];
        let common = two
            .iter()
            .filter(|dart| node_stamp(dart) == self.stamp)
            .count();
        let shared = |dart: u32| self.is_between(overlay, dart, other);
        let length = one.iter().filter(|&&dart| shared(dart)).count();
        let begins = (0..one.len())
            .filter(|&index| {
                shared(one[index]) && !shared(one[(index + one.len() - 1) % one.len()])
            })
            .count();
        begins == 1 && common == length + 1
    }

    fn is_between(&self, overlay: &Overlay, dart: u32, other: usize) -> bool {
        !overlay.is_drawn(dart) && self.owners[twin(dart) as usize] == other as u32
    }

    fn join(&mut self, part: usize, other: usize) -> Reverse<(u64, usize)> {
        let [mut one, mut two] = [part, other].map(|part| std::mem::take(&mut self.parts[part]));
        let within = |dart: u32, other: usize| self.owners[twin(dart) as usize] == other as u32;
        let mut walk = Vec::with_capacity(one.walk.len() + two.walk.len());
        for (own, beside) in [(&mut one.walk, other), (&mut two.walk, part)] {
            let count = own.len();
            let start = (0..count).find(|&index| {
                within(own[index], beside) && !within(own[(index + 1) % count], beside)
            });
            own.rotate_left(start.map_or(0, |start| (start + 1) % count));
            walk.extend(own.iter().filter(|&&dart| !within(dart, beside)));
        }
        for dart in one.walk.into_iter().chain(two.walk) {
            self.owners[dart as usize] = NONE;
        }
        let area = one.area + two.area;
        self.add(Part { walk, area })
    }
}
