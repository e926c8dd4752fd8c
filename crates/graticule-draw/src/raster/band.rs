use super::shade::Shader;
use super::{SAMPLES, STEPS, Vertex};

/// Which of two triangles is seen where they cover the same sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// The nearer one; of equally near ones the first.
    NearestOnTop,
    /// The last one.
    LastOnTop,
}

/// No triangle covers the sample.
const NOTHING: u32 = u32::MAX;

/// Rows up to this many samples wide are tested sample by sample; in wider ones the two ends of
/// the covered span are computed, which costs three divisions.
const NARROW: i64 = 8;

/// Pixel rows of the image, sample by sample, while they are filled.
pub(super) struct Band {
    pixel_columns: u32,
    pixel_rows: u32,
    first_sample_row: i32,
    depths: Vec<f32>,
    ids: Vec<u32>,
}

/// One side of a triangle: positive inside.
#[derive(Clone, Copy)]
struct Side {
    /// Value at the first sample of the row under consideration; at least 0 for covered samples.
    value: i64,
    step_right: i64,
    step_down: i64,
}

impl Side {
    /// The side from `a` to `b`, evaluated at the middle of the sample in this column and row. A
    /// sample exactly on a side belongs to the triangle if it is a left or a top side, hence to
    /// one of two neighbours.
    fn new(a: Vertex, b: Vertex, column: i32, row: i32) -> Self {
        let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
        let middle = |index: i32| i64::from(index) * i64::from(STEPS) + i64::from(STEPS / 2);
        let value = dx * (middle(row) - i64::from(a.y)) - dy * (middle(column) - i64::from(a.x));
        let owns_its_samples = dy < 0 || (dy == 0 && dx > 0);
        Self {
            value: if owns_its_samples { value } else { value - 1 },
            step_right: -dy * i64::from(STEPS),
            step_down: dx * i64::from(STEPS),
        }
    }

    /// Narrows the span `first..last` of columns, counted from where `value` holds, to where the
    /// side is not negative.
    fn narrow(&self, span: &mut [i64; 2]) {
        match self.step_right {
            0 if self.value < 0 => span[1] = span[0],
            0 => {}
            step if step > 0 => span[0] = span[0].max(-self.value.div_euclid(step)),
            step => span[1] = span[1].min(self.value.div_euclid(-step) + 1),
        }
    }
}

/// Depth over the image of a triangle.
struct Depth {
    at_first_sample: f64,
    step_right: f64,
    step_down: f64,
    range: [f32; 2],
}

impl Depth {
    fn new([a, b, c]: [Vertex; 3], doubled_area: i64, column: i32, row: i32) -> Self {
        let [ab_x, ab_y] = [f64::from(b.x - a.x), f64::from(b.y - a.y)];
        let [ac_x, ac_y] = [f64::from(c.x - a.x), f64::from(c.y - a.y)];
        let (ab, ac) = (f64::from(b.depth - a.depth), f64::from(c.depth - a.depth));
        let area = doubled_area as f64;
        let slope_x = (ab * ac_y - ac * ab_y) / area;
        let slope_y = (ac * ab_x - ab * ac_x) / area;
        let steps = f64::from(STEPS);
        let middle = |index: i32| (f64::from(index) + 0.5) * steps;
        let [x, y] = [
            middle(column) - f64::from(a.x),
            middle(row) - f64::from(a.y),
        ];
        Self {
            at_first_sample: f64::from(a.depth) + slope_x * x + slope_y * y,
            step_right: slope_x * steps,
            step_down: slope_y * steps,
            range: [
                a.depth.min(b.depth).min(c.depth),
                a.depth.max(b.depth).max(c.depth),
            ],
        }
    }

    /// Clamped, because the slope of a triangle seen edge-on exaggerates rounding.
    fn at(&self, right: i64, down: i64) -> f32 {
        let depth =
            self.at_first_sample + self.step_right * right as f64 + self.step_down * down as f64;
        (depth as f32).clamp(self.range[0], self.range[1])
    }
}

impl Band {
    pub(super) fn new(pixel_columns: u32) -> Self {
        Self {
            pixel_columns,
            pixel_rows: 0,
            first_sample_row: 0,
            depths: Vec::new(),
            ids: Vec::new(),
        }
    }

    /// Empties the band and moves it to other pixel rows.
    pub(super) fn begin(&mut self, first_pixel_row: u32, pixel_rows: u32) {
        self.pixel_rows = pixel_rows;
        self.first_sample_row = first_pixel_row as i32 * SAMPLES;
        let samples = self.sample_columns() as usize * self.sample_rows() as usize;
        self.depths.clear();
        self.depths.resize(samples, f32::NEG_INFINITY);
        self.ids.clear();
        self.ids.resize(samples, NOTHING);
    }

    fn sample_columns(&self) -> i32 {
        self.pixel_columns as i32 * SAMPLES
    }

    fn sample_rows(&self) -> i32 {
        self.pixel_rows as i32 * SAMPLES
    }

    /// Draws triangle number `id` into the samples that it covers.
    pub(super) fn fill(&mut self, id: u32, corners: [Vertex; 3], order: Order) {
        let [a, mut b, mut c] = corners;
        let mut doubled_area = i64::from(b.x - a.x) * i64::from(c.y - a.y)
            - i64::from(b.y - a.y) * i64::from(c.x - a.x);
        if doubled_area < 0 {
            (b, c, doubled_area) = (c, b, -doubled_area);
        }
        let columns = covered(a.x, b.x, c.x, 0, self.sample_columns());
        let first_row = self.first_sample_row;
        let rows = covered(a.y, b.y, c.y, first_row, first_row + self.sample_rows());
        if doubled_area == 0 || columns.is_empty() || rows.is_empty() {
            return;
        }
        let side = |from, to| Side::new(from, to, columns.start, rows.start);
        let mut sides = [side(a, b), side(b, c), side(c, a)];
        let depth = Depth::new([a, b, c], doubled_area, columns.start, rows.start);
        let width = columns.len() as i64;
        for down in 0..rows.len() as i64 {
            let row = i64::from(rows.start - first_row) + down;
            let start = row * i64::from(self.sample_columns()) + i64::from(columns.start);
            let mut span = [0, width];
            if width > NARROW {
                for side in &sides {
                    side.narrow(&mut span);
                }
            }
            for right in span[0]..span[1] {
                let is_outside = |side: &Side| side.value + side.step_right * right < 0;
                if width <= NARROW && sides.iter().any(is_outside) {
                    continue;
                }
                self.cover((start + right) as usize, depth.at(right, down), id, order);
            }
            for side in &mut sides {
                side.value += side.step_down;
            }
        }
    }

    #[inline]
    fn cover(&mut self, sample: usize, depth: f32, id: u32, order: Order) {
        if order == Order::LastOnTop || depth > self.depths[sample] {
            self.depths[sample] = depth;
            self.ids[sample] = id;
        }
    }

    /// The colours of the pixels, multiplied by their opacity, and the depths in their middles.
    pub(super) fn resolve(&self, shader: &Shader<'_>) -> (Vec<[u8; 4]>, Vec<f32>) {
        let pixels = (self.pixel_columns * self.pixel_rows) as usize;
        let mut colors = Vec::with_capacity(pixels);
        let mut depths = Vec::with_capacity(pixels);
        for row in 0..self.pixel_rows as i32 {
            for column in 0..self.pixel_columns as i32 {
                colors.push(self.pixel(column, row, shader));
                let middle = SAMPLES / 2;
                let sample = self.sample(column * SAMPLES + middle, row * SAMPLES + middle);
                depths.push(self.depths[sample]);
            }
        }
        (colors, depths)
    }

    fn sample(&self, column: i32, row: i32) -> usize {
        (row * self.sample_columns() + column) as usize
    }

    fn is_empty(&self, column: i32, row: i32) -> bool {
        (row * SAMPLES..(row + 1) * SAMPLES).all(|y| {
            let first = self.sample(column * SAMPLES, y);
            let line = &self.ids[first..first + SAMPLES as usize];
            line.iter().all(|&id| id == NOTHING)
        })
    }

    /// Each triangle seen in the pixel is shaded once, in the middle of its samples.
    fn pixel(&self, column: i32, row: i32, shader: &Shader<'_>) -> [u8; 4] {
        let mut seen = [(NOTHING, [0_i32; 3]); (SAMPLES * SAMPLES) as usize];
        let mut count = 0;
        if self.is_empty(column, row) {
            return [0; 4];
        }
        for y in row * SAMPLES..(row + 1) * SAMPLES {
            for x in column * SAMPLES..(column + 1) * SAMPLES {
                let id = self.ids[self.sample(x, y)];
                if id == NOTHING {
                    continue;
                }
                // Most often the one seen last.
                let known = seen[..count].iter().rposition(|&(other, _)| other == id);
                let entry = known.unwrap_or_else(|| {
                    seen[count].0 = id;
                    count += 1;
                    count - 1
                });
                let sums = &mut seen[entry].1;
                *sums = [sums[0] + 1, sums[1] + x, sums[2] + y];
            }
        }
        let mut sum = [0.0_f32; 4];
        for &(id, [samples, x, y]) in &seen[..count] {
            let middle = |sum: i32| (f64::from(sum) / f64::from(samples) + 0.5) * f64::from(STEPS);
            let first_row = f64::from(self.first_sample_row * STEPS);
            let color = shader.color(id, [middle(x), middle(y) + first_row]);
            let weight = samples as f32 / (SAMPLES * SAMPLES) as f32;
            let parts = [color.red, color.green, color.blue, 1.0];
            for (sum, part) in sum.iter_mut().zip(parts) {
                *sum += part.clamp(0.0, 1.0) * weight;
            }
        }
        sum.map(|part| (part * 255.0 + 0.5) as u8)
    }
}

/// The samples of a row or column from `first` on, below `end`, whose middles can lie between the
/// least and the largest of three places.
fn covered(a: i32, b: i32, c: i32, first: i32, end: i32) -> std::ops::Range<i32> {
    let low = (a.min(b).min(c) - STEPS / 2).div_euclid(STEPS);
    let high = (a.max(b).max(c) - STEPS / 2).div_euclid(STEPS) + 1;
    low.max(first)..high.min(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use graticule_fixtures::Noise;

    fn vertex(x: i32, y: i32, depth: f32) -> Vertex {
        Vertex { x, y, depth }
    }

    fn empty_band(columns: u32, rows: u32) -> Band {
        let mut band = Band::new(columns);
        band.begin(0, rows);
        band
    }

    #[test]
    fn triangles_around_a_vertex_cover_each_sample_once() {
        let mut noise = Noise::new(3);
        for _ in 0..50 {
            let mut place = || vertex(noise.below(20_000) as i32, noise.below(12_000) as i32, 0.0);
            let middle = place();
            let corners = [
                vertex(0, 0, 0.0),
                vertex(30_000, 0, 0.0),
                vertex(30_000, 15_000, 0.0),
                vertex(0, 15_000, 0.0),
            ];
            let mut counts = vec![0; 40 * 3 * 20 * 3];
            for side in 0..4 {
                let mut band = empty_band(40, 20);
                band.fill(
                    0,
                    [middle, corners[side], corners[(side + 1) % 4]],
                    Order::LastOnTop,
                );
                for (count, &id) in counts.iter_mut().zip(&band.ids) {
                    *count += i32::from(id != NOTHING);
                }
            }
            for (sample, &count) in counts.iter().enumerate() {
                let (x, y) = ((sample % 120) * 256 + 128, (sample / 120) * 256 + 128);
                assert_eq!(count, i32::from(x < 30_000 && y < 15_000), "{x} {y}");
            }
        }
    }

    #[test]
    fn spans_and_single_samples_agree() {
        let mut noise = Noise::new(4);
        for _ in 0..300 {
            let mut place = || vertex(noise.below(9_000) as i32, noise.below(9_000) as i32, 0.0);
            let triangle = [place(), place(), place()];
            let mut band = empty_band(12, 12);
            band.fill(0, triangle, Order::LastOnTop);
            let [a, mut b, mut c] = triangle;
            let sides = |b, c| [(a, b), (b, c), (c, a)].map(|(from, to)| Side::new(from, to, 0, 0));
            let area = i64::from(b.x - a.x) * i64::from(c.y - a.y)
                - i64::from(b.y - a.y) * i64::from(c.x - a.x);
            if area < 0 {
                (b, c) = (c, b);
            }
            for row in 0..36 {
                for column in 0..36 {
                    let inside = sides(b, c).iter().all(|side| {
                        side.value + side.step_right * column + side.step_down * row >= 0
                    });
                    let sample = (row * 36 + column) as usize;
                    assert_eq!(band.ids[sample] == 0, inside && area != 0);
                }
            }
        }
    }

    #[test]
    fn the_nearer_triangle_is_seen_in_whatever_order() {
        let flat = |depth| [(0, 0), (9_000, 0), (0, 9_000)].map(|(x, y)| vertex(x, y, depth));
        for depths in [[1.0, 2.0], [2.0, 1.0]] {
            let mut band = empty_band(4, 4);
            band.fill(0, flat(depths[0]), Order::NearestOnTop);
            band.fill(1, flat(depths[1]), Order::NearestOnTop);
            let nearest = u32::from(depths[1] > depths[0]);
            assert_eq!(band.ids[0], nearest);
            band.fill(7, flat(0.0), Order::LastOnTop);
            assert_eq!(band.ids[0], 7);
        }
    }
}
