//! Elements in words: how many, of which kind, and the first of them.

use super::ElementList;

/// Elements named in a sentence; a report has more.
const NAMED: usize = 3;

/// What a list of elements says, for example `3 T-junctions: vertex 5, 6, 7`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sentence {
    pub(super) count: usize,
    pub(super) text: String,
}

/// An element as a sentence names it.
trait Named {
    fn name(&self) -> String;
}

impl Named for u32 {
    fn name(&self) -> String {
        self.to_string()
    }
}

impl Named for [u32; 2] {
    fn name(&self) -> String {
        format!("{} and {}", self[0], self[1])
    }
}

/// Vertices by number. Here and below `nouns` holds singular and plural, apart by a bar; there is
/// nothing to say of an empty list.
pub(super) fn of_vertices(elements: &ElementList<u32>, nouns: &str) -> Option<Sentence> {
    sentence(elements, nouns, "vertex", ", ")
}

/// Polygons by number.
pub(super) fn of_polygons(elements: &ElementList<u32>, nouns: &str) -> Option<Sentence> {
    sentence(elements, nouns, "polygon", ", ")
}

/// Components by their first polygons.
pub(super) fn of_components(elements: &ElementList<u32>, nouns: &str) -> Option<Sentence> {
    sentence(elements, nouns, "from polygon", ", ")
}

/// Edges by their two vertices.
pub(super) fn of_edges(elements: &ElementList<[u32; 2]>, nouns: &str) -> Option<Sentence> {
    sentence(elements, nouns, "between vertices", "; ")
}

fn sentence<T: Named>(
    elements: &ElementList<T>,
    nouns: &str,
    place: &str,
    separator: &str,
) -> Option<Sentence> {
    let count = elements.count();
    let (singular, plural) = nouns.split_once('|').unwrap_or((nouns, nouns));
    let noun = if count == 1 { singular } else { plural };
    let named: Vec<_> = elements.all().iter().take(NAMED).map(Named::name).collect();
    let more = if count > NAMED { ", …" } else { "" };
    let text = format!("{count} {noun}: {place} {}{more}", named.join(separator));
    (count > 0).then_some(Sentence { count, text })
}
