//! The commands, a module each.

pub(crate) mod cite;
pub(crate) mod demo;
pub(crate) mod field;
pub(crate) mod flatten;
pub(crate) mod info;
pub(crate) mod layout;
pub(crate) mod measure;
pub(crate) mod parameterize;
pub(crate) mod remesh;
pub(crate) mod repair;
