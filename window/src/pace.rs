//! How many pixels are drawn while the camera moves.
//!
//! A graphics card draws them all. Software draws fewer: the picture's sides are halved while frames take too long, and doubled
//! again where they would not. When the camera rests the picture is drawn whole, and then with four samples a pixel.

use std::time::Duration;

/// Frames that take longer are too long: 12 a second. What is drawn in a quarter of that could be twice as wide and high.
const LONGEST: Duration = Duration::from_millis(80);

/// Samples along a pixel's side: the fewest while the camera moves, and the most when it rests.
const LEAST: f32 = 0.25;
const MOST: f32 = 2.0;

/// The most samples of a picture that has more than one a pixel: their textures take 200 MB.
const MOST_IN_ALL: f32 = 16e6;

/// How long the camera has to rest before all pixels are drawn, and before there are four samples in each.
const RESTS: [Duration; 2] = [Duration::from_millis(150), Duration::from_millis(400)];

/// The pace of the frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Samples along a pixel's side while the camera moves.
    moving: f32,
    /// Mean duration of the last frames in motion, seconds; `None` before the first.
    seconds: Option<f32>,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            moving: 1.0,
            seconds: None,
        }
    }
}

impl Pace {
    /// Tells how long a frame took in which the camera moved.
    pub fn frame_in_motion(&mut self, duration: Duration) {
        let last = duration.as_secs_f32();
        let mean = self.seconds.map_or(last, |mean| 0.75 * mean + 0.25 * last);
        self.seconds = Some(mean);
        let longest = LONGEST.as_secs_f32();
        if mean > longest && self.moving > LEAST {
            self.moving *= 0.5;
            self.seconds = None;
        } else if mean < 0.25 * longest && self.moving < 1.0 {
            self.moving *= 2.0;
            self.seconds = None;
        }
    }

    /// Samples along a pixel's side of a picture of so many columns and rows, when the camera has rested for so long.
    pub fn samples(&self, rest: Duration, [width, height]: [u32; 2]) -> f32 {
        let [whole, fine] = RESTS;
        let has_room = MOST * MOST * width as f32 * height as f32 <= MOST_IN_ALL;
        if rest >= fine && has_room {
            MOST
        } else if rest >= whole {
            1.0
        } else {
            self.moving
        }
    }

    /// How long until more samples are drawn, if the camera goes on resting; `None` where there are as many as there will be.
    pub fn next(rest: Duration) -> Option<Duration> {
        RESTS
            .into_iter()
            .find(|&until| rest < until)
            .map(|until| until.saturating_sub(rest))
    }

    /// Frames a second in motion; `None` where nothing has moved yet.
    pub fn frames_per_second(&self) -> Option<f32> {
        self.seconds.map(|seconds| 1.0 / seconds.max(1e-3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1280, 720];

    fn after(frames: usize, duration: impl Fn(f32) -> Duration) -> Pace {
        let mut pace = Pace::default();
        for _ in 0..frames {
            pace.frame_in_motion(duration(pace.moving));
        }
        pace
    }

    /// Its frames take 16 ms whatever is drawn.
    #[test]
    fn a_graphics_card_draws_all_pixels_always() {
        let pace = after(100, |_| Duration::from_millis(16));
        assert!(pace.samples(Duration::ZERO, SIZE) >= 1.0);
    }

    /// Its frames take 10 ms and a second for all pixels: at a quarter of the sides that is 72 ms, at half of them 260.
    #[test]
    fn software_draws_as_many_as_it_can_in_time_and_keeps_to_it() {
        let cost = |samples: f32| Duration::from_secs_f32(0.01 + samples * samples);
        let pace = after(20, cost);
        assert!(pace.moving <= 0.25, "{pace:?}");
        assert!((after(21, cost).moving - pace.moving).abs() < 1e-6);
    }

    #[test]
    fn what_has_become_faster_is_drawn_finer_again() {
        let mut pace = after(20, |_| Duration::from_secs(1));
        assert!(pace.moving < 1.0);
        for _ in 0..20 {
            pace.frame_in_motion(Duration::from_millis(5));
        }
        assert!(pace.moving >= 1.0);
    }

    #[test]
    fn a_camera_at_rest_is_shown_finer_until_it_is_shown_best() {
        let pace = Pace::default();
        let mut rest = Duration::ZERO;
        let mut samples = pace.samples(rest, SIZE);
        while let Some(wait) = Pace::next(rest) {
            rest += wait;
            assert!(pace.samples(rest, SIZE) >= samples);
            samples = pace.samples(rest, SIZE);
        }
        assert!(samples >= MOST && rest < Duration::from_secs(1));
    }

    #[test]
    fn a_picture_on_a_very_large_screen_has_one_sample_a_pixel() {
        let samples = Pace::default().samples(Duration::MAX, [7680, 4320]);
        assert!((samples - 1.0).abs() < f32::EPSILON);
    }
}
