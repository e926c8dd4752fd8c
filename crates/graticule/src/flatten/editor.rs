//! Boundary points moved in real time: [DMA02] §4.2.
//!
//! A map with fixed boundary is linear in the places of its boundary vertices. The response of the
//! whole map to a boundary vertex that is moved by one unit (a discrete Green function) is computed
//! when the vertex is first taken hold of; from then on, moving it costs one pass over the
//! coordinates.
//!
//! [DMA02]: crate::papers::DMA02

use glam::DVec2;

use crate::Hint;
use crate::mesh::{PerVertex, VertexId};
use crate::watch::Watch;

use super::optimal::in_own_unit;
use super::{BoundaryPositions, FixedOptions, FixedSystem, FlatMap, FlattenError, Patch};

/// Responses computed in one go: their solves share the passes over the factor.
const BATCH: usize = 16;

/// How boundaries are edited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditorOptions {
    /// How the interior follows the boundary.
    pub fixed: FixedOptions,
    /// The most memory that impulse responses may take: 8 bytes per vertex and handle.
    pub most_bytes: usize,
}

impl Default for EditorOptions {
    /// Conformal weights, holes closed, 256 MiB.
    fn default() -> Self {
        Self {
            fixed: FixedOptions::default(),
            most_bytes: 256 << 20,
        }
    }
}

/// Why an edit is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// A handle is not one of the vertices whose places decide the map.
    #[error("{vertex} cannot be moved: the map does not depend on a place of it")]
    NotPlaced {
        /// The vertex.
        vertex: VertexId,
    },
    /// A handle is taken twice.
    #[error("{vertex} is among the handles twice")]
    Repeated {
        /// The vertex.
        vertex: VertexId,
    },
    /// An edit is begun within another.
    #[error("an edit of {handles} handles is going on")]
    Editing {
        /// Its handles.
        handles: usize,
    },
    /// There is no edit to go on with.
    #[error("no edit is going on")]
    NotEditing,
    /// Not one place per handle.
    #[error("{given} places were given for {handles} handles")]
    PlaceCount {
        /// Handles of the edit.
        handles: usize,
        /// Places given.
        given: usize,
    },
    /// A place is not finite.
    #[error("{vertex} was to be moved to ({}, {})", .place[0], .place[1])]
    NonFinite {
        /// The handle.
        vertex: VertexId,
        /// The place.
        place: [f64; 2],
    },
    /// The handles' responses do not fit into the memory allowed.
    #[error("{handles} handles need {needed} bytes; {allowed} are allowed")]
    Memory {
        /// Handles asked for.
        handles: usize,
        /// Bytes that they need.
        needed: usize,
        /// Bytes allowed.
        allowed: usize,
    },
    /// The map cannot be made.
    #[error(transparent)]
    Flatten(#[from] FlattenError),
}

impl Hint for EditError {
    fn hint(&self) -> Option<String> {
        let text = match self {
            Self::NotPlaced { .. } => "take vertices of the outer boundary or of fixed holes",
            Self::Repeated { .. } => "name each handle once",
            Self::Editing { .. } => "commit or cancel that edit first",
            Self::NotEditing => "begin an edit first",
            Self::PlaceCount { .. } => "give one place per handle, in the order of the handles",
            Self::NonFinite { .. } => "give finite coordinates",
            Self::Memory { .. } => "take fewer handles at once, or allow more memory",
            Self::Flatten(error) => return error.hint(),
        };
        Some(text.into())
    }
}

/// A map with fixed boundary whose boundary points are moved by hand.
///
/// An edit begins with some handles, moves them any number of times, and ends in
/// [`commit`](Self::commit) or [`cancel`](Self::cancel). [`uv`](Self::uv) is the map at every
/// moment. Responses are kept from edit to edit, those not used for longest going first.
///
/// Cost: [`new`](Self::new) one factorisation; a handle's first use one solve; a move one pass over
/// the coordinates per handle that changes its place.
#[derive(Debug)]
pub struct BoundaryEditor {
    system: FixedSystem,
    most_bytes: usize,
    /// Places that are in force, in unit lengths, in the order of the system's fixed vertices.
    places: Vec<DVec2>,
    /// The map that they make, in the surface's unit of length.
    committed: PerVertex<DVec2>,
    shown: PerVertex<DVec2>,
    responses: Vec<Response>,
    edit: Option<Edit>,
    edits: u64,
}

/// What one unit of a coordinate of a boundary vertex adds to that coordinate of every vertex.
#[derive(Debug)]
struct Response {
    /// Place of the vertex among the fixed ones.
    handle: usize,
    values: Vec<f64>,
    /// The edit that used it last.
    used: u64,
}

#[derive(Debug)]
struct Edit {
    /// Places of the handles among the fixed vertices, and in the list of responses.
    handles: Vec<usize>,
    responses: Vec<usize>,
    /// Where they are now, in unit lengths.
    places: Vec<DVec2>,
}

impl BoundaryEditor {
    /// Makes the map with this boundary and holds its factorisation.
    ///
    /// # Errors
    /// [`FlattenError`], as of [`FixedSystem::new`].
    pub fn new(
        patch: &Patch,
        boundary: &BoundaryPositions,
        options: &EditorOptions,
        watch: &Watch,
    ) -> Result<Self, FlattenError> {
        let _stage = watch.stage("boundary editor");
        let system = FixedSystem::new(patch, boundary, &options.fixed, watch)?;
        let places = system.unit_places(boundary)?;
        let committed = solved(&system, &places)?;
        Ok(Self {
            system,
            most_bytes: options.most_bytes,
            places,
            shown: committed.clone(),
            committed,
            responses: Vec::new(),
            edit: None,
            edits: 0,
        })
    }

    /// The map as it is now, in the surface's unit of length.
    #[must_use]
    pub fn uv(&self) -> &PerVertex<DVec2> {
        &self.shown
    }

    /// The vertices that can be moved, ascending.
    #[must_use]
    pub fn movable(&self) -> &[VertexId] {
        self.system.fixed()
    }

    /// The patch.
    #[must_use]
    pub fn patch(&self) -> &Patch {
        self.system.patch()
    }

    /// Whether an edit is going on.
    #[must_use]
    pub fn is_editing(&self) -> bool {
        self.edit.is_some()
    }

    /// Bytes that impulse responses take now.
    #[must_use]
    pub fn response_bytes(&self) -> usize {
        self.responses.len() * self.bytes_per_handle()
    }

    /// Computes the responses of these handles, so that an edit of them begins at once.
    ///
    /// # Errors
    /// [`EditError`] names a vertex that is no handle; [`EditError::Editing`],
    /// [`EditError::Memory`].
    pub fn prepare(&mut self, handles: &[VertexId], watch: &Watch) -> Result<(), EditError> {
        if let Some(edit) = &self.edit {
            let handles = edit.handles.len();
            return Err(EditError::Editing { handles });
        }
        let handles = self.checked(handles)?;
        self.edits += 1;
        self.compute(&handles, watch)
    }

    /// Takes hold of these vertices.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare).
    pub fn begin(&mut self, handles: &[VertexId], watch: &Watch) -> Result<(), EditError> {
        self.prepare(handles, watch)?;
        let handles = self.checked(handles)?;
        let place = |handle: &usize| {
            let mut responses = self.responses.iter();
            responses.position(|response| response.handle == *handle)
        };
        self.edit = Some(Edit {
            // Each was computed a moment ago.
            responses: handles.iter().filter_map(place).collect(),
            places: handles.iter().map(|&handle| self.places[handle]).collect(),
            handles,
        });
        Ok(())
    }

    /// Moves the handles to these places, in their order and in the surface's unit of length, and
    /// the whole map with them.
    ///
    /// # Errors
    /// [`EditError::NotEditing`], [`EditError::PlaceCount`], [`EditError::NonFinite`]; then nothing
    /// has moved.
    pub fn move_to(&mut self, places: &[DVec2]) -> Result<&PerVertex<DVec2>, EditError> {
        let unit = self.system.patch().unit_length();
        let edit = self.edit.as_mut().ok_or(EditError::NotEditing)?;
        if places.len() != edit.handles.len() {
            let (handles, given) = (edit.handles.len(), places.len());
            return Err(EditError::PlaceCount { handles, given });
        }
        if let Some(bad) = places.iter().position(|place| !place.is_finite()) {
            let vertex = self.system.fixed()[edit.handles[bad]];
            let place = places[bad].to_array();
            return Err(EditError::NonFinite { vertex, place });
        }
        for (k, place) in places.iter().enumerate() {
            let moved = *place - edit.places[k] * unit;
            if moved != DVec2::ZERO {
                let response = &self.responses[edit.responses[k]];
                response.add_to(&mut self.shown, moved);
                edit.places[k] = *place / unit;
            }
        }
        Ok(&self.shown)
    }

    /// Ends the edit; the handles stay where they are.
    ///
    /// The map is put together anew from the last one committed, so that the rounding of many small
    /// moves does not add up.
    ///
    /// # Errors
    /// [`EditError::NotEditing`].
    pub fn commit(&mut self) -> Result<(), EditError> {
        let edit = self.edit.take().ok_or(EditError::NotEditing)?;
        let unit = self.system.patch().unit_length();
        for (k, &handle) in edit.handles.iter().enumerate() {
            let moved = (edit.places[k] - self.places[handle]) * unit;
            self.responses[edit.responses[k]].add_to(&mut self.committed, moved);
            self.places[handle] = edit.places[k];
            let vertex = self.system.fixed()[handle];
            self.committed[vertex] = edit.places[k] * unit;
        }
        self.shown.clone_from(&self.committed);
        Ok(())
    }

    /// Ends the edit; everything is as it was before.
    ///
    /// # Errors
    /// [`EditError::NotEditing`].
    pub fn cancel(&mut self) -> Result<(), EditError> {
        self.edit.take().ok_or(EditError::NotEditing)?;
        self.shown.clone_from(&self.committed);
        Ok(())
    }

    /// The places in force, without those of an edit that is going on.
    ///
    /// # Errors
    /// None for places that the editor accepted; the type is that of
    /// [`BoundaryPositions::new`].
    pub fn boundary(&self) -> Result<BoundaryPositions, super::BoundaryError> {
        let unit = self.system.patch().unit_length();
        let pairs = self.system.fixed().iter().zip(&self.places);
        let places = pairs.map(|(&vertex, &place)| (vertex, place * unit));
        BoundaryPositions::new(self.system.patch(), places)
    }

    /// The map of the places in force, solved directly, checked and measured.
    ///
    /// # Errors
    /// [`FlattenError`], as of [`FixedSystem::map`].
    pub fn map(&self, watch: &Watch) -> Result<FlatMap, FlattenError> {
        let extended = self.system.extended(&self.places)?;
        self.system.finished(&extended, false, watch)
    }

    fn bytes_per_handle(&self) -> usize {
        self.committed.len() * size_of::<f64>()
    }

    /// Places of the handles among the fixed vertices.
    fn checked(&self, handles: &[VertexId]) -> Result<Vec<usize>, EditError> {
        let mut places = Vec::with_capacity(handles.len());
        for &vertex in handles {
            let place = self.system.fixed().binary_search(&vertex);
            let place = place.map_err(|_| EditError::NotPlaced { vertex })?;
            if places.contains(&place) {
                return Err(EditError::Repeated { vertex });
            }
            places.push(place);
        }
        Ok(places)
    }

    /// Computes the responses that are not there yet, within the memory allowed.
    fn compute(&mut self, handles: &[usize], watch: &Watch) -> Result<(), EditError> {
        let needed = handles.len() * self.bytes_per_handle();
        if needed > self.most_bytes {
            return Err(EditError::Memory {
                handles: handles.len(),
                needed,
                allowed: self.most_bytes,
            });
        }
        for response in &mut self.responses {
            if handles.contains(&response.handle) {
                response.used = self.edits;
            }
        }
        let known = |handle: &usize| self.responses.iter().any(|r| r.handle == *handle);
        let missing: Vec<usize> = handles.iter().filter(|h| !known(h)).copied().collect();
        self.make_room(missing.len());
        let _stage = watch.stage("impulse responses");
        for batch in missing.chunks(BATCH) {
            watch.check().map_err(FlattenError::from)?;
            self.solve_batch(batch)?;
        }
        Ok(())
    }

    /// Lets go of the responses that have not been used for longest.
    fn make_room(&mut self, missing: usize) {
        let most = self.most_bytes / self.bytes_per_handle().max(1);
        let excess = (self.responses.len() + missing).saturating_sub(most);
        self.responses.sort_by_key(|response| response.used);
        self.responses.drain(..excess);
    }

    fn solve_batch(&mut self, handles: &[usize]) -> Result<(), FlattenError> {
        let solution = self.system.impulse_responses(handles)?;
        let own = self.committed.len();
        let columns = solution.values.len() / handles.len();
        let pairs = handles.iter().zip(solution.columns(columns));
        for (&handle, column) in pairs {
            self.responses.push(Response {
                handle,
                values: column[..own].to_vec(),
                used: self.edits,
            });
        }
        Ok(())
    }
}

impl Response {
    fn add_to(&self, map: &mut PerVertex<DVec2>, moved: DVec2) {
        for (position, share) in map.as_mut_slice().iter_mut().zip(&self.values) {
            *position += moved * *share;
        }
    }
}

/// The map for these places by a direct solve, in the surface's unit of length.
fn solved(system: &FixedSystem, places: &[DVec2]) -> Result<PerVertex<DVec2>, FlattenError> {
    let positions = system.extended(places)?.positions;
    Ok(in_own_unit(system.patch(), &positions))
}
