use std::collections::HashMap;

use graticule::mesh::{NO_VALUE, PolygonLabels};

/// Names that hold from one statement to the next, for all polygons in between.
#[derive(Default)]
pub(crate) struct LabelRuns {
    /// First polygon and name, where the name changes; `None` where polygons have no name.
    runs: Vec<(usize, Option<String>)>,
}

impl LabelRuns {
    /// From polygon `polygon` on, `name` holds; the empty name is none.
    pub(crate) fn begin(&mut self, polygon: usize, name: String) {
        if self.runs.last().is_some_and(|(start, _)| *start == polygon) {
            self.runs.pop();
        }
        let name = (!name.is_empty()).then_some(name);
        self.runs.push((polygon, name));
    }

    /// The labels of `polygons` polygons, or `None` if none has a name.
    pub(crate) fn finish(self, polygons: usize) -> Option<PolygonLabels> {
        let mut labels = PolygonLabels::default();
        let mut numbers: HashMap<String, u32> = HashMap::new();
        let mut number = NO_VALUE;
        for (start, name) in self.runs {
            if start == polygons {
                break;
            }
            labels.polygon_names.resize(start, number);
            number = name.map_or(NO_VALUE, |name| {
                *numbers.entry(name).or_insert_with_key(|name| {
                    labels.names.push(name.clone());
                    labels.names.len() as u32 - 1
                })
            });
        }
        labels.polygon_names.resize(polygons, number);
        (!labels.names.is_empty()).then_some(labels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_numbered_by_their_first_polygon() {
        let mut runs = LabelRuns::default();
        let statements = [
            (0, "unused"),
            (0, "b"),
            (2, ""),
            (3, "a"),
            (4, "b"),
            (6, "end"),
        ];
        for (polygon, name) in statements {
            runs.begin(polygon, name.to_owned());
        }
        let labels = runs.finish(6).unwrap();
        assert_eq!(labels.names, ["b", "a"]);
        assert_eq!(labels.polygon_names, [0, 0, NO_VALUE, 1, 0, 0]);
    }

    #[test]
    fn names_without_polygons_are_nothing() {
        let mut runs = LabelRuns::default();
        runs.begin(3, "late".to_owned());
        assert_eq!(runs.finish(3), None);
    }
}
