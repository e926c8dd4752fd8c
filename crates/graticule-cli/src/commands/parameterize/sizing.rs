//! Sizes of charts, and of quads, that vary over the surface: by curvature, by a file, by the colours of the mesh.

use std::fs;
use std::path::{Path, PathBuf};

use graticule::field::FieldResult;
use graticule::mesh::{PerVertex, PolygonSoup, Repaired, VertexId};
use graticule::periodic::{ChartSize, CurvatureSizing, curvature_density};
use graticule::watch::Watch;
use serde::Serialize;

use crate::failure::Failure;

/// Where sizes of vertices come from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SizeSource {
    /// The brightness of the vertices' colours.
    Colors,
    /// A text file.
    File(PathBuf),
}

/// What `--sizing` names.
#[expect(
    clippy::unnecessary_wraps,
    reason = "the signature is the argument parser's"
)]
pub(crate) fn parse_source(text: &str) -> Result<SizeSource, std::convert::Infallible> {
    Ok(if text == "colors" {
        SizeSource::Colors
    } else {
        SizeSource::File(text.into())
    })
}

/// Size of charts on black vertices over that on grey ones, and of these over that on white ones.
const DARKEST: f64 = 0.25;

/// Largest factor by which curvature makes charts smaller.
const CURVATURE_RANGE: f64 = 4.0;

/// By how much charts vary.
pub(super) struct Sizing<'a> {
    pub(super) chart_size: ChartSize,
    /// The angle in degrees by which a chart may bend.
    pub(super) angle: Option<f64>,
    pub(super) source: Option<&'a SizeSource>,
}

impl Sizing<'_> {
    /// The density of lines at each vertex, over that of charts of the size asked for: of the curl
    /// correction, of curvature and of the sizes given, multiplied.
    pub(super) fn density(
        &self,
        field: &FieldResult,
        soup: &PolygonSoup,
        repaired: &Repaired,
        watch: &Watch,
    ) -> Result<Option<PerVertex<f64>>, Failure> {
        let surface = &repaired.surface;
        let mut factors: Vec<PerVertex<f64>> = field.scale.iter().cloned().collect();
        if let Some((angle, curvatures)) = self.angle.zip(field.curvatures.as_ref()) {
            let sizing = CurvatureSizing {
                chart_size: self.chart_size.on(surface)?,
                angle: angle.to_radians(),
                range: CURVATURE_RANGE,
            };
            factors.push(curvature_density(surface, curvatures, &sizing, watch)?);
        }
        if let Some(source) = self.source {
            factors.push(source.on_surface(soup, repaired)?.map(|size| size.recip()));
        }
        Ok(factors.into_iter().reduce(|product, factor| {
            PerVertex::from_fn(product.len(), |vertex| product[vertex] * factor[vertex])
        }))
    }
}

impl SizeSource {
    /// The size at each vertex of the repaired surface, over that asked for.
    pub(crate) fn on_surface(
        &self,
        soup: &PolygonSoup,
        repaired: &Repaired,
    ) -> Result<PerVertex<f64>, Failure> {
        let sizes = self.sizes(soup)?;
        let own = |vertex: VertexId| sizes[repaired.vertex_sources[vertex] as usize];
        Ok(PerVertex::from_fn(
            repaired.surface.mesh().vertex_count(),
            own,
        ))
    }

    /// The size at each vertex of the mesh file, over that asked for.
    fn sizes(&self, soup: &PolygonSoup) -> Result<Vec<f64>, Failure> {
        match self {
            Self::File(path) => sizes_of_file(path, soup.positions.len()),
            Self::Colors => {
                let colors = soup.attributes.vertex_colors.as_ref();
                let colors = colors.ok_or_else(|| {
                    Failure::new(
                        "the vertices have no colours",
                        "name a file of sizes instead",
                    )
                })?;
                let size = |[red, green, blue, _]: &[f32; 4]| {
                    let brightness = f64::from(red + green + blue) / 3.0;
                    libm::pow(DARKEST, 1.0 - 2.0 * brightness.clamp(0.0, 1.0))
                };
                Ok(colors.iter().map(size).collect())
            }
        }
    }
}

/// One number for each vertex of the mesh file, between white space.
fn sizes_of_file(path: &Path, vertices: usize) -> Result<Vec<f64>, Failure> {
    let hint = "give one number above 0 for each vertex of the mesh file";
    let failure = |fact: String| Failure::new(fact, hint).at(path.display());
    let text = fs::read_to_string(path).map_err(|error| failure(error.to_string()))?;
    let number = |(place, word): (usize, &str)| {
        let number: Option<f64> = word.parse().ok();
        let number =
            number.filter(|size| size.is_finite() && size.recip().is_finite() && *size > 0.0);
        number.ok_or_else(|| failure(format!("number {} is {word}", place + 1)))
    };
    let sizes = text.split_whitespace().enumerate().map(number);
    let sizes = sizes.collect::<Result<Vec<f64>, Failure>>()?;
    if sizes.len() == vertices {
        Ok(sizes)
    } else {
        let given = sizes.len();
        Err(failure(format!(
            "{given} numbers were given, but there are {vertices} vertices"
        )))
    }
}
