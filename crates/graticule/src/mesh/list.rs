use serde::{Serialize, Serializer, ser::SerializeStruct};

/// Elements found, in ascending order of their discovery: all are counted and kept, only the first
/// few are shown and serialised.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementList<T> {
    elements: Vec<T>,
}

impl<T> ElementList<T> {
    /// How many elements are shown.
    pub const SHOWN: usize = 20;

    /// The number of elements.
    #[must_use]
    pub fn count(&self) -> usize {
        self.elements.len()
    }

    /// Whether there is no element.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// All elements.
    #[must_use]
    pub fn all(&self) -> &[T] {
        &self.elements
    }

    /// The first [`SHOWN`](Self::SHOWN) elements.
    #[must_use]
    pub fn shown(&self) -> &[T] {
        &self.elements[..self.count().min(Self::SHOWN)]
    }

    pub(super) fn push(&mut self, element: T) {
        self.elements.push(element);
    }
}

impl<T> Default for ElementList<T> {
    fn default() -> Self {
        Self {
            elements: Vec::new(),
        }
    }
}

impl<T> From<Vec<T>> for ElementList<T> {
    fn from(elements: Vec<T>) -> Self {
        Self { elements }
    }
}

impl<T> FromIterator<T> for ElementList<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        elements.into_iter().collect::<Vec<_>>().into()
    }
}

impl<T> Extend<T> for ElementList<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, elements: I) {
        self.elements.extend(elements);
    }
}

/// `{"count": 1200, "first": [3, 7, …]}`
impl<T: Serialize> Serialize for ElementList<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_struct("ElementList", 2)?;
        list.serialize_field("count", &self.count())?;
        list.serialize_field("first", self.shown())?;
        list.end()
    }
}
