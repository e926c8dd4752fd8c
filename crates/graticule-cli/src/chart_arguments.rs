//! Options of commands whose charts have a size.

use clap::Args;
use graticule::periodic::ChartSize;
use serde::Serialize;

use crate::field_arguments::parse_number;

/// How large charts are.
#[derive(Args, Clone, Copy, Debug, Serialize)]
pub(crate) struct ChartArguments {
    /// Side of a chart in mean edge lengths
    #[arg(long, value_name = "N", default_value_t = 10.0, value_parser = parse_positive)]
    chart_size: f64,
    /// Side of a chart in the unit of the mesh
    #[arg(long, value_name = "LENGTH", value_parser = parse_positive, conflicts_with = "chart_size")]
    chart_length: Option<f64>,
    /// About how many charts to make
    #[arg(long, value_name = "N", value_parser = parse_positive,
        conflicts_with_all = ["chart_size", "chart_length"])]
    chart_count: Option<f64>,
}

impl ChartArguments {
    /// The library's option.
    pub(crate) fn chart_size(&self) -> ChartSize {
        match (self.chart_length, self.chart_count) {
            (Some(length), _) => ChartSize::Length(length),
            (None, Some(count)) => ChartSize::Count(count),
            (None, None) => ChartSize::MeanEdges(self.chart_size),
        }
    }
}

fn parse_positive(text: &str) -> Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x.is_finite(), "above 0, finite")
}
