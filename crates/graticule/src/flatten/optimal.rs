//! Near-optimal maps: the best combination of the conformal and the authalic map ([DMA02] §5.1).
//!
//! [DMA02]: crate::papers::DMA02

use std::ops::RangeInclusive;

use glam::DVec2;

use crate::mesh::PerVertex;
use crate::tolerance::{ONE_MAP, ROUNDING, SEARCHED_LAMBDA};
use crate::watch::Watch;

use super::fixed::Extended;
use super::functional::Measured;
use super::polynomial::Quartic;
use super::{
    BoundaryPositions, FixedOptions, FixedSystem, FlatMap, FlattenError, Functional, Holes, Method,
    Mix, Patch, Weights,
};

/// Steps at whose ends a functional that is no polynomial is computed before the best are refined.
const SCAN_POINTS: i32 = 96;
/// The λ at which they begin and end: some way beyond both base maps.
const SCAN_RANGE: [f64; 2] = [-1.0, 2.0];
const SCAN_STEP: f64 = (SCAN_RANGE[1] - SCAN_RANGE[0]) / SCAN_POINTS as f64;
/// How often as many steps are added where the functional still falls at an end.
const MOST_EXTENSIONS: i32 = 4;
/// Places of the scan around which the search goes on.
const REFINED_MINIMA: usize = 3;

/// How a near-optimal map is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NearOptimalOptions {
    /// What is made least.
    pub functional: Functional,
    /// What becomes of holes that were given no places.
    pub holes: Holes,
}

/// A λ with the value of the functional there.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LambdaValue {
    /// The share of the conformal map; that of the authalic map is 1 − λ.
    pub lambda: f64,
    /// The functional of this combination.
    pub value: f64,
}

/// A near-optimal map and how it was found.
#[derive(Clone, Debug)]
pub struct NearOptimalMap {
    /// The map.
    pub map: FlatMap,
    /// The λ chosen, and the functional there.
    pub best: LambdaValue,
    /// All that were compared, by λ: the real critical points of the quartic, or the local minima
    /// that the search found.
    pub candidates: Vec<LambdaValue>,
    /// The functional along λ, over the searched range, for pictures; infinite values left out.
    pub curve: Vec<LambdaValue>,
    /// The conformal and the authalic map, in the surface's unit of length: every λ combines them.
    pub bases: [PerVertex<DVec2>; 2],
    /// What both base maps were scaled by before they were measured: areas agree in total then.
    pub scale: f64,
}

/// The combination λ U^A + (1 − λ) U^χ of the conformal and the authalic map with the same boundary
/// that makes a functional least ([DMA02] Eq. 8).
///
/// Edge lengths and areas are quartic in λ: the real roots of the derivative come in closed form,
/// and all are compared. Other functionals are searched for along λ, on the same two maps. Areas in
/// total are made to agree before the maps are compared; the map itself keeps its boundary.
///
/// Flips are not excluded; the result counts them.
///
/// Cost: one symmetric and one LU factorisation of the mesh's size; the search is linear per λ.
///
/// # Errors
/// [`FlattenError`], as of [`fixed_map`](super::fixed_map);
/// [`FlattenError::NoFiniteValue`] where a functional is infinite on all maps searched.
///
/// [DMA02]: crate::papers::DMA02
pub fn near_optimal_map(
    patch: &Patch,
    boundary: &BoundaryPositions,
    options: NearOptimalOptions,
    watch: &Watch,
) -> Result<NearOptimalMap, FlattenError> {
    let _stage = watch.stage("near-optimal map");
    let base = |weights| base(patch, boundary, weights, options.holes, watch);
    let (system, conformal) = base(Weights::Cotangent)?;
    let (_, authalic) = base(Weights::Intrinsic(Mix::AUTHALIC))?;
    let line = Line {
        conformal: &conformal.positions,
        authalic: &authalic.positions,
    };
    let scale = scale_to_patch(patch, line.conformal)?;
    let measured = Measured::new(patch, options.functional).scaled(scale);
    let stage = watch.stage("search λ");
    let value = |lambda| measured.value(&line.at(lambda));
    let mut curve = scan(&value, watch)?;
    let mut candidates = match options.functional {
        _ if line.is_one_map() => vec![at_lambda(&value, 1.0)],
        Functional::EdgeLength => critical(&edge_length_quartic(&measured, line, scale)),
        Functional::Area => critical(&area_quartic(&measured, line, scale)),
        _ => refined(&value, &curve, watch)?,
    };
    drop(stage);
    curve.retain(|point| point.value.is_finite());
    candidates.retain(|candidate| candidate.value.is_finite());
    let best = least(&candidates).ok_or(FlattenError::NoFiniteValue {
        functional: options.functional,
    })?;
    let combined = Extended {
        positions: line.at(best.lambda),
        residual: conformal.residual.max(authalic.residual),
    };
    let mut map = system.finished(&combined, false, watch)?;
    map.method = Method::NearOptimal;
    Ok(NearOptimalMap {
        map,
        best,
        candidates,
        curve,
        bases: [line.conformal, line.authalic].map(|positions| in_own_unit(patch, positions)),
        scale,
    })
}

/// A map with fixed boundary and the system it comes from.
fn base(
    patch: &Patch,
    boundary: &BoundaryPositions,
    weights: Weights,
    holes: Holes,
    watch: &Watch,
) -> Result<(FixedSystem, Extended), FlattenError> {
    let options = FixedOptions { weights, holes };
    let system = FixedSystem::new(patch, boundary, &options, watch)?;
    let extended = system.extended(&system.unit_places(boundary)?)?;
    Ok((system, extended))
}

/// Positions of the patch's vertices in its own unit of length.
pub(super) fn in_own_unit(patch: &Patch, positions: &[DVec2]) -> PerVertex<DVec2> {
    let own = &positions[..patch.mesh().vertex_count()];
    PerVertex::new(own.iter().map(|p| *p * patch.unit_length()).collect())
}

/// The two base maps.
#[derive(Clone, Copy)]
struct Line<'a> {
    conformal: &'a [DVec2],
    authalic: &'a [DVec2],
}

impl Line<'_> {
    fn at(self, lambda: f64) -> Vec<DVec2> {
        let pairs = self.conformal.iter().zip(self.authalic);
        let point = |(a, x): (&DVec2, &DVec2)| *a * lambda + *x * (1.0 - lambda);
        pairs.map(point).collect()
    }

    /// Whether both maps are one, up to what their solves leave: then λ decides nothing.
    fn is_one_map(self) -> bool {
        let pairs = self.conformal.iter().zip(self.authalic);
        let apart = pairs.map(|(a, x)| a.distance(*x)).fold(0.0, f64::max);
        let extent = self
            .conformal
            .iter()
            .map(|p| p.length())
            .fold(0.0, f64::max);
        apart <= ONE_MAP * extent
    }

    /// The authalic position and the way from it to the conformal one.
    fn ray(self, vertex: usize) -> [DVec2; 2] {
        let from = self.authalic[vertex];
        [from, self.conformal[vertex] - from]
    }
}

/// The factor that gives a map the area of the patch.
fn scale_to_patch(patch: &Patch, positions: &[DVec2]) -> Result<f64, FlattenError> {
    let mesh = patch.mesh();
    let doubled = mesh.faces().map(|face| {
        let [a, b, c] = mesh.triangle(face).map(|v| positions[v.0 as usize]);
        (b - a).perp_dot(c - a)
    });
    let area = 0.5 * doubled.sum::<f64>() / patch.unit_area();
    if area.is_nan() || area <= ROUNDING {
        return Err(FlattenError::Collapsed { area });
    }
    Ok(area.recip().sqrt())
}

/// [DMA02] §5.1: `Σ (|u_i − u_j|² / |x_i − x_j|² − 1)²` as a polynomial in λ, over the number of
/// edges.
///
/// [DMA02]: crate::papers::DMA02
fn edge_length_quartic(measured: &Measured<'_>, line: Line<'_>, scale: f64) -> Quartic {
    let mut quartic = Quartic::default();
    let weight = 1.0 / measured.edges().len().max(1) as f64;
    for &([i, j], inverse) in measured.edges() {
        let ([from, along], [other, other_along]) = (line.ray(i), line.ray(j));
        let (from, along) = ((from - other) * scale, (along - other_along) * scale);
        let square = [
            from.length_squared() * inverse - 1.0,
            2.0 * from.dot(along) * inverse,
            along.length_squared() * inverse,
        ];
        quartic.add_square(square, weight);
    }
    quartic
}

/// [DMA02] §5.1, areas, without the stray square: `Σ (A_param / A_3D − 1)²`, over the number of
/// triangles.
///
/// [DMA02]: crate::papers::DMA02
fn area_quartic(measured: &Measured<'_>, line: Line<'_>, scale: f64) -> Quartic {
    let mut quartic = Quartic::default();
    let weight = 1.0 / measured.triangles().count().max(1) as f64;
    for ([a, b, c], source) in measured.triangles() {
        let side = |end: usize| {
            let ([from, along], [end, end_along]) = (line.ray(a), line.ray(end));
            [(end - from) * scale, (end_along - along) * scale]
        };
        let ([p, p_along], [q, q_along]) = (side(b), side(c));
        let ratio = 0.5 / source.area();
        let square = [
            p.perp_dot(q) * ratio - 1.0,
            (p.perp_dot(q_along) + p_along.perp_dot(q)) * ratio,
            p_along.perp_dot(q_along) * ratio,
        ];
        quartic.add_square(square, weight);
    }
    quartic
}

/// The critical points with their values; where there is none, both maps are one.
fn critical(quartic: &Quartic) -> Vec<LambdaValue> {
    let mut points = quartic.critical_points();
    if points.is_empty() {
        points.push(1.0);
    }
    let value = |lambda| quartic.value(lambda);
    points
        .into_iter()
        .map(|point| at_lambda(&value, point))
        .collect()
}

fn at_lambda(value: &dyn Fn(f64) -> f64, lambda: f64) -> LambdaValue {
    LambdaValue {
        lambda,
        value: value(lambda),
    }
}

fn least(candidates: &[LambdaValue]) -> Option<LambdaValue> {
    let by_value = |a: &&LambdaValue, b: &&LambdaValue| a.value.total_cmp(&b.value);
    candidates.iter().min_by(by_value).copied()
}

/// The functional at evenly spaced places, further on where it still falls at an end.
fn scan(value: &dyn Fn(f64) -> f64, watch: &Watch) -> Result<Vec<LambdaValue>, FlattenError> {
    let mut values = scan_between(value, 0..=SCAN_POINTS, watch)?;
    for extension in 1..=MOST_EXTENSIONS {
        let lowest = least(&values).filter(|best| best.value.is_finite());
        let Some(best) = lowest else { break };
        let points = SCAN_POINTS * extension;
        if best.lambda >= values[values.len() - 1].lambda {
            values.extend(scan_between(
                value,
                points + 1..=points + SCAN_POINTS,
                watch,
            )?);
        } else if best.lambda <= values[0].lambda {
            let (from, to) = (-points, -points + SCAN_POINTS - 1);
            let before = scan_between(value, from..=to, watch)?;
            values.splice(0..0, before);
        } else {
            break;
        }
    }
    Ok(values)
}

/// The functional at places of the scan by their numbers; 0 lies at the lower end of
/// [`SCAN_RANGE`].
fn scan_between(
    value: &dyn Fn(f64) -> f64,
    numbers: RangeInclusive<i32>,
    watch: &Watch,
) -> Result<Vec<LambdaValue>, FlattenError> {
    let at = |number: i32| {
        watch.check()?;
        Ok(at_lambda(
            value,
            SCAN_RANGE[0] + SCAN_STEP * f64::from(number),
        ))
    };
    numbers.map(at).collect()
}

/// The lowest local minima of a scan, refined by golden sections.
fn refined(
    value: &dyn Fn(f64) -> f64,
    values: &[LambdaValue],
    watch: &Watch,
) -> Result<Vec<LambdaValue>, FlattenError> {
    let lowest = |k: usize| {
        let beside = [k.checked_sub(1), (k + 1 < values.len()).then_some(k + 1)];
        let mut beside = beside.into_iter().flatten();
        values[k].value.is_finite() && beside.all(|other| values[k].value <= values[other].value)
    };
    let mut minima: Vec<usize> = (0..values.len()).filter(|&k| lowest(k)).collect();
    minima.sort_by(|&a, &b| values[a].value.total_cmp(&values[b].value));
    minima.truncate(REFINED_MINIMA);
    let step = SCAN_STEP;
    let mut refined = Vec::with_capacity(minima.len());
    for k in minima {
        let middle = values[k];
        let found = golden_section(value, [middle.lambda - step, middle.lambda + step], watch)?;
        refined.push(if found.value < middle.value {
            found
        } else {
            middle
        });
    }
    refined.sort_by(|a, b| a.lambda.total_cmp(&b.lambda));
    Ok(refined)
}

/// The minimum within an interval (J. Kiefer, *Sequential minimax search for a maximum*, 1953).
fn golden_section(
    value: &dyn Fn(f64) -> f64,
    [mut low, mut high]: [f64; 2],
    watch: &Watch,
) -> Result<LambdaValue, FlattenError> {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let at = |lambda: f64| at_lambda(value, lambda);
    let mut left = at(high - ratio * (high - low));
    let mut right = at(low + ratio * (high - low));
    while high - low > SEARCHED_LAMBDA {
        watch.check()?;
        if left.value <= right.value {
            (high, right) = (right.lambda, left);
            left = at(high - ratio * (high - low));
        } else {
            (low, left) = (left.lambda, right);
            right = at(low + ratio * (high - low));
        }
    }
    Ok(if left.value <= right.value {
        left
    } else {
        right
    })
}
