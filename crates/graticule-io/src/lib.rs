//! Mesh files: reading and writing OBJ, PLY, OFF, STL and glTF.
#![forbid(unsafe_code)]
