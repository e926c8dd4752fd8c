//! In which order to eliminate unknowns so that the factor stays sparse.

use glam::DVec3;

use super::Pattern;

mod cut;
mod dissection;
mod graph;
mod placement;
mod separator;

pub use graph::Graph;
pub use placement::Placement;

/// Below this many vertices minimum degree is at least as fast, ordering and one factorisation
/// taken together.
const SMALLEST_DISSECTED: usize = 60_000;

/// An order of elimination, and its inverse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ordering {
    /// Unknown at each place.
    order: Vec<u32>,
    /// Place of each unknown.
    places: Vec<u32>,
}

impl Ordering {
    /// The order in which `unknowns` stand in the given list.
    ///
    /// `None` unless every number below the list's length occurs once.
    #[must_use]
    pub fn from_order(order: Vec<u32>) -> Option<Self> {
        let mut places = vec![u32::MAX; order.len()];
        for (place, &unknown) in order.iter().enumerate() {
            let slot = places.get_mut(unknown as usize)?;
            if *slot != u32::MAX {
                return None;
            }
            *slot = place as u32;
        }
        Some(Self { order, places })
    }

    /// `order` holds every number below its length once.
    pub(super) fn from_permutation(order: Vec<u32>) -> Self {
        let mut places = vec![0; order.len()];
        for (place, &unknown) in order.iter().enumerate() {
            places[unknown as usize] = place as u32;
        }
        Self { order, places }
    }

    /// Unknowns as numbered: no reordering.
    #[must_use]
    pub fn natural(count: usize) -> Self {
        Self::from_permutation((0..count as u32).collect())
    }

    /// Approximate minimum degree (Amestoy, Davis and Duff 1996), by `faer`.
    #[must_use]
    pub fn minimum_degree(graph: &Graph) -> Self {
        Self::from_permutation(dissection::minimum_degree(graph))
    }

    /// Nested dissection by the vertices' coordinates.
    ///
    /// Any points give a valid order, coincident and non-finite ones too; points that follow the
    /// graph give a good one. O(n log n); uses rayon on large graphs, with the same result for any
    /// number of threads.
    ///
    /// # Panics
    /// Unless there is one point per vertex.
    #[must_use]
    pub fn nested_dissection(graph: &Graph, coordinates: &[DVec3]) -> Self {
        assert_eq!(graph.vertices(), coordinates.len(), "one point per vertex");
        Self::from_permutation(dissection::dissect(graph, &to_unit_size(coordinates)))
    }

    /// Minimum degree for small graphs, nested dissection for large ones.
    ///
    /// # Panics
    /// As [`nested_dissection`](Self::nested_dissection).
    #[must_use]
    pub fn for_mesh(graph: &Graph, coordinates: &[DVec3]) -> Self {
        if graph.vertices() < SMALLEST_DISSECTED {
            Self::minimum_degree(graph)
        } else {
            Self::nested_dissection(graph, coordinates)
        }
    }

    /// The order for `block` unknowns per vertex, numbered `block * vertex + k`: those of one vertex
    /// follow each other.
    #[must_use]
    pub fn expanded(&self, block: usize) -> Self {
        let block = block as u32;
        let unknowns = |&vertex: &u32| (0..block).map(move |k| block * vertex + k);
        Self::from_permutation(self.order.iter().flat_map(unknowns).collect())
    }

    /// An order of the first unknowns of a pattern, those of one point together: `group_of` ascends
    /// and has one entry for each of them, `points` one for each group.
    pub(crate) fn of_groups(pattern: &Pattern, group_of: &[u32], points: &[DVec3]) -> Self {
        let graph = Graph::of_groups(pattern, points.len(), group_of);
        Self::for_mesh(&graph, points).expanded_to(group_of)
    }

    /// The order of unknowns that belong to groups: `group_of` ascends, one entry per unknown.
    fn expanded_to(&self, group_of: &[u32]) -> Self {
        let first = |group: u32| group_of.partition_point(|&other| other < group) as u32;
        let unknowns = |&group: &u32| first(group)..first(group + 1);
        Self::from_permutation(self.order.iter().flat_map(unknowns).collect())
    }

    /// Number of unknowns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are no unknowns.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The unknowns, first eliminated first.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Place of each unknown in the order.
    #[must_use]
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    pub(super) fn faer(&self) -> faer::perm::PermRef<'_, u32> {
        faer::perm::PermRef::new_checked(&self.order, &self.places, self.order.len())
    }
}

/// The numbers of the points along a curve that fills space: what is near in it is near in space.
pub(crate) fn along_curve(points: &[DVec3]) -> Vec<u32> {
    let all = (0..points.len() as u32).collect();
    dissection::sorted_along_curve(all, &to_unit_size(points))
}

/// The points moved and scaled into `-1..=1`; the origin in place of those that are not finite.
fn to_unit_size(points: &[DVec3]) -> Vec<DVec3> {
    let finite = || points.iter().filter(|point| point.is_finite());
    let lowest = finite().fold(DVec3::INFINITY, |a, &b| a.min(b));
    let highest = finite().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
    // Halves, since the extent itself may overflow.
    let middle = lowest / 2.0 + highest / 2.0;
    let extent = (highest / 2.0 - lowest / 2.0).max_element();
    let scale = |point: &DVec3| {
        if !point.is_finite() || extent.is_nan() || extent <= 0.0 {
            return DVec3::ZERO;
        }
        (*point - middle) / extent
    };
    points.iter().map(scale).collect()
}
