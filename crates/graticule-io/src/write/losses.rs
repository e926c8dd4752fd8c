use glam::DVec3;
use graticule::mesh::{Attributes, PolygonSoup};
use graticule::watch::Warning;

use super::{fits_single, per_vertex};
use crate::Format;

/// Collects what a format could not hold.
pub(crate) struct Losses {
    format: Format,
    warnings: Vec<Warning>,
}

impl Losses {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            warnings: Vec::new(),
        }
    }

    pub(super) fn finish(self) -> Vec<Warning> {
        self.warnings
    }

    pub(crate) fn warn(&mut self, code: &'static str, message: impl Into<String>) {
        let message = message.into();
        self.warnings.push(Warning { code, message });
    }

    /// `what` is there, and the format cannot hold it.
    pub(crate) fn lose(&mut self, what: &str, there: bool) {
        if there {
            let format = self.format;
            self.warn("not-kept", format!("{format} cannot hold {what}: left out"));
        }
    }

    /// Names of every kind.
    pub(crate) fn lose_names(&mut self, attributes: &Attributes) {
        self.lose("objects", attributes.objects.is_some());
        self.lose("materials", attributes.materials.is_some());
        self.lose_groups(attributes);
    }

    /// Names that only OBJ has.
    pub(crate) fn lose_groups(&mut self, attributes: &Attributes) {
        self.lose("groups", attributes.groups.is_some());
        self.lose("smoothing groups", attributes.smoothing_groups.is_some());
        self.lose(
            "material libraries",
            !attributes.material_libraries.is_empty(),
        );
    }

    /// All texture coordinate sets from number `kept` on.
    pub(crate) fn lose_uv_sets(&mut self, attributes: &Attributes, kept: usize) {
        let lost = attributes.uv_sets.len().saturating_sub(kept);
        self.lose(
            &format!("{lost} more sets of texture coordinates"),
            lost > 0,
        );
    }

    /// What triangles in single precision cannot show of a mesh.
    pub(crate) fn lose_shape(&mut self, soup: &PolygonSoup) {
        let polygons = soup
            .polygons
            .iter()
            .filter(|corners| corners.len() > 3)
            .count();
        if polygons > 0 {
            self.warn(
                "polygons-triangulated",
                format!("{polygons} polygons were cut into triangles"),
            );
        }
        if !soup
            .positions
            .iter()
            .all(|position| fits_single(&position.to_array()))
        {
            self.warn(
                "positions-rounded",
                "positions were rounded to single precision",
            );
        }
    }

    /// Vertices that no polygon has, where only polygons are written.
    pub(crate) fn lose_unused_vertices(&mut self, soup: &PolygonSoup, used: &[bool]) {
        let unused = soup.positions.len() - used.iter().filter(|&&used| used).count();
        self.lose(&format!("{unused} vertices without faces"), unused > 0);
    }
}

/// The normals, if each vertex has one; told as a loss where they differ between its corners.
pub(crate) fn vertex_normals(soup: &PolygonSoup, losses: &mut Losses) -> Option<Vec<DVec3>> {
    let set = soup.attributes.normals.as_ref()?;
    let normals = per_vertex(set, soup);
    losses.lose(
        "normals that differ between the corners of a vertex",
        normals.is_none(),
    );
    normals
}
