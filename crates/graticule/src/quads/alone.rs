//! Nets of their own for components that the net of the whole surface left with inverted quads.
//!
//! Components have nothing in common but the way in which whole numbers are settled and features are
//! let go: where one leaves the net no room, others suffer with it.

use super::PolygonMesh;
use super::debris::{is_told_by_places, options_for};
use super::remesh::{RemeshError, RemeshOptions, remesh_whole};
use super::small_components::{kept, states};
use crate::mesh::{
    ComponentId, Components, Element, FaceId, PerComponent, Surface, Topology, submesh_of,
};
use crate::tolerance::SMALL_COMPONENT;
use crate::watch::Watch;

/// Components with more than this part of all triangles are not tried: alone they would fare no better.
const LARGEST_PART: usize = 2;

/// Gives components with inverted quads, or with two on the same vertices, a net of their own where that
/// has neither; returns their number, which is a warning.
///
/// `options` has the features as edges, and the density as a length. Cost: less than that of the net
/// of the whole.
///
/// # Errors
/// [`RemeshError::Stopped`].
pub(super) fn remesh_alone(
    mesh: &mut PolygonMesh,
    surface: &Surface,
    options: &RemeshOptions,
    watch: &Watch,
) -> Result<usize, RemeshError> {
    let topology = Topology::of(surface.mesh());
    let count = topology.components.len();
    if count == 1 || is_told_by_places(options) {
        return Ok(0);
    }
    let component_of = |polygon: usize| {
        let vertex = mesh.polygons.vertices(polygon)[0];
        topology.face_components[mesh.origins[vertex as usize].face]
    };
    let states = states(mesh, component_of, count);
    let components = Components::new(surface, &topology);
    let sizes = SMALL_COMPONENT + 1..=surface.mesh().face_count() / LARGEST_PART;
    let mut is_replaced = PerComponent::filled(count, false);
    let mut parts = Vec::new();
    for component in (0..count).map(ComponentId::from_index) {
        let faces = components.faces(component);
        if states[component].is_crumpled()
            && sizes.contains(&faces.len())
            && let Some(part) = net_alone(surface, faces, options, watch)?
        {
            is_replaced[component] = true;
            parts.push(part);
        }
    }
    if parts.is_empty() {
        return Ok(0);
    }
    let mut whole = kept(mesh, |polygon| !is_replaced[component_of(polygon)]);
    for part in &parts {
        append(&mut whole, part);
    }
    whole.feature_edges.sort_unstable();
    *mesh = whole;
    let message = format!(
        "{} components with inverted quads in the net of the whole have one of their own",
        parts.len()
    );
    watch.warn("remeshed-alone", message);
    Ok(parts.len())
}

/// The net of a component by itself, if no quad of it is inverted.
fn net_alone(
    surface: &Surface,
    faces: &[FaceId],
    options: &RemeshOptions,
    watch: &Watch,
) -> Result<Option<PolygonMesh>, RemeshError> {
    let Ok(part) = submesh_of(surface, faces.to_vec()) else {
        return Ok(None);
    };
    let options = options_for(&part, surface, options);
    // What it warns of is known of the whole.
    let made = remesh_whole(
        &part.surface,
        &options,
        &[options.density],
        &watch.quiet_part(),
    );
    watch.check()?;
    let made = made.ok().and_then(|levels| levels.into_iter().next());
    let Some(mut mesh) = made.map(|made| made.mesh) else {
        return Ok(None);
    };
    let state = states(&mesh, |_| ComponentId::from_index(0), 1)[ComponentId::from_index(0)];
    if state.is_crumpled() || mesh.check(&part.surface).is_err() {
        return Ok(None);
    }
    for origin in &mut mesh.origins {
        origin.face = part.face_sources[origin.face];
    }
    Ok(Some(mesh))
}

/// Adds the polygons of another component.
fn append(mesh: &mut PolygonMesh, part: &PolygonMesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&part.positions);
    mesh.origins.extend(&part.origins);
    for polygon in 0..part.polygons.len() {
        let vertices = part.polygons.vertices(polygon).iter();
        let vertices: Vec<u32> = vertices.map(|vertex| first + vertex).collect();
        mesh.polygons.push(&vertices);
    }
    let edges = part.feature_edges.iter();
    mesh.feature_edges
        .extend(edges.map(|edge| edge.map(|vertex| first + vertex)));
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use graticule_fixtures::icosphere;

    use super::*;
    use crate::measure::scaled_jacobian;
    use crate::mesh::Polygons;
    use crate::periodic::GridDensity;
    use crate::quads::remesh;

    fn least(mesh: &PolygonMesh) -> f64 {
        let quads = (0..mesh.polygons.len()).map(|polygon| {
            let quad = <[u32; 4]>::try_from(mesh.polygons.vertices(polygon)).unwrap();
            scaled_jacobian(quad.map(|v| mesh.positions[v as usize]))
        });
        quads.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_component_with_inverted_quads_gets_a_net_of_its_own_and_the_others_stay() {
        let balls = icosphere(4).joined(&icosphere(3).map(|p: DVec3| p * 0.7 + DVec3::X * 3.0));
        let surface = Surface::from_triangles(balls.positions, &balls.triangles).unwrap();
        let watch = Watch::new();
        let mut options = RemeshOptions {
            density: GridDensity::Quads(400),
            ..RemeshOptions::default()
        };
        let made = remesh(&surface, &options, &watch).unwrap();
        options.density = GridDensity::EdgeLength(made.report.map.edge_length);
        let sound = made.mesh;
        assert!(least(&sound) > 0.0);
        let mut mesh = sound.clone();
        assert_eq!(
            remesh_alone(&mut mesh, &surface, &options, &watch).unwrap(),
            0
        );
        assert_eq!(mesh, sound);

        // A vertex of the smaller ball goes over to its other side.
        let is_small = |vertex: usize| sound.positions[vertex].x > 1.5;
        let small: Vec<usize> = (0..sound.positions.len())
            .filter(|&v| is_small(v))
            .collect();
        let far = |v: &usize| sound.positions[*v].distance(sound.positions[small[0]]);
        let across = (small.iter()).max_by(|a, b| far(a).total_cmp(&far(b)));
        let across = *across.unwrap();
        mesh.origins[small[0]] = sound.origins[across];
        mesh.positions[small[0]] = sound.positions[across];
        assert!(least(&mesh) <= 0.0);
        assert_eq!(
            remesh_alone(&mut mesh, &surface, &options, &watch).unwrap(),
            1
        );
        assert!(least(&mesh) > 0.0);
        mesh.check(&surface).unwrap();
        let polygons = |mesh: &PolygonMesh| -> Polygons {
            let all = (0..mesh.polygons.len()).map(|polygon| mesh.polygons.vertices(polygon));
            let is_large = |vertices: &&[u32]| mesh.positions[vertices[0] as usize].x < 1.5;
            all.filter(is_large).collect()
        };
        let corners = |mesh: &PolygonMesh| -> Vec<DVec3> {
            let polygons = polygons(mesh);
            let all = (0..polygons.len()).flat_map(|polygon| polygons.vertices(polygon).to_vec());
            all.map(|vertex| mesh.positions[vertex as usize]).collect()
        };
        assert_eq!(corners(&mesh), corners(&sound));
        let is_told = |warning: &crate::watch::Warning| warning.code == "remeshed-alone";
        assert!(watch.warnings().iter().any(is_told));
    }
}
