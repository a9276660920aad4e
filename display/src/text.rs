//! Text in a picture, antialiased.
//!
//! The font is Hack (MIT and Bitstream Vera licences), from the crate that egui takes its fonts
//! from.

use ab_glyph::{Font, FontRef, ScaleFont, point};
use scene::Rgb;

use crate::settings::Size;

/// Side of the pixels' square per height of a capital letter: what is called font size.
const CAPITAL_HEIGHT: f32 = 0.73;

/// A canvas of display light, row by row from the top.
#[derive(Debug)]
pub struct Canvas<'a> {
    /// One per pixel.
    pub pixels: &'a mut [Rgb],
    /// Its size.
    pub size: Size,
}

impl Canvas<'_> {
    /// Mixes a colour into a pixel; outside the canvas nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, color: Rgb, opacity: f32) {
        let Size { width, height } = self.size;
        if (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y) {
            let pixel = &mut self.pixels[(y * i64::from(width) + x) as usize];
            *pixel = pixel.lerp(color, opacity.clamp(0.0, 1.0));
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, [left, top]: [i64; 2], [width, height]: [i64; 2], color: Rgb) {
        for y in top..top + height {
            for x in left..left + width {
                self.blend(x, y, color, 1.0);
            }
        }
    }
}

/// A font at a size.
#[derive(Clone, Debug)]
pub struct Typeface {
    font: FontRef<'static>,
    size: f32,
}

impl Typeface {
    /// The font with lines of `size` pixels. `None` if the font's data cannot be read, which only a
    /// broken build has.
    pub fn new(size: f32) -> Option<Self> {
        let font = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR).ok()?;
        Some(Self { font, size })
    }

    /// Width of a text, pixels.
    pub fn width(&self, text: &str) -> f32 {
        let font = self.font.as_scaled(self.size);
        text.chars()
            .map(|c| font.h_advance(self.font.glyph_id(c)))
            .sum()
    }

    /// Height of a capital letter or digit, pixels.
    pub fn capital_height(&self) -> f32 {
        let font = self.font.as_scaled(self.size);
        font.ascent() * CAPITAL_HEIGHT
    }

    /// Draws a text from `x` on, its capital letters centred on `middle`.
    pub fn draw(&self, canvas: &mut Canvas, x: f32, middle: f32, text: &str, color: Rgb) {
        let baseline = (middle + 0.5 * self.capital_height()).round();
        let font = self.font.as_scaled(self.size);
        let mut x = x;
        for c in text.chars() {
            let id = self.font.glyph_id(c);
            let glyph = id.with_scale_and_position(self.size, point(x, baseline));
            if let Some(outline) = self.font.outline_glyph(glyph) {
                let [left, top] = [outline.px_bounds().min.x, outline.px_bounds().min.y];
                outline.draw(|dx, dy, coverage| {
                    let (x, y) = (left as i64 + i64::from(dx), top as i64 + i64::from(dy));
                    canvas.blend(x, y, color, coverage);
                });
            }
            x += font.h_advance(id);
        }
    }
}
