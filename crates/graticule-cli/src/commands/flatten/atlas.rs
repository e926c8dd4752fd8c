//! A whole surface laid flat without flips: `--injective`, `--no-overlap`, `--cut`.

use glam::DVec2;
use graticule::flatten::{Atlas, AtlasOptions, hold_rounding, lay_flat};
use graticule::geometry::dihedral_angles;
use graticule::mesh::{EdgeId, HalfedgeId, NO_VALUE, PerCorner, PolygonSoup, Repaired, Surface};
use serde_json::{Value, json};

use super::atlas_options::{AtlasArguments, SeamArgument};
use super::method::is_diagonal;
use super::options::{Options, Scale};
use super::piece::component_of;
use super::{Judged, put_into};
use crate::failure::Failure;
use crate::lines::Lines;
use crate::mesh_input::Input;
use crate::outcome::Outcome;
use crate::report::to_value;
use crate::session::Session;
use crate::uvs;

/// Cuts, flattens, packs, measures; puts all into the outcome.
pub(super) fn run(
    options: &Options,
    input: Input,
    repaired: &Repaired,
    outcome: &mut Outcome,
    session: &Session,
) -> Result<Option<graticule_draw::Picture>, Failure> {
    let part = Part::choose(repaired, options.component)?;
    let atlas = {
        let _stage = session.watch.stage("flatten");
        let options = atlas_options(&options.atlas, &input.soup, repaired, &part, session)?;
        lay_flat(&part.surface, &options, &session.watch)?
    };
    let scale = match options.scale() {
        Scale::UnitSquare => 1.0 / atlas.side,
        Scale::AsMade => 1.0,
    };
    // What is measured is what the file will hold.
    let format = options.paths.output()?.format();
    let mut places: Vec<DVec2> = atlas.places.iter().map(|&place| place * scale).collect();
    let triangles = triangles_of(&atlas.corners);
    let lost = hold_rounding(&triangles, &mut places, |place| format.stored_uv(place));
    if lost > 0 {
        let message =
            format!("in single precision {lost} triangles of the map are flipped or gone");
        session.watch.warn("lost-in-single-precision", message);
    }
    outcome.report.result = to_report(&atlas, &part)?;
    let corners = atlas.corners.map(|&place| places[place as usize]);
    let judged = Judged::at_corners(&part.surface, corners, session)?;
    judged.tell(outcome)?;
    let picture = match session.common.picture {
        Some(_) => Some(judged.draw(session)?),
        None => None,
    };
    let whole = part.on_whole(repaired, &atlas.corners);
    let soup = uvs::put_at_corners(input.soup, repaired, places, &whole);
    put_into(outcome, soup);
    Ok(picture)
}

/// The corners' values, triangle by triangle.
fn triangles_of(corners: &PerCorner<u32>) -> Vec<[u32; 3]> {
    let triples = corners.as_slice().chunks_exact(3);
    triples
        .map(|triple| [triple[0], triple[1], triple[2]])
        .collect()
}

/// The surface to be laid flat: all components, or one.
struct Part {
    surface: Surface,
    /// The corner of the whole for each corner.
    corner_sources: PerCorner<HalfedgeId>,
}

impl Part {
    fn choose(repaired: &Repaired, component: Option<u32>) -> Result<Self, Failure> {
        let whole = &repaired.surface;
        let Some(component) = component else {
            return Ok(Self {
                surface: whole.clone(),
                corner_sources: PerCorner::new(whole.mesh().halfedges().collect()),
            });
        };
        let part = component_of(whole, component)?;
        Ok(Self {
            surface: part.surface,
            corner_sources: part.corner_sources,
        })
    }

    /// The edges of the part among those that `wanted` says of the whole, by a side of each.
    fn edges(&self, wanted: impl Fn(HalfedgeId) -> bool) -> Vec<EdgeId> {
        let mesh = self.surface.mesh();
        let side = |edge: EdgeId| self.corner_sources[mesh.edge_halfedge(edge)];
        mesh.edges().filter(|&edge| wanted(side(edge))).collect()
    }

    /// Values of the part's corners at those of the whole.
    fn on_whole(&self, repaired: &Repaired, values: &PerCorner<u32>) -> PerCorner<u32> {
        let count = repaired.surface.mesh().halfedge_count();
        let mut whole = PerCorner::filled(count, NO_VALUE);
        for (corner, &source) in self.corner_sources.enumerate() {
            whole[source] = values[corner];
        }
        whole
    }
}

fn atlas_options(
    arguments: &AtlasArguments,
    soup: &PolygonSoup,
    repaired: &Repaired,
    part: &Part,
    session: &Session,
) -> Result<AtlasOptions, Failure> {
    let mesh = repaired.surface.mesh();
    let mut is_seam = vec![false; mesh.edge_count()];
    for kind in &arguments.seam {
        let edges = match kind {
            SeamArgument::Lines => line_edges(soup, repaired, session),
            SeamArgument::Uv => uv_seams(soup, repaired)?,
        };
        for edge in edges {
            is_seam[edge.0 as usize] = true;
        }
    }
    if let Some(degrees) = arguments.seam_angle {
        let angles = dihedral_angles(&repaired.surface);
        let sharp = |edge: &EdgeId| angles[*edge].abs() > degrees.to_radians();
        mesh.edges()
            .filter(sharp)
            .for_each(|edge| is_seam[edge.0 as usize] = true);
    }
    let is_diagonal = |side: HalfedgeId| is_diagonal(repaired, side);
    Ok(AtlasOptions {
        seam: part.edges(|side| is_seam[mesh.edge(side).0 as usize] && !is_diagonal(side)),
        uncut: part.edges(is_diagonal),
        cut: arguments.cut(),
        injective: arguments.injective(),
        packing: arguments.packing(),
    })
}

/// The edges along the file's lines.
fn line_edges(soup: &PolygonSoup, repaired: &Repaired, session: &Session) -> Vec<EdgeId> {
    let Lines { edges, beside } = Lines::of(soup, repaired);
    if !beside.is_empty() {
        let missed = beside.len();
        let message = format!("{missed} segments of the file's lines run along no edge");
        session.watch.warn("lines-off-edges", message);
    }
    edges
}

/// The edges at which the file's own texture coordinates differ from side to side.
fn uv_seams(soup: &PolygonSoup, repaired: &Repaired) -> Result<Vec<EdgeId>, Failure> {
    let Some(set) = soup.attributes.uv_sets.first() else {
        return Err(Failure::new(
            "the mesh has no texture coordinates to take seams from",
            "leave --seam uv out",
        ));
    };
    let uv = uvs::of_surface(repaired, set);
    let mesh = repaired.surface.mesh();
    let differs = |edge: &EdgeId| {
        let side = mesh.edge_halfedge(*edge);
        let twin = mesh.twin(side);
        twin.is_some_and(|twin| uv[side] != uv[twin.next()] || uv[side.next()] != uv[twin])
    };
    Ok(mesh.edges().filter(differs).collect())
}

fn to_report(atlas: &Atlas, part: &Part) -> Result<Value, Failure> {
    let area: f64 =
        graticule::geometry::total_area(&graticule::geometry::face_shapes(&part.surface));
    Ok(json!({
        "method": "injective",
        "vertices": atlas.places.len(),
        "islands": to_value(&atlas.islands)?,
        "seam": {
            "edges": atlas.seam.len(),
            "length": atlas.seam_length,
            "length_over_root_of_area": atlas.seam_length / area.sqrt(),
        },
    }))
}
