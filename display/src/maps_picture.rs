//! A picture of the two multiplier maps, and of what the thesis's one is off by.
//!
//! Three unfolded hemicubes: the exact delta form factors and the thesis's, both as parts of the largest of all, and the
//! thesis's over the exact ones in false colours. With r the distance to a pixel's centre on the cube the quotient is in
//! proportion to r^3 on top and to r^2 at the sides ([`compute::delta_form_factors`], Differences): it grows from the
//! middle to the rim, and a pixel counts too much where it is above 1.

use compute::delta_form_factors::multipliers;
use compute::settings::Maps;
use image::RgbImage;
use scene::Rgb;
use visibility::hemicube::FACES;

use crate::number::{ends, with_digits};
use crate::panels::{Panel, Sheet, around, ink};
use crate::settings::{Mode, Range};
use crate::ticks::ticks;
use crate::tone::Tone;
use crate::unfolding::{ResolutionError, Unfolding};

/// The most labels of the quotient's legend, which is as wide as five of the longest at least.
const MAX_LABELS: usize = 5;

/// The picture at a resolution: pixels along a face, even, 2 to [`MAX_RESOLUTION`](visibility::hemicube::MAX_RESOLUTION).
pub fn maps_picture(resolution: u32) -> Result<RgbImage, ResolutionError> {
    let unfolding = Unfolding::new(resolution)?;
    let [exact, thesis] = [Maps::Exact, Maps::Thesis].map(|maps| unfolded(maps, unfolding));
    let quotients = quotients(&exact, &thesis);
    let range = range(&quotients);
    let largest = exact.iter().chain(&thesis).fold(0.0, |a, &b| b.max(a));
    let exact = &exact[..];
    let grey = |value: f64| Rgb::splat((value / largest) as f32);
    let tone = Tone::new(Mode::FalseColor, range);
    let [low, high] = ends(range);
    let panels = [
        panel("exact delta form factors".into(), exact, exact, grey),
        panel("the thesis's multipliers".into(), exact, &thesis, grey),
        panel(
            format!("thesis's over exact, {low} to {high}"),
            exact,
            &quotients,
            |quotient| tone.color_at(tone.scale().position(quotient)),
        ),
    ];
    let largest = with_digits(largest, 4);
    let lines = [
        format!("{resolution} pixels along a face; both maps sum to 1; white is {largest}"),
        // Beside the legend's labels.
        String::new(),
    ];
    let mut sheet = Sheet::new(&panels, unfolding.side(), panels.len(), &lines);
    draw_legend(&mut sheet, &tone);
    Ok(sheet.image())
}

/// A panel of values, one per pixel of the square. The empty corners, in which no pixel counts, look like what is around it.
fn panel<'p>(
    caption: String,
    exact: &'p [f64],
    values: &'p [f64],
    light: impl Fn(f64) -> Rgb + 'p,
) -> Panel<'p> {
    let light = move |k: usize| {
        if exact[k] > 0.0 {
            light(values[k])
        } else {
            around()
        }
    };
    Panel {
        caption,
        light: Box::new(light),
    }
}

/// Multipliers, dimensionless, one per pixel of the square; 0 in its empty corners.
fn unfolded(maps: Maps, unfolding: Unfolding) -> Vec<f64> {
    let [top, side] = multipliers(maps, unfolding.resolution());
    let faces = (0..FACES).map(|face| if face == 0 { &top[..] } else { &side });
    unfolding.lay_out(0.0, faces)
}

/// The thesis's multipliers over the exact ones, dimensionless, one per pixel; 1 in the empty corners.
fn quotients(exact: &[f64], thesis: &[f64]) -> Vec<f64> {
    let pairs = exact.iter().zip(thesis);
    pairs
        .map(|(&exact, &thesis)| if exact > 0.0 { thesis / exact } else { 1.0 })
        .collect()
}

/// The least and the largest quotient.
fn range(quotients: &[f64]) -> Range {
    let low = quotients.iter().copied().fold(f64::MAX, f64::min);
    let high = quotients.iter().copied().fold(0.0, f64::max);
    Range {
        low,
        // At the lowest resolution most pixels are alike.
        high: high.max(low * (1.0 + f64::from(f32::EPSILON))),
    }
}

/// A bar of colours below the last panel, with ticks and labels.
fn draw_legend(sheet: &mut Sheet, tone: &Tone) {
    let letter = sheet.letter();
    let (corners, side) = sheet.places();
    let Some(&[left, top]) = corners.last() else {
        return;
    };
    let bar = letter.round() as i64;
    let top = top + side + bar / 2;
    let thickness = (letter / 12.0).round().max(1.0) as i64;
    let mut canvas = sheet.canvas();
    for x in 0..side {
        let position = (x as f64 + 0.5) / side as f64;
        canvas.fill([left + x, top], [1, bar], tone.color_at(position));
    }
    for tick in ticks(tone.scale(), MAX_LABELS) {
        let x = left + (tick.position * (side - thickness) as f64).round() as i64;
        let length = if tick.label.is_some() { 2 } else { 1 } * bar / 4;
        sheet
            .canvas()
            .fill([x, top + bar], [thickness, length], ink());
        if let Some(label) = tick.label {
            let middle = (top + bar) as f32 + 1.1 * letter;
            let width = sheet.width(&label);
            let (first, last) = (left as f32, (left + side) as f32 - width);
            let start = (x as f32 - 0.5 * width).min(last).max(first);
            sheet.write(start, middle, &label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the thesis's sum S before it is normalised, a pixel's quotient is pi r^3 / (S dA) on top and pi r^2 / (S dA)
    /// at the sides, but that its exact multiplier f is a mean over the pixel, of side p: off by p^2/24 times the Laplacian
    /// of f, which is 8 f in the middle and below 20 f elsewhere.
    #[test]
    fn quotient_grows_with_the_cube_of_the_distance_on_top_and_its_square_at_the_sides() {
        let resolution = 100;
        let unfolding = Unfolding::new(resolution).unwrap();
        let [exact, thesis] = [Maps::Exact, Maps::Thesis].map(|maps| unfolded(maps, unfolding));
        let quotients = quotients(&exact, &thesis);
        let pixel = 2.0 / f64::from(resolution);
        let tolerance = (8.0 + 20.0) / 24.0 * pixel * pixel;
        let r = |face: usize, i: usize, j: usize| {
            let window = visibility::hemicube::windows(resolution)[face];
            window.direction(i, j).length()
        };
        let middle = quotients[unfolding.index(0, 50, 50)] / r(0, 50, 50).powi(3);
        for (face, i, j) in [(0, 0, 0), (0, 99, 30), (1, 0, 49), (2, 50, 20), (4, 99, 40)] {
            let power = if face == 0 { 3 } else { 2 };
            let constant = quotients[unfolding.index(face, i, j)] / r(face, i, j).powi(power);
            assert!(
                (constant / middle - 1.0).abs() < tolerance,
                "face {face}, {i}, {j}: {constant} {middle}"
            );
        }
    }

    #[test]
    fn both_maps_sum_to_one_and_so_some_pixels_count_too_much_and_some_too_little() {
        for resolution in [4, 50, 128] {
            let unfolding = Unfolding::new(resolution).unwrap();
            let [exact, thesis] = [Maps::Exact, Maps::Thesis].map(|maps| unfolded(maps, unfolding));
            let Range { low, high } = range(&quotients(&exact, &thesis));
            assert!(low < 1.0 && high > 1.0, "{low} {high}");
        }
    }

    #[test]
    fn picture_has_three_panels_and_is_there_at_every_resolution() {
        for resolution in [2, 4, 100, 256] {
            let image = maps_picture(resolution).unwrap();
            let side = (2 * resolution).max(256);
            assert!(image.width() > 3 * side && image.height() > side);
        }
        assert!(maps_picture(3).is_err());
    }
}
