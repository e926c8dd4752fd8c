//! How each chart becomes squares: [PGP06] §3.4, Fig. 6.
//!
//! [PGP06]: crate::papers::PGP06

use glam::DVec2;

use super::split_arcs::{Outline, OutlinePlace, ParameterizedArc};
use super::{Chart, ChartKind, ChartLayout};
use crate::tolerance::WHOLE_LENGTH;

/// Lengths, in spacings of the net, of which the sides of charts are multiples: lines are a half or a
/// quarter of a spacing apart where charts were no disks.
const UNITS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Most squares of one chart that keep the net: a chart with more units along its border has far less
/// area than they would need, and its net is not worth keeping.
const MOST_PARTS: u32 = 64;

/// What is to become of a chart.
#[derive(Clone, Debug)]
pub(super) struct ChartPlan {
    pub(super) outline: Outline,
    pub(super) shape: PlannedShape,
    /// Whether all seams of its squares keep the net, if that was asked for.
    pub(super) keeps_net: bool,
}

/// The squares of a chart.
#[derive(Clone, Debug)]
pub(super) enum PlannedShape {
    /// One, with the coordinates of the net.
    Net { size: DVec2 },
    /// One, with its corners there.
    Square {
        corners: Vec<OutlinePlace>,
        size: DVec2,
    },
    /// One for each corner, between lines from the centre to the middles of the sides.
    Split {
        corners: Vec<OutlinePlace>,
        middles: Vec<OutlinePlace>,
        /// Width and height of each in spacings of the net.
        side: f64,
    },
}

/// Plans all charts and marks the arcs where squares will have corners.
///
/// With `keep_net`, lengths along arcs are those of the net, so that squares on both sides have the
/// same: a chart that is no rectangle of the net gets a corner at each whole length of its outline.
pub(super) fn plan_charts(
    layout: &ChartLayout,
    arcs: &mut [ParameterizedArc],
    keep_net: bool,
) -> Vec<ChartPlan> {
    let spacing = mean_spacing(arcs);
    let plans: Vec<_> = (layout.charts().iter())
        .map(|chart| plan_chart(chart, arcs, spacing, keep_net))
        .collect();
    for plan in &plans {
        let (corners, middles): (&[_], &[_]) = match &plan.shape {
            PlannedShape::Net { .. } => (&[], &[]),
            PlannedShape::Square { corners, .. } => (corners, &[]),
            PlannedShape::Split {
                corners, middles, ..
            } => (corners, middles),
        };
        for &place in corners.iter().chain(middles) {
            plan.outline.mark(place, arcs);
        }
    }
    plans
}

/// The mean length in space of one spacing of the net.
fn mean_spacing(arcs: &[ParameterizedArc]) -> f64 {
    let (mut space, mut net) = (0.0, 0.0);
    for arc in arcs {
        if let Some(length) = arc.net_length {
            space += arc.space_length;
            net += length;
        }
    }
    if net > 0.0 && space > 0.0 {
        return space / net;
    }
    let all: f64 = arcs.iter().map(|arc| arc.space_length).sum();
    (all / arcs.len().max(1) as f64).max(f64::MIN_POSITIVE)
}

fn plan_chart(chart: &Chart, arcs: &[ParameterizedArc], spacing: f64, keep_net: bool) -> ChartPlan {
    let outline = Outline::of(chart, arcs, spacing);
    if chart.kind == ChartKind::Regular {
        let size = DVec2::new(outline.side_length(0), outline.side_length(1));
        // Charts cut at other places than the net's lines do not repeat a pattern.
        let finest = UNITS[UNITS.len() - 1];
        let keeps_net = is_whole(size.x / finest) && is_whole(size.y / finest);
        return ChartPlan {
            outline,
            shape: PlannedShape::Net { size },
            keeps_net,
        };
    }
    if keep_net {
        let outline = Outline::whole(chart, arcs);
        let shape = (UNITS.iter()).find_map(|&unit| whole_shape(&outline, unit));
        if let Some(shape) = shape {
            return ChartPlan {
                outline,
                shape,
                keeps_net: true,
            };
        }
    }
    let shape = shape(&outline);
    ChartPlan {
        outline,
        shape,
        keeps_net: false,
    }
}

/// A square for four sides, else one for each corner.
fn shape(outline: &Outline) -> PlannedShape {
    let sides = outline.corners.len() - 1;
    let place = |length: &f64| outline.place_at(*length);
    let corners = outline.corners[..sides].iter().map(place).collect();
    if sides == 4 {
        let mean = |side| 0.5 * (outline.side_length(side) + outline.side_length(side + 2));
        return PlannedShape::Square {
            corners,
            size: DVec2::new(mean(0), mean(1)),
        };
    }
    let middle = |side| outline.corners[side] + 0.5 * outline.side_length(side);
    let middles = (0..sides).map(|side| outline.place_at(middle(side)));
    PlannedShape::Split {
        corners,
        middles: middles.collect(),
        side: 0.5,
    }
}

/// A rectangle of the net if the sides allow it, else a square for each unit of the outline's length;
/// `None` if the corners are not at whole units, or these are too many.
fn whole_shape(outline: &Outline, unit: f64) -> Option<PlannedShape> {
    if !(outline.corners.iter()).all(|&length| is_whole(length / unit)) {
        return None;
    }
    let sides = outline.corners.len() - 1;
    let length = |side: usize| (outline.side_length(side % sides) / unit).round();
    if sides == 4 && (0..2).all(|side| length(side).total_cmp(&length(side + 2)).is_eq()) {
        return Some(shape(outline));
    }
    #[expect(clippy::cast_sign_loss, reason = "a length")]
    let count = (outline.length() / unit).round() as u32;
    let place = move |k: u32, offset| outline.place_at((f64::from(k) + offset) * unit);
    let places = |offset: f64| (0..count).map(move |k| place(k, offset));
    let corners = places(0.0).collect();
    match count {
        4 => Some(PlannedShape::Square {
            corners,
            size: DVec2::splat(unit),
        }),
        3..=MOST_PARTS => Some(PlannedShape::Split {
            corners,
            middles: places(0.5).collect(),
            side: 0.5 * unit,
        }),
        _ => None,
    }
}

fn is_whole(length: f64) -> bool {
    (length - length.round()).abs() < WHOLE_LENGTH
}
