//! The false colours' legend: a panel at the picture's right with the colours, ticks and the unit.
//!
//! The range's ends stand above and below the colours, with "> " or "< " where there are values
//! beyond, which have the end's colour.
//!
//! The panel takes its place from the view, which stays whole beside it. Its letters grow with the
//! picture's height, and are never smaller than can be read; a picture too small to spare the room
//! has no legend.

use scene::Rgb;
use scene::srgb::decode;

use crate::luminance::luminance;
use crate::number;
use crate::quantity::Shown;
use crate::scale::Scale;
use crate::settings::{Range, Size};
use crate::text::{Canvas, Typeface};
use crate::ticks::ticks;
use crate::tone::Tone;

/// Rows of the picture for each pixel of letter size.
const ROWS_PER_LETTER_SIZE: f32 = 40.0;
/// Smallest and largest letters, pixels.
const LETTER_SIZES: [f32; 2] = [13.0, 96.0];
/// Width of the panel in letter sizes: the longest heading, "irradiance", and margins.
const WIDTH: f32 = 7.4;
/// The least height of a picture with a legend, in letter sizes: headings, ends and three ticks.
const MIN_HEIGHT: f32 = 12.0;
/// Distance from the panel's edges, in letter sizes.
const MARGIN: f32 = 0.8;
/// Width of the bar of colours, in letter sizes.
const BAR: f32 = 1.3;
/// Height of a line of the heading, in letter sizes.
const LINE: f32 = 1.35;
/// The least distance between labels, in letter sizes.
const LABEL_DISTANCE: f32 = 1.8;

/// sRGB codes of the panel, its letters and ticks: a dark grey that does not outshine the picture.
const PANEL: f32 = 0.11;
const INK: f32 = 0.90;

/// Where a legend goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Letter size, pixels.
    letter: f32,
    /// Width of the panel, pixels.
    pub width: u32,
}

impl Layout {
    /// The legend of a picture with this many rows.
    fn of_height(height: u32) -> Self {
        let [smallest, largest] = LETTER_SIZES;
        let letter = (height as f32 / ROWS_PER_LETTER_SIZE)
            .clamp(smallest, largest)
            .round();
        Self {
            letter,
            width: (WIDTH * letter).round() as u32,
        }
    }

    /// The legend inside a picture of this size; `None` if it would take more than half of it.
    pub fn inside(size: Size) -> Option<Self> {
        let layout = Self::of_height(size.height);
        (2 * layout.width <= size.width && MIN_HEIGHT * layout.letter <= size.height as f32)
            .then_some(layout)
    }

    /// The size of a picture whose view has this size, beside the legend.
    pub fn around(view: Size) -> Size {
        Size {
            width: view.width + Self::of_height(view.height).width,
            ..view
        }
    }
}

/// Which ends of a scale values lie beyond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clipped {
    /// Some lie below the low end.
    pub below: bool,
    /// Some lie above the high end.
    pub above: bool,
}

impl Clipped {
    /// Of these values, W/m^2.
    pub fn of(values: impl Iterator<Item = Rgb> + Clone, range: Range) -> Self {
        let mut lights = values.map(|value| f64::from(luminance(value)));
        // Both ends are rounded to f32, as luminances are.
        let beyond = |light: f64, end: f64| (light - end) > f64::from(f32::EPSILON) * end.abs();
        Self {
            below: lights.clone().any(|light| beyond(-light, -range.low)),
            above: lights.any(|light| beyond(light, range.high)),
        }
    }

    /// What the range's ends say, the low one first.
    fn labels(self, range: Range) -> [String; 2] {
        let [low, high] = number::ends(range);
        let marked = |mark, is_clipped, end| {
            if is_clipped {
                format!("{mark} {end}")
            } else {
                end
            }
        };
        [marked("<", self.below, low), marked(">", self.above, high)]
    }
}

/// What a legend explains.
#[derive(Clone, Copy)]
pub struct Explained<'a> {
    /// The lines of its heading, of ten letters at most each.
    pub heading: &'a [String],
    /// Where values lie.
    pub scale: &'a Scale,
    /// Display light of a place on the scale, 0 to 1.
    pub color_at: &'a dyn Fn(f64) -> Rgb,
}

/// Draws the legend of what is shown over the right of a picture.
pub fn draw(canvas: &mut Canvas, layout: Layout, tone: &Tone, shown: Shown, clipped: Clipped) {
    let explained = Explained {
        heading: &heading(shown, tone),
        scale: tone.scale(),
        color_at: &|position| tone.color_at(position),
    };
    draw_scale(canvas, layout, &explained, clipped);
}

/// Draws the legend of any scale over the right of a picture.
pub fn draw_scale(canvas: &mut Canvas, layout: Layout, explained: &Explained, clipped: Clipped) {
    let &Explained {
        heading,
        scale,
        color_at,
    } = explained;
    let letter = layout.letter;
    let Some(typeface) = Typeface::new(letter) else {
        return;
    };
    let ink = Rgb::splat(decode(INK));
    let height = canvas.size.height as f32;
    let panel_left = f64::from(canvas.size.width - layout.width) as i64;
    canvas.fill(
        [panel_left, 0],
        [i64::from(layout.width), i64::from(canvas.size.height)],
        Rgb::splat(decode(PANEL)),
    );
    let left = panel_left as f32 + MARGIN * letter;
    for (line, text) in heading.iter().enumerate() {
        let middle = (MARGIN + 0.5 + line as f32 * LINE) * letter;
        typeface.draw(canvas, left, middle, text, ink);
    }

    let lines = heading.len() as f32 + 1.0;
    let top = ((MARGIN + lines * LINE + 0.9) * letter).round() as i64;
    let bottom = (height - (MARGIN + LINE) * letter).round() as i64;
    let range = scale.range();
    let ends = number::ends(range);
    for (label, middle) in clipped.labels(range).iter().zip([
        bottom as f32 + (LINE - 0.5) * letter,
        top as f32 - (LINE - 0.5) * letter,
    ]) {
        typeface.draw(canvas, left, middle, label, ink);
    }
    let (bar_left, bar_width) = (left.round() as i64, (BAR * letter).round() as i64);
    for y in top..bottom {
        let position = 1.0 - ((y - top) as f64 + 0.5) / (bottom - top) as f64;
        canvas.fill([bar_left, y], [bar_width, 1], color_at(position));
    }

    let thickness = (letter / 12.0).round().max(1.0) as i64;
    let max_labels = ((bottom - top) as f32 / (LABEL_DISTANCE * letter)) as usize;
    for tick in ticks(scale, max_labels.max(2)) {
        // The middle of the line, so that ticks at the ends stay on the bar.
        let length = (bottom - top - thickness) as f64;
        let y = top + ((1.0 - tick.position) * length).round() as i64;
        let tick_length = if tick.label.is_some() { 0.45 } else { 0.22 };
        let bar_right = bar_left + bar_width;
        canvas.fill(
            [bar_right, y],
            [(tick_length * letter).round() as i64, thickness],
            ink,
        );
        // What an end says already is not said again beside it.
        if let Some(label) = tick.label.as_ref().filter(|label| !ends.contains(label)) {
            let middle = y as f32 + 0.5 * thickness as f32;
            typeface.draw(canvas, bar_right as f32 + 0.75 * letter, middle, label, ink);
        }
    }
}

/// What is shown, a word a line, its unit, and how the colours run.
fn heading(shown: Shown, tone: &Tone) -> Vec<String> {
    let name = shown.name();
    let mut lines: Vec<String> = name.split(' ').map(str::to_owned).collect();
    lines.extend(Some(shown.unit().to_owned()).filter(|unit| !unit.is_empty()));
    lines.push(tone.scale().kind().to_owned());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Mode;

    #[test]
    fn legend_takes_at_most_half_of_any_picture() {
        for width in [1, 64, 200, 320, 1024, 16_384] {
            for height in [1, 64, 150, 240, 768, 16_384] {
                if let Some(layout) = Layout::inside(Size { width, height }) {
                    assert!(2 * layout.width <= width);
                    assert!(layout.letter >= LETTER_SIZES[0]);
                }
            }
        }
        assert!(
            Layout::inside(Size {
                width: 320,
                height: 240
            })
            .is_some()
        );
    }

    #[test]
    fn headings_and_labels_fit_the_panel() {
        for height in [144, 240, 768, 2000, 16_384] {
            let layout = Layout::of_height(height);
            let typeface = Typeface::new(layout.letter).unwrap();
            let room = layout.width as f32 - 2.0 * MARGIN * layout.letter;
            for heading in ["radiosity", "irradiance", "difference", "W/m²"] {
                assert!(typeface.width(heading) <= room, "{heading} at {height}");
            }
            // The longest that ends have where four digits tell them apart.
            for end in ["< 1.234e-30", "> 0.001234"] {
                assert!(typeface.width(end) <= room + 0.8 * layout.letter, "{end}");
            }
            // The longest labels that ticks make of ranges as scenes have them.
            for label in ["0.005", "50000", "2e-10", "-0.005", "-0.0035"] {
                let left = (BAR + 0.75) * layout.letter;
                assert!(
                    left + typeface.width(label) <= room + 0.5 * layout.letter,
                    "{label}"
                );
            }
        }
    }

    #[test]
    fn ends_are_marked_where_values_lie_beyond() {
        let range = Range {
            low: 0.2,
            high: 90.0,
        };
        let labels = |values: &[f32]| {
            let values: Vec<Rgb> = values.iter().map(|&v| Rgb::splat(v)).collect();
            Clipped::of(values.into_iter(), range).labels(range)
        };
        assert_eq!(labels(&[0.2, 5.0, 90.0]), ["0.2", "90"]);
        assert_eq!(labels(&[0.19, 5.0, 90.0]), ["< 0.2", "90"]);
        assert_eq!(labels(&[0.2, 91.0]), ["0.2", "> 90"]);
        assert_eq!(labels(&[0.0, 91.0]), ["< 0.2", "> 90"]);
    }

    #[test]
    fn legend_is_drawn_within_its_panel_and_shows_both_ends() {
        let tone = Tone::new(
            Mode::FalseColor,
            Range {
                low: 0.2,
                high: 90.0,
            },
        );
        let size = Size {
            width: 640,
            height: 480,
        };
        let layout = Layout::inside(size).unwrap();
        let mut pixels = vec![Rgb::splat(0.5); 640 * 480];
        draw(
            &mut Canvas {
                pixels: &mut pixels,
                size,
            },
            layout,
            &tone,
            Shown::default(),
            Clipped::default(),
        );
        let view_width = (size.width - layout.width) as usize;
        for row in pixels.chunks(640) {
            assert!(row[..view_width].iter().all(|&p| p == Rgb::splat(0.5)));
            assert!(row[view_width..].iter().all(|&p| p != Rgb::splat(0.5)));
        }
        for end in [0.0, 1.0] {
            let color = tone.color_at(end);
            // A row is 1/400 of the scale.
            assert!(
                pixels.iter().any(|p| p.abs_diff_eq(color, 0.01)),
                "end {end} is missing"
            );
        }
    }
}
