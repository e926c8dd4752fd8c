//! Figures as lines of text.

use std::fmt::Write;

use graticule::measure::MapMeasure;

/// Rows of a name and a text, names aligned.
pub(crate) struct Table {
    rows: Vec<(String, String)>,
}

impl Table {
    pub(crate) fn new() -> Self {
        Self { rows: Vec::new() }
    }

    pub(crate) fn row(&mut self, name: &str, text: impl Into<String>) {
        self.rows.push((name.into(), text.into()));
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let widths = self.rows.iter().map(|(name, _)| name.chars().count());
        let width = widths.max().unwrap_or(0);
        for (name, text) in &self.rows {
            writeln!(formatter, "  {name:width$}  {text}")?;
        }
        Ok(())
    }
}

/// A count with its noun.
pub(crate) fn counted(count: usize, singular: &str, plural: &str) -> String {
    match count {
        1 => format!("1 {singular}"),
        _ => format!("{count} {plural}"),
    }
}

/// A figure with four digits.
pub(crate) fn figure(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e6).contains(&magnitude) {
        let digits = (3 - libm::floor(libm::log10(magnitude)) as i64).clamp(0, 6);
        format!("{value:.*}", usize::try_from(digits).unwrap_or_default())
    } else {
        format!("{value:.3e}")
    }
}

/// What is worth knowing of a map at a glance.
pub(crate) fn measure_table(measure: &MapMeasure) -> Table {
    let mut table = Table::new();
    let faces = &measure.faces;
    let mut triangles = format!(
        "{}: {} flipped, {} with next to no area",
        faces.total, faces.flipped, faces.degenerate
    );
    for (count, what) in [
        (faces.without_uv, "without coordinates"),
        (faces.non_finite_uv, "with coordinates that are not finite"),
        (faces.flat_in_space, "flat in space"),
    ] {
        if count > 0 {
            let _ = write!(triangles, ", {count} {what}");
        }
    }
    table.row("triangles", triangles);
    let islands = &measure.islands;
    let mut island_text = counted(islands.count, "island", "islands");
    let loops = counted(islands.boundary_loops, "boundary loop", "boundary loops");
    let _ = write!(island_text, ", {loops}");
    if islands.mirrored > 0 {
        let _ = write!(island_text, ", {} mirrored", islands.mirrored);
    }
    table.row("layout", island_text);
    table.row("one to one", one_to_one(measure));
    distortion_rows(&mut table, measure);
    table
}

/// Whether the map is one to one, or every reason why it is not.
fn one_to_one(measure: &MapMeasure) -> String {
    if measure.bijective {
        return "yes".into();
    }
    let mut reasons = Vec::new();
    let (faces, overlap) = (&measure.faces, &measure.overlap);
    for (count, singular, plural) in [
        (faces.flipped, "flipped triangle", "flipped triangles"),
        (
            faces.zero_uv_area,
            "triangle without area",
            "triangles without area",
        ),
        (
            faces.without_uv,
            "triangle without coordinates",
            "triangles without coordinates",
        ),
        (
            faces.non_finite_uv,
            "triangle with infinite coordinates",
            "triangles with infinite coordinates",
        ),
        (
            measure.islands.folded_vertices,
            "folded vertex",
            "folded vertices",
        ),
    ] {
        if count > 0 {
            reasons.push(counted(count, singular, plural));
        }
    }
    if overlap.any && overlap.area_share > 0.0 {
        let share = figure(100.0 * overlap.area_share);
        reasons.push(format!("{share} % of the area is covered more than once"));
    } else if overlap.any {
        reasons.push("triangles overlap, on too little area to be seen".into());
    }
    format!("no: {}", reasons.join(", "))
}

fn distortion_rows(table: &mut Table, measure: &MapMeasure) {
    let Some(distortion) = &measure.distortion else {
        table.row("distortion", "no triangle can be measured");
        return;
    };
    let qc = &distortion.quasi_conformal_error;
    let row = format!(
        "mean {}, 95 % {}, 99 % {}, largest {}   (conformal: 1)",
        figure(qc.mean),
        figure(qc.p95),
        figure(qc.p99),
        figure(qc.max)
    );
    table.row("quasi-conformal error", row);
    let area = &distortion.area_scale;
    let row = format!(
        "mean |log| {}, from {} to {}   (equiareal: 0, 1, 1)",
        figure(area.log_mean),
        figure(area.min),
        figure(area.max)
    );
    table.row("area scale", row);
    let row = format!(
        "L2 {}, L∞ {}   (isometric: 1)",
        figure(distortion.l2_stretch),
        figure(distortion.linf_stretch)
    );
    table.row("stretch", row);
    let row = format!("{}   (orthogonal: 0)", figure(distortion.shear_mean));
    table.row("shear", row);
    if let Some(energy) = distortion.symmetric_dirichlet {
        let row = format!("{}   (isometric: 4)", figure(energy));
        table.row("symmetric Dirichlet", row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits_whatever_their_size() {
        let shown: Vec<_> = [1.0, 0.012_345, 1234.5, 99_999.4, 1.5e9, -2e-7, 0.0]
            .map(figure)
            .into();
        let expected = [
            "1.000",
            "0.01235",
            "1234",
            "99999",
            "1.500e9",
            "-2.000e-7",
            "0",
        ];
        assert_eq!(shown, expected);
    }
}
