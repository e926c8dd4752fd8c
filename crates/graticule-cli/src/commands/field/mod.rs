//! `graticule field`: a field of crosses, lines or vectors on a surface.

mod guides;
mod options;
mod output;
mod picture;
mod ply;
mod singularities;
mod table;

use graticule::field::{FieldError, FieldResult, cross_field};
use graticule::mesh::{PolygonSoup, Repaired};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::Outcome;
use crate::report::{Report, to_value};
use crate::session::Session;

use guides::Wishes;
pub(crate) use guides::lines_of_file;
pub(crate) use options::{Drawing, Options};
use output::FieldOutput;
pub(crate) use picture::panel;
use singularities::Places;

/// Reads, repairs, computes, draws, writes.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let (plan, output) = options.check(&session.common)?;
    let wishes = Wishes::read(options.guide.as_deref())?;
    let places = Places::of(options)?;
    let input = Input::read(&options.mesh, session)?;
    let mut outcome = Outcome::of(Report::new("field", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired_on_the_way(options.repair_options(), session)?;
    outcome.report.repair = repair_to_report(&repaired.changes)?;
    let found = Found {
        soup: &input.soup,
        repaired: &repaired,
        field: field(options, (&wishes, &places), &input, &repaired, session)?,
    };
    outcome.report.result = found.to_report()?;
    outcome.remarks = table::table(&found.field).to_string();
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        outcome.picture = Some(format.encode(&picture::picture(
            &repaired.surface,
            &found.field,
            options.draw,
        )?));
    }
    match output {
        FieldOutput::Ply(path) => outcome.files.push((path, found.to_ply())),
        FieldOutput::Lines => outcome.mesh = Some(found.to_lines()),
        FieldOutput::Json(Some(path)) => outcome.files.push((path, found.to_json()?.into_bytes())),
        FieldOutput::Json(None) => outcome.text = found.to_json()?,
    }
    plan.finish(session, outcome)
}

/// The field that the options ask for; an error names guides by their place in the file.
fn field(
    options: &Options,
    (wishes, places): (&Wishes, &Places),
    input: &Input,
    repaired: &Repaired,
    session: &Session,
) -> Result<FieldResult, Failure> {
    let mut wanted = options.field_options(session.common.seed);
    let guides = wishes.on_surface(&input.soup, repaired)?;
    wanted.guides = guides.iter().map(|(_, guide)| *guide).collect();
    let strokes = wishes.strokes();
    wanted.strokes = strokes.iter().map(|(_, stroke)| stroke.clone()).collect();
    let (edges, beside) = lines_of_file(&input.soup, repaired);
    wanted.features.edges = edges;
    wanted.strokes.extend(beside);
    wanted.singularities = places.plan(wanted.symmetry, repaired)?;
    let found = cross_field(&repaired.surface, &wanted, &session.watch);
    found.map_err(|error| match error {
        FieldError::Guide { guide, what, value } => {
            let guide = guides[guide].0;
            Failure::from(FieldError::Guide { guide, what, value })
        }
        FieldError::Stroke { number, what } => {
            // Those of the mesh file come after those of the guide file.
            let number = strokes.get(number).map_or(number, |(number, _)| *number);
            Failure::from(FieldError::Stroke { number, what })
        }
        error => Failure::from(error).at(input.path.display()),
    })
}

/// A field with the file that it belongs to.
struct Found<'a> {
    soup: &'a PolygonSoup,
    repaired: &'a Repaired,
    field: FieldResult,
}

impl Found<'_> {
    /// The figures, and where the field is singular.
    fn to_report(&self) -> Result<Value, Failure> {
        let mut report = to_value(&self.field.report)?;
        report["singular"] = self.singularities();
        Ok(report)
    }

    /// The singular triangles: polygon of the file, middle, index.
    fn singularities(&self) -> Value {
        let found = &self.field.singularities;
        let order = f64::from(found.symmetry.order());
        let singular = found.faces.iter().map(|singularity| {
            let middle = output::middle(&self.repaired.surface, singularity.face);
            json!({
                "polygon": self.repaired.face_polygons[singularity.face],
                "position": middle.to_array(),
                "index": f64::from(singularity.steps) / order,
            })
        });
        singular.collect()
    }
}
