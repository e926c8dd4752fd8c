//! The command as its users meet it: through the real binary.

mod arguments;
mod atlas;
mod bench;
mod demo;
mod field;
mod flatten;
mod info;
mod layout;
mod layout_atlas;
mod measure;
mod parameterize;
mod remesh;
mod repair;
mod streams;
