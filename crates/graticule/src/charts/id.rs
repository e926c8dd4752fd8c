use std::fmt;

use crate::mesh::{Element, element_id};

element_id!(
    /// A chart of a [`ChartLayout`](super::ChartLayout).
    ChartId,
    "chart"
);
element_id!(
    /// An arc of a [`ChartLayout`](super::ChartLayout).
    ArcId,
    "arc"
);
element_id!(
    /// A square of [`ChartMaps`](super::ChartMaps): a chart, or a part of one.
    SquareId,
    "square"
);
