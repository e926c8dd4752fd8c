use super::PolygonSoup;
use super::faces::PolygonFaces;

/// The polygons of a soup that span a face, without repeated corners, and why others do not.
#[derive(Clone, Debug)]
pub(super) struct UsablePolygons {
    pub(super) faces: PolygonFaces,
    /// The soup corner of each corner.
    pub(super) corner_sources: Vec<u32>,
    /// The soup polygon of each face.
    pub(super) polygon_sources: Vec<u32>,
    /// Polygons given with less than three corners.
    pub(super) too_few_corners: Vec<u32>,
    /// Polygons with a corner that names no vertex.
    pub(super) out_of_range: Vec<u32>,
    /// Polygons with a corner whose position is not finite.
    pub(super) non_finite: Vec<u32>,
    /// Polygons that repeat a corner: next to itself, or around a spike.
    pub(super) repeated: Vec<u32>,
    /// Those of them that have less than three corners without.
    pub(super) collapsed: Vec<u32>,
}

impl UsablePolygons {
    /// Looks at each polygon with every vertex `v` replaced by `names[v]`.
    pub(super) fn of(soup: &PolygonSoup, names: &[u32]) -> Self {
        let (polygons, corners) = (soup.polygons.len(), soup.polygons.corner_count());
        let mut usable = Self {
            faces: PolygonFaces::with_capacity(polygons, corners),
            corner_sources: Vec::with_capacity(corners),
            polygon_sources: Vec::with_capacity(polygons),
            too_few_corners: Vec::new(),
            out_of_range: Vec::new(),
            non_finite: Vec::new(),
            repeated: Vec::new(),
            collapsed: Vec::new(),
        };
        // A byte each: the polygons ask in any order.
        let finite: Vec<_> = soup
            .positions
            .iter()
            .map(|position| position.is_finite())
            .collect();
        let mut kept = Vec::new();
        for polygon in 0..polygons {
            let vertices = soup.polygons.vertices(polygon);
            let is_finite = |&vertex: &u32| finite.get(vertex as usize).copied();
            if vertices.iter().any(|vertex| is_finite(vertex).is_none()) {
                usable.out_of_range.push(polygon as u32);
            } else if vertices
                .iter()
                .any(|vertex| is_finite(vertex) == Some(false))
            {
                usable.non_finite.push(polygon as u32);
            } else {
                usable.add(soup, names, polygon, &mut kept);
            }
        }
        usable
    }

    fn add(&mut self, soup: &PolygonSoup, names: &[u32], polygon: usize, kept: &mut Vec<u32>) {
        let number = polygon as u32;
        let vertices = soup.polygons.vertices(polygon);
        if vertices.len() < 3 {
            return self.too_few_corners.push(number);
        }
        let name = |place: u32| names[vertices[place as usize] as usize];
        distinct_corners(vertices.len() as u32, name, kept);
        if kept.len() < vertices.len() {
            self.repeated.push(number);
        }
        if kept.len() < 3 {
            return self.collapsed.push(number);
        }
        let first = soup.polygons.corner_range(polygon).start as u32;
        self.faces.push(kept.iter().map(|&place| name(place)));
        self.corner_sources
            .extend(kept.iter().map(|place| first + place));
        self.polygon_sources.push(number);
    }
}

/// The places left around a polygon when corners equal to the one before, and spikes that return
/// to the same vertex, are taken out.
fn distinct_corners(corners: u32, name: impl Fn(u32) -> u32, kept: &mut Vec<u32>) {
    kept.clear();
    for place in 0..corners {
        match **kept {
            [.., last] if name(last) == name(place) => {}
            [.., before, _] if name(before) == name(place) => {
                kept.pop();
            }
            _ => kept.push(place),
        }
    }
    // The same across the end.
    let mut start = 0;
    loop {
        match kept[start..] {
            [first, .., last] if name(first) == name(last) => drop(kept.pop()),
            [first, .., before, _] if name(first) == name(before) => drop(kept.pop()),
            [_, second, .., last] if name(second) == name(last) => start += 1,
            _ => break,
        }
    }
    kept.drain(..start);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distinct(names: &[u32]) -> Vec<u32> {
        let mut kept = Vec::new();
        distinct_corners(names.len() as u32, |place| names[place as usize], &mut kept);
        kept.iter().map(|&place| names[place as usize]).collect()
    }

    #[test]
    fn repeated_corners_and_spikes_go() {
        assert_eq!(distinct(&[0, 2, 3, 1, 1]), [0, 2, 3, 1]);
        assert_eq!(distinct(&[0, 0, 1, 2, 0]), [0, 1, 2]);
        assert_eq!(distinct(&[0, 1, 2, 1, 3]), [0, 1, 3]);
        assert_eq!(distinct(&[5, 0, 1, 2, 0]), [0, 1, 2]);
        assert_eq!(distinct(&[0, 1, 2, 0, 5]), [0, 1, 2]);
        assert!(distinct(&[7, 7, 7]).len() < 3);
        assert!(distinct(&[0, 1, 0, 1]).len() < 3);
    }

    #[test]
    fn a_vertex_passed_twice_stays() {
        assert_eq!(distinct(&[0, 1, 2, 0, 3, 4]), [0, 1, 2, 0, 3, 4]);
    }
}
