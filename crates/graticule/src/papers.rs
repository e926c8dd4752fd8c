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

/// *Texture Mapping Progressive Meshes*: the L² and L∞ stretch of a map.
pub const SSGH01: Paper = Paper {
    key: "SSGH01",
    authors: "Pedro V. Sander, John Snyder, Steven J. Gortler, Hugues Hoppe",
    title: "Texture Mapping Progressive Meshes",
    published: "SIGGRAPH 2001, pages 409-416",
    doi: "10.1145/383259.383307",
};

/// *MIPS: An Efficient Global Parametrization Method*: the ratio of singular values and its sum
/// with its inverse.
pub const HG00: Paper = Paper {
    key: "HG00",
    authors: "Kai Hormann, Günther Greiner",
    title: "MIPS: An Efficient Global Parametrization Method",
    published: "Curve and Surface Design: Saint-Malo 1999, Vanderbilt University Press 2000, pages 153-162",
    doi: "",
};

/// *Bijective Parameterization with Free Boundaries*: the symmetric Dirichlet energy.
pub const SS15: Paper = Paper {
    key: "SS15",
    authors: "Jason Smith, Scott Schaefer",
    title: "Bijective Parameterization with Free Boundaries",
    published: "ACM Transactions on Graphics 34(4), 2015, article 70",
    doi: "10.1145/2766947",
};

/// *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*: exact
/// signs of orientation.
pub const SHE97: Paper = Paper {
    key: "SHE97",
    authors: "Jonathan Richard Shewchuk",
    title: "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
    published: "Discrete & Computational Geometry 18(3), 1997, pages 305-363",
    doi: "10.1007/PL00009321",
};
