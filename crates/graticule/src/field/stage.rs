use glam::DVec3;

use super::report::counts_by_index;
use super::{
    CancelOptions, Cancellation, CrossField, FieldError, FieldOptions, FieldReport, Guidance,
    PrincipalCurvature, Singularities, SmoothField, Symmetry, Triangulations, cancel_close_pairs,
    curl_correction, feature_edges, principal_curvatures, smooth_field,
};
use crate::geometry::{
    EdgeLengths, IntrinsicTriangulation, Similarity, intrinsic_delaunay, normalized, vertex_areas,
    vertex_frames,
};
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
    options.check()?;
    let _stage = watch.stage("field");
    let (unit_surface, similarity) = normalized(surface);
    let ground = Ground::of(&unit_surface, watch)?;
    let curvatures = ground.curvatures(options, watch)?;
    let (guidance, feature_edges) = ground.guidance(options, curvatures.as_ref())?;
    let smooth = smooth_field(
        &ground.delaunay,
        ground.surface.positions(),
        &guidance,
        &options.smoothing,
        watch,
    )?;
    let SmoothField { field, report } = smooth;
    let (field, cancellation) = ground.cancelled(field, &guidance, options, watch)?;
    let singularities = ground.singularities(&field);
    let euler_characteristic = ground.checked_index_sum(&singularities)?;
    let curl = ground.curl(&field, options, watch)?;
    let [mean_deviation, mean_confidence] = ground.deviation(&field, curvatures.as_ref());
    let (scale, curl) = curl.map_or((None, None), |curl| (Some(curl.scale), Some(curl.report)));
    Ok(FieldResult {
        report: FieldReport {
            symmetry: options.symmetry,
            fixed_vertices: guidance.fixed_count(),
            feature_edges,
            singularities: singularities.count(),
            singularities_by_index: counts_by_index(&singularities),
            index_sum: singularities.index_sum(),
            euler_characteristic,
            mean_deviation,
            mean_confidence,
            smoothing: report,
            cancellation,
            curl,
        },
        directions: field.directions_in_space(ground.surface, &ground.original),
        normals: vertex_frames(ground.surface).map(|frame| frame.normal),
        field,
        singularities,
        curvatures: curvatures.map(|curvatures| at_own_scale(&curvatures, &similarity)),
        scale,
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

/// What every step stands on.
struct Ground<'a> {
    surface: &'a Surface,
    original: IntrinsicTriangulation,
    delaunay: IntrinsicTriangulation,
}

impl<'a> Ground<'a> {
    fn of(surface: &'a Surface, watch: &Watch) -> Result<Self, FieldError> {
        let _stage = watch.stage("triangulation");
        let (delaunay, _) = intrinsic_delaunay(surface, watch)?;
        Ok(Self {
            surface,
            original: IntrinsicTriangulation::of(surface)?,
            delaunay,
        })
    }

    fn curvatures(
        &self,
        options: &FieldOptions,
        watch: &Watch,
    ) -> Result<Option<PerVertex<PrincipalCurvature>>, FieldError> {
        let wanted = options
            .curvature
            .filter(|_| options.symmetry != Symmetry::Vector);
        let found =
            wanted.map(|wanted| principal_curvatures(self.surface, &self.original, &wanted, watch));
        Ok(found.transpose()?)
    }

    /// Everything that the field should follow, and the number of feature edges.
    fn guidance(
        &self,
        options: &FieldOptions,
        curvatures: Option<&PerVertex<PrincipalCurvature>>,
    ) -> Result<(Guidance, usize), FieldError> {
        let mesh = self.surface.mesh();
        let mut guidance = match curvatures {
            Some(curvatures) => Guidance::from_curvature(options.symmetry, curvatures),
            None => Guidance::none(options.symmetry, mesh.vertex_count()),
        };
        if let Some(strength) = options.boundary {
            guidance.follow_boundary(mesh, &self.original, strength);
        }
        let features = self.features(options)?;
        let count = features.len();
        guidance.follow_edges(&self.original, features, options.features.strength);
        guidance.follow_guides(self.surface, &self.original, &options.guides)?;
        Ok((guidance, count))
    }

    fn features(&self, options: &FieldOptions) -> Result<Vec<crate::mesh::EdgeId>, FieldError> {
        if options.symmetry == Symmetry::Vector {
            return Ok(Vec::new());
        }
        let wanted = &options.features;
        let count = self.surface.mesh().edge_count();
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
            edges.extend(feature_edges(self.surface, dihedral, wanted.least_edges));
        }
        edges.sort_unstable();
        edges.dedup();
        Ok(edges)
    }

    fn cancelled(
        &self,
        field: CrossField,
        guidance: &Guidance,
        options: &FieldOptions,
        watch: &Watch,
    ) -> Result<(CrossField, Option<Cancellation>), FieldError> {
        if options.cancel_distance == 0.0 {
            return Ok((field, None));
        }
        let triangulations = Triangulations {
            original: &self.original,
            delaunay: &self.delaunay,
        };
        let cancel = CancelOptions {
            distance: options.cancel_distance * EdgeLengths::of(self.surface).mean(),
            smoothing: options.smoothing,
        };
        let (field, report) = cancel_close_pairs(
            self.surface,
            &triangulations,
            guidance,
            field,
            &cancel,
            watch,
        )?;
        Ok((field, Some(report)))
    }

    fn singularities(&self, field: &CrossField) -> Singularities {
        Singularities::of(field, self.surface.mesh(), &self.original)
    }

    fn checked_index_sum(&self, singularities: &Singularities) -> Result<i64, FieldError> {
        let sum = singularities.index_sum();
        let euler_characteristic = Topology::of(self.surface.mesh()).total.euler_characteristic;
        if (sum - euler_characteristic as f64).abs() < INDEX_ROUNDING {
            Ok(euler_characteristic)
        } else {
            Err(FieldError::IndexSum {
                sum,
                euler_characteristic,
            })
        }
    }

    fn curl(
        &self,
        field: &CrossField,
        options: &FieldOptions,
        watch: &Watch,
    ) -> Result<Option<super::CurlCorrection>, FieldError> {
        let Some(wanted) = &options.curl_correction else {
            return Ok(None);
        };
        let positions = self.surface.positions();
        let mesh = self.surface.mesh();
        curl_correction(mesh, &self.delaunay, positions, field, wanted, watch).map(Some)
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
        for (vertex, &area) in vertex_areas(&self.original).enumerate() {
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
