//! Citation keys as items, so that a source named in a doc comment is a checked link.
//!
//! Write ``[`PGP06`] Eq. 14`` in the documentation and end the comment, or the module, with the
//! link target ``[`PGP06`]: crate::papers::PGP06``: a misspelt key then fails the documentation
//! build.

/// A published source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Paper {
    /// The short key that the code and the documentation use.
    pub key: &'static str,
    /// Authors, in the order printed.
    pub authors: &'static str,
    /// Title, as printed.
    pub title: &'static str,
    /// Where and when it appeared.
    pub published: &'static str,
    /// Digital object identifier, or empty.
    pub doi: &'static str,
}

/// *Intrinsic Parameterizations of Surface Meshes*.
pub const DMA02: Paper = Paper {
    key: "DMA02",
    authors: "Mathieu Desbrun, Mark Meyer, Pierre Alliez",
    title: "Intrinsic Parameterizations of Surface Meshes",
    published: "Computer Graphics Forum 21(3), Eurographics 2002, pages 209-218",
    doi: "10.1111/1467-8659.00580",
};

/// *Periodic Global Parameterization*.
pub const PGP06: Paper = Paper {
    key: "PGP06",
    authors: "Nicolas Ray, Wan Chiu Li, Bruno Lévy, Alla Sheffer, Pierre Alliez",
    title: "Periodic Global Parameterization",
    published: "ACM Transactions on Graphics 25(4), 2006, pages 1460-1485",
    doi: "10.1145/1183287.1183297",
};
