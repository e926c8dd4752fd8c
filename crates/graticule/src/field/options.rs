use std::f64::consts::PI;

use super::{
    CurlOptions, CurvatureOptions, FieldError, Guide, SingularityPlan, SmoothingOptions, Strength,
    Stroke, Symmetry,
};
use crate::mesh::{EdgeId, PerVertex};

/// How [`cross_field`](super::cross_field()) makes a field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldOptions {
    /// The number of directions at each point.
    pub symmetry: Symmetry,
    /// How the curvature is estimated that lines and crosses follow; `None` for none. Vectors never
    /// follow it: it says nothing of forward and backward.
    pub curvature: Option<CurvatureOptions>,
    /// How the field is smoothed.
    pub smoothing: SmoothingOptions,
    /// How strongly the field is held to the boundary.
    pub boundary: Option<Strength>,
    /// Which edges the field runs along.
    pub features: FeatureOptions,
    /// Directions wished for; they win over boundary and features.
    pub guides: Vec<Guide>,
    /// Lines on the surface to run along; they count as guides.
    pub strokes: Vec<Stroke>,
    /// How far apart lines along the field are to be at each vertex, over each other: the field is
    /// smooth in the metric in which they are so everywhere, and its singularities are where lines
    /// begin and end for that. `None` for the same everywhere.
    pub sizes: Option<PerVertex<f64>>,
    /// Distance, in mean edge lengths, up to which two singularities of opposite sign cancel; 0 for
    /// none.
    pub cancel_distance: f64,
    /// The same as a length in the unit of the positions; the larger of the two counts. For quads
    /// of a given size: pairs closer than a few of them only disturb the net.
    pub cancel_length: f64,
    /// Where the field is to be singular.
    pub singularities: SingularityPlan,
    /// How curl is corrected, if it is.
    pub curl_correction: Option<CurlOptions>,
}

/// Weight of a boundary that is followed softly: some three times that of the clearest curvature,
/// so that a ragged rim still does not make singularities.
pub(super) const BOUNDARY_WEIGHT: f64 = 10.0;

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            symmetry: Symmetry::Cross,
            curvature: Some(CurvatureOptions::default()),
            smoothing: SmoothingOptions::default(),
            boundary: Some(Strength::Soft(BOUNDARY_WEIGHT)),
            features: FeatureOptions::default(),
            guides: Vec::new(),
            strokes: Vec::new(),
            sizes: None,
            cancel_distance: 7.0,
            cancel_length: 0.0,
            singularities: SingularityPlan::Found,
            curl_correction: None,
        }
    }
}

/// Which edges lines and crosses run along; vectors do not, as an edge has no direction.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureOptions {
    /// The angle between the normals of two triangles, in radians, from which on their edge is a
    /// feature; `None` for no such edges.
    pub dihedral: Option<f64>,
    /// Fewest edges in a line of them.
    pub least_edges: usize,
    /// Further edges.
    pub edges: Vec<EdgeId>,
    /// How strongly the field is held to all these.
    pub strength: Strength,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self {
            dihedral: Some(60.0_f64.to_radians()),
            least_edges: 10,
            edges: Vec::new(),
            strength: Strength::Hard,
        }
    }
}

impl FieldOptions {
    /// Refuses numbers out of range.
    pub(super) fn check(&self, vertices: usize) -> Result<(), FieldError> {
        self.check_sizes(vertices)?;
        let radius = self.curvature.map_or(1.0, |curvature| curvature.radius);
        let share = self.curvature.map_or(1.0, |curvature| curvature.share);
        let dihedral = self.features.dihedral.unwrap_or(1.0);
        let finite = f64::MIN_POSITIVE..=f64::MAX;
        for (name, value, is_good, range) in [
            (
                "curvature radius",
                radius,
                finite.contains(&radius),
                "above 0, finite",
            ),
            (
                "share of the curvature",
                share,
                (0.0..=1.0).contains(&share),
                "0 to 1",
            ),
            (
                "cancel distance",
                self.cancel_distance,
                (0.0..=f64::MAX).contains(&self.cancel_distance),
                "0 and above, finite",
            ),
            (
                "cancel length",
                self.cancel_length,
                (0.0..=f64::MAX).contains(&self.cancel_length),
                "0 and above, finite",
            ),
            (
                "feature angle",
                dihedral,
                (0.0..=PI).contains(&dihedral),
                "0 to π",
            ),
        ] {
            if !is_good {
                return Err(FieldError::Option { name, value, range });
            }
        }
        for strength in [self.boundary, Some(self.features.strength)] {
            if let Some(Strength::Soft(value)) = strength
                && !finite.contains(&value)
            {
                let (name, range) = ("weight of a soft constraint", "above 0, finite");
                return Err(FieldError::Option { name, value, range });
            }
        }
        Ok(())
    }

    fn check_sizes(&self, needed: usize) -> Result<(), FieldError> {
        let Some(sizes) = &self.sizes else {
            return Ok(());
        };
        let given = sizes.len();
        if given != needed {
            return Err(FieldError::SizeCount { given, needed });
        }
        let is_good = |size: f64| size.is_finite() && size > 0.0 && size.recip().is_finite();
        let bad = sizes.iter().copied().find(|&size| !is_good(size));
        bad.map_or(Ok(()), |value| {
            let (name, range) = ("size", "above 0, finite");
            Err(FieldError::Option { name, value, range })
        })
    }
}
