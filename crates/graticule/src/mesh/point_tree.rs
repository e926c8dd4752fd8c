use std::ops::ControlFlow;

use glam::DVec3;

/// Points in leaves of at most this number.
const LEAF: usize = 8;

/// Points in a balanced tree of boxes, from which points can be taken away.
///
/// Built in O(n log n). A query visits the boxes that it does not rule out: for thin regions
/// O(√n) in the plane whatever the distribution of the points.
#[derive(Debug)]
pub(crate) struct PointTree {
    points: Vec<DVec3>,
    /// Point numbers, so ordered that every node owns a range.
    order: Vec<u32>,
    nodes: Vec<Node>,
    leaf_of_point: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    start: u32,
    end: u32,
    /// Number of points still here.
    live: u32,
    parent: u32,
    /// The first of two children side by side; 0 for a leaf.
    children: u32,
}

impl PointTree {
    pub(crate) fn new(points: Vec<DVec3>) -> Self {
        let count = points.len();
        let mut tree = Self {
            points,
            order: (0..count as u32).collect(),
            nodes: Vec::new(),
            leaf_of_point: vec![0; count],
        };
        let root = tree.node(0, count, 0);
        tree.nodes.push(root);
        let mut next = 0;
        while next < tree.nodes.len() {
            tree.divide(next);
            next += 1;
        }
        tree
    }

    pub(crate) fn point(&self, number: u32) -> DVec3 {
        self.points[number as usize]
    }

    /// Takes a point away; each point at most once.
    pub(super) fn remove(&mut self, number: u32) {
        let mut node = self.leaf_of_point[number as usize] as usize;
        let range = self.nodes[node].start as usize..self.nodes[node].end as usize;
        let live = self.nodes[node].live as usize;
        // The live points of a leaf come first.
        let slots = &mut self.order[range];
        if let Some(slot) = slots[..live].iter().position(|&point| point == number) {
            slots.swap(slot, live - 1);
            loop {
                self.nodes[node].live -= 1;
                if node == 0 {
                    break;
                }
                node = self.nodes[node].parent as usize;
            }
        }
    }

    /// Shows every point in the boxes (lowest, highest corner) that `may_hold` lets pass, until
    /// `visit` breaks off.
    pub(crate) fn search<B>(
        &self,
        may_hold: impl Fn(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(u32) -> ControlFlow<B>,
    ) -> Option<B> {
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if node.live == 0 || !may_hold(node.low, node.high) {
                continue;
            }
            if node.children != 0 {
                stack.extend([node.children + 1, node.children]);
                continue;
            }
            for &point in &self.order[node.start as usize..(node.start + node.live) as usize] {
                if let ControlFlow::Break(answer) = visit(point) {
                    return Some(answer);
                }
            }
        }
        None
    }

    fn node(&self, start: usize, end: usize, parent: u32) -> Node {
        let bounds = self.order[start..end]
            .iter()
            .map(|&point| self.points[point as usize]);
        let (low, high) = bounds.fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(low, high), point| (low.min(point), high.max(point)),
        );
        let [start, end] = [start as u32, end as u32];
        let live = end - start;
        Node {
            low,
            high,
            start,
            end,
            live,
            parent,
            children: 0,
        }
    }

    fn divide(&mut self, index: usize) {
        let node = self.nodes[index].clone();
        let [start, end] = [node.start as usize, node.end as usize];
        if end - start <= LEAF {
            for &point in &self.order[start..end] {
                self.leaf_of_point[point as usize] = index as u32;
            }
            return;
        }
        let extent = node.high - node.low;
        let axis = (0..3).fold(0, |best, axis| {
            if extent[axis] > extent[best] {
                axis
            } else {
                best
            }
        });
        let points = &self.points;
        let middle = (end - start) / 2;
        self.order[start..end].select_nth_unstable_by(middle, |&a, &b| {
            let [first, second] = [a, b].map(|point| points[point as usize][axis]);
            first.total_cmp(&second).then(a.cmp(&b))
        });
        self.nodes[index].children = self.nodes.len() as u32;
        let children = [(start, start + middle), (start + middle, end)]
            .map(|(start, end)| self.node(start, end, index as u32));
        self.nodes.extend(children);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn within(tree: &PointTree, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        tree.search::<()>(
            |node_low, node_high| node_low.cmple(high).all() && node_high.cmpge(low).all(),
            |point| {
                let position = tree.point(point);
                if position.cmpge(low).all() && position.cmple(high).all() {
                    found.push(point);
                }
                ControlFlow::Continue(())
            },
        );
        found.sort_unstable();
        found
    }

    #[test]
    fn a_search_finds_what_is_there_and_not_what_was_removed() {
        let position = |i: u32| DVec3::new(f64::from(i % 17), f64::from(i % 13), f64::from(i % 3));
        let mut tree = PointTree::new((0..300).map(position).collect());
        let [low, high] = [DVec3::new(3.0, 2.0, 0.0), DVec3::new(9.0, 8.0, 1.0)];
        let inside = |i: &u32| position(*i).cmpge(low).all() && position(*i).cmple(high).all();
        assert_eq!(
            within(&tree, low, high),
            (0..300).filter(inside).collect::<Vec<_>>()
        );
        for point in (0..300).step_by(2) {
            tree.remove(point);
        }
        assert_eq!(
            within(&tree, low, high),
            (1..300).step_by(2).filter(inside).collect::<Vec<_>>()
        );
    }
}
