//! Charts on squares: what is written, told and drawn of them.

use glam::DVec2;
use graticule::charts::{
    ChartAtlas, ChartLayout, ChartMaps, Seam, SquareId, chart_atlas, chart_maps,
};
use graticule::geometry::{face_shapes, total_area};
use graticule::measure::{MapMeasure, measure_map};
use graticule::mesh::{
    CornerAttribute, Element, PerCorner, PolygonLabels, PolygonSoup, Repaired, Surface,
};
use graticule::quads::Carry;
use graticule_draw::{CheckerStyle, LayoutStyle, Panel, Squares, SurfaceStyle, surface, uv_layout};
use serde_json::{Value, json};

use super::atlas_options::AtlasArguments;
use super::textures;
use crate::failure::Failure;
use crate::outcome::Outcome;
use crate::report::to_value;
use crate::session::Session;
use crate::tables::measure_table;
use crate::uvs;

/// Squares of the checker along each side of a chart of the net.
const SQUARES_ON_NET: f64 = 8.0;

/// The mesh as it was read, its surface, and the layout made from it.
pub(super) struct AtlasInput<'a> {
    pub(super) soup: &'a PolygonSoup,
    pub(super) repaired: &'a Repaired,
    pub(super) layout: &'a ChartLayout,
}

/// A layout with every chart on a square, and the squares side by side.
pub(super) struct Atlas {
    maps: ChartMaps,
    packed: ChartAtlas,
    measure: MapMeasure,
    keeps_net: bool,
}

impl Atlas {
    /// Lays the charts down and measures them.
    pub(super) fn of(
        arguments: &AtlasArguments,
        atlas_input: &AtlasInput<'_>,
        session: &Session,
    ) -> Result<Self, Failure> {
        let watch = &session.watch;
        let input = &atlas_input.repaired.surface;
        let maps = chart_maps(input, atlas_input.layout, &arguments.map_options(), watch)?;
        let packed = chart_atlas(&maps, &arguments.arrangement(), watch)?;
        let measure = measure_map(maps.surface(), &packed.corner_uv, watch)?;
        let keeps_net = arguments.keeps_net();
        Ok(Self {
            maps,
            packed,
            measure,
            keeps_net,
        })
    }

    /// Puts everything but the picture into the outcome.
    pub(super) fn tell(
        &self,
        arguments: &AtlasArguments,
        atlas_input: &AtlasInput<'_>,
        outcome: &mut Outcome,
        session: &Session,
    ) -> Result<(), Failure> {
        outcome.report.result["atlas"] = self.to_report(&atlas_input.repaired.surface)?;
        outcome.report.measure = to_value(&self.measure)?;
        outcome.remarks += &measure_table(&self.measure).to_string();
        let files = textures::files(arguments, atlas_input, &self.maps, &self.packed, session)?;
        outcome.files.extend(files);
        outcome.mesh = Some(self.to_soup(atlas_input));
        Ok(())
    }

    fn to_report(&self, input: &Surface) -> Result<Value, Failure> {
        let surface = self.maps.surface();
        let areas = [input, surface].map(|surface| total_area(&face_shapes(surface)));
        let length: f64 = self
            .maps
            .seams()
            .iter()
            .map(|seam| length(surface, seam))
            .sum();
        let mut report = to_value(&self.maps.counts())?;
        let more = json!({
            "vertices": surface.mesh().vertex_count(),
            "triangles": surface.mesh().face_count(),
            "flipped": self.packed.flipped,
            "largest_gap": self.maps.largest_gap(),
            "area_error": (areas[1] / areas[0] - 1.0).abs(),
            "seam_length": length,
            "seam_length_over_root_of_area": length / areas[0].sqrt(),
            "tiles": self.packed.tiles,
            "covered": self.packed.covered,
            "texels_per_unit": self.packed.density,
            "placements": to_value(&self.packed.placements)?,
        });
        if let (Value::Object(report), Value::Object(more)) = (&mut report, more) {
            report.extend(more);
        }
        Ok(report)
    }

    /// The charts on their squares.
    pub(super) fn maps(&self) -> &ChartMaps {
        &self.maps
    }

    /// The refined mesh with the attributes of the input, the atlas as texture coordinates, and the
    /// charts as groups where the input has none.
    fn to_soup(&self, atlas_input: &AtlasInput<'_>) -> PolygonSoup {
        let surface = self.maps.surface();
        let plain = PolygonSoup::from(surface);
        let carry = Carry {
            original: atlas_input.soup,
            repaired: atlas_input.repaired,
            polygons: &plain.polygons,
            origins: self.maps.refined().vertex_origin.as_slice(),
        };
        let mut soup = carry.to_soup();
        let (values, corner_values) =
            uvs::distinct_at_vertices(surface.mesh(), &self.packed.corner_uv);
        let set = CornerAttribute {
            name: String::new(),
            values,
            corner_values: corner_values.into_vec(),
        };
        soup.attributes.uv_sets = vec![set];
        let charts = atlas_input.layout.charts().len();
        let chart = |square: &SquareId| self.maps.squares()[square.index()].chart.0;
        soup.attributes.groups.get_or_insert_with(|| PolygonLabels {
            names: (0..charts).map(|chart| format!("chart_{chart}")).collect(),
            polygon_names: self.maps.square_of().iter().map(chart).collect(),
        });
        soup
    }

    /// The checker over the surface, and the squares side by side ([PGP06] Fig. 1E).
    pub(super) fn panels(&self) -> Result<Vec<Panel>, Failure> {
        let shape = self.maps.surface();
        let checker = self.checker();
        let style = SurfaceStyle {
            checker: Some(CheckerStyle {
                uvs: &checker,
                squares: Squares::OfSide(1.0),
            }),
            ..SurfaceStyle::default()
        };
        let layout = LayoutStyle {
            edges: false,
            ..LayoutStyle::default()
        };
        let caption = if self.keeps_net {
            "E: a pattern on the net"
        } else {
            "E: a pattern on each square"
        };
        Ok(vec![
            surface(shape, &style)?.with_caption(caption),
            uv_layout(shape, &self.packed.corner_uv, &layout)?.with_caption("F: the atlas"),
        ])
    }

    /// The place of each corner in a checker. On a net it is that of the atlas, where whole steps lead
    /// over the seams; else a whole number of its squares fits on each square of the atlas.
    fn checker(&self) -> PerCorner<DVec2> {
        let placements = &self.packed.placements;
        if self.keeps_net {
            let mut squares = placements.iter().zip(self.maps.squares());
            let kept = squares.find(|(_, square)| square.keeps_net);
            let unit = kept.map_or(1.0, |(placement, square)| square.size.x / placement.size.x);
            // Two at least: the pattern repeats at whole coordinates.
            let count = (SQUARES_ON_NET * unit).round().max(2.0);
            return self.packed.corner_uv.map(|&uv| on_net(uv, count));
        }
        let area: f64 = placements.iter().map(|p| p.size.x * p.size.y).sum();
        let net_area: f64 = (self.maps.squares().iter())
            .map(|square| square.size.x * square.size.y)
            .sum();
        let per_unit = SQUARES_ON_NET * (net_area / area).sqrt();
        let counts = |size: DVec2| (size * per_unit).round().max(DVec2::ONE);
        PerCorner::from_fn(self.packed.corner_uv.len(), |corner| {
            let square = self.maps.square_of()[corner.face()].index();
            self.maps.coordinates()[corner] * counts(placements[square].size)
        })
    }
}

/// The place in a checker on a net. A quarter turn about the middle of one of its squares leaves it as
/// it is, one about a corner would exchange the colours: whole coordinates are in the middle of squares.
fn on_net(uv: DVec2, count: f64) -> DVec2 {
    uv * count + 0.5
}

/// The length of a seam in space, 0 along the boundary.
fn length(surface: &Surface, seam: &Seam) -> f64 {
    if seam.sides.contains(&None) {
        return 0.0;
    }
    let steps = seam.vertices.windows(2);
    steps
        .map(|ends| {
            surface
                .position(ends[0])
                .distance(surface.position(ends[1]))
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checker_on_a_net_goes_on_over_quarter_turns_and_whole_shifts() {
        let is_dark = |uv: DVec2| {
            let square = on_net(uv, SQUARES_ON_NET).floor();
            (square.x + square.y).rem_euclid(2.0) > 0.5
        };
        let here = DVec2::new(0.32, 0.72);
        let shift = DVec2::new(3.0, -8.0);
        let mut there = here;
        for _ in 0..4 {
            there = there.perp();
            assert_eq!(is_dark(here), is_dark(there + shift), "{there}");
        }
        assert_ne!(is_dark(here), is_dark(here + DVec2::X / SQUARES_ON_NET));
    }
}
