use std::collections::BTreeSet;

use glam::{DMat4, DQuat, DVec3};
use gltf::json::scene::Node;
use gltf::json::{Index, Root};

use crate::Format;
use crate::error::{Place, Problem, ReadError};

/// A mesh where a node puts it.
pub(super) struct Instance {
    pub(super) mesh: usize,
    pub(super) name: String,
    pub(super) transform: DMat4,
    /// Whether a skin moves the mesh.
    pub(super) skinned: bool,
}

/// All meshes of the scene to be shown, in the order of a walk from the root; if the file has no
/// node at all, each mesh once as it is.
pub(super) fn instances(root: &Root) -> Result<Vec<Instance>, ReadError> {
    if root.nodes.is_empty() {
        let meshes = root.meshes.iter().enumerate();
        let as_it_is = meshes.map(|(mesh, content)| Instance {
            mesh,
            name: content.name.clone().unwrap_or_default(),
            transform: DMat4::IDENTITY,
            skinned: false,
        });
        return Ok(as_it_is.collect());
    }
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> = Vec::new();
    let mut found = Vec::new();
    for start in roots(root)? {
        stack.push((start, DMat4::IDENTITY));
        while let Some((index, parent)) = stack.pop() {
            let node = node(root, index)?;
            if std::mem::replace(&mut visited[index], true) {
                return Err(malformed(index, Problem::NodeCycle));
            }
            let transform = parent * local_transform(node);
            if let Some(mesh) = node.mesh {
                found.push(instance(root, node, mesh.value(), transform, index)?);
            }
            let children = node.children.iter().flatten().rev();
            stack.extend(children.map(|child| (child.value(), transform)));
        }
    }
    Ok(found)
}

fn malformed(node: usize, problem: Problem) -> ReadError {
    ReadError::malformed(Format::Gltf, Place::element("node", node), problem)
}

fn node(root: &Root, index: usize) -> Result<&Node, ReadError> {
    root.nodes.get(index).ok_or_else(|| {
        let problem = Problem::MissingObject {
            kind: "node",
            index,
            count: root.nodes.len(),
        };
        malformed(index, problem)
    })
}

fn instance(
    root: &Root,
    node: &Node,
    mesh: usize,
    transform: DMat4,
    index: usize,
) -> Result<Instance, ReadError> {
    let Some(content) = root.meshes.get(mesh) else {
        let problem = Problem::MissingObject {
            kind: "mesh",
            index: mesh,
            count: root.meshes.len(),
        };
        return Err(malformed(index, problem));
    };
    let name = node.name.as_ref().or(content.name.as_ref());
    Ok(Instance {
        mesh,
        name: name.cloned().unwrap_or_default(),
        transform,
        skinned: node.skin.is_some(),
    })
}

/// The nodes of the default scene, or of the first one, or those that are no one's child.
fn roots(root: &Root) -> Result<Vec<usize>, ReadError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(index) {
        return Ok(scene.nodes.iter().map(Index::value).collect());
    }
    if root.scene.is_some() {
        let problem = Problem::MissingObject {
            kind: "scene",
            index,
            count: root.scenes.len(),
        };
        return Err(ReadError::malformed(Format::Gltf, Place::Header, problem));
    }
    let children: BTreeSet<usize> = root
        .nodes
        .iter()
        .flat_map(|node| node.children.iter().flatten())
        .map(Index::value)
        .collect();
    Ok((0..root.nodes.len())
        .filter(|node| !children.contains(node))
        .collect())
}

fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |value: Option<[f32; 3]>, default| {
        value.map_or(default, |value| DVec3::from_array(value.map(f64::from)))
    };
    // Unit quaternions by the rules; rounding and exporters' slips scale them.
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| {
        let rotation = DQuat::from_array(rotation.0.map(f64::from));
        if rotation.length_squared() > 0.0 {
            rotation.normalize()
        } else {
            DQuat::IDENTITY
        }
    });
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
