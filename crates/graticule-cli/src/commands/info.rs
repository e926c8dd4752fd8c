//! `graticule info`: what a mesh file holds.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use graticule::mesh::{Defects, ElementList, Repaired, Severity, Surface, Topology};
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::mesh_input::{Input, repair_to_report};
use crate::outcome::{Outcome, Plan};
use crate::picture::surface_picture;
use crate::repair_options::RepairArguments;
use crate::report::{Report, to_value};
use crate::session::Session;
use crate::tables::{Table, counted, figure};

/// Components that are listed one by one.
const LISTED_COMPONENTS: usize = ElementList::<u32>::SHOWN;

/// Options of `graticule info`.
#[derive(Args, Debug, Serialize)]
pub(crate) struct Options {
    /// The mesh to look at; - is standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    #[command(flatten)]
    repair: RepairArguments,
}

/// Reads and tells. A mesh that cannot be repaired is told of, too: that is no failure here.
pub(crate) fn run(options: &Options, session: &Session) -> Result<(), Failure> {
    let plan = Plan::check(&session.common)?;
    let input = Input::read(&options.mesh, session)?;
    let defects = {
        let _stage = session.watch.stage("find defects");
        Defects::find(&input.soup)
    };
    let mut outcome = Outcome::of(Report::new("info", session.options_to_report(options)?));
    outcome.report.input = input.to_report();
    let repaired = input.repaired(options.repair.into(), session);
    session.check()?;
    let surface = repaired.as_ref().ok().map(Described::of);
    outcome.text = text(&input, &defects, surface.as_ref(), repaired.as_ref().err());
    outcome.report.result = json!({
        "sound": defects.is_sound(),
        "extent": extent(&input).map(|extent| extent.to_array()),
        "findings": to_value(&defects.findings())?,
        "defects": to_value(&defects)?,
        "surface": surface.as_ref().map_or(Value::Null, Described::to_report),
        "refusal": repaired.as_ref().err().map(|failure| failure.fact.as_str()),
    });
    if let Ok(repaired) = &repaired {
        outcome.report.repair = repair_to_report(&repaired.changes)?;
    }
    if let Some(format) = plan.picture_format() {
        let _stage = session.watch.stage("draw");
        outcome.picture = Some(format.encode(&surface_picture(&repaired?.surface)?));
    }
    plan.finish(session, outcome)
}

/// The surface after repair: sizes and topology.
struct Described {
    topology: Topology,
    /// The largest extent, in which the two below are given.
    unit: f64,
    mean_edge_length: f64,
    area: f64,
}

impl Described {
    fn of(repaired: &Repaired) -> Self {
        let surface = &repaired.surface;
        let [unit, mean_edge_length, area] = sizes(surface);
        Self {
            topology: Topology::of(surface.mesh()),
            unit,
            mean_edge_length,
            area,
        }
    }
}

/// The largest extent; in this unit the mean length of an edge, and the area, so that no square
/// overflows or vanishes.
fn sizes(surface: &Surface) -> [f64; 3] {
    let mesh = surface.mesh();
    let [low, high] = surface.bounding_box();
    let unit = (high - low).max_element();
    let length = |edge| (surface.halfedge_vector(mesh.edge_halfedge(edge)) / unit).length();
    let area = |face| {
        let [a, b, c] = surface.corner_positions(face).map(|p| (p - low) / unit);
        (b - a).cross(c - a).length() / 2.0
    };
    let lengths: f64 = mesh.edges().map(length).sum();
    let areas: f64 = mesh.faces().map(area).sum();
    [unit, lengths / mesh.edge_count() as f64, areas]
}

/// Extent along each axis of the vertices that are finite; `None` where there is none.
fn extent(input: &Input) -> Option<DVec3> {
    let finite = input.soup.positions.iter().filter(|p| p.is_finite());
    let [low, high] = finite.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &p| {
        [low.min(p), high.max(p)]
    });
    (low.x <= high.x).then(|| high - low)
}

impl Described {
    fn to_report(&self) -> Value {
        let Topology {
            components, total, ..
        } = &self.topology;
        let listed = &components.as_slice()[..components.len().min(LISTED_COMPONENTS)];
        json!({
            "components": components.len(),
            "total": total,
            "listed_components": listed,
            "mean_edge_length": self.mean_edge_length * self.unit,
            "area": self.area * self.unit * self.unit,
        })
    }

    /// One line for each component, up to a limit.
    fn component_lines(&self) -> String {
        let components = &self.topology.components;
        let mut text = String::new();
        for (number, component) in components.iter().enumerate().take(LISTED_COMPONENTS) {
            let _ = writeln!(
                text,
                "  component {number}: {} vertices, {} faces, genus {}, {}",
                component.vertices,
                component.faces,
                component.genus,
                counted(component.boundary_loops, "boundary loop", "boundary loops"),
            );
        }
        if components.len() > LISTED_COMPONENTS {
            let _ = writeln!(text, "  and {} more", components.len() - LISTED_COMPONENTS);
        }
        text
    }
}

/// The account for people.
fn text(
    input: &Input,
    defects: &Defects,
    surface: Option<&Described>,
    refusal: Option<&Failure>,
) -> String {
    let mut text = format!("{}\n{}", input.path.display(), file_table(input));
    text.push_str(&findings_text(defects));
    match (surface, refusal) {
        (Some(surface), _) => {
            let title = if defects.is_sound() {
                "surface"
            } else {
                "surface after repair"
            };
            let _ = write!(text, "{title}\n{}", surface_table(surface));
            if surface.topology.components.len() > 1 {
                text.push_str(&surface.component_lines());
            }
        }
        (None, Some(refusal)) => {
            let _ = writeln!(
                text,
                "no surface can be made of it\n  {}\n  {}",
                refusal.fact, refusal.hint
            );
        }
        (None, None) => {}
    }
    text
}

fn file_table(input: &Input) -> Table {
    let soup = &input.soup;
    let mut table = Table::new();
    let size = input
        .bytes
        .map_or(String::new(), |bytes| format!(", {bytes} bytes"));
    table.row("format", format!("{}{size}", input.format));
    let mut holds = counted(soup.positions.len(), "vertex", "vertices");
    let _ = write!(
        holds,
        ", {}",
        counted(soup.polygons.len(), "polygon", "polygons")
    );
    if !soup.polylines.is_empty() {
        let _ = write!(
            holds,
            ", {}",
            counted(soup.polylines.len(), "polyline", "polylines")
        );
    }
    table.row("holds", holds);
    table.row("attributes", attributes_text(input));
    if let Some(extent) = extent(input) {
        let [x, y, z] = extent.to_array().map(figure);
        table.row("extent", format!("{x} × {y} × {z}"));
    }
    table
}

fn attributes_text(input: &Input) -> String {
    let attributes = &input.soup.attributes;
    let mut parts = Vec::new();
    let sets = attributes.uv_sets.len();
    if sets > 0 {
        parts.push(counted(
            sets,
            "set of texture coordinates",
            "sets of texture coordinates",
        ));
    }
    if attributes.normals.is_some() {
        parts.push("normals".into());
    }
    if attributes.vertex_colors.is_some() {
        parts.push("colours".into());
    }
    for (labels, singular, plural) in [
        (&attributes.objects, "object", "objects"),
        (&attributes.groups, "group", "groups"),
        (&attributes.materials, "material", "materials"),
        (
            &attributes.smoothing_groups,
            "smoothing group",
            "smoothing groups",
        ),
    ] {
        parts.extend(
            labels
                .iter()
                .map(|labels| counted(labels.names.len(), singular, plural)),
        );
    }
    if parts.is_empty() {
        "none".into()
    } else {
        parts.join(", ")
    }
}

fn findings_text(defects: &Defects) -> String {
    let mut text = String::new();
    let findings = defects.findings();
    for (severity, title) in [
        (Severity::Refused, "defects without a sound repair"),
        (Severity::Repairable, "defects that repair mends"),
        (Severity::Note, "worth knowing"),
    ] {
        let of_kind: Vec<_> = findings.iter().filter(|f| f.severity == severity).collect();
        if !of_kind.is_empty() {
            let _ = writeln!(text, "{title}");
        }
        for finding in of_kind {
            let _ = writeln!(text, "  {finding}");
        }
    }
    text
}

fn surface_table(surface: &Described) -> Table {
    let mut table = Table::new();
    let total = &surface.topology.total;
    let sizes = format!(
        "{} vertices, {} edges, {} faces",
        total.vertices, total.edges, total.faces
    );
    table.row("triangles", sizes);
    let topology = format!(
        "{}, genus {}, {}, Euler characteristic {}",
        counted(surface.topology.components.len(), "component", "components"),
        total.genus,
        counted(total.boundary_loops, "boundary loop", "boundary loops"),
        total.euler_characteristic,
    );
    table.row("topology", topology);
    let unit = surface.unit;
    table.row("mean edge", figure(surface.mean_edge_length * unit));
    let area = surface.area * unit * unit;
    let text = if area.is_normal() || surface.area == 0.0 {
        figure(area)
    } else {
        // Beyond the range of double precision.
        format!("{} × {}²", figure(surface.area), figure(unit))
    };
    table.row("area", text);
    table
}
