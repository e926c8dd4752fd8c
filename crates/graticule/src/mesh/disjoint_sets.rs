/// Sets that only ever grow together; the smallest member names the set.
#[derive(Clone, Debug)]
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one member each.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
        }
    }

    /// The smallest member of the set that holds `member`.
    pub(crate) fn find(&mut self, mut member: u32) -> u32 {
        while self.parents[member as usize] != member {
            let grandparent = self.parents[self.parents[member as usize] as usize];
            self.parents[member as usize] = grandparent;
            member = grandparent;
        }
        member
    }

    /// Joins the sets of both members; returns whether they were apart.
    pub(crate) fn join(&mut self, first: u32, second: u32) -> bool {
        let [first, second] = [self.find(first), self.find(second)];
        self.parents[first.max(second) as usize] = first.min(second);
        first != second
    }

    /// For each member the smallest one of its set.
    pub(crate) fn into_names(mut self) -> Vec<u32> {
        // Parents are never larger than their children, so one pass in order suffices.
        for member in 0..self.parents.len() {
            self.parents[member] = self.parents[self.parents[member] as usize];
        }
        self.parents
    }
}

/// Numbers the distinct values `0..` in the order of their first appearance; `names` become
/// numbers. Returns how many there are. Every name must be the index of an element.
pub(crate) fn number_names(names: &mut [u32]) -> usize {
    let mut numbers = vec![u32::MAX; names.len()];
    let mut count = 0;
    for name in names {
        let number = &mut numbers[*name as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *name = *number;
    }
    count as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_member_names_the_set() {
        let mut sets = DisjointSets::new(6);
        assert!(sets.join(5, 3));
        assert!(sets.join(3, 1));
        assert!(!sets.join(1, 5));
        assert_eq!(sets.find(5), 1);
        let mut names = sets.into_names();
        assert_eq!(names, [0, 1, 2, 1, 4, 1]);
        assert_eq!(number_names(&mut names), 4);
        assert_eq!(names, [0, 1, 2, 1, 3, 1]);
    }
}
