use glam::DVec3;

use super::curvature::curvatures_on;
use super::report::counts_by_index;
use super::tangent::TangentPlanes;
use super::{
    CancelOptions, Cancellation, CrossField, FieldDomain, FieldError, FieldOptions, FieldReport,
    Guidance, Prescription, PrincipalCurvature, Singularities, SingularityPlan, Stroke, Symmetry,
    feature_edges, smooth_field,
};
use crate::geometry::{Similarity, normalized};
use crate::mesh::{PerVertex, Surface, Topology};
use crate::tolerance::INDEX_ROUNDING;
use crate::watch::Watch;

/// A field on a surface, with everything that was found on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldResult {
    /// The field, as angles in the tangent planes.
    pub field: CrossField,
    /// One of the field's directions at each vertex as a unit vector in space; the others are
    /// this one turned about the normal.
    pub directions: PerVertex<DVec3>,
    /// The unit normal of each vertex.
    pub normals: PerVertex<DVec3>,
    /// Where the field is singular.
    pub singularities: Singularities,
    /// The curvatures that were followed, in one over the unit of the positions.
    pub curvatures: Option<PerVertex<PrincipalCurvature>>,
    /// The factor at each vertex that takes the curl away, if asked for.
    pub scale: Option<PerVertex<f64>>,
    /// The figures.
    pub report: FieldReport,
}

/// A smooth field that follows curvature, boundary, features and guides ([PGP06] §4).
///
/// The surface is brought to unit size inside: the result is the same at every scale. Curvature,
/// features and singularities are those of its own triangles; smoothing and curl correction use
/// the intrinsic Delaunay triangulation, where no weight is negative.
///
/// Any surface has such a field, whatever its genus, its components and its boundary. Without
/// guidance it is the smoothest that is found from seeded phases.
///
/// Cost: near-linear; most of it is one complex factorisation, and one real one for the curl
/// correction.
///
/// # Errors
/// [`FieldError`]: an option out of range, a guide that fits no element or points out of the
/// surface, triangles too degenerate to divide by; or the watch stopped it.
///
/// [PGP06]: crate::papers::PGP06
pub fn cross_field(
    surface: &Surface,
    options: &FieldOptions,
    watch: &Watch,
) -> Result<FieldResult, FieldError> {
    options.check(surface.mesh().vertex_count())?;
    let _stage = watch.stage("field");
    let (unit_surface, similarity) = normalized(surface);
    let domain = FieldDomain::of(&unit_surface, watch)?;
    let ground = Ground {
        domain: &domain,
        options,
        similarity: &similarity,
    };
    let curvatures = ground.curvatures(watch)?;
    let (guidance, feature_edges) = ground.guidance(curvatures.as_ref())?;
    let (delaunay, positions) = (domain.delaunay(), unit_surface.positions());
    let smooth = smooth_field(delaunay, positions, &guidance, &options.smoothing, watch)?;
    let smoothing = smooth.report;
    let (field, cancellation) = ground.planned(smooth.field, &guidance, watch)?;
    let singularities = domain.singularities(&field);
    let curl = options.curl_correction.as_ref();
    let curl = curl
        .map(|wanted| domain.curl_correction(&field, wanted, watch))
        .transpose()?;
    let (scale, curl) = curl.map_or((None, None), |curl| (Some(curl.scale), Some(curl.report)));
    let [mean_deviation, mean_confidence] = ground.deviation(&field, curvatures.as_ref());
    let report = FieldReport {
        symmetry: options.symmetry,
        fixed_vertices: guidance.fixed_count(),
        feature_edges,
        singularities: singularities.count(),
        singularities_by_index: counts_by_index(&singularities),
        index_sum: singularities.index_sum(),
        euler_characteristic: ground.checked_index_sum(&singularities)?,
        mean_deviation,
        mean_confidence,
        smoothing,
        cancellation,
        curl,
    };
    Ok(FieldResult {
        directions: field.directions_through(&TangentPlanes::on(&domain)),
        normals: domain.frames().map(|frame| frame.normal),
        curvatures: curvatures.map(|curvatures| at_own_scale(&curvatures, &similarity)),
        field,
        singularities,
        scale,
        report,
    })
}

/// The curvatures of the surface before it was brought to unit size.
fn at_own_scale(
    curvatures: &PerVertex<PrincipalCurvature>,
    similarity: &Similarity,
) -> PerVertex<PrincipalCurvature> {
    let exponent = similarity.exponent();
    curvatures.map(|&curvature| PrincipalCurvature {
        max: libm::ldexp(curvature.max, exponent),
        min: libm::ldexp(curvature.min, exponent),
        ..curvature
    })
}

/// The steps, with what the options say of each.
struct Ground<'a> {
    domain: &'a FieldDomain<'a>,
    options: &'a FieldOptions,
    /// From the caller's coordinates to those of the domain.
    similarity: &'a Similarity,
}

impl Ground<'_> {
    fn curvatures(
        &self,
        watch: &Watch,
    ) -> Result<Option<PerVertex<PrincipalCurvature>>, FieldError> {
        let wanted = self.options.curvature;
        let wanted = wanted.filter(|_| self.options.symmetry != Symmetry::Vector);
        let found = wanted.map(|wanted| {
            let planes = TangentPlanes::on(self.domain);
            curvatures_on(planes, self.domain.edge_graph(), wanted, watch)
        });
        Ok(found.transpose()?)
    }

    /// Everything that the field should follow, and the number of feature edges.
    fn guidance(
        &self,
        curvatures: Option<&PerVertex<PrincipalCurvature>>,
    ) -> Result<(Guidance, usize), FieldError> {
        let (surface, triangulation) = (self.domain.surface(), self.domain.triangulation());
        let options = self.options;
        let mut guidance = match curvatures {
            Some(curvatures) => {
                let mut guidance = Guidance::from_curvature(options.symmetry, curvatures);
                guidance.lighten(options.curvature.map_or(1.0, |wanted| wanted.share));
                guidance
            }
            None => Guidance::none(options.symmetry, surface.mesh().vertex_count()),
        };
        if let Some(sizes) = &options.sizes {
            guidance.follow_sizes(sizes);
        }
        if let Some(strength) = options.boundary {
            guidance.follow_boundary(surface.mesh(), triangulation, strength);
        }
        let features = self.features()?;
        let count = features.len();
        guidance.follow_edges(triangulation, features, options.features.strength);
        guidance.follow_guides(surface, triangulation, &options.guides)?;
        guidance.follow_strokes(self.domain, &self.strokes())?;
        Ok((guidance, count))
    }

    /// The strokes in the coordinates of the domain.
    fn strokes(&self) -> Vec<Stroke> {
        let strokes = self.options.strokes.iter();
        let moved = strokes.map(|stroke| Stroke {
            points: (stroke.points.iter())
                .map(|&point| self.similarity.apply(point))
                .collect(),
            strength: stroke.strength,
        });
        moved.collect()
    }

    fn features(&self) -> Result<Vec<crate::mesh::EdgeId>, FieldError> {
        if self.options.symmetry == Symmetry::Vector {
            return Ok(Vec::new());
        }
        let (surface, wanted) = (self.domain.surface(), &self.options.features);
        let count = surface.mesh().edge_count();
        if let Some((guide, edge)) =
            (wanted.edges.iter().enumerate()).find(|(_, edge)| edge.0 as usize >= count)
        {
            let (kind, number) = ("edge", edge.0);
            return Err(FieldError::NoSuchElement {
                guide,
                kind,
                number,
                count,
            });
        }
        let mut edges = wanted.edges.clone();
        if let Some(dihedral) = wanted.dihedral {
            edges.extend(feature_edges(surface, dihedral, wanted.least_edges));
        }
        edges.sort_unstable();
        edges.dedup();
        Ok(edges)
    }

    /// The field with the singularities that the options ask for.
    fn planned(
        &self,
        field: CrossField,
        guidance: &Guidance,
        watch: &Watch,
    ) -> Result<(CrossField, Option<Cancellation>), FieldError> {
        let prescribed = |field: &CrossField, singularities| {
            let smoothing = self.options.smoothing.smoothing;
            let wanted = Prescription {
                singularities,
                smoothing,
            };
            self.domain
                .with_singularities(field, guidance, &wanted, watch)
        };
        match &self.options.singularities {
            SingularityPlan::Found => self.cancelled(field, guidance, watch),
            SingularityPlan::Given(wanted) => Ok((prescribed(&field, wanted.clone())?, None)),
            SingularityPlan::Moved(moves) => {
                let (field, report) = self.cancelled(field, guidance, watch)?;
                let found = self.domain.singularities(&field);
                let wanted = self.domain.moved_singularities(&found.faces, moves)?;
                Ok((prescribed(&field, wanted)?, report))
            }
        }
    }

    fn cancelled(
        &self,
        field: CrossField,
        guidance: &Guidance,
        watch: &Watch,
    ) -> Result<(CrossField, Option<Cancellation>), FieldError> {
        let in_edges = self.options.cancel_distance * self.domain.mean_edge_length();
        let distance = in_edges.max(libm::ldexp(
            self.options.cancel_length,
            self.similarity.exponent(),
        ));
        if distance == 0.0 {
            return Ok((field, None));
        }
        let cancel = CancelOptions {
            distance,
            smoothing: self.options.smoothing.smoothing,
        };
        // Where triangles are too degenerate for indices to be counted, pairs would be without end.
        self.checked_index_sum(&self.domain.singularities(&field))?;
        let found = self
            .domain
            .cancel_close_pairs(&field, guidance, &cancel, watch)?;
        Ok((found.0, Some(found.1)))
    }

    fn checked_index_sum(&self, singularities: &Singularities) -> Result<i64, FieldError> {
        let sum = singularities.index_sum();
        let topology = Topology::of(self.domain.surface().mesh());
        let euler_characteristic = topology.total.euler_characteristic;
        if (sum - euler_characteristic as f64).abs() < INDEX_ROUNDING {
            Ok(euler_characteristic)
        } else {
            Err(FieldError::IndexSum {
                sum,
                euler_characteristic,
            })
        }
    }

    /// Mean deviation from the directions of curvature in degrees, and mean confidence in them.
    fn deviation(
        &self,
        field: &CrossField,
        curvatures: Option<&PerVertex<PrincipalCurvature>>,
    ) -> [Option<f64>; 2] {
        let Some(curvatures) = curvatures else {
            return [None; 2];
        };
        let [mut deviations, mut weights, mut total] = [0.0; 3];
        for (vertex, &area) in self.domain.areas().enumerate() {
            let curvature = curvatures[vertex];
            let weight = area * curvature.confidence;
            let off = field
                .symmetry()
                .reduce(field.angle(vertex) - curvature.direction)
                .0;
            deviations += weight * off.abs().to_degrees();
            weights += weight;
            total += area;
        }
        let deviation = (weights > 0.0).then(|| deviations / weights);
        [deviation, (total > 0.0).then(|| weights / total)]
    }
}
