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
        "{}: {} flipped, {} degenerate",
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
    table.row("layout", island_text);
    let one_to_one = match (measure.bijective, measure.overlap.any) {
        (true, _) => "yes".to_owned(),
        (false, true) => {
            let share = 100.0 * measure.overlap.area_share;
            format!(
                "no: {} % of the area is covered more than once",
                figure(share)
            )
        }
        (false, false) => format!("no: {} folded vertices", islands.folded_vertices),
    };
    table.row("one to one", one_to_one);
    distortion_rows(&mut table, measure);
    table
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
