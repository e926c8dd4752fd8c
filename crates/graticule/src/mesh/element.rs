use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

use serde::{Serialize, Serializer};

use super::{ComponentId, EdgeId, FaceId, HalfedgeId, VertexId};

/// A kind of mesh element: an index with a type of its own.
pub trait Element: Copy {
    /// The element with this index.
    fn from_index(index: usize) -> Self;
    /// The index of this element, counted from 0.
    fn index(self) -> usize;
}

/// One value for each element of a kind, indexed by the element.
#[derive(Clone, Debug, PartialEq)]
pub struct PerElement<E, T> {
    values: Vec<T>,
    element: PhantomData<fn(E)>,
}

/// One value for each vertex.
pub type PerVertex<T> = PerElement<VertexId, T>;
/// One value for each triangle.
pub type PerFace<T> = PerElement<FaceId, T>;
/// One value for each edge.
pub type PerEdge<T> = PerElement<EdgeId, T>;
/// One value for each corner of each triangle; corner and halfedge share their numbering.
pub type PerCorner<T> = PerElement<HalfedgeId, T>;
/// One value for each component.
pub type PerComponent<T> = PerElement<ComponentId, T>;

impl<E: Element, T> PerElement<E, T> {
    /// Wraps values that stand in the order of the elements.
    #[must_use]
    pub fn new(values: Vec<T>) -> Self {
        Self {
            values,
            element: PhantomData,
        }
    }

    /// The same value for `count` elements.
    #[must_use]
    pub fn filled(count: usize, value: T) -> Self
    where
        T: Clone,
    {
        Self::new(vec![value; count])
    }

    /// One value computed for each of `count` elements, in order.
    #[must_use]
    pub fn from_fn(count: usize, value: impl FnMut(E) -> T) -> Self {
        Self::new((0..count).map(E::from_index).map(value).collect())
    }

    /// The number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no element.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values in the order of the elements.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }

    /// The values in the order of the elements, to be changed.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// Gives the values up, in the order of the elements.
    #[must_use]
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// The values in the order of the elements.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.values.iter()
    }

    /// Each element with its value.
    #[must_use]
    pub fn enumerate(&self) -> impl ExactSizeIterator<Item = (E, &T)> {
        self.values
            .iter()
            .enumerate()
            .map(|(index, value)| (E::from_index(index), value))
    }

    /// A new array with `change` applied to each value.
    #[must_use]
    pub fn map<U>(&self, change: impl FnMut(&T) -> U) -> PerElement<E, U> {
        PerElement::new(self.values.iter().map(change).collect())
    }
}

impl<E: Element, T> Index<E> for PerElement<E, T> {
    type Output = T;

    #[inline]
    fn index(&self, element: E) -> &T {
        &self.values[element.index()]
    }
}

impl<E: Element, T> IndexMut<E> for PerElement<E, T> {
    #[inline]
    fn index_mut(&mut self, element: E) -> &mut T {
        &mut self.values[element.index()]
    }
}

impl<'a, E: Element, T> IntoIterator for &'a PerElement<E, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<E: Element, T: Serialize> Serialize for PerElement<E, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.values.serialize(serializer)
    }
}
