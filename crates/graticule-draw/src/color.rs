/// A colour by its sRGB-coded red, green and blue, each in `0.0..=1.0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// Red.
    pub red: f32,
    /// Green.
    pub green: f32,
    /// Blue.
    pub blue: f32,
}

impl Color {
    /// White.
    pub const WHITE: Self = Self::hex(0x00ff_ffff);
    /// Text and axes.
    pub const INK: Self = Self::hex(0x0022_262b);
    /// A surface without further colour.
    pub const CLAY: Self = Self::hex(0x00d9_dee6);
    /// Multiplies the odd squares of a checker.
    pub const CHECKER: Self = Self::hex(0x006f_93bd);
    /// Triangles without value or without coordinates.
    pub const MISSING: Self = Self::hex(0x009a_9a9a);
    /// Flipped triangles.
    pub const FLIPPED: Self = Self::hex(0x00e3_001b);
    /// Triangles that overlap others in a layout.
    pub const OVERLAPPING: Self = Self::hex(0x00f0_9a1a);
    /// What the far side of a surface is tinted with.
    pub const FAR_SIDE: Self = Self::hex(0x00a8_6a3a);
    /// Seams of a layout.
    pub const SEAM: Self = Self::hex(0x00c2_4a00);

    /// A colour from `0xrrggbb`.
    #[must_use]
    pub const fn hex(code: u32) -> Self {
        Self::from_bytes([(code >> 16) as u8, (code >> 8) as u8, code as u8])
    }

    /// A colour from red, green and blue in `0..=255`.
    #[must_use]
    pub const fn from_bytes([red, green, blue]: [u8; 3]) -> Self {
        Self {
            red: red as f32 / 255.0,
            green: green as f32 / 255.0,
            blue: blue as f32 / 255.0,
        }
    }

    /// Red, green and blue in `0..=255`.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 3] {
        // A cast from float saturates, and maps NaN to 0.
        [self.red, self.green, self.blue].map(|part| part.mul_add(255.0, 0.5) as u8)
    }

    /// This colour for `share` 0, `other` for `share` 1, and in between along the line in sRGB.
    #[must_use]
    pub fn mix(self, other: Self, share: f32) -> Self {
        let blend = |a: f32, b: f32| a + (b - a) * share;
        Self {
            red: blend(self.red, other.red),
            green: blend(self.green, other.green),
            blue: blend(self.blue, other.blue),
        }
    }

    /// Part by part product: `other` seen through this colour.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self {
            red: self.red * other.red,
            green: self.green * other.green,
            blue: self.blue * other.blue,
        }
    }

    /// The colour with each part multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            red: self.red * factor,
            green: self.green * factor,
            blue: self.blue * factor,
        }
    }

    /// The colour of class `index`, for charts and other classes: the eight of Okabe and Ito
    /// (2008), which readers with any kind of colour vision can tell apart; black is left out, and
    /// they repeat after seven.
    #[must_use]
    pub fn of_class(index: usize) -> Self {
        const CLASSES: [u32; 7] = [
            0x00e6_9f00,
            0x0056_b4e9,
            0x0000_9e73,
            0x00f0_e442,
            0x0000_72b2,
            0x00d5_5e00,
            0x00cc_79a7,
        ];
        Self::hex(CLASSES[index % CLASSES.len()])
    }
}

/// How a number between 0 and 1 becomes a colour. All maps are perceptually ordered and can be
/// read with any kind of colour vision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorMap {
    /// From dark violet over green to yellow; for most figures.
    #[default]
    Viridis,
    /// From dark blue to yellow, the same to readers with red-green blindness.
    Cividis,
    /// From black over red to pale yellow.
    Inferno,
    /// From pale yellow over orange to dark red: low values recede; for errors.
    YellowRed,
    /// From blue over white to red; for figures with a neutral middle, such as log area.
    BlueRed,
    /// From violet over white to orange; for figures with a neutral middle.
    VioletOrange,
}

impl ColorMap {
    /// The colour at `share`, which is clamped to `0.0..=1.0`; [`Color::MISSING`] for NaN.
    #[must_use]
    pub fn at(self, share: f64) -> Color {
        if share.is_nan() {
            return Color::MISSING;
        }
        let share = share.clamp(0.0, 1.0);
        let (gradient, share) = match self {
            Self::Viridis => (colorous::VIRIDIS, share),
            Self::Cividis => (colorous::CIVIDIS, share),
            Self::Inferno => (colorous::INFERNO, share),
            Self::YellowRed => (colorous::YELLOW_ORANGE_RED, share),
            Self::BlueRed => (colorous::RED_BLUE, 1.0 - share),
            Self::VioletOrange => (colorous::PURPLE_ORANGE, share),
        };
        Color::from_bytes(gradient.eval_continuous(share).into_array())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_colours_round_trip() {
        for byte in 0..=255 {
            let bytes = [byte, 255 - byte, byte / 2];
            assert_eq!(Color::from_bytes(bytes).to_bytes(), bytes);
        }
    }

    #[test]
    fn maps_clamp_and_know_missing_values() {
        for map in [ColorMap::Viridis, ColorMap::BlueRed, ColorMap::YellowRed] {
            assert_eq!(map.at(-5.0), map.at(0.0));
            assert_eq!(map.at(f64::INFINITY), map.at(1.0));
            assert_ne!(map.at(0.0), map.at(1.0));
            assert_eq!(map.at(f64::NAN), Color::MISSING);
        }
    }
}
