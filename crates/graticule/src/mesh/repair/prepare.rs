use glam::DVec3;

use super::{NonFinite, RepairChanges, RepairError, RepairOptions, weld};
use crate::mesh::PolygonSoup;
use crate::mesh::faces::{Faces, PolygonFaces};
use crate::mesh::usable::UsablePolygons;

/// Sets aside what cannot be used, refuses what must not be, welds.
pub(super) fn prepare(
    soup: &PolygonSoup,
    options: RepairOptions,
    changes: &mut RepairChanges,
) -> Result<UsablePolygons, RepairError> {
    if soup.polygons.is_empty() {
        let vertices = soup.positions.len();
        return Err(RepairError::NoFaces { vertices });
    }
    let mut names: Vec<u32> = (0..soup.positions.len() as u32).collect();
    let mut usable = UsablePolygons::of(soup, &names);
    refuse_bad_corners(soup, &usable, options)?;
    check_extent(soup, &usable.faces)?;
    if weld::weld(soup, &usable, options.weld, &mut names, changes) {
        usable = UsablePolygons::of(soup, &names);
    }
    if weld::join_nearby(soup, &usable, options.weld_within, &mut names, changes) {
        usable = UsablePolygons::of(soup, &names);
    }
    if usable.polygon_sources.is_empty() {
        let polygons = soup.polygons.len();
        return Err(RepairError::NoUsableFaces { polygons });
    }
    record(soup, &usable, &names, changes);
    Ok(usable)
}

fn refuse_bad_corners(
    soup: &PolygonSoup,
    usable: &UsablePolygons,
    options: RepairOptions,
) -> Result<(), RepairError> {
    let vertices = soup.positions.len();
    let position = |vertex: u32| soup.positions.get(vertex as usize);
    let first_bad = |polygons: &[u32], is_bad: &dyn Fn(u32) -> bool| {
        let &polygon = polygons.first()?;
        let corners = soup.polygons.vertices(polygon as usize);
        let &vertex = corners.iter().find(|&&vertex| is_bad(vertex))?;
        Some((polygon, vertex))
    };
    if let Some((polygon, index)) = first_bad(&usable.out_of_range, &|v| position(v).is_none()) {
        return Err(RepairError::IndexOutOfRange {
            polygon,
            index,
            vertices,
        });
    }
    let not_finite = |vertex: u32| position(vertex).is_some_and(|position| !position.is_finite());
    match first_bad(&usable.non_finite, &not_finite) {
        Some((polygon, vertex)) if options.non_finite == NonFinite::Refuse => {
            Err(RepairError::NonFinitePosition {
                vertex,
                position: soup.positions[vertex as usize].to_array(),
                polygon,
            })
        }
        _ => Ok(()),
    }
}

fn check_extent(soup: &PolygonSoup, faces: &PolygonFaces) -> Result<(), RepairError> {
    let vertices = (0..faces.corner_count() as u32).map(|corner| faces.origin(corner));
    let magnitude = |vertex: u32| soup.positions[vertex as usize].abs().max_element();
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for vertex in vertices.clone() {
        let position = soup.positions[vertex as usize];
        [low, high] = [low.min(position), high.max(position)];
    }
    let extent = (high - low).max_element();
    if extent == 0.0 {
        return Err(RepairError::ZeroExtent);
    }
    if extent < f64::INFINITY {
        return Ok(());
    }
    let farthest = vertices.max_by(|&a, &b| magnitude(a).total_cmp(&magnitude(b)).then(b.cmp(&a)));
    farthest.map_or(Ok(()), |vertex| {
        let coordinate = magnitude(vertex);
        Err(RepairError::ExtentOverflow { vertex, coordinate })
    })
}

fn record(soup: &PolygonSoup, usable: &UsablePolygons, names: &[u32], changes: &mut RepairChanges) {
    let mut used = vec![false; names.len()];
    for corner in 0..usable.faces.corner_count() as u32 {
        used[usable.faces.origin(corner) as usize] = true;
    }
    let numbered = (0_u32..).zip(names);
    changes.unused_vertices_dropped = numbered
        .filter(|&(vertex, &name)| !used[vertex as usize] && vertex == name)
        .map(|(vertex, _)| vertex)
        .collect();
    let mut collapsed = [&usable.too_few_corners[..], &usable.collapsed].concat();
    collapsed.sort_unstable();
    let survives = |polygon: &u32| collapsed.binary_search(polygon).is_err();
    let repeated = usable.repeated.iter().copied();
    changes.repeated_corners_dropped = repeated.filter(survives).collect();
    changes.collapsed_polygons_dropped = collapsed.into();
    changes.non_finite_polygons_dropped = usable.non_finite.clone().into();
    let sizes = (0..usable.faces.face_count() as u32).map(|face| usable.faces.corners(face).len());
    changes.polygons_triangulated = sizes.filter(|&size| size > 3).count();
    debug_assert!(soup.polygons.len() >= usable.polygon_sources.len());
}
