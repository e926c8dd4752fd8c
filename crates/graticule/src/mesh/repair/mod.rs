//! From a polygon soup to a sound surface, with an account of every change and a way back.
//!
//! The stages, each on the result of the one before:
//!
//! 1. [`prepare`]: set unusable polygons aside, weld, drop repeated corners and duplicates;
//! 2. [`Draft`]: cut the polygons into triangles;
//! 3. [`manifold`]: choose which faces hold together at crowded edges, give each fan its vertex
//!    (cutting as [Guéziec, Taubin, Lazarus, Horn 2001]);
//! 4. [`orient`]: orient each component, closed ones outward;
//! 5. [`cracks`]: cut triangles at vertices in the middle of their sides;
//! 6. [`degenerate`]: collapse, exchange or drop triangles without area;
//! 7. [`fins`]: on demand, drop small pieces that hung on others.

mod carry;
mod changes;
mod cracks;
mod degenerate;
mod draft;
mod duplicates;
mod error;
mod fins;
mod manifold;
mod nesting;
mod orient;
mod prepare;
mod weld;

use serde::Serialize;

pub use changes::RepairChanges;
pub use error::RepairError;

use self::draft::Draft;
use super::{PerCorner, PerFace, PerVertex, PolygonSoup, Surface, TriangleMesh};
use crate::watch::Watch;

/// How often triangles without area are looked for anew after others were removed. Twice is rare.
const DEGENERATE_ROUNDS: usize = 8;

/// Whether vertices at exactly the same position become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weld {
    /// Closes seams: pairs of boundary edges at the same place, with no other edge there. A pair
    /// is closed
    ///
    /// - if it joins different components, or lies in a component that other seams join to
    ///   others: triangles with vertices of their own, charts, the faces of a box;
    /// - if the corners on both sides have different texture coordinates in a file that keeps one
    ///   per vertex: then that is why the vertices were doubled.
    ///
    /// A seam of a component with itself alone is left open otherwise: the surface was cut there.
    /// Vertices that coincide elsewhere are left alone, so that nothing new hangs together at a
    /// point.
    #[default]
    Auto,
    /// All of them.
    Always,
    /// None.
    Never,
}

/// What to do with polygons that have a vertex with a position that is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NonFinite {
    /// Refuse the soup, naming the vertex.
    #[default]
    Refuse,
    /// Drop the polygons.
    DropPolygons,
}

/// What to do with pieces that cannot be oriented.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NonOrientable {
    /// Refuse the soup, naming an edge.
    #[default]
    Refuse,
    /// Cut them open along edges until they can be oriented.
    CutOpen,
}

/// What to do with small pieces that hang on a larger one by an edge with more than two faces, or by
/// a vertex, and that splitting it sets apart: scans have them by the thousand.
///
/// They stay in any case if they are more than a hundredth of the surface together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fins {
    /// Keep them as components.
    #[default]
    Keep,
    /// Drop those of less than this area.
    DropBelowArea(f64),
    /// Drop those of less than this share of the area of the whole surface.
    DropBelowShare(f64),
}

/// Choices where more than one answer is sound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RepairOptions {
    /// Whether vertices at exactly the same position become one.
    pub weld: Weld,
    /// Distance, in the unit of the positions, within which vertices of open edges become one too;
    /// 0 for none. Cracks up to this width close, and so do edges up to this length at them.
    pub weld_within: f64,
    /// What to do with polygons that have a vertex with a position that is not finite.
    pub non_finite: NonFinite,
    /// What to do with pieces that cannot be oriented.
    pub non_orientable: NonOrientable,
    /// What to do with small pieces that hang on others.
    pub fins: Fins,
}

/// A sound surface, what was changed to get it, and where its elements come from.
///
/// Vertices stand in the order of the soup vertices they come from, with copies made by splitting
/// after all others. Triangles stand in the order of their polygons.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaired {
    /// The surface.
    pub surface: Surface,
    /// The soup vertex of each vertex.
    pub vertex_sources: PerVertex<u32>,
    /// The soup corner of each corner.
    pub corner_sources: PerCorner<u32>,
    /// The soup polygon of each triangle.
    pub face_polygons: PerFace<u32>,
    /// What was changed.
    pub changes: RepairChanges,
    /// Soup corners that lost their triangle, each with one at the same vertex whose value it
    /// takes; in the order of the losses.
    stand_ins: Vec<[u32; 2]>,
}

/// Makes a sound, oriented, manifold surface of a polygon soup.
///
/// Fixes what has one sound answer, and says so in [`Repaired::changes`]:
///
/// - drops polygons with less than three corners, repeated corners and unused vertices;
/// - welds, see [`Weld`];
/// - drops all but one of several polygons over the same vertices; two that face opposite ways
///   both stay where they part two solids (a wall all of whose rim has other polygons in pairs), or
///   until crowded edges are parted where they are a flap folded out of a surface;
/// - cuts polygons into triangles, see [`triangulate_polygon`](super::triangulate_polygon);
/// - where more than two triangles share an edge, keeps those together that enclose a solid
///   between them, or in open components those that go on flattest, and splits the edge for the
///   others; splits vertices that join separate fans;
/// - orients each component consistently, turning as few triangles as possible; then closed
///   components outward. A closed component inside another is turned only together with the
///   outermost one around it, so that a cavity stays one;
/// - closes holes without width between the side of a triangle and vertices in its middle, by cutting
///   the triangle there;
/// - collapses edges without length, exchanges the long edge of triangles without area, and drops
///   such triangles at the boundary. None of it moves the surface or opens a hole;
/// - on demand, drops small pieces that hang on others, see [`Fins`].
///
/// Positions are not changed. Repairing the result again changes nothing, save that welding may
/// find seams that other repairs laid bare ([`Weld::Always`] joins even split vertices, and splits
/// them once more).
///
/// Cost: O(n log n) time, O(n) memory.
///
/// # Errors
/// [`RepairError`]: no usable polygon, an index out of range, positions that are not finite or all
/// the same, a piece that cannot be oriented; or the watch stopped it.
pub fn repair(
    soup: &PolygonSoup,
    options: &RepairOptions,
    watch: &Watch,
) -> Result<Repaired, RepairError> {
    let _stage = watch.stage("repair");
    let mut changes = RepairChanges::default();
    let usable = prepare::prepare(soup, *options, &mut changes)?;
    watch.check()?;
    let mut draft = Draft::of(soup, &usable, &mut changes, watch)?;
    if draft.triangles.len() > usable.polygon_sources.len() {
        // Polygons cut into triangles may share some.
        draft.drop_duplicates(&mut changes);
    }
    watch.check()?;
    let mut twins = manifold::make_manifold(&mut draft, &mut changes, watch)?;
    if !changes.edges_split.is_empty() && draft.drop_duplicates(&mut changes) {
        // A wall that was held to itself is a sheet given twice after all.
        twins = draft.twins();
    }
    watch.check()?;
    orient::orient(&mut draft, twins, *options, &mut changes)?;
    watch.check()?;
    for _ in 0..DEGENERATE_ROUNDS {
        // Either may leave work for the other: corners that meet close a hole to a crack.
        let closed = cracks::close_cracks(&mut draft, &mut changes);
        let removed = degenerate::remove_degenerate(&mut draft, &mut changes, watch)?;
        if removed {
            manifold::make_manifold(&mut draft, &mut changes, watch)?;
        }
        if !closed && !removed {
            break;
        }
    }
    let flat = degenerate::drop_flat_components(&mut draft, &mut changes);
    let fins = fins::drop_fins(&mut draft, options.fins, &mut changes);
    if flat || fins {
        // Takes their vertices out.
        manifold::make_manifold(&mut draft, &mut changes, watch)?;
    }
    watch.check()?;
    warn(&changes, watch);
    finish(draft, changes)
}

/// Warns of what was left as it is although another answer was possible.
fn warn(changes: &RepairChanges, watch: &Watch) {
    let seams = changes.seams_left_open.count();
    if seams > 0 {
        watch.warn(
            "seams-left-open",
            format!("pairs of boundary edges at the same places left open, as cuts: {seams}"),
        );
    }
    let flat = changes.zero_area_left.count();
    if flat > 0 {
        watch.warn(
            "zero-area-left",
            format!(
                "triangles without area that cannot be removed without changing the topology: {flat}"
            ),
        );
    }
}

fn finish(draft: Draft, mut changes: RepairChanges) -> Result<Repaired, RepairError> {
    if draft.triangles.is_empty() {
        return Err(RepairError::NothingLeft);
    }
    changes.vertices_split = repeated(&draft.vertex_sources).into();
    let mesh = TriangleMesh::new(draft.positions.len(), &draft.triangles)?;
    Ok(Repaired {
        surface: Surface::new(mesh, PerVertex::new(draft.positions))?,
        vertex_sources: PerVertex::new(draft.vertex_sources),
        corner_sources: PerCorner::new(draft.corner_sources.into_flattened()),
        face_polygons: PerFace::new(draft.polygons),
        changes,
        stand_ins: draft.stand_ins,
    })
}

/// The values that occur more than once, in ascending order.
fn repeated(values: &[u32]) -> Vec<u32> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    let equal = sorted.chunk_by(|a, b| a == b);
    equal
        .filter(|run| run.len() > 1)
        .map(|run| run[0])
        .collect()
}

#[cfg(test)]
mod tests;
