//! Panels: square pictures side by side, each under a caption, and lines of text below all.
//!
//! Panels of few pixels are enlarged by whole pixels, so that each pixel stays a square of one colour; those of too many
//! are reduced to means.

use image::RgbImage;
use rayon::prelude::*;
use scene::Rgb;
use scene::srgb::decode;

use crate::settings::Size;
use crate::text::{Canvas, Typeface};
use crate::tone::to_srgb8;

/// Smallest and largest side of a panel, pixels: four of the largest are half of what a picture may have
/// ([`crate::settings::MAX_PIXELS`]).
const SIDES: [usize; 2] = [256, 4096];
/// Pixels of a panel's side for each pixel of letter size.
const SIDE_PER_LETTER_SIZE: f32 = 28.0;
/// The smallest letters, pixels.
const SMALLEST_LETTER: f32 = 13.0;
/// Height of a line of text and distance between panels, in letter sizes.
const LINE: f32 = 1.6;
const MARGIN: f32 = 0.8;

/// sRGB codes of what is around panels, and of letters: a dark grey that does not outshine the picture.
const AROUND: f32 = 0.11;
const INK: f32 = 0.90;

/// Display light of what is around panels, and of what in a panel belongs to none.
pub fn around() -> Rgb {
    Rgb::splat(decode(AROUND))
}

/// Display light of letters.
pub fn ink() -> Rgb {
    Rgb::splat(decode(INK))
}

/// A square picture.
pub struct Panel<'a> {
    /// One line.
    pub caption: String,
    /// Display light of a pixel by its index, row by row from the top: large pictures are not kept.
    pub light: Box<dyn Fn(usize) -> Rgb + 'a>,
}

/// Panels on a sheet.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Display light, row by row from the top.
    pixels: Vec<Rgb>,
    size: Size,
    /// Letter size, pixels.
    letter: f32,
    /// Left and top of each panel, pixels.
    corners: Vec<[i64; 2]>,
    /// Side of a panel, pixels.
    side: i64,
}

impl Sheet {
    /// Panels of `pixels` x `pixels` pixels, row by row, so many in a row, with lines below all.
    pub fn new(panels: &[Panel], pixels: usize, columns: usize, lines: &[String]) -> Self {
        let (grow, shrink) = scales(pixels);
        let side = (pixels / shrink * grow) as f32;
        let (columns, rows) = (columns.max(1), panels.len().div_ceil(columns.max(1)));
        let letter = letter_size(side, columns, panels, lines);
        let (line, margin) = ((LINE * letter).round(), (MARGIN * letter).round());
        let (step_right, step_down) = (side + margin, side + margin + line);
        let width = margin + columns as f32 * step_right;
        let below = if lines.is_empty() { 0.0 } else { margin };
        let text = line * lines.len() as f32 + below;
        let size = Size {
            width: width as u32,
            height: (margin + rows as f32 * step_down + text) as u32,
        };
        let mut sheet = Self {
            pixels: vec![around(); size.width as usize * size.height as usize],
            size,
            letter,
            corners: Vec::new(),
            side: side as i64,
        };
        for (k, panel) in panels.iter().enumerate() {
            let left = margin + (k % columns) as f32 * step_right;
            let top = margin + (k / columns) as f32 * step_down;
            sheet.write(left, top + 0.5 * line, &panel.caption);
            let corner = [left as i64, (top + line) as i64];
            sheet.corners.push(corner);
            sheet.paint(corner, &panel.light, pixels, (grow, shrink));
        }
        let top = margin + rows as f32 * step_down;
        for (k, text) in lines.iter().enumerate() {
            sheet.write(margin, top + (k as f32 + 0.5) * line, text);
        }
        sheet
    }

    /// Draws a picture of `pixels` x `pixels` pixels.
    fn paint(
        &mut self,
        [left, top]: [i64; 2],
        light: &dyn Fn(usize) -> Rgb,
        pixels: usize,
        (grow, shrink): (usize, usize),
    ) {
        let share = 1.0 / (shrink * shrink) as f32;
        let mean = |x: usize, y: usize| -> Rgb {
            let rows = (y * shrink..(y + 1) * shrink).map(|y| y * pixels + x * shrink);
            share
                * rows
                    .flat_map(|start| start..start + shrink)
                    .map(light)
                    .sum::<Rgb>()
        };
        let step = grow as i64;
        let mut canvas = self.canvas();
        for y in 0..pixels / shrink {
            for x in 0..pixels / shrink {
                let corner = [left + x as i64 * step, top + y as i64 * step];
                canvas.fill(corner, [step, step], mean(x, y));
            }
        }
    }

    /// Writes a line of text from `left` on, its letters centred on `middle`, pixels.
    pub fn write(&mut self, left: f32, middle: f32, text: &str) {
        if let Some(typeface) = Typeface::new(self.letter) {
            typeface.draw(&mut self.canvas(), left, middle, text, ink());
        }
    }

    /// To draw more on it.
    pub fn canvas(&mut self) -> Canvas<'_> {
        Canvas {
            pixels: &mut self.pixels,
            size: self.size,
        }
    }

    /// Width of a line of text, pixels.
    pub fn width(&self, text: &str) -> f32 {
        Typeface::new(self.letter).map_or(0.0, |typeface| typeface.width(text))
    }

    /// Letter size, pixels.
    pub fn letter(&self) -> f32 {
        self.letter
    }

    /// Left and top of each panel, and the side of all, pixels.
    pub fn places(&self) -> (&[[i64; 2]], i64) {
        (&self.corners, self.side)
    }

    /// The sheet for the eye, sRGB.
    pub fn image(&self) -> RgbImage {
        let bytes: Vec<u8> = self
            .pixels
            .par_iter()
            .flat_map_iter(|&light| to_srgb8(light))
            .collect();
        RgbImage::from_raw(self.size.width, self.size.height, bytes).unwrap_or_default()
    }
}

/// By how much a panel is enlarged and reduced.
fn scales(pixels: usize) -> (usize, usize) {
    let [smallest, largest] = SIDES;
    let pixels = pixels.max(1);
    (smallest.div_ceil(pixels).max(1), pixels.div_ceil(largest))
}

/// Letters as suit the panels, or as much smaller as it takes for the longest text to fit.
fn letter_size(side: f32, columns: usize, panels: &[Panel<'_>], lines: &[String]) -> f32 {
    let letter = (side / SIDE_PER_LETTER_SIZE).round().max(SMALLEST_LETTER);
    let Some(typeface) = Typeface::new(letter) else {
        return letter;
    };
    let excess = |text: &String, room: f32| typeface.width(text) / room;
    let all = side * columns as f32;
    let captions = panels.iter().map(|panel| excess(&panel.caption, side));
    let most = captions
        .chain(lines.iter().map(|line| excess(line, all)))
        .fold(1.0, f32::max);
    (letter / most).floor().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(pixels: usize, count: usize, columns: usize) -> Sheet {
        // Each pixel in a grey of its own.
        let grey = |k: usize| Rgb::splat(k as f32 / (pixels * pixels) as f32);
        let panel = || Panel {
            caption: "caption".into(),
            light: Box::new(grey),
        };
        let panels: Vec<Panel> = (0..count).map(|_| panel()).collect();
        Sheet::new(&panels, pixels, columns, &["below".into()])
    }

    fn at(sheet: &Sheet, x: i64, y: i64) -> Rgb {
        sheet.pixels[y as usize * sheet.size.width as usize + x as usize]
    }

    #[test]
    fn small_panels_are_enlarged_by_whole_pixels() {
        let sheet = sheet(12, 3, 2);
        let (corners, side) = sheet.places();
        assert_eq!(side, 12 * 22);
        for &[left, top] in corners {
            for y in 0..side {
                for x in 0..side {
                    let expected = ((y / 22) * 12 + x / 22) as f32 / 144.0;
                    assert_eq!(at(&sheet, left + x, top + y), Rgb::splat(expected));
                }
            }
        }
    }

    #[test]
    fn large_panels_are_reduced_to_means() {
        let pixels = 2 * SIDES[1];
        let sheet = sheet(pixels, 1, 1);
        let (corners, side) = sheet.places();
        assert_eq!(side as usize, SIDES[1]);
        let [left, top] = corners[0];
        // Of a linear ramp, the mean of four pixels is half a row and half a pixel on. f32 rounds four values up to 1.
        let expected = (pixels as f32 * 6.5 + 8.5) / (pixels * pixels) as f32;
        let error = at(&sheet, left + 4, top + 3) - Rgb::splat(expected);
        assert!(error.abs().max_element() < 4.0 * f32::EPSILON);
    }

    #[test]
    fn panels_lie_inside_beside_each_other() {
        let sheet = sheet(300, 3, 2);
        let (corners, side) = sheet.places();
        for (k, a) in corners.iter().enumerate() {
            assert!(a[0] >= 0 && a[0] + side <= i64::from(sheet.size.width));
            assert!(a[1] >= 0 && a[1] + side <= i64::from(sheet.size.height));
            for b in &corners[..k] {
                assert!((a[0] - b[0]).abs() >= side || (a[1] - b[1]).abs() >= side);
            }
        }
    }

    #[test]
    fn texts_fit_their_panels() {
        let panel = |caption: &str| Panel {
            caption: caption.into(),
            light: Box::new(|_| Rgb::ZERO),
        };
        for caption in ["short", &"long ".repeat(20)] {
            let sheet = Sheet::new(&[panel(caption)], 4, 1, &[]);
            let typeface = Typeface::new(sheet.letter()).unwrap();
            assert!(typeface.width(caption) <= sheet.side as f32);
        }
    }
}
