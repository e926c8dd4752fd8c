use graticule::mesh::{PerFace, PerVertex, Surface};

use crate::error::check_count;
use crate::{ColorScale, DrawError, Legend, Paint};

/// A number for each element of a surface, shown as colour with a legend.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    /// The numbers; NaN where there is none.
    pub values: Values<'a>,
    /// What they are, with the unit.
    pub title: String,
    /// How they become colours.
    pub scale: ColorScale,
}

/// One number for each face or vertex.
#[derive(Clone, Copy, Debug)]
pub enum Values<'a> {
    /// Each triangle has one colour.
    PerFace(&'a PerFace<f64>),
    /// The number is interpolated in the triangles.
    PerVertex(&'a PerVertex<f64>),
}

impl<'a> Figure<'a> {
    /// A number for each face, in the standard colours and robust range.
    #[must_use]
    pub fn per_face(title: impl Into<String>, values: &'a PerFace<f64>) -> Self {
        Self {
            values: Values::PerFace(values),
            title: title.into(),
            scale: ColorScale::default(),
        }
    }

    /// A number for each vertex, in the standard colours and robust range.
    #[must_use]
    pub fn per_vertex(title: impl Into<String>, values: &'a PerVertex<f64>) -> Self {
        Self {
            values: Values::PerVertex(values),
            title: title.into(),
            scale: ColorScale::default(),
        }
    }

    /// The same figure in other colours or another range.
    #[must_use]
    pub fn with_scale(mut self, scale: ColorScale) -> Self {
        self.scale = scale;
        self
    }

    /// The colours of the faces of `surface`, and what they mean.
    pub(crate) fn paint(&self, surface: &Surface) -> Result<(Paint, Legend), DrawError> {
        let mesh = surface.mesh();
        match self.values {
            Values::PerFace(values) => {
                check_count("face values", mesh.face_count(), values.len())?;
                let legend = self.scale.legend(&self.title, values.as_slice());
                let colors = values.iter().map(|&value| legend.color(value));
                Ok((Paint::PerFace(colors.collect()), legend))
            }
            Values::PerVertex(values) => {
                check_count("vertex values", mesh.vertex_count(), values.len())?;
                let legend = self.scale.legend(&self.title, values.as_slice());
                // Far beyond the ends an interpolated colour would jump within the triangle.
                let share = |&value: &f64| legend.share(value).clamp(-1.0, 2.0) as f32;
                let shares = values.iter().map(share).collect();
                Ok((Paint::PerVertex(shares, legend.map), legend))
            }
        }
    }
}
