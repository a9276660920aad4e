//! What the false colours mean: a bar of them with ticks, the quantity and its unit.

use display::Shown;
use display::number;
use display::ticks::ticks;
use display::tone::{Tone, to_srgb8};
use egui::{Align2, Color32, FontId, Mesh, Pos2, Rect, Sense, Shape, Ui, Vec2, pos2};

/// Width of the legend, points.
pub const WIDTH: f32 = 110.0;
/// Width of the bar, points.
const BAR: f32 = 18.0;
/// The least distance of labels, points.
const LABEL_DISTANCE: f32 = 26.0;
/// Parts of the bar, each of one colour.
const PARTS: u16 = 128;
/// Letters of the labels, points.
const LETTERS: f32 = 13.0;

/// Draws the legend over the height that there is.
pub fn show(ui: &mut Ui, tone: &Tone, shown: Shown) {
    ui.strong(shown.name());
    for line in [shown.unit(), tone.scale().kind()] {
        if !line.is_empty() {
            ui.label(line);
        }
    }
    let [low, high] = number::ends(tone.scale().range());
    ui.label(high);
    let room = Vec2::new(
        ui.available_width(),
        (ui.available_height() - 30.0).max(60.0),
    );
    let (rect, _) = ui.allocate_exact_size(room, Sense::hover());
    let bar = Rect::from_min_size(rect.min, Vec2::new(BAR, rect.height()));
    ui.painter().add(Shape::mesh(colors(tone, bar)));
    let ink = ui.visuals().text_color();
    let most = (rect.height() / LABEL_DISTANCE) as usize;
    for tick in ticks(tone.scale(), most.max(2)) {
        let y = bar.bottom() - tick.position as f32 * bar.height();
        let length = if tick.label.is_some() { 7.0 } else { 3.0 };
        let ends = [pos2(bar.right(), y), pos2(bar.right() + length, y)];
        ui.painter().line_segment(ends, (1.0, ink));
        if let Some(label) = tick.label {
            let place = pos2(bar.right() + 11.0, y);
            let font = FontId::proportional(LETTERS);
            ui.painter()
                .text(place, Align2::LEFT_CENTER, label, font, ink);
        }
    }
    ui.label(low);
}

/// The bar, from the low end at its bottom up.
fn colors(tone: &Tone, bar: Rect) -> Mesh {
    let mut mesh = Mesh::default();
    let y = |part: u16| bar.bottom() - f32::from(part) / f32::from(PARTS) * bar.height();
    for part in 0..PARTS {
        let [r, g, b] = to_srgb8(tone.color_at((f64::from(part) + 0.5) / f64::from(PARTS)));
        let rect = Rect::from_min_max(
            Pos2::new(bar.left(), y(part + 1)),
            Pos2::new(bar.right(), y(part)),
        );
        mesh.add_colored_rect(rect, Color32::from_rgb(r, g, b));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use display::{Mode, Range};

    use super::*;

    #[test]
    fn the_bar_runs_from_the_low_end_at_its_bottom_to_the_high_end() {
        let range = Range {
            low: 0.1,
            high: 9.0,
        };
        let tone = Tone::new(Mode::FalseColor, range);
        let bar = Rect::from_min_max(pos2(0.0, 0.0), pos2(10.0, 300.0));
        let mesh = colors(&tone, bar);
        let color_at = |y: f32| {
            let nearest = mesh.vertices.iter().min_by(|a, b| {
                let [a, b] = [a, b].map(|v| (v.pos.y - y).abs());
                a.total_cmp(&b)
            });
            nearest.unwrap().color
        };
        // The colour of a part is that of its middle.
        let half = 0.5 / f64::from(PARTS);
        for (y, position) in [(300.0, half), (0.0, 1.0 - half)] {
            let [r, g, b] = to_srgb8(tone.color_at(position));
            assert_eq!(color_at(y), Color32::from_rgb(r, g, b));
        }
    }
}
