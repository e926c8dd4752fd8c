//! Pictures of meshes, fields, lines and UV maps, on the CPU.
#![forbid(unsafe_code)]
