//! Every chart of a layout on a square: [PGP06] §3.3 and §3.4.
//!
//! [PGP06]: crate::papers::PGP06

use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

use super::chart_map_assembly::Assembly;
use super::chart_map_polygon::ChartMethod;
use super::chart_map_squares::Layouted;
use super::split::plan_charts;
use super::split_arcs::{finish_arcs, parameterize_arcs};
use super::{ArcId, ChartId, ChartLayout, ChartMapError, SquareId};
use crate::flatten::FlattenError;
use crate::mesh::{Element, FaceId, PerCorner, PerFace, RefinedSurface, Surface, VertexId};
use crate::watch::Watch;

/// How charts are laid onto squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChartMapOptions {
    /// Keep the lengths of the net along all arcs, so that one pattern repeated over all squares
    /// shows no seam: charts of other outlines than a rectangle are split at each whole length.
    pub keep_net: bool,
    /// Steps, at most, by which each square without the net's coordinates goes from mean value
    /// coordinates down to less distortion, its border staying; 0 for mean value coordinates.
    pub improvement_steps: u32,
    /// Rounds of relaxation across the borders of charts that do not have the net's coordinates
    /// (Khodakovsky et al. 2003).
    pub relaxation_rounds: u32,
}

impl Default for ChartMapOptions {
    fn default() -> Self {
        Self {
            keep_net: false,
            improvement_steps: 100,
            relaxation_rounds: 0,
        }
    }
}

/// A chart of the layout, or a part of one, on a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartSquare {
    /// The chart.
    pub chart: ChartId,
    /// How its coordinates were found.
    pub method: ChartMethod,
    /// Width and height in spacings of the net: whole numbers for most charts, a half for the parts
    /// of a split one.
    pub size: DVec2,
    /// Its triangles, by number.
    pub faces: Range<u32>,
    /// Whether it has the lengths of the net along all sides.
    pub keeps_net: bool,
}

/// A line along which two squares meet, or one ends at the boundary: from corner to corner of one or
/// the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// The vertices along it.
    pub vertices: Vec<VertexId>,
    /// What it is to the squares on its left and its right.
    pub sides: [Option<SeamSide>; 2],
}

/// A seam as part of a square's side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamSide {
    /// The square.
    pub square: SquareId,
    /// The side: bottom, right, top, left.
    pub side: u8,
    /// How far along the side, counter-clockwise, the seam's first and last vertex lie, in
    /// `0.0..=1.0`.
    pub shares: [f64; 2],
}

/// Names a seam while squares are made one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SeamKey {
    /// From this corner of squares on the arc to the next.
    Arc(ArcId, u32),
    /// From the centre of a chart to the middle of a side.
    Spoke(ChartId, u32),
}

/// All charts of a layout on unit squares.
///
/// The triangles are those of the layout, split where squares needed corners or a chart was divided;
/// each knows the input's triangle that it is part of. Held by construction: no triangle is flipped,
/// and along each seam the coordinates of both sides agree up to one affine map.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartMaps {
    pub(super) refined: RefinedSurface,
    pub(super) square_of: PerFace<SquareId>,
    pub(super) coordinates: PerCorner<DVec2>,
    pub(super) squares: Vec<ChartSquare>,
    pub(super) seams: Vec<Seam>,
}

/// How many charts were laid down in which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ChartMapCounts {
    /// Charts of the layout.
    pub charts: usize,
    /// Squares.
    pub squares: usize,
    /// Charts that were split.
    pub split_charts: usize,
    /// Squares with the net's coordinates.
    pub net: usize,
    /// Squares with mean value coordinates.
    pub mean_value: usize,
    /// Squares with each vertex in the middle of its neighbours.
    pub uniform: usize,
    /// Squares laid down from coarse to fine.
    pub coarse_to_fine: usize,
    /// Squares whose sides have the lengths of the net.
    pub keep_net: usize,
}

/// Lays each chart of a layout of `input` onto a square.
///
/// Charts that the net makes rectangles of keep its coordinates, unless these squeeze them
/// ([`SQUEEZED_CHART`](crate::tolerance::SQUEEZED_CHART)); those and others with four sides get mean
/// value coordinates, from which the symmetric Dirichlet energy is lowered, with places on the border
/// that both sides of an arc share: the net's where one side has some and they do not squeeze the arc
/// ([`SQUEEZED_ARC`](crate::tolerance::SQUEEZED_ARC)), else by length. Charts with another number of sides are split first, from the centre
/// to the middles of the sides ([PGP06] §3.4): along lines that are straight on a regular polygon,
/// so that they stay inside and meet nowhere else. A T-junction is a place on a side of the one square and
/// a corner of the others.
///
/// Where a chart finds no room to double precision, as steps along its border differ by many orders of
/// magnitude, vertices there are spread evenly, with the warning `chart-borders-evened`. A chart that
/// double precision does not suffice to split goes onto one square whole (`charts-not-split`). Another
/// warning (`chart-map-fallback`) tells of charts that rounding made another method necessary for;
/// with [`keep_net`](ChartMapOptions::keep_net), one more (`net-not-kept`) of charts whose seams will
/// show.
///
/// Cost: near-linear; charts are laid down in parallel.
///
/// # Errors
/// [`ChartMapError`].
///
/// [PGP06]: crate::papers::PGP06
pub fn chart_maps(
    input: &Surface,
    layout: &ChartLayout,
    options: &ChartMapOptions,
    watch: &Watch,
) -> Result<ChartMaps, ChartMapError> {
    let _stage = watch.stage("chart maps");
    let mut is_even = vec![false; layout.arcs().len()];
    let assembly = loop {
        match lay_down(input, layout, options, &is_even, watch)? {
            Ok(assembly) => break assembly,
            Err(failures) => even_out(layout, &mut is_even, failures, watch)?,
        }
    };
    assembly.warn(watch);
    let mut maps = assembly.finish(layout)?;
    maps.relax(options.relaxation_rounds, watch)?;
    maps.warn(*options, watch);
    Ok(maps)
}

/// The squares of all charts, or the charts that there is no room for on their squares, each with what
/// is in the way.
pub(super) fn lay_down(
    input: &Surface,
    layout: &ChartLayout,
    options: &ChartMapOptions,
    is_even: &[bool],
    watch: &Watch,
) -> Result<Result<Assembly, Vec<(ChartId, FlattenError)>>, ChartMapError> {
    let mut arcs = parameterize_arcs(layout, is_even);
    let plans = plan_charts(layout, &mut arcs, options.keep_net);
    let shared = finish_arcs(&mut arcs, layout);
    let layouted = Layouted::new(input, layout, &arcs, options.improvement_steps);
    let squares = plans.par_iter().enumerate().map(|(index, plan)| {
        watch.check()?;
        match layouted.squares(ChartId::from_index(index), plan, watch) {
            Err(ChartMapError::Chart { chart, reason }) => Ok(Err((chart, reason))),
            outcome => outcome.map(Ok),
        }
    });
    let mut assembly = Assembly::new(shared as usize);
    let mut failures = Vec::new();
    let squares: Vec<_> = squares.collect::<Result<_, ChartMapError>>()?;
    for (index, (squares, plan)) in squares.into_iter().zip(&plans).enumerate() {
        match squares {
            Ok(squares) => assembly.add(ChartId::from_index(index), squares, plan),
            Err(failure) => failures.push(failure),
        }
    }
    Ok(if failures.is_empty() {
        Ok(assembly)
    } else {
        Err(failures)
    })
}

/// Spreads the vertices on the arcs of charts evenly; the first failure, where they were so already.
fn even_out(
    layout: &ChartLayout,
    is_even: &mut [bool],
    failures: Vec<(ChartId, FlattenError)>,
    watch: &Watch,
) -> Result<(), ChartMapError> {
    let count = failures.len();
    for (chart, reason) in failures {
        let mut arcs = layout.chart(chart).sides.iter().flatten();
        if arcs.clone().all(|(arc, _)| is_even[arc.index()]) {
            return Err(ChartMapError::Chart { chart, reason });
        }
        arcs.by_ref()
            .for_each(|(arc, _)| is_even[arc.index()] = true);
    }
    let message = format!(
        "{count} charts had no room on squares, to double precision: vertices along their borders are \
         spread evenly instead of by length"
    );
    watch.warn("chart-borders-evened", message);
    Ok(())
}

impl ChartMaps {
    /// The layout's surface, refined further.
    #[must_use]
    pub fn refined(&self) -> &RefinedSurface {
        &self.refined
    }

    /// The surface of [`refined`](Self::refined).
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.refined.surface
    }

    /// The square of each triangle.
    #[must_use]
    pub fn square_of(&self) -> &PerFace<SquareId> {
        &self.square_of
    }

    /// The place of each corner in its triangle's unit square.
    #[must_use]
    pub fn coordinates(&self) -> &PerCorner<DVec2> {
        &self.coordinates
    }

    /// The squares.
    #[must_use]
    pub fn squares(&self) -> &[ChartSquare] {
        &self.squares
    }

    /// The lines between the squares.
    #[must_use]
    pub fn seams(&self) -> &[Seam] {
        &self.seams
    }

    /// The triangles of a square.
    pub fn faces_of(&self, square: SquareId) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        self.squares[square.index()].faces.clone().map(FaceId)
    }

    /// How the squares were made.
    #[must_use]
    pub fn counts(&self) -> ChartMapCounts {
        let with = |method| self.squares.iter().filter(|s| s.method == method).count();
        let charts = self.squares.chunk_by(|a, b| a.chart == b.chart);
        ChartMapCounts {
            charts: charts.clone().count(),
            squares: self.squares.len(),
            split_charts: charts.filter(|squares| squares.len() > 1).count(),
            net: with(ChartMethod::Net),
            mean_value: with(ChartMethod::MeanValue),
            uniform: with(ChartMethod::Uniform),
            coarse_to_fine: with(ChartMethod::CoarseToFine),
            keep_net: self
                .squares
                .iter()
                .filter(|square| square.keeps_net)
                .count(),
        }
    }

    /// By how much the coordinates on both sides of a seam disagree at most, in lengths of the seam.
    #[must_use]
    pub fn largest_gap(&self) -> f64 {
        let shares = |seam: &Seam, side: usize| -> Option<Vec<f64>> {
            let side = seam.sides[side].as_ref()?;
            Some(self.shares_along(seam, side))
        };
        let gap = |seam: &Seam| match [0, 1].map(|side| shares(seam, side)) {
            [Some(left), Some(right)] => {
                let gaps = left.iter().zip(&right).map(|(a, b)| (a - b).abs());
                gaps.fold(0.0, f64::max)
            }
            _ => 0.0,
        };
        self.seams.iter().map(gap).fold(0.0, f64::max)
    }

    /// How far along a seam its vertices lie, by the coordinates of one side, and how far beside the
    /// side of the square where that is more.
    fn shares_along(&self, seam: &Seam, side: &SeamSide) -> Vec<f64> {
        let mesh = self.surface().mesh();
        let at = |vertex: VertexId| {
            let corner = mesh
                .outgoing(vertex)
                .find(|h| self.square_of[h.face()] == side.square);
            corner.map_or(DVec2::NAN, |corner| self.coordinates[corner])
        };
        let places = seam.vertices.iter().map(|&vertex| at(vertex));
        places
            .map(|place| side.share(place) + side.measure(place)[1])
            .collect()
    }

    fn warn(&self, options: ChartMapOptions, watch: &Watch) {
        let counts = self.counts();
        let fallen = counts.uniform + counts.coarse_to_fine;
        if fallen > 0 {
            let message = format!(
                "mean value coordinates failed or would have flipped triangles in {fallen} squares: {} were laid \
                 down with equal weights, {} from coarse to fine",
                counts.uniform, counts.coarse_to_fine
            );
            watch.warn("chart-map-fallback", message);
        }
        let broken = counts.squares - counts.keep_net;
        if options.keep_net && broken > 0 {
            let message = format!(
                "{broken} squares do not have the lengths of the net along their sides: a repeated \
                 pattern shows seams there"
            );
            watch.warn("net-not-kept", message);
        }
    }
}

impl SeamSide {
    /// How far along the square's side a place is, and how far from the side.
    fn measure(&self, place: DVec2) -> [f64; 2] {
        match self.side {
            0 => [place.x, place.y.abs()],
            1 => [place.y, (1.0 - place.x).abs()],
            2 => [1.0 - place.x, (1.0 - place.y).abs()],
            _ => [1.0 - place.y, place.x.abs()],
        }
    }

    /// How far along the seam a place is, seen from this side: 0 at its first vertex, 1 at its last.
    #[must_use]
    pub fn share(&self, place: DVec2) -> f64 {
        let [from, to] = self.shares;
        (self.measure(place)[0] - from) / (to - from)
    }

    /// The place in the square this far along the seam.
    #[must_use]
    pub fn place(&self, share: f64) -> DVec2 {
        let [from, to] = self.shares;
        let along = from + (to - from) * share;
        match self.side {
            0 => DVec2::new(along, 0.0),
            1 => DVec2::new(1.0, along),
            2 => DVec2::new(1.0 - along, 1.0),
            _ => DVec2::new(0.0, 1.0 - along),
        }
    }
}
