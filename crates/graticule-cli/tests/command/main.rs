//! The command as its users meet it: through the real binary.

mod arguments;
mod bench;
mod demo;
mod field;
mod flatten;
mod info;
mod measure;
mod parameterize;
mod repair;
mod streams;
