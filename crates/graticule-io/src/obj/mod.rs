//! Wavefront OBJ (Appendix B1 of the Advanced Visualizer manual), as written in practice: vertex
//! colours behind the coordinates, faces before their vertices, names with blanks.

mod faces;
mod labels;
mod read;
mod write;

pub(crate) use labels::LabelRuns;
pub(crate) use read::read;
pub(crate) use write::write;
