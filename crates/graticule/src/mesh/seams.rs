use std::ops::Range;

use super::faces::Faces;
use super::gluing::{EdgeUses, NONE};

/// Two boundary sides that lie at the same place and are the only two sides there: the surface
/// was cut there, or never welded.
pub(super) type Seam = [u32; 2];

/// All seams. `names` has one vertex for each position, `twins` belongs to the faces as given.
pub(super) fn find_seams(faces: &impl Faces, twins: &[u32], names: &[u32]) -> Vec<Seam> {
    let named = NamedFaces { faces, names };
    let uses = EdgeUses::of(&named, names.len());
    let seams = uses.iter().filter_map(|group| match *group {
        [first, second] => Some([first, second]),
        _ => None,
    });
    seams
        .filter(|seam| {
            let [from, to] = named.edge(seam[0]);
            from != to && seam.iter().all(|&side| twins[side as usize] == NONE)
        })
        .collect()
}

/// Faces whose vertices go by other names.
struct NamedFaces<'a, F> {
    faces: &'a F,
    names: &'a [u32],
}

impl<F: Faces> Faces for NamedFaces<'_, F> {
    fn face_count(&self) -> usize {
        self.faces.face_count()
    }

    fn corner_count(&self) -> usize {
        self.faces.corner_count()
    }

    fn corners(&self, face: u32) -> Range<u32> {
        self.faces.corners(face)
    }

    fn face(&self, corner: u32) -> u32 {
        self.faces.face(corner)
    }

    fn origin(&self, corner: u32) -> u32 {
        self.names[self.faces.origin(corner) as usize]
    }

    fn next(&self, corner: u32) -> u32 {
        self.faces.next(corner)
    }

    fn previous(&self, corner: u32) -> u32 {
        self.faces.previous(corner)
    }
}
