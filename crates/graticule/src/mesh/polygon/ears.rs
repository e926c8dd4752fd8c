use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::Outline;
use crate::mesh::gluing::NONE;
use crate::mesh::point_tree::PointTree;
use crate::tolerance;

/// Cuts the polygon into triangles, the best ear first.
pub(super) fn clip(outline: &Outline) -> Vec<[u32; 3]> {
    let mut clipper = EarClipper::new(outline);
    clipper.clip_ears();
    clipper.clip_the_rest();
    clipper.triangles
}

/// A corner that may be an ear, by shape; stale once the corner's neighbours have changed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    quality: f64,
    corner: u32,
    version: u32,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_quality = self.quality.total_cmp(&other.quality);
        by_quality
            .then(other.corner.cmp(&self.corner))
            .then(self.version.cmp(&other.version))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

struct EarClipper<'a> {
    outline: &'a Outline,
    before: Vec<u32>,
    after: Vec<u32>,
    versions: Vec<u32>,
    candidates: BinaryHeap<Candidate>,
    /// Corners that turn right or go straight: the only ones that can lie in a left-turning ear.
    blockers: PointTree,
    is_blocker: Vec<bool>,
    /// The corners that each blocker keeps from being ears, as linked lists.
    first_waiting: Vec<u32>,
    next_waiting: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    left: usize,
}

impl<'a> EarClipper<'a> {
    fn new(outline: &'a Outline) -> Self {
        let corners = outline.len();
        let count = corners as u32;
        let points = outline.shadow.iter().map(|point| point.extend(0.0));
        let mut clipper = Self {
            outline,
            before: (0..count)
                .map(|corner| (corner + count - 1) % count)
                .collect(),
            after: (0..count).map(|corner| (corner + 1) % count).collect(),
            versions: vec![0; corners],
            candidates: BinaryHeap::with_capacity(corners),
            blockers: PointTree::new(points.collect()),
            is_blocker: vec![true; corners],
            first_waiting: vec![NONE; corners],
            next_waiting: vec![NONE; corners],
            triangles: Vec::with_capacity(corners - 2),
            left: corners,
        };
        for corner in 0..count {
            clipper.assess(corner);
        }
        clipper
    }

    fn ear(&self, corner: u32) -> [u32; 3] {
        let index = corner as usize;
        [self.before[index], corner, self.after[index]]
    }

    fn clip_ears(&mut self) {
        while self.left > 3 {
            let Some(best) = self.candidates.pop() else {
                return;
            };
            let corner = best.corner;
            if best.version != self.versions[corner as usize] {
                continue;
            }
            match self.blocker_of(self.ear(corner)) {
                Some(blocker) => {
                    self.next_waiting[corner as usize] = self.first_waiting[blocker as usize];
                    self.first_waiting[blocker as usize] = corner;
                }
                None => self.clip(corner),
            }
        }
    }

    /// Without an ear left the shadow crosses itself or has no area: goes on with the best corner,
    /// whatever lies in the way, so that every polygon is cut.
    fn clip_the_rest(&mut self) {
        self.candidates.clear();
        let mut corner = self.after.iter().position(|&after| after != NONE);
        for _ in 0..self.left {
            let Some(index) = corner else { return };
            self.push(index as u32);
            corner = Some(self.after[index] as usize);
        }
        while self.left > 2 {
            let Some(best) = self.candidates.pop() else {
                return;
            };
            if best.version != self.versions[best.corner as usize] {
                continue;
            }
            let [before, _, after] = self.ear(best.corner);
            self.cut(best.corner);
            self.push(before);
            self.push(after);
        }
    }

    fn push(&mut self, corner: u32) {
        let version = self.versions[corner as usize];
        let quality = self.outline.quality(self.ear(corner));
        self.candidates.push(Candidate {
            quality,
            corner,
            version,
        });
    }

    fn clip(&mut self, corner: u32) {
        let [before, _, after] = self.ear(corner);
        self.cut(corner);
        self.assess(before);
        self.assess(after);
    }

    fn cut(&mut self, corner: u32) {
        let [before, _, after] = self.ear(corner);
        self.triangles.push([before, corner, after]);
        self.after[before as usize] = after;
        self.before[after as usize] = before;
        self.after[corner as usize] = NONE;
        for changed in [before, corner, after] {
            self.versions[changed as usize] += 1;
        }
        self.left -= 1;
    }

    /// Makes a left-turning corner a candidate; one that did not turn left before stops blocking.
    fn assess(&mut self, corner: u32) {
        if self.outline.turn(self.ear(corner)) <= 0.0 {
            return;
        }
        self.push(corner);
        if std::mem::replace(&mut self.is_blocker[corner as usize], false) {
            self.blockers.remove(corner);
            self.release(corner);
        }
    }

    fn release(&mut self, blocker: u32) {
        let mut waiting = std::mem::replace(&mut self.first_waiting[blocker as usize], NONE);
        while waiting != NONE {
            let next = std::mem::replace(&mut self.next_waiting[waiting as usize], NONE);
            if self.after[waiting as usize] != NONE {
                self.push(waiting);
            }
            waiting = next;
        }
    }

    fn blocker_of(&self, ear: [u32; 3]) -> Option<u32> {
        let triangle = ear.map(|corner| self.outline.shadow[corner as usize]);
        self.blockers.search(
            |low, high| box_meets_triangle(low, high, triangle),
            |corner| {
                if self.blocks(corner, ear) {
                    ControlFlow::Break(corner)
                } else {
                    ControlFlow::Continue(())
                }
            },
        )
    }

    fn blocks(&self, corner: u32, ear: [u32; 3]) -> bool {
        let [before, tip, after] = ear;
        let outline = self.outline;
        let point = outline.shadow[corner as usize];
        let ends = [before, after].map(|end| outline.shadow[end as usize]);
        if ear.contains(&corner) || self.after[corner as usize] == NONE || ends.contains(&point) {
            return false;
        }
        let in_cone = |corner: u32| {
            [[before, tip, corner], [tip, after, corner]].map(|triple| outline.turn(triple))
        };
        if point == outline.shadow[tip as usize] {
            // The polygon passes the tip once more: it matters only if it enters the ear there.
            let [previous, _, next] = self.ear(corner);
            return [previous, next]
                .iter()
                .any(|&neighbor| in_cone(neighbor).iter().all(|&turn| turn > 0.0));
        }
        in_cone(corner).iter().all(|&turn| turn >= 0.0)
            && outline.turn([after, before, corner]) >= 0.0
    }
}

/// Whether a box may meet a triangle that turns left; sometimes true when they do not meet.
fn box_meets_triangle(low: DVec3, high: DVec3, triangle: [DVec2; 3]) -> bool {
    let [low, high] = [low.truncate(), high.truncate()];
    let [a, b, c] = triangle;
    if a.max(b).max(c).cmplt(low).any() || a.min(b).min(c).cmpgt(high).any() {
        return false;
    }
    [[a, b], [b, c], [c, a]].iter().all(|&[from, to]| {
        let along = to - from;
        // The corner of the box farthest to the left of the side.
        let x = if along.y > 0.0 { low.x } else { high.x };
        let y = if along.x > 0.0 { high.y } else { low.y };
        along.perp_dot(DVec2::new(x, y) - from) >= -tolerance::UNIT_ROUNDING
    })
}
