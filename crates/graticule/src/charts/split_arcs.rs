//! The arcs of a layout with one parameter each, and the vertices put on them.

use glam::DVec2;

use super::{Arc, ArcId, Chart, ChartKind, ChartLayout, Direction};
use crate::mesh::{Element, HalfedgeId, VertexId};
use crate::tolerance::{SAME_ARC_PLACE, SHORTEST_ARC_STEP, SQUEEZED_ARC};

/// A vertex of an arc once it is split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ArcStop {
    /// Where it lies along the arc, in `0.0..=1.0`.
    pub(super) parameter: f64,
    /// Its number among the vertices of the layout and the new ones on arcs.
    pub(super) vertex: u32,
    /// Whether a corner of a square may lie there; all such are counted from 0.
    pub(super) break_number: Option<u32>,
    /// The step of the chain that it lies on, and how far along, if it is new.
    pub(super) on_step: Option<(usize, f64)>,
}

/// An arc with a parameter that both its sides share.
#[derive(Clone, Debug)]
pub(super) struct ParameterizedArc {
    /// The parameter at each vertex of the chain, ascending from 0 to 1.
    parameters: Vec<f64>,
    /// The length in spacings of the net, where a chart beside it has coordinates.
    pub(super) net_length: Option<f64>,
    /// The length in space.
    pub(super) space_length: f64,
    marks: Vec<f64>,
    /// All vertices, in order; see [`finish_arcs`].
    pub(super) stops: Vec<ArcStop>,
}

/// Gives each arc a parameter: the net's where a chart beside it is regular and the net does not squeeze
/// the arc, else its length; on those that are to be even one that grows by the same with each step.
pub(super) fn parameterize_arcs(layout: &ChartLayout, is_even: &[bool]) -> Vec<ParameterizedArc> {
    let of_arc = |(arc, &is_even): (&Arc, &bool)| {
        let (mut parameters, space_length) = by_length(layout, &arc.vertices);
        if is_even {
            let steps = (arc.vertices.len() - 1) as f64;
            parameters = (0..arc.vertices.len()).map(|k| k as f64 / steps).collect();
        }
        ParameterizedArc {
            parameters,
            net_length: None,
            space_length,
            marks: Vec::new(),
            stops: Vec::new(),
        }
    };
    let mut arcs: Vec<_> = layout.arcs().iter().zip(is_even).map(of_arc).collect();
    for chart in layout.charts() {
        if chart.kind == ChartKind::Regular {
            for &(arc, direction) in chart.sides.iter().flatten() {
                let known = &mut arcs[arc.index()];
                if known.net_length.is_none()
                    && let Some((parameters, length)) = by_net(layout, arc, direction)
                {
                    let squeezed = squeeze(&parameters, &known.parameters) > SQUEEZED_ARC;
                    if !is_even[arc.index()] && !squeezed {
                        known.parameters = parameters;
                    }
                    known.net_length = Some(length);
                }
            }
        }
    }
    arcs
}

/// Splits the arcs where they were marked; vertices from `first_new` on are new. Returns how many
/// vertices there are then.
pub(super) fn finish_arcs(arcs: &mut [ParameterizedArc], layout: &ChartLayout) -> u32 {
    let mut next = layout.surface().mesh().vertex_count() as u32;
    for (arc, chain) in arcs.iter_mut().zip(layout.arcs()) {
        next = arc.finish(&chain.vertices, next);
    }
    next
}

impl ParameterizedArc {
    /// Puts a corner of a square at a place along the arc, or at a vertex very near to it.
    pub(super) fn mark(&mut self, parameter: f64) {
        self.marks.push(parameter);
    }

    fn finish(&mut self, chain: &[VertexId], mut next: u32) -> u32 {
        let last = chain.len() - 1;
        let of_chain = |index: usize| ArcStop {
            parameter: self.parameters[index],
            vertex: chain[index].0,
            break_number: (index == 0 || index == last).then_some(0),
            on_step: None,
        };
        let mut stops: Vec<ArcStop> = (0..chain.len()).map(of_chain).collect();
        self.marks.sort_by(f64::total_cmp);
        for &mark in &self.marks {
            let at = stops.partition_point(|stop| stop.parameter < mark);
            let near = [at.saturating_sub(1), at.min(stops.len() - 1)];
            let distance = |&stop: &usize| (stops[stop].parameter - mark).abs();
            if let Some(stop) = near.into_iter().find(|s| distance(s) < SAME_ARC_PLACE) {
                stops[stop].break_number = Some(0);
                continue;
            }
            let step = self.parameters.partition_point(|&p| p < mark) - 1;
            let [from, to] = [self.parameters[step], self.parameters[step + 1]];
            let stop = ArcStop {
                parameter: mark,
                vertex: next,
                break_number: Some(0),
                on_step: Some((step, (mark - from) / (to - from))),
            };
            stops.insert(at, stop);
            next += 1;
        }
        let breaks = stops
            .iter_mut()
            .filter_map(|stop| stop.break_number.as_mut());
        (0..)
            .zip(breaks)
            .for_each(|(count, number)| *number = count);
        self.stops = stops;
        next
    }

    /// The vertices in the order in which a chart passes them, parameters counted that way.
    pub(super) fn passed(&self, direction: Direction) -> Vec<ArcStop> {
        let mut stops = self.stops.clone();
        if direction == Direction::Backward {
            stops.reverse();
            let steps = self.parameters.len() - 1;
            for stop in &mut stops {
                stop.parameter = 1.0 - stop.parameter;
                stop.on_step = (stop.on_step).map(|(step, share)| (steps - 1 - step, 1.0 - share));
            }
        }
        stops
    }
}

/// How much steps along an arc are shorter or longer than they are in space: the mean, along it, of
/// half the sum of both squared; 1 where they are in proportion.
fn squeeze(parameters: &[f64], by_length: &[f64]) -> f64 {
    let steps = parameters.windows(2).zip(by_length.windows(2));
    let squeezed = steps.map(|(steps, lengths)| {
        let [step, length] = [steps, lengths].map(|ends| ends[1] - ends[0]);
        let square = (step / length).powi(2);
        0.5 * length * (square + 1.0 / square)
    });
    squeezed.sum()
}

/// Shares of the length along a chain, and the length.
fn by_length(layout: &ChartLayout, chain: &[VertexId]) -> (Vec<f64>, f64) {
    let surface = layout.surface();
    let steps = chain.windows(2).map(|ends| {
        surface
            .position(ends[0])
            .distance(surface.position(ends[1]))
    });
    let steps: Vec<f64> = steps.collect();
    let length: f64 = steps.iter().sum();
    (shares_of_length(&steps), length)
}

/// Where steps end, over where the last one does; from 0 on.
pub(super) fn shares_of_length(steps: &[f64]) -> Vec<f64> {
    let whole: f64 = steps.iter().sum();
    // A step without length would leave no room for the triangles beside it.
    let least = whole.max(f64::MIN_POSITIVE) * SHORTEST_ARC_STEP;
    let mut sum = 0.0;
    let mut ends = vec![0.0];
    ends.extend(steps.iter().map(|step| {
        sum += step.max(least);
        sum
    }));
    let mut parameters: Vec<f64> = ends.iter().map(|end| end / sum).collect();
    if let Some(end) = parameters.last_mut() {
        *end = 1.0;
    }
    parameters
}

/// The parameter that the regular chart passing the arc in this direction has on it, and the length
/// there; `None` if it does not go straight on.
fn by_net(layout: &ChartLayout, arc: ArcId, direction: Direction) -> Option<(Vec<f64>, f64)> {
    let mut chain = layout.arc(arc).vertices.clone();
    if direction == Direction::Backward {
        chain.reverse();
    }
    let places = chain_places(layout, &chain)?;
    let whole = *places.last()? - places[0];
    let length = whole.length();
    let along = |place: &DVec2| (*place - places[0]).dot(whole) / (length * length);
    let mut parameters: Vec<f64> = places.iter().map(along).collect();
    if direction == Direction::Backward {
        parameters.reverse();
        for parameter in &mut parameters {
            *parameter = 1.0 - *parameter;
        }
    }
    *parameters.first_mut()? = 0.0;
    *parameters.last_mut()? = 1.0;
    let ascends = parameters.windows(2).all(|pair| pair[0] < pair[1]);
    ascends.then_some((parameters, length))
}

/// The coordinates along a chain on the border of the chart to its left.
fn chain_places(layout: &ChartLayout, chain: &[VertexId]) -> Option<Vec<DVec2>> {
    let sides = border_halfedges(layout, chain)?;
    let first = sides.iter().map(|&side| layout.coordinates()[side]);
    let end = sides
        .last()
        .and_then(|side| layout.coordinates()[side.next()]);
    first.chain([end]).collect()
}

/// The halfedges along a chain of vertices.
pub(super) fn border_halfedges(
    layout: &ChartLayout,
    chain: &[VertexId],
) -> Option<Vec<HalfedgeId>> {
    let mesh = layout.surface().mesh();
    let along = |ends: &[VertexId]| {
        mesh.outgoing(ends[0])
            .find(|&h| mesh.destination(h) == ends[1])
    };
    chain.windows(2).map(along).collect()
}

/// A passage of a chart along an arc.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcUse {
    pub(super) arc: ArcId,
    pub(super) direction: Direction,
    /// The length that the chart counts it with.
    pub(super) length: f64,
}

/// A place on the outline of a chart: an arc's place among those that it passes, and how far along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlinePlace {
    pub(super) passage: usize,
    pub(super) share: f64,
}

/// The arcs that a chart passes, and the length of its sides.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub(super) passages: Vec<ArcUse>,
    /// Where the length counted from the first corner is at the start of each passage, and at the
    /// end of all.
    starts: Vec<f64>,
    /// The length counted at each corner, and at the end of all.
    pub(super) corners: Vec<f64>,
}

impl Outline {
    /// The outline with the lengths of the net on sides where all arcs have one, else in space, each
    /// in mean spacings then.
    pub(super) fn of(chart: &Chart, arcs: &[ParameterizedArc], spacing: f64) -> Self {
        let mut outline = Self {
            passages: Vec::new(),
            starts: vec![0.0],
            corners: vec![0.0],
        };
        let mut sum = 0.0;
        for side in &chart.sides {
            let arc = |arc: ArcId| &arcs[arc.index()];
            let on_net = side.iter().all(|&(a, _)| arc(a).net_length.is_some());
            for &(number, direction) in side {
                let in_space = (arc(number).space_length / spacing).max(SHORTEST_ARC_STEP);
                let net = arc(number).net_length.filter(|_| on_net);
                let length = net.unwrap_or(in_space);
                outline.passages.push(ArcUse {
                    arc: number,
                    direction,
                    length,
                });
                sum += length;
                outline.starts.push(sum);
            }
            outline.corners.push(sum);
        }
        outline
    }

    /// The outline with arcs of unknown length counted as one spacing: what a net without seams
    /// needs.
    pub(super) fn whole(chart: &Chart, arcs: &[ParameterizedArc]) -> Self {
        let mut outline = Self::of(chart, arcs, 1.0);
        let mut sum = 0.0;
        let mut places = vec![0];
        places.extend(chart.sides.iter().scan(0, |end, side| {
            *end += side.len();
            Some(*end)
        }));
        for (passage, start) in outline.passages.iter_mut().zip(&mut outline.starts) {
            *start = sum;
            passage.length = arcs[passage.arc.index()].net_length.unwrap_or(1.0);
            sum += passage.length;
        }
        if let Some(end) = outline.starts.last_mut() {
            *end = sum;
        }
        outline.corners = places.iter().map(|&place| outline.starts[place]).collect();
        outline
    }

    /// The length of all sides.
    pub(super) fn length(&self) -> f64 {
        self.starts[self.passages.len()]
    }

    /// The length of a side.
    pub(super) fn side_length(&self, side: usize) -> f64 {
        self.corners[side + 1] - self.corners[side]
    }

    /// The place where the length counted is this.
    pub(super) fn place_at(&self, length: f64) -> OutlinePlace {
        let after = self.starts.partition_point(|&start| start <= length);
        let passage = after.clamp(1, self.passages.len()) - 1;
        let share = (length - self.starts[passage]) / self.passages[passage].length;
        OutlinePlace {
            passage,
            share: share.clamp(0.0, 1.0),
        }
    }

    /// The length counted at a place.
    pub(super) fn length_at(&self, place: OutlinePlace) -> f64 {
        self.starts[place.passage] + place.share * self.passages[place.passage].length
    }

    /// Marks a place as a corner of a square.
    pub(super) fn mark(&self, place: OutlinePlace, arcs: &mut [ParameterizedArc]) {
        let passage = self.passages[place.passage];
        let share = match passage.direction {
            Direction::Forward => place.share,
            Direction::Backward => 1.0 - place.share,
        };
        arcs[passage.arc.index()].mark(share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_in_proportion_to_length_are_not_squeezed_and_others_are_by_their_ratio() {
        let lengths = [0.0, 0.25, 0.5, 1.0];
        assert!((squeeze(&lengths, &lengths) - 1.0).abs() < 1e-15);
        // Half the length at a third of its share, half of it at five thirds.
        let third = [0.0, 1.0 / 6.0, 1.0];
        let expected = 0.25 * (1.0 / 9.0 + 9.0 + 25.0 / 9.0 + 9.0 / 25.0);
        assert!((squeeze(&third, &[0.0, 0.5, 1.0]) - expected).abs() < 1e-12);
    }
}
