//! `graticule flatten`: a patch laid flat, written as the mesh that was read with texture
//! coordinates.

mod atlas;
mod atlas_options;
mod file_vertices;
mod method;
mod options;
mod piece;
mod told;

use glam::DVec2;
use graticule::flatten::FlatMap;
use graticule::measure::{MapMeasure, corner_uvs, measure_map};
use graticule::mesh::{NO_VALUE, PerCorner, PolygonSoup, Surface};
use graticule::watch::Watch;
use graticule_draw::Picture;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::picture::{area_panel, curve_panel, in_rows_of_three, map_panels, map_picture};
use crate::report::{Report, to_value};
use crate::session::Session;
use crate::tables::{figure, measure_table};
use crate::uvs;

use method::{Illustration, Task};
pub(crate) use options::Options;
use options::Scale;
use piece::Piece;

/// Reads, repairs, flattens, measures, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = options.check(&session.common)?;
    let input = Input::read(&options.paths.mesh, session)?;
    let mut outcome = Outcome::of(Report::new(
        "flatten",
        session.options_to_report(&options.in_force())?,
    ));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair_options(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let at_input = |failure: Failure| failure.at(input.path.display());
    if options.atlas.are_asked_for() {
        let place = input.path.display().to_string();
        let picture = atlas::run(options, input, &repaired, &mut outcome, session)
            .map_err(|failure| failure.at(place))?;
        let encoded = plan.picture_format().zip(picture);
        outcome.picture = encoded.map(|(format, picture)| format.encode(&picture));
        return plan.finish(session, outcome);
    }
    let piece = Piece::choose(&repaired, options.component).map_err(at_input)?;
    let made = {
        let _stage = session.watch.stage("flatten");
        let task = Task {
            options,
            soup: &input.soup,
            repaired: &repaired,
            piece: &piece,
            watch: &session.watch,
        };
        task.run().map_err(at_input)?
    };
    let uv = match options.scale() {
        Scale::UnitSquare => made.map.unit_square_uv(),
        Scale::AsMade => made.map.uv.clone(),
    };
    // What is measured is what the file will hold.
    let uv = match plan.mesh_format() {
        Some(format) => uv.map(|&uv| format.stored_uv(uv)),
        None => uv,
    };
    let corners = made.corners(&piece, &uv);
    outcome.report.result = map_to_report(&made.map);
    if let (Value::Object(result), Value::Object(details)) =
        (&mut outcome.report.result, &made.details)
    {
        result.extend(details.clone());
    }
    let judged = Judged::at_corners(&piece.surface, corners, session).map_err(at_input)?;
    judged.tell(&mut outcome)?;
    if let Some(format) = plan.picture_format() {
        let picture = judged.illustrated(made.illustration.as_ref(), session);
        outcome.picture = Some(format.encode(&picture.map_err(at_input)?));
    }
    let soup = match &made.cut {
        Some(cut) => {
            let at_corner = |corner| {
                let own = piece.corner(corner);
                own.map_or(NO_VALUE, |corner| cut[corner].0)
            };
            let corners = repaired.surface.mesh().halfedge_count();
            let uv_of_corner = PerCorner::from_fn(corners, at_corner);
            uvs::put_at_corners(input.soup, &repaired, uv.into_vec(), &uv_of_corner)
        }
        None => uvs::put_into(input.soup, &repaired, &uv, |vertex| {
            piece.vertex(vertex).map_or(NO_VALUE, |vertex| vertex.0)
        }),
    };
    put_into(&mut outcome, soup);
    outcome.ascii = input.ascii;
    plan.finish(session, outcome)
}

/// Puts the mesh into the outcome, its polygons such that a fan from the first corner turns none of
/// its triangles over in the map, as far as there is one.
fn put_into(outcome: &mut Outcome, mut soup: PolygonSoup) {
    let turned = uvs::begin_polygons_for_fans(&mut soup);
    outcome.report.result["polygons_begun_elsewhere"] = turned.into();
    outcome.mesh = Some(soup);
}

/// A map with its measure.
pub(super) struct Judged<'a> {
    surface: &'a Surface,
    corners: PerCorner<DVec2>,
    measure: MapMeasure,
}

impl<'a> Judged<'a> {
    /// Measures a map given at the corners.
    fn at_corners(
        surface: &'a Surface,
        corners: PerCorner<DVec2>,
        session: &Session,
    ) -> Result<Self, Failure> {
        let measure = measure_map(surface, &corners, &session.watch)?;
        warn_of_overlaps(&measure, session);
        Ok(Self {
            surface,
            corners,
            measure,
        })
    }

    /// Puts the measure into report and remarks.
    pub(super) fn tell(&self, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.report.measure = to_value(&self.measure)?;
        outcome.remarks = measure_table(&self.measure).to_string();
        Ok(())
    }

    /// Draws the map.
    pub(super) fn draw(&self, session: &Session) -> Result<Picture, Failure> {
        let _stage = session.watch.stage("draw");
        map_picture(self.surface, &self.corners, &self.measure, &session.watch)
    }

    /// Draws the map and how it came about.
    fn illustrated(
        &self,
        illustration: Option<&Illustration>,
        session: &Session,
    ) -> Result<Picture, Failure> {
        let Some(told) = illustration else {
            return self.draw(session);
        };
        let _stage = session.watch.stage("draw");
        let before = corner_uvs(self.surface.mesh(), &told.before);
        // What there is to warn of has been told of the result.
        let measure = measure_map(self.surface, &before, &Watch::new())?;
        let before = area_panel(self.surface, &measure)?.with_caption(told.before_name);
        let mut panels = map_panels(self.surface, &self.corners, &self.measure, &session.watch)?;
        panels.extend([before, curve_panel(&told.curve, told.marked, &told.caption)]);
        Ok(in_rows_of_three(panels)?)
    }
}

/// A map may overlap itself although no triangle is flipped: a free boundary may cross itself.
fn warn_of_overlaps(measure: &MapMeasure, session: &Session) {
    if measure.overlap.any {
        let share = figure(100.0 * measure.overlap.area_share);
        let message = format!(
            "the map overlaps itself: {share} % of its area is covered more than once; \
             --no-overlap lays every triangle down apart"
        );
        session.watch.warn("overlap", message);
    }
}

/// What the report tells of a map beside its measure.
pub(super) fn map_to_report(map: &FlatMap) -> Value {
    json!({
        "method": map.method,
        "vertices": map.uv.len(),
        "residual": map.residual,
        "flips": map.flips,
        "flip_free_in_theory": map.flip_free_in_theory,
        "intrinsic_flips": map.intrinsic_flips,
        "energy": map.energy,
    })
}
